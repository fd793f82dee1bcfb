#include "clearing/tried_objects.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>

namespace rangegrasp::clearing {

double SharedSamples(Samples a, Samples b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  Samples both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  const std::size_t either = a.size() + b.size() - both.size();
  return either == 0 ? 0.0 : static_cast<double>(both.size()) / static_cast<double>(either);
}

// The one that has the most in common; the first of equals.
const TriedObjects::Entry* TriedObjects::Find(const Samples& object) const {
  const Entry* best = nullptr;
  double best_share = 0.0;
  for (const Entry& entry : entries_) {
    const double share = SharedSamples(entry.samples, object);
    if (share < options_->same_object_share || share <= best_share) continue;
    best_share = share;
    best = &entry;
  }
  return best;
}

TriedObjects::Entry& TriedObjects::FindOrAdd(const Samples& object) {
  const Entry* found = Find(object);
  Entry& entry =
      found ? entries_[static_cast<std::size_t>(found - entries_.data())] : entries_.emplace_back();
  entry.samples = object;
  return entry;
}

Passed TriedObjects::StateOf(const Samples& object) const {
  const Entry* entry = Find(object);
  if (!entry) return Passed::kNotYet;
  return entry->tries >= options_->tries_per_object ? Passed::kTriesUsedUp : entry->passed;
}

int TriedObjects::TriesAt(const Samples& object) const {
  const Entry* entry = Find(object);
  return entry ? entry->tries : 0;
}

std::optional<int> TriedObjects::TurnOf(const Samples& object) const {
  if (!MayBeTaken(object)) return std::nullopt;
  return options_->retry == Retry::kAfterOthers ? TriesAt(object) : 0;
}

void TriedObjects::PassOver(const Samples& object, Passed why) { FindOrAdd(object).passed = why; }

void TriedObjects::Failed(const Samples& object, const base::Pose& X_CH) {
  Entry& entry = FindOrAdd(object);
  ++entry.tries;
  entry.failed_X_CH.push_back(X_CH);
}

void TriedObjects::Taken(const Samples& object) {
  const Entry* entry = Find(object);
  if (entry) entries_.erase(entries_.begin() + (entry - entries_.data()));
}

void TriedObjects::SceneChanged() {
  for (Entry& entry : entries_) entry.passed = Passed::kNotYet;
}

bool TriedObjects::LikeFailed(const Entry& entry, const base::Pose& X_CH) const {
  return std::any_of(
      entry.failed_X_CH.begin(), entry.failed_X_CH.end(), [&](const base::Pose& failed) {
        const base::Pose X_moved = failed.inverse() * X_CH;
        return X_moved.translation().norm() <= options_->other_grasp_m &&
               Eigen::AngleAxisd(X_moved.linear()).angle() <= options_->other_grasp_rad;
      });
}

void TriedObjects::PutFailedLast(grasp::Detection& detection) const {
  if (detection.objects.empty()) return;
  const Entry* entry = Find(detection.objects.front().samples);
  if (!entry) return;
  std::stable_partition(detection.grasps.begin(), detection.grasps.end(),
                        [&](const grasp::DetectedGrasp& g) { return !LikeFailed(*entry, g.X_CH); });
}

}  // namespace rangegrasp::clearing
