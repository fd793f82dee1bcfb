#include "seam/stitching/internal/control_unit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::seam {
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

// The effect of rotation given in the dissertation: 10 degrees move the line by 14 mm.
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
  // Braking before the corner stays within the head's acceleration limit.
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

constexpr double kAhead_m = 0.08;

HeadState At(double x_m, double y_m, double heading_rad) {
  HeadState head;
  head.needle = {x_m, y_m};
  head.heading_rad = heading_rad;
  return head;
}

Correction Packet(double time_s, double edge_x_m, std::optional<bool> sure = {}) {
  Correction correction;
  correction.sure = sure;
  correction.time_s = time_s;
  correction.valid = true;
  correction.edge_x_m = edge_x_m;
  return correction;
}

TEST(ControlUnit, PosesBetweenControlStepsLieOnTheLineBetweenTheirs) {
  ControlUnit unit({}, kAhead_m, 62.0);
  unit.Record(At(0.0, 0.0, 0.1));
  unit.Record(At(1e-3, 2e-3, 0.3));
  unit.Record(At(5e-3, 4e-3, 0.3));
  for (const double t : {0.0, 0.25, 0.8, 1.0}) {
    const HeadState first = unit.PoseAt(t * kControlPeriod_s);
    EXPECT_NEAR(first.needle.x(), t * 1e-3, 1e-15);
    EXPECT_NEAR(first.needle.y(), t * 2e-3, 1e-15);
    EXPECT_NEAR(first.heading_rad, 0.1 + t * 0.2, 1e-12);
    EXPECT_NEAR(unit.PoseAt((1.0 + t) * kControlPeriod_s).needle.x(), 1e-3 + t * 4e-3, 1e-15);
  }
  // Before the first and after the last record the pose is held.
  EXPECT_EQ(unit.PoseAt(-1.0).needle.y(), 0.0);
  EXPECT_EQ(unit.PoseAt(1.0).needle.y(), 4e-3);
}

// The line's middle is 80 mm ahead along the heading, and the line is perpendicular to it.
TEST(ControlUnit, AnEdgePointIsWhereTheLineWasWhenItWasSeen) {
  ControlUnit unit({}, kAhead_m, 62.0);
  unit.Record(At(1e-3, 0.05, 0.2));
  unit.Record(At(9e-3, 0.09, 0.6));
  const auto point = unit.Receive(Packet(0.0, 3e-3));
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->x_m, 1e-3 - kAhead_m * std::sin(0.2) + 3e-3 * std::cos(0.2), 1e-12);
  EXPECT_NEAR(point->y_m, 0.05 + kAhead_m * std::cos(0.2) + 3e-3 * std::sin(0.2), 1e-12);
}

TEST(ControlUnit, IgnoresAPacketThatMovesTheEdgeFurtherThanTheHeadCouldGo) {
  ControlUnit unit({}, kAhead_m, 62.0);
  for (int i = 0; i <= 100; ++i) unit.Record(At(0.0, 0.3e-3 * i, 0.0));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(unit.Receive(Packet(0.1 * i, 0.0)));
  EXPECT_FALSE(unit.Receive(Packet(0.4, 0.038)));
  EXPECT_FALSE(unit.Receive(Packet(0.4, -0.038)));
  // A half circle of radius 20 mm begins with 10.5 mm sideways over 3 mm along the track.
  EXPECT_TRUE(unit.Receive(Packet(0.5, -0.0105)));
  EXPECT_TRUE(unit.Receive(Packet(0.6, 0.0)));
}

TEST(ControlUnit, PacketsWithoutAPositionTellNone) {
  ControlUnit unit({}, kAhead_m, 62.0);
  unit.Record({});
  EXPECT_FALSE(unit.Receive({}));
}

TEST(ControlUnit, AnObstacleStopsTheHeadWhereItIs) {
  ControlUnit unit({}, kAhead_m, 62.0);
  unit.Record(At(-5e-3, 0.01, 0.1));
  EXPECT_GT(unit.Command().velocity.norm(), 0.0);
  EXPECT_FALSE(unit.end());
  Correction correction;
  correction.stop = StopReason::kObstacle;
  unit.Receive(correction);
  const HeadCommand command = unit.Command();
  EXPECT_EQ(command.velocity.norm(), 0.0);
  EXPECT_EQ(command.heading_rad, 0.1);
  EXPECT_EQ(unit.end(), TrackEnd::kObstacle);
}

// A unit that moved at 30 mm/s along a straight edge, sure for one second and doubtful for another.
ControlUnit BehindADoubtfulStretch() {
  ControlUnit unit({}, kAhead_m, 62.0);
  for (int i = 0; i <= 200; ++i) {
    unit.Record(At(-5e-3, 0.3e-3 * i, 0.0));
    if (i == 0) unit.Command();
    if (i % 10 == 0) unit.Receive(Packet(i * kControlPeriod_s, 0.0, i <= 100));
  }
  Correction end;
  end.time_s = 2.0;
  end.stop = StopReason::kMatEnd;
  unit.Receive(end);
  return unit;
}

std::optional<TrackEnd> EndAt(double y_m, ControlUnit unit) {
  unit.Record(At(-5e-3, y_m, 0.0));
  unit.Command();
  return unit.end();
}

TEST(ControlUnit, AMatEndLiesWhereTheEdgeWasLastSeenBeyondDoubt) {
  const ControlUnit unit = BehindADoubtfulStretch();
  const double sure_y = 0.03 + kAhead_m;
  EXPECT_FALSE(EndAt(sure_y - 6e-3, unit));
  EXPECT_EQ(EndAt(sure_y - 5e-3, unit), TrackEnd::kMatEnd);
}

TEST(ControlUnit, GoesOnIfTheEdgeIsThereBeyondDoubtAfterAMatEndThatIsNoLongerTold) {
  ControlUnit doubtful = BehindADoubtfulStretch();
  doubtful.Receive(Packet(2.0, 0.0, false));
  EXPECT_EQ(EndAt(0.105, doubtful), TrackEnd::kMatEnd);
  ControlUnit sure = BehindADoubtfulStretch();
  sure.Receive(Packet(2.0, 0.0, true));
  EXPECT_FALSE(EndAt(0.105, sure));
}

}  // namespace
}  // namespace rangegrasp::seam
