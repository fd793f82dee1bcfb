#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/observation.h"
#include "geometry/ray_caster.h"
#include "perception/scene.h"
#include "recognition/internal/prepared.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition::internal {

/// What a sample was taken for.
enum class Part : std::uint8_t {
  kOwn,
  kOther,
  kGround,
  kLost  ///< not measured, between two samples of its profile that were
};

/// A sample as a ray from its sensor.
struct SampleRay {
  Eigen::Vector3f origin_C;
  Eigen::Vector3f direction_C;  ///< unit
  float distance_m = 0.0f;
  float weight = 1.0f;  ///< samples that it stands for
  Part part = Part::kGround;
  std::uint32_t point = 0;  ///< position in Scene::points_C; none for a lost one
  /// Of its color (tone.h); NaN where that is not known.
  Eigen::Vector3f tone = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
};
using SampleRays = std::vector<SampleRay>;

/// The rays to a segment and those beside it.
/// @param own  the segment's points, positions in scene.cloud
SampleRays RaysAbout(const geometry::Observation& observation, const perception::Scene& scene,
                     const geometry::Indices& own, double beside_m);
/// About `count` of them, half of them the segment's own, the rest evenly; weights make up for it.
SampleRays Fewer(const SampleRays& rays, std::size_t count);

/// What rays say of an object in a pose; sums of weights.
struct Evidence {
  double fit = 0.0;  ///< of explained samples: 1 - (e / tolerance)^2
  double explained = 0.0;
  double violated = 0.0;
  double unexplained = 0.0;
  double hidden = 0.0;      ///< rays that something else before the surface stops
  double lost = 0.0;        ///< rays that meet the surface well, and of which nothing came back
  double squares_m2 = 0.0;  ///< sum of e^2 over explained ones
  double colored = 0.0;     ///< explained ones whose color and the model's there are known
  double agreed = 0.0;      ///< of them: 1 - (d / tolerance)^2, 0 at least

  /// Of the shape alone.
  double ShapeScore(const RecognitionOptions& options) const;
  /// How well the colors agree; 1 where they are not known.
  double Color() const { return colored > 0.0 ? agreed / colored : 1.0; }
  double Score(const RecognitionOptions& options) const;
};
/// @param explained  receives positions in Scene::points_C; may be null
Evidence Weigh(const PreparedObject& object, const base::Pose& X_CB, const SampleRays& rays,
               double tolerance_m, double color_tolerance, geometry::Indices* explained = nullptr);

}  // namespace rangegrasp::recognition::internal
