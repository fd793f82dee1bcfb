#include "grasp/internal/cylindrical_candidates.h"

#include <algorithm>
#include <array>

#include "core/units.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

/// As published: tool centre on the axis, in the middle of the height or as deep as hand and table
/// allow.
Candidate Published(Task& task, const View& view) {
  const double diameter = 2.0 * task.object.axis->radius_m;
  const std::size_t open = task.hand.IndexAtGap(diameter + task.options.cylindrical.opening_m);
  const std::size_t held = task.hand.IndexAtGap(diameter);
  const std::size_t last = std::min(held + 1, task.hand.states.size() - 1);
  const double limit = DepthLimit(task, view, task.profiles.LowerSide(0.0, open),
                                  ReachDown(task, view, 0.0, open, last), 0.0, 0.0);
  const Vector3d origin(0.0, 0.0, std::min(limit, 0.5 * (view.top_m + view.bottom_m)));
  Candidate candidate = MakeCandidate(task, view, origin, origin, 0.0, GraspType::kCylindrical);
  SetStates(task, open, held, diameter, candidate);
  candidate.grasp.score = view.thumb_to_arm;
  return candidate;
}

}  // namespace

std::vector<Candidate> CylindricalCandidates(Task& task) {
  const CylindricalOptions& options = task.options.cylindrical;
  std::vector<Candidate> candidates;
  const auto axis = UprightAxis(task);
  if (!axis || 2.0 * task.object.axis->radius_m > task.MaxWidth()) return candidates;
  const Vector3d& center = task.object.axis->center_C;
  const Vector3d towards_arm = NormalPart(task.arm_C - center, *axis);
  const double best = options.pitch_rad;
  for (int k = 0; k < options.yaw_steps; ++k) {
    const double yaw = 2.0 * core::kPi * k / options.yaw_steps;
    const View view =
        MakeView(task, task.coarse, center, -*axis, Eigen::AngleAxisd(yaw, *axis) * towards_arm);
    if (!task.options.refine) {
      candidates.push_back(Published(task, view));
      candidates.back().group = k;
      continue;
    }
    const Band band = MakeBand(task, view, 0.0);
    const std::array middle{0.5 * (view.top_m + view.bottom_m)};
    for (const double pitch : {best, best - options.second_pitch_rad}) {
      PlaceAtDepths(task, view, band, {pitch, best}, middle, GraspType::kCylindrical, k,
                    candidates);
    }
  }
  return candidates;
}

}  // namespace rangegrasp::grasp::internal
