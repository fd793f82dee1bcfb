#pragma once

#include <utility>
#include <vector>

#include "base/frames.h"
#include "perception/scene.h"
#include "recognition/internal/prepared_object.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition::internal {

/// A perceived object, prepared for comparison with known objects.
struct Segment {
  geometry::PointCloud cloud_C;        ///< with normals
  geometry::Points source_C;           ///< fewer points, for registration
  SampleRays rays;                     ///< all rays around it; the following are fewer of them:
  SampleRays rough;                    ///< tens
  SampleRays coarse;                   ///< hundreds
  SampleRays few;                      ///< more hundreds
  SampleRays fine;                     ///< thousands
  std::vector<PointPairs> references;  ///< of its points that vote for poses
  bool colored = false;                ///< some rays have tones
  base::Pose X_TC = base::Pose::Identity();  ///< table frame: z up, origin on it
  geometry::Points eyes_C;  ///< positions of the views that saw much of it; at least one
};

/// Poses of one object that differ by more are distinct. This is slightly more than the required
/// accuracy of 5 mm and 5 deg.
inline constexpr PoseDifference kDiffers{0.006, 0.105};
bool AreDistinct(const base::Pose& a, const base::Pose& b, const Symmetry& symmetry);

/// Prepares the points `own` of the scene's cloud for comparison with the library.
Segment SegmentOf(const geometry::Observation& observation, const perception::Scene& scene,
                  const geometry::Indices& own, const RecognitionOptions& options);

/// The poses of one known object at one segment. Keeps references to its constructor's arguments.
class Match {
 public:
  /// Guesses poses: the best by the coarse score.
  Match(const PreparedObject& object, const Segment& segment, const RecognitionOptions& options);

  const PreparedObject& object() const { return *object_; }
  /// Best first; may be empty.
  const std::vector<Posed>& posed() const { return posed_; }
  /// Of the best pose; 0 without one.
  double Score() const { return posed_.empty() ? 0.0 : posed_.front().score; }
  double ShapeScore(const base::Pose& X_CB) const;

  /// Registers the poses, and scores them finely.
  void Register() { posed_ = Registered(std::move(posed_)); }

  // The following need at least one pose.

  /// Adds poses that may be confused with the best one, unless the rays exclude them: turned about
  /// the model's principal axes and its axis of revolution, and upside down. For a body that is
  /// round except for a handle, the guesses may have missed the handle's position.
  void AddTurned();
  /// Refines the best pose and those with similar scores; the one that fits most tightly goes
  /// first. Afterwards the scores are those of shape and colors.
  void Settle();
  /// Poses that differ from the best just enough to be distinct: shifted along and turned about the
  /// principal axes. If an end is hidden, the extent of the body is not determined.
  std::vector<Posed> Moved() const;

 private:
  std::vector<Posed> Registered(std::vector<Posed> posed) const;
  void Aim();
  base::Pose Aimed(const base::Pose& X_CB) const;
  Posed Refined(Posed posed) const;
  double CoarseScore(const SampleRays& rays, const base::Pose& X_CB) const;
  double FewScore(const base::Pose& X_CB) const;
  Evidence Fine(const base::Pose& X_CB, double tolerance_share = 1.0) const;
  // No evidence for poses that are deeper than this in the table.
  Evidence WeighAbove(double max_sunk_m, const base::Pose& X_CB, const SampleRays& rays,
                      double tolerance_m) const;
  void Climb(int axis, double step_m, double step_rad, Posed& posed) const;

  const PreparedObject* object_;
  const Segment* segment_;
  const RecognitionOptions* options_;
  std::vector<Posed> posed_;
};

}  // namespace rangegrasp::recognition::internal
