#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/observation.h"
#include "geometry/ray_caster.h"
#include "pcl_bridge/registration.h"
#include "perception/scene.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition::internal {

/// A color for comparison: the shares of red and blue in its light, and the logarithm of its
/// brightness with a small weight, since faces turned away from the lamps are darker.
using Tone = Eigen::Vector3f;

/// A point's pairs with the other points of a cloud with normals, as point pair features (Drost et
/// al. 2010, "Model globally, match locally"): each is a distance and three angles, in steps.
struct PointPairs {
  struct Pair {
    std::uint32_t feature;
    float turn;  ///< of the second point about the first one's normal, in steps of the votes
  };
  base::Pose to_axis;  ///< puts the point at the origin and its normal along x
  std::vector<Pair> pairs;
};
/// Those of about `count` points, evenly chosen from the cloud thinned as the models are.
std::vector<PointPairs> ReferencesOf(const geometry::PointCloud& cloud, int count);

/// A pose and its score: from the rays, or the votes for it.
struct Posed {
  base::Pose X_CB;
  double score = 0.0;
  /// The guess from which it was registered, if the object lay on the table there.
  std::optional<base::Pose> lying_CB = {};
};

/// A model's pairs of points by feature. PCL's voting (PPFRegistration) keeps only one voted pose.
class PairTable {
 public:
  explicit PairTable(const geometry::PointCloud& surface_B);

  /// Appends the poses with most votes of a scene's point, at most two.
  void Vote(const PointPairs& scene, std::vector<Posed>& voted) const;

 private:
  struct Pair {
    std::uint16_t reference;
    float turn;  // as in PointPairs
  };
  struct Bucket {
    std::vector<Pair> pairs;  ///< pairs that vote
    float weight = 0.0f;      ///< of a vote
  };

  geometry::PointCloud points_B_;
  std::unordered_map<std::uint32_t, Bucket> pairs_;
};

/// One known object, prepared for the search.
struct PreparedObject {
  explicit PreparedObject(KnownObject known);

  KnownObject object;
  geometry::RayCaster rays;        ///< the mesh in B
  std::vector<Tone> print_tones;   ///< of the mesh's print, one per texel
  std::vector<Tone> plain_tones;   ///< one per triangle; may be empty, as the print's
  pcl_bridge::PlaneTarget target;  ///< surface_B
  geometry::Points hull_B;         ///< corners of the convex hull
  Eigen::Matrix3d axes_B;          ///< principal axes, unit columns
  std::optional<Axis> round;       ///< axis about which most of it is round
  /// Rotations R_TB in which it lies on a table with z up, modulo symmetry.
  std::vector<Eigen::Matrix3d> lying;
  PairTable pairs;

  bool has_tones() const { return !print_tones.empty() || !plain_tones.empty(); }
  /// NaN where the color is unknown.
  Tone ToneAt(const geometry::Hit& hit) const;
};

/// Classification of a sample.
enum class Part : std::uint8_t {
  kOwn,
  kOther,
  kGround,
  kLost  ///< not measured, but between two measured samples of its profile
};

/// A sample as a ray from its sensor.
struct SampleRay {
  Eigen::Vector3f origin_C;
  Eigen::Vector3f direction_C;  ///< unit
  float distance_m = 0.0f;
  float weight = 1.0f;  ///< number of samples that it represents
  Part part = Part::kGround;
  std::uint32_t point = 0;  ///< position in Scene::points_C; unused for lost samples
  Tone tone = Tone::Constant(std::numeric_limits<float>::quiet_NaN());  ///< NaN if unknown
};
using SampleRays = std::vector<SampleRay>;

/// The rays that pass within beside_m of a segment's bounding sphere.
/// @param own  the segment's points, positions in scene.cloud
SampleRays RaysAbout(const geometry::Observation& observation, const perception::Scene& scene,
                     const geometry::Indices& own, double beside_m);
/// About `count` of the rays, half of them the segment's own, evenly sampled; weights compensate.
SampleRays Fewer(const SampleRays& rays, std::size_t count);

/// Evidence of the rays for an object in a pose, as sums of weights.
struct Evidence {
  double fit = 0.0;  ///< sum over explained samples of 1 - (e / tolerance)^2
  double explained = 0.0;
  double violated = 0.0;
  double unexplained = 0.0;
  double hidden = 0.0;      ///< rays stopped by another object in front of the surface
  double lost = 0.0;        ///< rays that should measure the surface well, but did not return
  double squares_m2 = 0.0;  ///< sum of e^2 over explained samples
  double colored = 0.0;     ///< explained samples with known color, also in the model
  double agreed = 0.0;      ///< sum over these of 1 - (d / tolerance)^2, each at least 0

  /// Score of the shape alone (see Recognize).
  double ShapeScore(const RecognitionOptions& options) const;
  /// Score of shape and colors.
  double Score(const RecognitionOptions& options) const;
  /// Agreement of the colors; 1 if they are unknown.
  double Color() const { return colored > 0.0 ? agreed / colored : 1.0; }
  /// Rays to the surface that nothing in front of it stops; at least 1.
  double Visible() const { return std::max(1.0, explained + violated); }
  double Rms_m() const { return std::sqrt(squares_m2 / std::max(1.0, explained)); }
};
/// @param explained  receives positions in Scene::points_C; may be null
Evidence Weigh(const PreparedObject& object, const base::Pose& X_CB, const SampleRays& rays,
               double tolerance_m, double color_tolerance, geometry::Indices* explained = nullptr);

}  // namespace rangegrasp::recognition::internal
