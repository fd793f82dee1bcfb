#include "trial/judge.h"

#include <algorithm>
#include <map>

namespace rangegrasp::trial {
namespace {

// Definitions: minimum lift height, and maximum final distance from the delivery place.
constexpr double kMinLift_m = 0.1;
constexpr double kDeliveryRadius_m = 0.15;
// "More than half" of the object's and of the target's samples.
constexpr double kHalf = 0.5;
// An object that moved by less was at most brushed. A few times the scan's noise.
constexpr double kMoved_m = 0.005;

// Number of the target's samples that are clear of the table.
std::ptrdiff_t VisibleSamples(const Sensed& sensed, const TargetTruth& target) {
  std::ptrdiff_t visible = 0;
  for (std::size_t v = 0; v < sensed.truth.size(); ++v) {
    const auto& points_W = sensed.observation.views[v].image.points_C;  // in a trial, C is W
    for (std::size_t i = 0; i < points_W.size(); ++i) {
      // False for a sample that was not measured.
      const bool clear = target.table_W.Distance(points_W[i]) > target.clearance_m;
      visible += clear && sensed.truth[v].label[i] == target.label ? 1 : 0;
    }
  }
  return visible;
}

// Number of samples with each object's label; key -1 is the scene.
std::map<int, int> ObjectVotes(const std::vector<geometry::SampleId>& samples,
                               const Sensed& sensed) {
  std::map<int, int> votes;
  for (const auto& id : samples) {
    ++votes[static_cast<int>(sensed.truth[id.view].label[id.sample]) - 1];
  }
  return votes;
}

}  // namespace

DetectionVerdict JudgeDetection(const grasp::Detection& detection, const Sensed& sensed,
                                const TargetTruth& target) {
  DetectionVerdict verdict;
  if (detection.objects.empty()) return verdict;
  const auto& samples = detection.objects.front().samples;
  const auto hits = std::ranges::count_if(samples, [&](const geometry::SampleId& id) {
    return sensed.truth[id.view].label[id.sample] == target.label;
  });
  const std::ptrdiff_t visible = VisibleSamples(sensed, target);
  if (samples.empty() || visible == 0) return verdict;
  verdict.share_of_object = static_cast<double>(hits) / static_cast<double>(samples.size());
  verdict.share_of_target = static_cast<double>(hits) / static_cast<double>(visible);
  verdict.right_target = verdict.share_of_object > kHalf;
  const double needed = detection.objects.front().whole ? kHalf : 0.0;
  verdict.segmented = verdict.share_of_target > needed;
  return verdict;
}

std::optional<int> MainObject(const std::vector<geometry::SampleId>& samples,
                              const Sensed& sensed) {
  const auto votes = ObjectVotes(samples, sensed);
  const auto most =
      std::ranges::max_element(votes, {}, [](const auto& vote) { return vote.second; });
  if (most == votes.end() || most->first < 0) return std::nullopt;
  return most->first;
}

std::optional<int> AimedAt(const grasp::Detection& detection, const Sensed& sensed,
                           const sim::World& world) {
  std::vector<int> there;
  for (int object = 0; object < world.objects(); ++object) {
    if (!world.parked(object)) there.push_back(object);
  }
  if (detection.objects.empty() || there.empty()) return std::nullopt;
  const auto& samples = detection.objects.front().samples;
  auto votes = ObjectVotes(samples, sensed);
  const auto votes_of = [&](int object) { return votes[object]; };
  const int most = *std::ranges::max_element(there, {}, votes_of);
  if (votes[most] > 0) return most;
  Eigen::Vector3d center_W = Eigen::Vector3d::Zero();
  for (const auto& id : samples) {
    center_W += sensed.observation.views[id.view].image.points_C[id.sample];
  }
  center_W /= std::max(1.0, static_cast<double>(samples.size()));
  return *std::ranges::min_element(
      there, {}, [&](int object) { return (world.ObjectCenterOfMass(object) - center_W).norm(); });
}

bool IsAtDelivery(const sim::World& world, int object) {
  if (world.parked(object)) return false;
  const Eigen::Vector3d place_W = world.SitePose("delivery").translation();
  const Eigen::Vector3d offset = world.ObjectCenterOfMass(object) - place_W;
  return offset.head<2>().norm() <= kDeliveryRadius_m;
}

Outcome JudgeExecution(const sim::ExecutionLog& log) {
  if (!log.audit.failed.empty()) return Outcome::kInvalidPhysics;
  if (!(log.lift_height_m >= kMinLift_m) || !log.held_after_lift) return Outcome::kNotLifted;
  if (!log.held_after_carry) return Outcome::kDropped;
  const bool in_place = log.final_distance_m <= kDeliveryRadius_m && log.at_rest &&
                        !log.touched_by_hand && log.on_support;
  return in_place ? Outcome::kDelivered : Outcome::kMisplaced;
}

std::vector<Eigen::Vector3d> CentersOf(const sim::World& world) {
  std::vector<Eigen::Vector3d> centers_W;
  for (int object = 0; object < world.objects(); ++object) {
    centers_W.push_back(world.ObjectCenterOfMass(object));
  }
  return centers_W;
}

OthersVerdict JudgeOthers(const std::vector<Eigen::Vector3d>& before_W, const sim::World& world,
                          int target) {
  OthersVerdict verdict;
  for (int object = 0; object < world.objects(); ++object) {
    if (object == target || world.parked(object)) continue;
    const Eigen::Vector3d center_W = world.ObjectCenterOfMass(object);
    const double way_m = (center_W - before_W.at(static_cast<std::size_t>(object))).norm();
    const bool moved = way_m > kMoved_m;
    verdict.moved += moved ? 1 : 0;
    verdict.brought += moved && IsAtDelivery(world, object) ? 1 : 0;
    verdict.left_table += world.OverTable(center_W) ? 0 : 1;
  }
  return verdict;
}

}  // namespace rangegrasp::trial
