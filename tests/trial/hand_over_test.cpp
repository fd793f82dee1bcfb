#include "trial/hand_over.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace rangegrasp::trial {
namespace {

TEST(HandOverUser, PullsWithinTheSpreadOfStraightOutAndNotAlwaysAlike) {
  HandOverOptions options;
  options.pull_spread_rad = base::Deg(20.0);
  const Eigen::Vector3d out_H = Eigen::Vector3d(0.0, 0.8, 0.6);
  base::Rng rng(3);
  double widest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d along = UserFor(options, out_H, rng).direction_H;
    EXPECT_NEAR(along.norm(), 1.0, 1e-12);
    widest = std::max(widest, std::acos(std::min(1.0, along.dot(out_H))));
  }
  EXPECT_LE(widest, base::Deg(20.0) + 1e-6);
  EXPECT_GT(widest, base::Deg(19.0));  // even over the cap, 1 in 10 is beyond 19 deg
}

}  // namespace
}  // namespace rangegrasp::trial
