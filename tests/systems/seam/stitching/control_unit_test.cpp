#include "seam/stitching/internal/control_unit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace rangegrasp::stitching::internal {
namespace {

constexpr double kAhead_m = 0.08;

HeadState At(double x_m, double y_m, double heading_rad) {
  HeadState head;
  head.needle = {x_m, y_m};
  head.heading_rad = heading_rad;
  return head;
}

std::string Packet(double time_s, double edge_x_m, std::optional<bool> sure = {}) {
  Correction correction;
  correction.sure = sure;
  correction.time_s = time_s;
  correction.valid = true;
  correction.edge_x_m = edge_x_m;
  return ToXml(correction);
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
  // Before the first and after the last there is nothing to go on.
  EXPECT_EQ(unit.PoseAt(-1.0).needle.y(), 0.0);
  EXPECT_EQ(unit.PoseAt(1.0).needle.y(), 4e-3);
}

// The line's middle is 80 mm ahead along the heading, and the line stands across it.
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
  // A half circle of 20 mm begins with 10.5 mm in 3 mm along the track.
  EXPECT_TRUE(unit.Receive(Packet(0.5, -0.0105)));
  EXPECT_TRUE(unit.Receive(Packet(0.6, 0.0)));
}

TEST(ControlUnit, PacketsWithoutAPositionTellNone) {
  ControlUnit unit({}, kAhead_m, 62.0);
  unit.Record({});
  EXPECT_FALSE(unit.Receive(ToXml({})));
}

TEST(ControlUnit, AnObstacleStopsTheHeadWhereItIs) {
  ControlUnit unit({}, kAhead_m, 62.0);
  unit.Record(At(-5e-3, 0.01, 0.1));
  EXPECT_GT(unit.Command().velocity.norm(), 0.0);
  EXPECT_FALSE(unit.end());
  Correction correction;
  correction.stop = seam::StopReason::kObstacle;
  unit.Receive(ToXml(correction));
  const HeadCommand command = unit.Command();
  EXPECT_EQ(command.velocity.norm(), 0.0);
  EXPECT_EQ(command.heading_rad, 0.1);
  EXPECT_EQ(unit.end(), TrackEnd::kObstacle);
}

// At 30 mm/s along a straight edge that is sure for a second, and doubtful for another.
ControlUnit BehindADoubtfulStretch() {
  ControlUnit unit({}, kAhead_m, 62.0);
  for (int i = 0; i <= 200; ++i) {
    unit.Record(At(-5e-3, 0.3e-3 * i, 0.0));
    if (i == 0) unit.Command();
    if (i % 10 == 0) unit.Receive(Packet(i * kControlPeriod_s, 0.0, i <= 100));
  }
  Correction end;
  end.time_s = 2.0;
  end.stop = seam::StopReason::kMatEnd;
  unit.Receive(ToXml(end));
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
}  // namespace rangegrasp::stitching::internal
