#include "grasp/internal/cylindrical_candidates.h"

#include <algorithm>
#include <array>

#include "base/units.h"

namespace rangegrasp::grasp::internal {
using Eigen::Vector3d;

std::vector<Candidate> CylindricalCandidates(Task& task) {
  const CylindricalOptions& options = task.options.cylindrical;
  std::vector<Candidate> candidates;
  const auto axis = UprightAxis(task);
  if (!axis || 2.0 * task.object.axis->radius_m > task.MaxWidth()) return candidates;
  const Vector3d& center = task.object.axis->center_C;
  const Vector3d towards_arm = NormalPart(task.arm_C - center, *axis);
  const double diameter_m = 2.0 * task.object.axis->radius_m;
  const double best = task.options.pitches ? options.pitch_rad : 0.0;
  std::vector<double> pitches{best};
  if (task.options.pitches) pitches.push_back(best - options.second_pitch_rad);
  for (int k = 0; k < options.yaw_steps; ++k) {
    const double yaw = 2.0 * base::kPi * k / options.yaw_steps;
    const View view =
        MakeView(task, task.coarse, center, -*axis, Eigen::AngleAxisd(yaw, *axis) * towards_arm);
    const Band band = MakeBand(task, view, 0.0);
    const std::array middle{0.5 * (view.top_m + view.bottom_m)};
    for (const double pitch : pitches) {
      Aim aim;
      aim.pitch_rad = pitch;
      aim.best_pitch_rad = best;
      // The tool centre on the axis, in the middle of the height; the width is the diameter.
      if (!task.options.centering) aim.width_m = diameter_m;
      const std::size_t before = candidates.size();
      PlaceAtDepths(task, view, band, aim, middle, GraspType::kCylindrical, k, candidates);
      if (task.options.contact_ranking) continue;
      for (std::size_t i = before; i < candidates.size(); ++i) {
        candidates[i].grasp.score = view.thumb_to_arm;  // next to the arm (section 5.2)
      }
    }
  }
  return candidates;
}

}  // namespace rangegrasp::grasp::internal
