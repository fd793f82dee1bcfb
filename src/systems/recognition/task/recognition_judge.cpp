#include "recognition/task/recognition_judge.h"

#include <algorithm>

#include "trial/judge.h"

namespace rangegrasp::recognition_task {
namespace {

JudgedFind JudgeFind(const recognition::FoundObject& found, const recognition::Library& library,
                     const trial::Sensed& sensed, const sim::World& world) {
  JudgedFind judged;
  judged.found = &found;
  int most = 0;
  for (const auto& [object, votes] : trial::ObjectVotes(found.samples, sensed)) {
    if (votes <= most) continue;
    most = votes;
    judged.truth = object;
  }
  if (judged.truth < 0) return judged;
  judged.named_right = world.object_name(judged.truth) == found.object;
  if (judged.named_right) {
    judged.off = recognition::Difference(found.X_CB, world.ObjectPose(judged.truth),
                                         library.Find(found.object).symmetry);
  }
  return judged;
}

}  // namespace

const JudgedFind* Judgement::OfTarget(int target) const {
  const auto of = std::ranges::find(finds, target, &JudgedFind::truth);
  return of == finds.end() ? nullptr : &*of;
}

Judgement Judge(const std::vector<recognition::FoundObject>& found,
                const recognition::Library& library, const trial::Sensed& sensed,
                const sim::World& world, int target, const Options& options) {
  Judgement judgement;
  for (const auto& one : found) {
    judgement.finds.push_back(JudgeFind(one, library, sensed, world));
  }
  const JudgedFind* of_target = judgement.OfTarget(target);
  if (!of_target) return judgement;
  if (!of_target->named_right) {
    judgement.outcome = Outcome::kWrongObject;
  } else {
    const bool near = of_target->off.distance_m <= options.max_distance_m &&
                      of_target->off.angle_rad <= options.max_angle_rad;
    judgement.outcome = near ? Outcome::kFound : Outcome::kWrongPose;
  }
  return judgement;
}

}  // namespace rangegrasp::recognition_task
