#include "cylinders/demo/demo_run.h"

#include <algorithm>
#include <cmath>

#include "base/words.h"
#include "cylinders/demo/demo_report.h"
#include "trial/between.h"

namespace rangegrasp::demo {
namespace {

/// The models of cylinders are drawn round the middle of their height.
FoundError ErrorOf(const cylinders::FoundCylinder& found, const base::Pose& X_WO) {
  const cylinders::Cylinder& c = found.cylinder_C;
  const Eigen::Vector3d axis_W = X_WO.linear().col(2);
  const Eigen::Vector3d off = c.center - X_WO.translation();
  const double along_m = off.dot(axis_W);
  return {.lies = found.lies,
          .from_rim = found.from_rim,
          .length_seen_m = found.length_seen_m,
          .axis_rad = std::acos(std::min(1.0, std::abs(axis_W.dot(c.axis)))),
          .along_m = std::abs(along_m),
          .across_m = (off - along_m * axis_W).norm()};
}

std::uint64_t SeedOfTry(std::uint64_t seed, int number) {
  if (number == 1) return seed;
  return base::DeriveSeed(base::DeriveSeed(seed, "try"), static_cast<std::uint64_t>(number));
}

/// Truth: the object that a try was about.
std::optional<int> ObjectOf(const trial::Attempt& attempt) {
  return attempt.log ? std::optional(attempt.log->target) : attempt.target;
}

class Run {
 public:
  Run(const Options& options, const trial::Cell& cell, std::size_t wanted, int target,
      sim::World& world, const Viewers& viewers)
      : options_(options),
        cell_(cell),
        wanted_(wanted),
        target_(target),
        world_(world),
        viewers_(viewers) {}

  Try Once(std::uint64_t seed) const {
    Try one;
    const base::Pose X_WO = world_.ObjectPose(target_);
    const auto see = [&](const cylinders::CylinderScene& scene,
                         const geometry::Observation& observation) {
      const auto found = std::ranges::find_if(
          scene.cylinders, [&](const auto& cylinder) { return cylinder.given == wanted_; });
      if (found != scene.cylinders.end()) one.found = ErrorOf(*found, X_WO);
      if (viewers_.cylinders) viewers_.cylinders(scene, observation);
    };
    const auto detector = MakeDemoDetector(options_, cell_.robot, wanted_, see);
    trial::AttemptOptions attempt;
    attempt.seed = seed;
    attempt.detector = detector.get();
    attempt.observer = viewers_.execution;
    if (options_.demo.delivery == Delivery::kHandOver) {
      attempt.user = trial::UserOf(options_.demo.hand_over, cell_.robot, seed);
    }
    one.attempt = trial::RunAttempt(cell_, world_, attempt);
    one.outcome = Judged(one.attempt);
    return one;
  }

  void GoHome() const { trial::GoHome(cell_, world_); }

 private:
  std::string Judged(const trial::Attempt& attempt) const {
    const bool none = attempt.detected.detection.objects.empty();
    const auto object = ObjectOf(attempt);
    if (!none && object && *object != target_) {
      return std::string(base::Word(trial::Outcome::kWrongTarget));
    }
    return OutcomeOf(attempt, options_.demo.delivery);
  }

  const Options& options_;
  const trial::Cell& cell_;
  std::size_t wanted_;
  int target_;
  sim::World& world_;
  const Viewers& viewers_;
};

}  // namespace

bool KnowsItFailed(const trial::Attempt& attempt, Delivery delivery) {
  if (attempt.outcome == trial::Outcome::kCrashed) return false;
  if (!attempt.log) return true;
  if (delivery == Delivery::kHandOver) return !attempt.log->hand_over;
  return !attempt.log->aperture.holds_after_carry;
}

std::vector<Try> RunDemo(const Options& options, const trial::Cell& cell, std::size_t wanted,
                         int target, std::uint64_t seed, sim::World& world,
                         const Viewers& viewers) {
  const Run run(options, cell, wanted, target, world, viewers);
  std::vector<Try> tries;
  for (int number = 1; number <= options.demo.max_tries; ++number) {
    if (number > 1) run.GoHome();
    if (viewers.on_try) viewers.on_try(number);
    tries.push_back(run.Once(SeedOfTry(seed, number)));
    if (!KnowsItFailed(tries.back().attempt, options.demo.delivery)) break;
  }
  return tries;
}

}  // namespace rangegrasp::demo
