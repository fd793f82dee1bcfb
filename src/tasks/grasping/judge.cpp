#include "tasks/grasping/judge.h"

#include <algorithm>

namespace rangegrasp::tasks::grasping {
namespace {

// Definitions: lifted by at least this, and at the end within this of the delivery place.
constexpr double kMinLift_m = 0.1;
constexpr double kDeliveryRadius_m = 0.15;
// "More than half", of the object's samples and of the target's.
constexpr double kHalf = 0.5;

}  // namespace

DetectionVerdict JudgeDetection(const Detected& detected,
                                const std::vector<sensing::ScanTruth>& truth,
                                std::uint32_t target_label) {
  DetectionVerdict verdict;
  const auto is_target = [&](const geometry::SampleId& id) {
    return truth[id.view].label[id.sample] == target_label;
  };
  if (detected.detection.objects.empty()) return verdict;
  const auto& samples = detected.detection.objects.front().samples;
  const auto hits = std::count_if(samples.begin(), samples.end(), is_target);
  const auto visible = std::count_if(detected.kept.begin(), detected.kept.end(), is_target);
  if (samples.empty() || visible == 0) return verdict;
  verdict.share_of_object = static_cast<double>(hits) / static_cast<double>(samples.size());
  verdict.share_of_target = static_cast<double>(hits) / static_cast<double>(visible);
  verdict.right_target = verdict.share_of_object > kHalf;
  verdict.segmented = verdict.share_of_target > kHalf;
  return verdict;
}

Outcome JudgeExecution(const sim::ExecutionLog& log) {
  if (!log.audit.failed.empty()) return Outcome::kInvalidPhysics;
  if (!(log.lift_height_m >= kMinLift_m) || !log.held_after_lift) return Outcome::kNotLifted;
  if (!log.held_after_carry) return Outcome::kDropped;
  const bool in_place = log.final_distance_m <= kDeliveryRadius_m && log.at_rest &&
                        !log.touched_by_hand && log.on_support;
  return in_place ? Outcome::kDelivered : Outcome::kMisplaced;
}

}  // namespace rangegrasp::tasks::grasping
