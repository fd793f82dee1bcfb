#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/observation.h"
#include "geometry/ray_caster.h"
#include "pcl_bridge/registration.h"
#include "perception/scene.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition::internal {

/// A color as it is compared: the shares of red and of blue in its light, and the logarithm of the
/// brightness with a small weight, since a face that is turned from the lamps is darker.
Eigen::Vector3f ToneOf(const geometry::Rgb& color);

/// The tones of a mesh's colors.
class MeshTones {
 public:
  /// @param colors  kept: must outlive it
  explicit MeshTones(const geometry::MeshColors& colors);

  bool known() const { return !print_.empty() || !plain_.empty(); }
  /// NaN where the color is not known.
  Eigen::Vector3f At(const geometry::Hit& hit) const;

 private:
  const geometry::MeshColors* colors_;
  std::vector<Eigen::Vector3f> print_;  // of each texel
  std::vector<Eigen::Vector3f> plain_;  // of each triangle
};

/// Point pair features (Drost et al. 2010, "Model globally, match locally"): pairs of a model's
/// points with normals by their distance and three angles. PCL's voting (PPFRegistration) keeps
/// only one of the poses voted for.
class PairTable {
 public:
  /// @param surface_B  thinned to about spacing_m
  PairTable(const geometry::PointCloud& surface_B, double spacing_m);

  struct Voted {
    base::Pose X_CB;
    double votes = 0.0;
  };
  /// The poses that pairs of `reference` with the scene's other points vote for most: at most
  /// `peaks` of them.
  void Vote(const geometry::PointCloud& scene_C, std::uint32_t reference, std::size_t peaks,
            std::vector<Voted>& voted) const;

  double spacing_m() const { return spacing_m_; }

 private:
  struct Pair {
    std::uint16_t reference;
    float angle;  // of the second point about the reference's normal
  };
  struct Bucket {
    std::vector<Pair> pairs;  ///< as many as vote
    float all = 0.0f;         ///< that have this feature
  };
  static void Thin(Bucket& bucket);
  std::uint32_t Key(const Eigen::Vector3d& p, const Eigen::Vector3d& n, const Eigen::Vector3d& q,
                    const Eigen::Vector3d& m) const;

  double spacing_m_;
  double diameter_m_ = 0.0;
  geometry::PointCloud points_B_;
  std::unordered_map<std::uint32_t, Bucket> pairs_;
};

/// One known object, made ready to be looked for.
struct PreparedObject {
  explicit PreparedObject(KnownObject known);

  KnownObject object;
  geometry::RayCaster rays;        ///< the mesh in B
  MeshTones tones;                 ///< of the mesh
  pcl_bridge::PlaneTarget target;  ///< surface_B
  geometry::Points hull_B;         ///< corners of the hull
  Eigen::Matrix3d axes_B;          ///< principal ones, unit columns
  std::optional<Axis> round;       ///< most of it is round about this
  /// Rotations R_TB in which it lies on a table with z up, symmetry aside.
  std::vector<Eigen::Matrix3d> lying;
  PairTable pairs;
};

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
  /// ToneOf its color; NaN where that is not known.
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

  /// Of the shape alone (Recognize).
  double ShapeScore(const RecognitionOptions& options) const;
  /// Of shape and colors.
  double Score(const RecognitionOptions& options) const;
  /// How well the colors agree; 1 where they are not known.
  double Color() const { return colored > 0.0 ? agreed / colored : 1.0; }
  /// Rays to the surface that nothing stops before it; 1 at least.
  double Visible() const { return std::max(1.0, explained + violated); }
  double Rms_m() const { return std::sqrt(squares_m2 / std::max(1.0, explained)); }
};
/// @param explained  receives positions in Scene::points_C; may be null
Evidence Weigh(const PreparedObject& object, const base::Pose& X_CB, const SampleRays& rays,
               double tolerance_m, double color_tolerance, geometry::Indices* explained = nullptr);

}  // namespace rangegrasp::recognition::internal

namespace rangegrasp::recognition {

struct Library::Prepared {
  std::vector<std::unique_ptr<internal::PreparedObject>> ready;
};

}  // namespace rangegrasp::recognition
