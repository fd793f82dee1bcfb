#include "grasp/internal/lateral_candidates.h"

#include <array>
#include <cmath>

#include "base/units.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

struct SideApproach {
  Vector3d approach;
  double ahead;  ///< cosine between it, seen from above, and the arm's way to the object
};

/// Away from the arm, level or a little downwards, and turned to both sides.
std::vector<SideApproach> SideApproaches(const Task& task) {
  const LateralOptions& options = task.options.lateral;
  const Vector3d away = NormalPart(task.com_C - task.arm_C, task.up_C);
  std::vector<SideApproach> approaches;
  for (const double down : options.downwards_rad) {
    for (int k = -options.turns_each_way; k <= options.turns_each_way; ++k) {
      const double turn = k * options.turn_rad;
      const Vector3d level = Eigen::AngleAxisd(turn, task.up_C) * away;
      approaches.push_back({std::cos(down) * level - std::sin(down) * task.up_C, std::cos(turn)});
    }
  }
  return approaches;
}

/// Along y, which is upright, or nearly so, with a level closing direction: from the centre of
/// mass up. Where the hand would be in the table it finds no place.
std::vector<double> Heights(const Task& task, const View& view) {
  const LateralOptions& options = task.options.lateral;
  const double sign = view.up.y() > 0.0 ? 1.0 : -1.0;
  const double top = sign > 0.0 ? view.y_max_m : -view.y_min_m;
  std::vector<double> heights;
  for (int k = 0; k < options.heights; ++k) {
    const double up = sign * view.com.y() + k * options.height_step_m;
    if (up <= top - task.options.power.end_m) heights.push_back(sign * up);
  }
  return heights;
}

}  // namespace

std::vector<Candidate> LateralCandidates(Task& task) {
  const double pitch = task.options.pitches ? task.options.power.pitch_rad : 0.0;
  std::vector<Candidate> candidates;
  int group = 0;
  for (const auto& [approach, ahead] : SideApproaches(task)) {
    for (const double side : {1.0, -1.0}) {
      View view =
          MakeView(task, task.coarse, task.com_C, approach, side * task.up_C.cross(approach));
      // Next to the arm is here the side that the hand comes from, not the thumb's.
      view.thumb_to_arm = ahead;
      const std::array depths{view.com.z(), 0.5 * (view.com.z() + view.bottom_m)};
      for (const double y : Heights(task, view)) {
        PlaceAtDepths(task, view, MakeBand(task, view, y), {pitch, pitch}, depths,
                      GraspType::kPower, group, candidates);
      }
      ++group;
    }
  }
  std::erase_if(candidates, [&](const Candidate& candidate) {
    const Vector3d off = candidate.grasp.X_CG.translation() - task.com_C;
    const double lever_m = (off - off.dot(task.up_C) * task.up_C).norm();
    return lever_m > task.options.lateral.max_lever_m ||
           candidate.grasp.contact_angle_rad > task.options.friction_cone_rad;
  });
  return candidates;
}

}  // namespace rangegrasp::grasp::internal
