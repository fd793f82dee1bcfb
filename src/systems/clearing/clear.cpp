#include "clearing/clear.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "base/stopwatch.h"
#include "base/units.h"

namespace rangegrasp::clearing {
namespace {

// Minimum share of common samples of two scans' objects that are the same: the sensor does not move
// between scans.
constexpr double kSameObject = 0.5;
// Grasps closer to a failed one are similar to it: half the width of a fingertip. The hand's
// compliance makes up for smaller differences.
constexpr double kOtherGrasp_m = 0.010;
constexpr double kOtherGrasp_rad = 15.0 * base::kDeg;

}  // namespace

double SharedSamples(Samples a, Samples b) {
  std::ranges::sort(a);
  std::ranges::sort(b);
  Samples both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  const std::size_t either = a.size() + b.size() - both.size();
  return either == 0 ? 0.0 : static_cast<double>(both.size()) / static_cast<double>(either);
}

// The entry with the largest share of common samples; the first of equals.
const TriedObjects::Entry* TriedObjects::Find(const Samples& object) const {
  const Entry* best = nullptr;
  double best_share = 0.0;
  for (const Entry& entry : entries_) {
    const double share = SharedSamples(entry.samples, object);
    if (share < kSameObject || share <= best_share) continue;
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
  return entry->tries >= tries_per_object_ ? Passed::kTriesUsedUp : entry->passed;
}

int TriedObjects::TriesAt(const Samples& object) const {
  const Entry* entry = Find(object);
  return entry ? entry->tries : 0;
}

std::optional<int> TriedObjects::TurnOf(const Samples& object) const {
  if (StateOf(object) != Passed::kNotYet) return std::nullopt;
  return TriesAt(object);
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

void TriedObjects::PutFailedLast(grasp::Detection& detection) const {
  if (detection.objects.empty()) return;
  const Entry* entry = Find(detection.objects.front().samples);
  if (!entry) return;
  std::ranges::stable_partition(detection.grasps, [&](const grasp::DetectedGrasp& grasp) {
    return std::ranges::none_of(entry->failed_X_CH, [&](const base::Pose& failed) {
      const base::Pose X_moved = failed.inverse() * grasp.X_CH;
      return X_moved.translation().norm() <= kOtherGrasp_m &&
             base::TurnOf(X_moved.linear()).angle() <= kOtherGrasp_rad;
    });
  });
}

namespace {

using trial::Attempt;
using trial::Outcome;
using trial::Sensed;

// Maximum number of attempts per allowed grasp. Attempts that end before a grasp only pass an
// object over. A pile of twelve objects has fewer segments than this.
constexpr int kAttemptsPerGrasp = 20;
// Scans repeated without a possible grasp before a run is given up: noise may have hidden one.
constexpr int kIdleScans = 2;
// An object this far below the table is on the floor.
constexpr double kFloor_m = -0.1;

const Samples& FirstSamples(const Attempt& attempt) {
  return attempt.detected.detection.objects.front().samples;
}

class Run {
 public:
  Run(const trial::Cell& cell, const ClearingOptions& options, sim::World& world,
      std::uint64_t seed, trial::Recorder& recorder)
      : cell_(cell),
        max_grasps_(options.max_grasps > 0 ? options.max_grasps
                                           : options.tries_per_object * world.objects()),
        world_(world),
        seed_(seed),
        recorder_(recorder),
        tried_(options.tries_per_object) {
    for (int i = 0; i < world.objects(); ++i) {
      result_.objects.emplace_back().object = world.object_name(i);
    }
  }

  Clearing Go() {
    std::optional<Stop> stop;
    while (!stop) stop = Next();
    result_.stop = *stop;
    DescribeLeft();
    recorder_.SetAttempt(0);
    recorder_.KeepMoments({"end"});
    recorder_.Take("end", world_);
    return std::move(result_);
  }

 private:
  ObjectEnd& EndOf(int object) { return result_.objects[static_cast<std::size_t>(object)]; }

  // Makes one attempt. @return why the run ends, if it does.
  std::optional<Stop> Next() {
    if (!sensed_) Scan();
    recorder_.SetAttempt(static_cast<int>(result_.steps.size()) + 1);
    Step step;
    step.scan = result_.scans;
    step.attempt = Try();
    const Attempt& attempt = step.attempt;
    const bool detector_failed = attempt.outcome == Outcome::kDetectorFailed;
    if (detector_failed || attempt.outcome == Outcome::kCrashed) {
      result_.detail = attempt.stage + ": " + attempt.detail;
      result_.steps.push_back(std::move(step));
      return detector_failed ? Stop::kDetectorFailed : Stop::kCrashed;
    }
    last_ = attempt.detected.detection;
    result_.perceived = last_.objects.size();
    // No object is left, so there is nothing to measure: ground truth ends the run.
    const bool empty = !last_.objects.empty() && !attempt.target;
    if (empty || last_.objects.empty() || !attempt.detected.has_turn) {
      result_.steps.push_back(std::move(step));
      return empty ? Stop::kEmpty : NothingToTake();
    }
    step.try_number = tried_.TriesAt(FirstSamples(attempt)) + 1;
    if (attempt.log) {
      AfterGrasp(step);
    } else {
      tried_.PassOver(FirstSamples(attempt),
                      attempt.outcome == Outcome::kNoPath ? Passed::kNoPath : Passed::kNoGrasp);
    }
    result_.steps.push_back(std::move(step));
    if (!trial::IsFinite(world_)) return Stop::kBrokenPhysics;
    const int attempts = static_cast<int>(result_.steps.size());
    const bool enough =
        result_.Grasps() >= max_grasps_ || attempts >= kAttemptsPerGrasp * max_grasps_;
    return enough ? std::optional(Stop::kMaxGrasps) : std::nullopt;
  }

  void Scan() {
    base::Stopwatch watch;
    const auto number = static_cast<std::uint64_t>(++result_.scans);
    sensed_ = trial::Look(cell_, world_, base::DeriveSeed(base::DeriveSeed(seed_, "look"), number));
    result_.scan_s += watch.Seconds();
  }

  Attempt Try() {
    return trial::RunAttempt(
        cell_, world_,
        {.seed = base::DeriveSeed(base::DeriveSeed(seed_, "attempt"), result_.steps.size()),
         .sensed = &*sensed_,
         .detector = &recorder_.detector(),
         .turn = [this](const Samples& samples) { return tried_.TurnOf(samples); },
         .prefer = [this](grasp::Detection& detection) { tried_.PutFailedLast(detection); },
         .observer = recorder_.Observer()});
  }

  // No object in the current scan may be taken: requests a new scan or ends the run.
  std::optional<Stop> NothingToTake() {
    if (last_.objects.empty()) return Stop::kNothingPerceived;
    if (idle_++ >= kIdleScans) return WhyNothing();
    sensed_.reset();
    tried_.SceneChanged();
    return std::nullopt;
  }

  Stop WhyNothing() const {
    Stop why = Stop::kNothingGraspable;
    for (const auto& object : last_.objects) {
      const Passed passed = tried_.StateOf(object.samples);
      if (passed == Passed::kTriesUsedUp) return Stop::kTriesUsedUp;
      if (passed == Passed::kNoPath) why = Stop::kNoPath;
    }
    return why;
  }

  void AfterGrasp(Step& step) {
    const Attempt& attempt = step.attempt;
    step.felt = attempt.log->aperture.feels_object_after_carry;
    result_.homing_s += trial::GoHome(cell_, world_);
    TakeAway(step);
    ++EndOf(attempt.log->target).grasps;
    if (step.felt) {
      tried_.Taken(FirstSamples(attempt));
    } else {
      tried_.Failed(FirstSamples(attempt), attempt.Grasp()->X_CH);
    }
    tried_.SceneChanged();
    idle_ = 0;
    sensed_.reset();
  }

  void TakeAway(Step& step) {
    for (int object = 0; object < world_.objects(); ++object) {
      if (!trial::IsAtDelivery(world_, object)) continue;
      const bool own = object == step.attempt.log->target;
      const bool delivered = own && step.attempt.outcome == Outcome::kDelivered;
      EndOf(object).fate = delivered ? Fate::kDelivered : Fate::kBrought;
      if (!delivered) EndOf(object).why = own ? base::Word(step.attempt.outcome) : "beside_another";
      world_.ParkObject(object);
      step.taken_away.push_back(object);
    }
  }

  void DescribeLeft() {
    std::map<int, Passed> seen;
    if (sensed_) {
      for (const auto& object : last_.objects) {
        const auto main = trial::MainObject(object.samples, *sensed_);
        if (main) seen[*main] = std::max(seen[*main], tried_.StateOf(object.samples));
      }
    }
    for (int object = 0; object < world_.objects(); ++object) {
      if (!world_.parked(object)) EndOf(object).why = WhyLeft(object, seen);
    }
  }

  std::string_view WhyLeft(int object, const std::map<int, Passed>& seen) const {
    if (result_.stop == Stop::kBrokenPhysics) return base::Word(result_.stop);
    const Eigen::Vector3d center_W = world_.ObjectCenterOfMass(object);
    if (!world_.OverTable(center_W) || world_.ObjectBottom(object) < kFloor_m) return "off_table";
    const auto workspace = trial::WorkspaceOf(cell_.robot, cell_.options.workspace_margin_m);
    if (!workspace.Contains(center_W)) return "out_of_workspace";
    if (!sensed_) return base::Word(result_.stop);
    const auto found = seen.find(object);
    return found == seen.end() ? "not_perceived" : base::Word(found->second);
  }

  const trial::Cell& cell_;
  const int max_grasps_;
  sim::World& world_;
  const std::uint64_t seed_;
  trial::Recorder& recorder_;
  TriedObjects tried_;
  Clearing result_;
  std::optional<Sensed> sensed_;
  grasp::Detection last_;  // in the current scan
  int idle_ = 0;
};

}  // namespace

int Clearing::Grasps() const {
  return static_cast<int>(
      std::ranges::count_if(steps, [](const Step& step) { return step.attempt.log.has_value(); }));
}

int Clearing::Count(Fate fate) const {
  return static_cast<int>(std::ranges::count(objects, fate, &ObjectEnd::fate));
}

Clearing ClearTable(const trial::Cell& cell, const ClearingOptions& options, sim::World& world,
                    std::uint64_t seed, trial::Recorder& recorder) {
  return Run(cell, options, world, seed, recorder).Go();
}

}  // namespace rangegrasp::clearing
