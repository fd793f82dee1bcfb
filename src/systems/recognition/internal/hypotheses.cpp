#include "recognition/internal/hypotheses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "recognition/internal/thin.h"

namespace rangegrasp::recognition::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::Points;

/// A segment that is so much longer or higher than the object cannot be it alone [m].
constexpr double kTooLarge_m = 0.015;
/// Poses are no nearer than this to each other, symmetry aside.
constexpr double kSameGuess_m = 0.010;
constexpr double kSameGuess_rad = 0.2;
/// Every so many samples of the surface tell how far it reaches.
constexpr std::size_t kStride = 8;

struct Extent {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  Vector3d high = Vector3d::Constant(-std::numeric_limits<double>::infinity());

  void Add(const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Vector3d Size() const { return high - low; }
  Vector3d Middle() const { return 0.5 * (low + high); }
};

/// A table frame whose x axis runs along the line of sight.
base::Pose AlongSight(const Segment& segment) {
  const Vector3d middle_T = segment.X_TC * geometry::Centroid(segment.cloud_C.points);
  Vector3d sight_T = middle_T - segment.X_TC * segment.eyes_C.front();
  sight_T.z() = 0.0;
  if (sight_T.norm() < 1e-6) sight_T = Vector3d::UnitX();
  const Matrix3d R = Eigen::Quaterniond::FromTwoVectors(sight_T.normalized(), Vector3d::UnitX())
                         .toRotationMatrix();
  return base::MakePose(R, Vector3d::Zero()) * segment.X_TC;
}

bool IsNew(const base::Pose& pose, const std::vector<base::Pose>& poses, const Symmetry& symmetry) {
  return std::ranges::none_of(poses, [&](const base::Pose& other) {
    const PoseDifference d = Difference(pose, other, symmetry);
    return d.distance_m < kSameGuess_m && d.angle_rad < kSameGuess_rad;
  });
}

}  // namespace

std::vector<base::Pose> LyingPoses(const PreparedObject& object, const Segment& segment) {
  const base::Pose X_SC = AlongSight(segment);
  Extent seen;
  for (const Vector3d& p : segment.cloud_C.points) seen.Add(X_SC * p);
  Points to_eyes;
  for (const Vector3d& eye_C : segment.eyes_C) {
    to_eyes.push_back((X_SC * eye_C - seen.Middle()).normalized());
  }
  const geometry::PointCloud& surface = object.object->surface_B;
  std::vector<base::Pose> poses;
  for (const Matrix3d& way : object.lying) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const Vector3d& corner : object.hull_B) lowest = std::min(lowest, way.row(2).dot(corner));
    Extent visible;
    for (std::size_t i = 0; i < surface.size(); i += kStride) {
      const Vector3d normal = way * surface.normals[i];
      const bool faces =
          std::ranges::any_of(to_eyes, [&](const Vector3d& e) { return normal.dot(e) > 0.1; });
      if (faces) visible.Add(way * surface.points[i]);
    }
    Vector3d size = visible.Size();
    size.z() = visible.high.z() - lowest;
    Vector3d of_segment = seen.Size();
    of_segment.z() = seen.high.z();
    if (((of_segment - size).array() > kTooLarge_m).any()) continue;
    Vector3d shift = seen.Middle() - visible.Middle();
    shift.z() = -lowest;
    poses.push_back(X_SC.inverse() * base::MakePose(way, shift));
  }
  return poses;
}

std::vector<base::Pose> VotedPoses(const PreparedObject& object, const Segment& segment,
                                   std::size_t references, base::Rng& rng) {
  constexpr std::size_t kPeaks = 2;
  const auto kept = Thinned(segment.cloud_C.points, object.pairs.spacing_m());
  const geometry::PointCloud thin{geometry::Select(segment.cloud_C.points, kept),
                                  geometry::Select(segment.cloud_C.normals, kept)};
  std::vector<PairTable::Voted> voted;
  const std::size_t step =
      std::max<std::size_t>(1, thin.size() / std::max<std::size_t>(1, references));
  for (std::size_t i = rng.Index(step); i < thin.size(); i += step) {
    object.pairs.Vote(thin, static_cast<std::uint32_t>(i), kPeaks, voted);
  }
  std::ranges::stable_sort(voted, std::greater{}, &PairTable::Voted::votes);
  std::vector<base::Pose> poses;
  for (const auto& one : voted) {
    if (IsNew(one.X_CB, poses, object.object->symmetry)) poses.push_back(one.X_CB);
  }
  return poses;
}

}  // namespace rangegrasp::recognition::internal
