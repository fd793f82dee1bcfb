#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "grasp/internal/candidates.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kOpen_m = 0.020;  // wider than the diameter, before closing

/// As published: tool centre on the axis, in the middle of the height or as deep as hand and table
/// allow.
Candidate Published(Task& task, const View& view) {
  const double diameter = 2.0 * task.object.axis->radius_m;
  const std::size_t open = StateAtGap(task.hand, diameter + kOpen_m);
  const std::size_t held = StateAtGap(task.hand, diameter);
  const std::size_t last = std::min(held + 1, task.hand.states.size() - 1);
  const double limit = std::min(TableLimit(view, ReachDown(task, view, 0.0, open, last), 0.0, 0.0,
                                           task.options.table_clearance_m),
                                DescentLimit(view, task.profiles.LowerSide(0.0, open), 0.0, 0.0,
                                             task.options.object_clearance_m));
  const Vector3d origin(0.0, 0.0, std::min(limit, 0.5 * (view.top_m + view.bottom_m)));
  Candidate candidate = MakeCandidate(task, view, origin, origin, 0.0, GraspType::kCylindrical);
  candidate.open_state = candidate.narrow_state = open;
  candidate.held_state = held;
  candidate.grasp.opening_m = task.hand.states[open].gap_m;
  candidate.grasp.width_m = diameter;
  candidate.grasp.score = view.thumb_to_arm;
  return candidate;
}

}  // namespace

std::vector<Candidate> CylindricalCandidates(Task& task) {
  std::vector<Candidate> candidates;
  const auto axis = UprightAxis(task);
  if (!axis || 2.0 * task.object.axis->radius_m > task.MaxWidth()) return candidates;
  const Vector3d& center = task.object.axis->center_C;
  const Vector3d towards_arm = NormalPart(task.arm_C - center, *axis);
  const double best = task.options.cylinder_pitch_rad;
  for (int k = 0; k < task.options.yaw_steps; ++k) {
    const double yaw = 2.0 * core::kPi * k / task.options.yaw_steps;
    const View view =
        MakeView(task, task.coarse, center, -*axis, Eigen::AngleAxisd(yaw, *axis) * towards_arm);
    if (!task.options.refine) {
      candidates.push_back(Published(task, view));
      candidates.back().group = k;
      continue;
    }
    const Band band = MakeBand(task, view, 0.0);
    for (const double pitch : {best, best - core::Deg(5.0)}) {
      PlaceAtDepths(task, view, band, {pitch, best}, {0.5 * (view.top_m + view.bottom_m)},
                    GraspType::kCylindrical, k, candidates);
    }
  }
  return candidates;
}

}  // namespace rangegrasp::grasp::internal
