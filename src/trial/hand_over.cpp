#include "trial/hand_over.h"

#include <algorithm>
#include <cmath>

#include "base/words.h"

namespace rangegrasp::trial {

using base::kMm;

void ReadUser(base::YamlMap map, HandOverOptions& options) {
  sim::UserOptions& user = options.user;
  map.Read("wait_s", user.wait_s, 0.0, 60.0, "the hand holds for so long before anyone pulls");
  map.Read("force_n", user.force_N, 0.1, 200.0, "what the pull rises to");
  map.Read("rise_s", user.rise_s, 0.01, 10.0, "in this time");
  map.Read("patience_s", user.patience_s, 0.0, 60.0, "of pulling in vain");
  map.ReadScaled("draw_mm", user.draw_m, kMm, 20.0, 1000.0,
                 "the object is drawn so far once the hand has let go");
  map.ReadScaled("spread_deg", options.pull_spread_rad, base::kDeg, 0.0, 90.0,
                 "the pull's direction is drawn within this of straight out of the open hand");
  map.Finish();
}

sim::UserOptions UserFor(const HandOverOptions& options, const Eigen::Vector3d& out_H,
                         base::Rng& rng) {
  sim::UserOptions user = options.user;
  // Even over the cap of the sphere.
  const double cosine = rng.Uniform(std::cos(options.pull_spread_rad), 1.0);
  const double round = rng.Uniform(0.0, 2.0 * base::kPi);
  const Eigen::Vector3d u = out_H.unitOrthogonal();
  const Eigen::Vector3d v = out_H.cross(u);
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  user.direction_H = cosine * out_H + sine * (std::cos(round) * u + std::sin(round) * v);
  return user;
}

sim::UserOptions UserOf(const HandOverOptions& options, const robot::Robot& robot,
                        std::uint64_t seed) {
  base::Rng rng = StageStream(seed, "user");
  return UserFor(options, robot.hand().X_HG_tip.linear().col(2), rng);
}

std::string HandOverOutcome(const Attempt& attempt) {
  const std::string word(base::Word(attempt.outcome));
  const bool offered = attempt.log && attempt.log->hand_over && attempt.log->held_after_carry;
  if (!offered) return word;
  if (attempt.outcome == Outcome::kInvalidPhysics || attempt.outcome == Outcome::kCrashed) {
    return word;
  }
  const sim::HandOverLog& log = *attempt.log->hand_over;
  if (log.early) return "felt_early";
  if (!log.felt) return "not_felt";
  return log.taken ? kHandedOver : "not_taken";
}

}  // namespace rangegrasp::trial
