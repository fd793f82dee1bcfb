#pragma once

#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "pcl_bridge/cloud.h"
#include "perception/scene.h"
#include "recognition/internal/evidence.h"
#include "recognition/internal/hypotheses.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition::internal {

/// Poses of one object that differ by more are two: what one wants to know a pose to, 5 mm and
/// 5 deg, and a little.
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

  /// Adds what the best pose may be taken for, as far as the rays leave it open: turned about the
  /// model's principal axes and the one that most of it is round about, and upside down. A body
  /// that is round but for a handle is guessed where its handle is not.
  void AddTurned(std::vector<Posed>& posed) const;

  /// What the pose may be instead: moved along and turned about the principal axes by as much as
  /// makes another pose. A hidden end leaves open how far a body reaches.
  std::vector<Posed> Moved(const Posed& posed) const;

  /// Poses that are about as good as the best are refined too, and the tightest of them goes first.
  /// From here on the scores are those of shape and colors.
  void Settle(std::vector<Posed>& posed) const;

  double ShapeScore(const base::Pose& X_CB) const;

 private:
  std::vector<base::Pose> Turned(const base::Pose& X_CB) const;
  void Aim(std::vector<Posed>& posed) const;
  base::Pose Aimed(const base::Pose& X_CB) const;
  Posed Refined(Posed posed) const;
  Posed Coarse(const base::Pose& X_CB) const;
  double Tight(const base::Pose& X_CB) const;
  double FineScore(const base::Pose& X_CB) const;
  Evidence WeighRays(const base::Pose& X_CB, const SampleRays& rays, double tolerance_m) const;
  bool Stands(const base::Pose& X_CB, double max_sunk_m) const;
  geometry::Points WithContact(const base::Pose& X_CB) const;
  base::Pose Lifted(const base::Pose& X_CB, double by_m) const;
  base::Pose Registered(const base::Pose& X_CB, const pcl_bridge::Cloud& source) const;
  void Climb(int axis, double step_m, double step_rad, Posed& posed) const;

  const PreparedObject* object_;
  const Segment* segment_;
  const pcl_bridge::Cloud* source_;
  const RecognitionOptions* options_;
};

}  // namespace rangegrasp::recognition::internal
