#pragma once

#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "pcl_bridge/cloud.h"
#include "perception/scene.h"
#include "recognition/internal/prepared_object.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition::internal {

/// A perceived object, prepared for the comparison with known ones.
struct Segment {
  geometry::PointCloud cloud_C;  ///< with normals
  geometry::Points source_C;     ///< fewer of its points, for registration
  SampleRays rays;               ///< all about it
  SampleRays coarse;
  SampleRays fine;
  SampleRays few;                            ///< between the two
  bool colored = false;                      ///< some rays have tones, and they count
  base::Pose X_TC = base::Pose::Identity();  ///< the table: z up, origin on it
  geometry::Points eyes_C;  ///< where the views stood that saw much of it; one or more
};

/// Poses of one object that differ by more are two: a little more than the wanted accuracy of 5 mm
/// and 5 deg.
inline constexpr double kDiffers_m = 0.006;
inline constexpr double kDiffers_rad = 0.105;

/// A pose with what the rays say of it.
struct Posed {
  base::Pose X_CB;
  double score = 0.0;
  bool lies = false;  ///< on the table, in one of its ways to
};

/// What is to be compared with the library: the points `own` of the scene's cloud.
Segment SegmentOf(const geometry::Observation& observation, const perception::Scene& scene,
                  const geometry::Indices& own, const RecognitionOptions& options);

/// One known object at one perceived one. Holds references to all that it is made of.
class Match {
 public:
  Match(const PreparedObject& object, const Segment& segment, const pcl_bridge::Cloud& source,
        const RecognitionOptions& options)
      : object_(&object), segment_(&segment), source_(&source), options_(&options) {}

  const PreparedObject& object() const { return *object_; }

  /// The best poses by the coarse score, the best first.
  std::vector<Posed> Guesses(base::Rng& rng) const;
  /// The same, registered, the best by the fine score first.
  std::vector<Posed> Registered(std::vector<Posed> posed) const;
  /// Adds poses that the best one may be confused with, as far as the rays leave them open: turned
  /// about the model's principal axes and its axis of revolution, and upside down. Of a body that
  /// is round but for a handle, guesses may have missed the handle's place.
  void AddTurned(std::vector<Posed>& posed) const;
  /// Poses that differ just enough to count as others: moved along and turned about the principal
  /// axes. A hidden end leaves open how far a body reaches.
  std::vector<Posed> Moved(const Posed& posed) const;
  /// Refines the best pose and those that are about as good; the one that fits most tightly goes
  /// first. From here on the scores are those of shape and colors.
  void Settle(std::vector<Posed>& posed) const;

  double ShapeScore(const base::Pose& X_CB) const;

 private:
  std::vector<base::Pose> Turned(const base::Pose& X_CB) const;
  void Aim(std::vector<Posed>& posed) const;
  base::Pose Aimed(const base::Pose& X_CB) const;
  Posed Refined(Posed posed) const;
  Posed Coarse(const base::Pose& X_CB) const;
  Evidence Fine(const base::Pose& X_CB, double tolerance_share = 1.0) const;
  // Nothing speaks for a pose that is deeper in the table.
  Evidence WeighAbove(double max_sunk_m, const base::Pose& X_CB, const SampleRays& rays,
                      double tolerance_m) const;
  geometry::Points WithContact(const base::Pose& X_CB) const;
  base::Pose Registered(const base::Pose& X_CB, const pcl_bridge::Cloud& source) const;
  void Climb(int axis, double step_m, double step_rad, Posed& posed) const;

  const PreparedObject* object_;
  const Segment* segment_;
  const pcl_bridge::Cloud* source_;
  const RecognitionOptions* options_;
};

}  // namespace rangegrasp::recognition::internal
