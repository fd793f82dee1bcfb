#include "seam/stitching/internal/head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::stitching::internal {
namespace {

constexpr double kTiny = 1e-12;

HeadOptions RandomLimits(base::Rng& rng) {
  HeadOptions limits;
  limits.speed_m_s = rng.Uniform(0.005, 0.3);
  limits.max_lateral_speed_m_s = rng.Uniform(0.005, 0.3);
  limits.max_acceleration_m_s2 = rng.Uniform(0.05, 3.0);
  limits.max_rotation_rad_s = rng.Uniform(0.05, 2.0);
  limits.max_rotation_acceleration_rad_s2 = rng.Uniform(0.2, 10.0);
  return limits;
}

TEST(Head, NoCommandBreaksItsLimits) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    base::Rng rng(seed);
    const HeadOptions limits = RandomLimits(rng);
    HeadState head;
    for (int i = 0; i < 300; ++i) {
      HeadCommand command;
      command.velocity = {rng.Normal(), rng.Normal()};
      command.heading_rad = rng.Normal();
      const HeadState next = Move(head, command, limits);
      const double dt = kControlPeriod_s;
      EXPECT_LE(next.velocity.norm(), limits.speed_m_s + kTiny);
      EXPECT_LE(std::abs(next.velocity.x()), limits.max_lateral_speed_m_s + kTiny);
      EXPECT_LE((next.velocity - head.velocity).norm(), limits.max_acceleration_m_s2 * dt + kTiny);
      EXPECT_LE(std::abs(next.rotation_rad_s), limits.max_rotation_rad_s + kTiny);
      EXPECT_LE(std::abs(next.rotation_rad_s - head.rotation_rad_s),
                limits.max_rotation_acceleration_rad_s2 * dt + kTiny);
      EXPECT_LT((next.needle - head.needle - next.velocity * dt).norm(), kTiny);
      head = next;
    }
  }
}

TEST(Head, TurnsToAHeadingWithoutSwinging) {
  HeadState head;
  double most = 0.0;
  for (int i = 0; i < 500; ++i) {
    head = Move(head, {Point::Zero(), 0.5}, {});
    most = std::max(most, head.heading_rad);
  }
  EXPECT_NEAR(head.heading_rad, 0.5, 1e-3);
  EXPECT_LT(most, 0.5 + 1e-3);
}

TEST(Head, ShiftsOnlyIfItMayNotRotate) {
  HeadOptions options;
  options.rotate = false;
  const HeadState head = Move({}, {Point(0.01, 0.02), 1.0}, options);
  EXPECT_EQ(head.heading_rad, 0.0);
  EXPECT_GT(head.needle.y(), 0.0);
}

// The rotation's effect that the dissertation names: 10 degrees move the line by 14 mm.
TEST(Head, TenDegreesMoveALine80MmAheadBy14Mm) {
  HeadState head;
  head.heading_rad = 10.0 * base::kPi / 180.0;
  EXPECT_NEAR(head.Line(0.08).x_m, -0.014, 0.5e-3);
  EXPECT_EQ(head.Line(0.08).heading_rad, head.heading_rad);
}

TEST(Head, ASafeSpeedLeavesRoomToReactAndToBrake) {
  const HeadOptions options;
  for (const double reaction_s : {0.0, 0.1, 0.5}) {
    const double v = SafeSpeed(0.07, reaction_s, options);
    EXPECT_NEAR(BrakingSpeed(0.07 - v * reaction_s, options), v, 1e-9);
  }
}

TEST(Route, IsSlowWhereItBends) {
  std::vector<Point> corner;
  for (int i = 0; i <= 100; ++i) corner.emplace_back(0.0, i * 1e-3);
  for (int i = 1; i <= 100; ++i) corner.emplace_back(-i * 1e-3, 0.1 + i * 0.1e-3);
  const HeadOptions options;
  const Route route(corner, 1.0, options);
  EXPECT_NEAR(route.Nearest({0.0, 0.05}).speed_m_s, options.speed_m_s, 1e-9);
  const double slow = route.Nearest({0.0, 0.1}).speed_m_s;
  EXPECT_LT(slow, 0.9 * options.speed_m_s);
  EXPECT_GT(slow, 0.1 * options.speed_m_s);
  // Braking into the corner costs no more than the head has.
  for (double y = 0.09; y < 0.0995; y += 0.5e-3) {
    const double v0 = route.Nearest({0.0, y}).speed_m_s;
    const double v1 = route.Nearest({0.0, y + 0.5e-3}).speed_m_s;
    EXPECT_LE((v0 * v0 - v1 * v1) / (2.0 * 0.5e-3), options.max_acceleration_m_s2);
  }
}

TEST(Route, IsNoFasterAcrossTheTrackThanTheHeadMayBe) {
  const std::vector<Point> line = {{0.0, 0.0}, {0.1, 0.1}};
  HeadOptions options;
  options.max_lateral_speed_m_s = 0.1 * options.speed_m_s;
  const Route route(line, 1.0, options);
  const double across = route.Nearest({0.05, 0.05}).speed_m_s / std::sqrt(2.0);
  EXPECT_LE(across, options.max_lateral_speed_m_s);
  EXPECT_GT(across, 0.9 * options.max_lateral_speed_m_s);
}

TEST(Route, TellsLengthsAlongItself) {
  const std::vector<Point> line = {{0.0, 0.0}, {0.03, 0.04}};
  const Route route(line, 1.0, {});
  const Route::Place start = route.Nearest({0.0, 0.0});
  EXPECT_NEAR(route.LengthTo(start, 0.02), 0.025, 1e-9);
  EXPECT_TRUE(std::isinf(route.LengthTo(start, 0.05)));
  EXPECT_NEAR((route.AtDistance(start, 0.02) - Point(0.012, 0.016)).norm(), 0.0, 0.3e-3);
  EXPECT_LT((route.Nearest({0.02, 0.01}).point - Point(0.012, 0.016)).norm(), 1e-9);
}

}  // namespace
}  // namespace rangegrasp::stitching::internal
