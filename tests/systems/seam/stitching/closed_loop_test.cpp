#include "seam/stitching/closed_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "base/words.h"
#include "seam/stitching/smooth_mats.h"

namespace rangegrasp::seam {
namespace {

Correction RandomCorrection(base::Rng& rng) {
  Correction c;
  c.time_s = rng.Uniform(0.0, 1e3);
  c.valid = rng.Uniform() < 0.5;
  c.edge_x_m = rng.Normal() * std::pow(10.0, rng.Uniform(-9.0, 3.0));
  c.deviation_m = rng.Normal();
  const std::size_t sure = rng.Index(3);
  if (sure > 0) c.sure = sure == 1;
  const std::size_t stop = rng.Index(3);
  if (stop == 1) c.stop = StopReason::kMatEnd;
  if (stop == 2) c.stop = StopReason::kObstacle;
  return c;
}

// The content of an XML element; empty if there is none.
std::string Element(const std::string& xml, const std::string& name) {
  const std::size_t at = xml.find("<" + name + ">");
  if (at == std::string::npos) return "";
  const std::size_t from = at + name.size() + 2;
  return xml.substr(from, xml.find("</" + name + ">", from) - from);
}

TEST(Correction, HasOneElementForEachMember) {
  EXPECT_EQ(ToXml({.time_s = 1.5,
                   .valid = true,
                   .edge_x_m = -0.003,
                   .deviation_m = 0.02,
                   .sure = {},
                   .stop = StopReason::kMatEnd}),
            "<correction><time_s>1.5</time_s><valid>true</valid><edge_x_m>-0.003</edge_x_m>"
            "<deviation_m>0.02</deviation_m><stop>mat_end</stop></correction>\n");
}

TEST(Correction, ItsNumbersReadBackToTheLastBit) {
  base::Rng rng(7);
  for (int i = 0; i < 1000; ++i) {
    const Correction sent = RandomCorrection(rng);
    const std::string xml = ToXml(sent);
    EXPECT_EQ(std::stod(Element(xml, "time_s")), sent.time_s);
    EXPECT_EQ(std::stod(Element(xml, "edge_x_m")), sent.edge_x_m);
    EXPECT_EQ(std::stod(Element(xml, "deviation_m")), sent.deviation_m);
    EXPECT_EQ(Element(xml, "valid"), sent.valid ? "true" : "false");
    EXPECT_EQ(Element(xml, "sure"), !sent.sure ? "" : *sent.sure ? "true" : "false");
    EXPECT_EQ(Element(xml, "stop"), sent.stop ? base::Word(*sent.stop) : "");
  }
}

TEST(Correction, IsOneLineSoThatAStreamCanBeCutAtLineEnds) {
  base::Rng rng(8);
  for (int i = 0; i < 20; ++i) {
    const std::string xml = ToXml(RandomCorrection(rng));
    EXPECT_EQ(xml.find('\n'), xml.size() - 1);
  }
}

constexpr double kStep_s = 0.01;

// A nearly undisturbed sensor.
StripeSensorOptions QuietSensor() {
  StripeSensorOptions options;
  options.row_sigma_px = 0.05;
  options.speckle = 0.0;
  options.outlier_share = 0.0;
  options.phantom_share = 0.0;
  return options;
}

// Mats like paper: a bright step without texture or fray.
MatOptions PlainMats() {
  MatOptions options = Smooth(EdgeShape::kStep);
  options.height_m = 0.8e-3;
  return options;
}

TrackResult Drive(const MatOptions& mats, const TrackOptions& options, std::uint64_t seed,
                  const StripeSensorOptions& sensor_options = QuietSensor()) {
  const StripeSensor sensor(sensor_options);
  base::Rng rng(base::DeriveSeed(seed, "calibration"));
  const Calibration calibration = CalibrateFromBody({}, sensor.ScanBody({}, 9, rng));
  return Track(Mats(mats, seed), sensor, calibration, options, seed);
}

void ExpectWithinLimits(const TrackResult& result, const HeadOptions& limits) {
  // Differences of positions near 0.5 m are rounded by about 1e-16 / step^2.
  constexpr double kRounding = 1e-9;
  double vx = 0.0, vy = 0.0, w = 0.0;
  for (std::size_t i = 1; i < result.path.size(); ++i) {
    const TrackPoint& a = result.path[i - 1];
    const TrackPoint& b = result.path[i];
    ASSERT_NEAR(b.time_s - a.time_s, kStep_s, 1e-9);
    const double x = (b.x_m - a.x_m) / kStep_s;
    const double y = (b.y_m - a.y_m) / kStep_s;
    const double r = (b.heading_rad - a.heading_rad) / kStep_s;
    ASSERT_LE(std::hypot(x, y), limits.speed_m_s + kRounding);
    ASSERT_LE(std::abs(x), limits.max_lateral_speed_m_s + kRounding);
    ASSERT_LE(std::hypot(x - vx, y - vy), limits.max_acceleration_m_s2 * kStep_s + kRounding);
    ASSERT_LE(std::abs(r), limits.max_rotation_rad_s + kRounding);
    ASSERT_LE(std::abs(r - w), limits.max_rotation_acceleration_rad_s2 * kStep_s + kRounding);
    vx = x, vy = y, w = r;
  }
  // The head ends at rest.
  EXPECT_LE(std::hypot(vx, vy), limits.max_acceleration_m_s2 * kStep_s + kRounding);
}

double LargestError(const TrackResult& result, double wanted_m, double from_y, double to_y) {
  double largest = 0.0;
  for (const TrackPoint& p : result.path) {
    if (p.y_m < from_y || p.y_m > to_y) continue;
    largest = std::max(largest, std::abs(p.distance_m - wanted_m));
  }
  return largest;
}

TEST(ClosedLoop, KeepsTheHeadWithinItsLimitsOnWhateverMats) {
  for (std::uint64_t seed = 1100; seed < 1108; ++seed) {
    base::Rng rng(seed);
    TrackOptions options;
    options.length_m = 0.2;
    options.head.rotate = seed % 2 == 0;
    options.head.speed_m_s = rng.Uniform(0.02, 0.1);
    options.head.max_lateral_speed_m_s = rng.Uniform(0.005, 0.05);
    options.head.max_acceleration_m_s2 = rng.Uniform(0.05, 0.5);
    options.head.max_rotation_rad_s = rng.Uniform(0.02, 0.5);
    options.head.max_rotation_acceleration_rad_s2 = rng.Uniform(0.1, 2.0);
    const auto shape = static_cast<EdgeShape>(seed % 6);
    const MatOptions mats = RandomMats(shape, {}, true, seed);
    const TrackResult result = Drive(mats, options, seed, {});
    ExpectWithinLimits(result, options.head);
  }
}

TEST(ClosedLoop, FollowsAPlainStraightSeamToATenthOfAMillimetre) {
  MatOptions mats = PlainMats();
  mats.course.offset_m = 4e-3;
  mats.course.slope = 0.05;
  for (const auto method : {DecisionMethod::kVoting, DecisionMethod::kWeights}) {
    TrackOptions options;
    options.tracker.method = method;
    const TrackResult result = Drive(mats, options, 1);
    EXPECT_EQ(result.end, TrackEnd::kDone);
    EXPECT_NEAR(result.path.back().y_m, options.length_m, 0.1e-3);
    EXPECT_LT(result.max_error_m, 0.1e-3);  // a column is 0.083 mm wide
    EXPECT_EQ(result.share_within_1mm, 1.0);
    ExpectWithinLimits(result, options.head);
  }
}

TEST(ClosedLoop, HasNoLagOnACurvedSeam) {
  MatOptions mats = PlainMats();
  mats.course.waves = {{8e-3, 0.2, 0.7}, {1e-3, 0.1, 2.0}};
  for (const bool rotate : {true, false}) {
    TrackOptions options;
    options.tracker.method = DecisionMethod::kVoting;
    options.head.rotate = rotate;
    const TrackResult result = Drive(mats, options, 2);
    EXPECT_EQ(result.end, TrackEnd::kDone);
    // The seam's slope reaches 0.3, so a lag of one correction period, 3 mm, would cause an error
    // of 0.9 mm.
    EXPECT_LT(result.max_error_m, 0.2e-3) << "rotate " << rotate;
  }
}

TEST(ClosedLoop, KeepsTheEdgeNearTheSameColumnByRotating) {
  MatOptions mats = PlainMats();
  mats.course.waves = {{8e-3, 0.2, 0.7}};
  const auto spread = [&](bool rotate) {
    TrackOptions options;
    options.tracker.method = DecisionMethod::kVoting;
    options.head.rotate = rotate;
    const TrackResult result = Drive(mats, options, 3);
    double low = 1.0, high = -1.0;
    for (const Reading& reading : result.readings) {
      if (reading.time_s < 5.0 || !reading.column) continue;
      low = std::min(low, reading.x_m);
      high = std::max(high, reading.x_m);
    }
    return high - low;
  };
  EXPECT_LT(spread(true), 0.3 * spread(false));
}

TEST(ClosedLoop, AsksForOtherDistancesAndGetsThem) {
  MatOptions mats = PlainMats();
  mats.course.waves = {{6e-3, 0.25, 0.0}};
  for (const double wanted : {2e-3, 10e-3}) {
    TrackOptions options;
    options.tracker.method = DecisionMethod::kVoting;
    options.wanted_distance_m = wanted;
    const TrackResult result = Drive(mats, options, 4);
    EXPECT_LT(result.max_error_m, 0.2e-3) << wanted;
  }
}

// Figure 3.25: the edge bulges in a half circle while the CAD path is straight.
TEST(ClosedLoop, FollowsAHalfCircle) {
  MatOptions mats = PlainMats();
  mats.course.half_circle_radius_m = 0.02;
  mats.course.half_circle_y_m = 0.22;
  for (const bool rotate : {true, false}) {
    TrackOptions options;
    options.tracker.method = DecisionMethod::kVoting;
    options.head.rotate = rotate;
    const TrackResult result = Drive(mats, options, 5);
    EXPECT_EQ(result.end, TrackEnd::kDone);
    ExpectWithinLimits(result, options.head);
    // The path at constant distance has corners 24.5 mm before and behind the middle. Rounding,
    // smoothing and the sampled vertical flanks affect a few millimetres around them.
    const double w = options.wanted_distance_m;
    EXPECT_LT(LargestError(result, w, 0.10, 0.22 - 0.0295), 1e-3) << rotate;
    EXPECT_LT(LargestError(result, w, 0.22 - 0.0295, 0.22 - 0.0185), 3e-3) << rotate;
    EXPECT_LT(LargestError(result, w, 0.22 - 0.0185, 0.22 + 0.0185), 1e-3) << rotate;
    EXPECT_LT(LargestError(result, w, 0.22 + 0.0185, 0.22 + 0.0295), 3e-3) << rotate;
    EXPECT_LT(LargestError(result, w, 0.22 + 0.0295, 0.40), 1e-3) << rotate;
    double furthest = 0.0;
    for (const TrackPoint& p : result.path) furthest = std::min(furthest, p.x_m);
    EXPECT_NEAR(furthest, -0.025, 0.3e-3);
  }
}

TEST(ClosedLoop, FollowsCurvedTexturedSeamsWithinAMillimetre) {
  double good = 0.0;
  int done = 0;
  for (std::uint64_t seed = 1200; seed < 1206; ++seed) {
    const MatOptions mats = RandomMats(static_cast<EdgeShape>(seed % 3), {}, true, seed);
    const TrackResult result = Drive(mats, {}, seed, {});
    if (result.end != TrackEnd::kDone) continue;
    ++done;
    good += result.share_within_1mm;
  }
  ASSERT_GE(done, 5);
  EXPECT_GE(good / done, 0.98);
}

TEST(ClosedLoop, RestsShortlyBeforeTheMatsEnd) {
  for (int i = 0; i < 5; ++i) {
    MatOptions mats = PlainMats();
    mats.end_y_m = 0.15 + 0.017 * i;
    const TrackOptions options;
    const TrackResult result = Drive(mats, options, 6);
    EXPECT_EQ(result.end, TrackEnd::kMatEnd);
    EXPECT_FALSE(result.reached_hazard);
    EXPECT_LT(result.path.back().y_m, mats.end_y_m);
    EXPECT_GT(result.path.back().y_m, mats.end_y_m - 0.03);
    EXPECT_LT(result.max_error_m, 0.3e-3);
    ExpectWithinLimits(result, options.head);
  }
}

MatOptions WithObstacle(double y_m) {
  MatOptions mats = PlainMats();
  mats.obstacles.push_back(
      {.x_m = -5e-3, .y_m = y_m, .size_x_m = 4e-3, .size_y_m = 4e-3, .height_m = 4e-3});
  return mats;
}

TEST(ClosedLoop, StopsAtOnceForAnObstacle) {
  const TrackOptions options;
  const TrackResult result = Drive(WithObstacle(0.2), options, 7);
  EXPECT_EQ(result.end, TrackEnd::kObstacle);
  EXPECT_FALSE(result.reached_hazard);
  EXPECT_LT(result.path.back().y_m, 0.2 - 0.06);
  EXPECT_GT(result.path.back().y_m, 0.2 - 0.085);
  ExpectWithinLimits(result, options.head);
}

TEST(ClosedLoop, NeverGoesFasterThanItCouldStop) {
  TrackOptions options;
  options.head.speed_m_s = 0.5;
  options.head.max_lateral_speed_m_s = 0.5;
  for (const double y : {0.12, 0.2, 0.3}) {
    const TrackResult result = Drive(WithObstacle(y), options, 8);
    EXPECT_EQ(result.end, TrackEnd::kObstacle);
    EXPECT_FALSE(result.reached_hazard);
    EXPECT_LT(result.path.back().y_m, y - 2e-3);
  }
}

TEST(ClosedLoop, TellsWhenTheNeedleHitsWhatTheSensorCouldNotSee) {
  // The monitor does not see flat objects as obstacles, so the needle hits one; the ground truth
  // reports it.
  MatOptions mats = WithObstacle(0.2);
  mats.obstacles[0].height_m = 0.2e-3;
  const TrackResult result = Drive(mats, {}, 9);
  EXPECT_TRUE(result.reached_hazard);
}

TEST(ClosedLoop, WithoutAnEdgeItRestsBeforeTheLinesFirstPlace) {
  MatOptions mats = PlainMats();
  mats.shape = EdgeShape::kNone;
  const TrackOptions options;
  const TrackResult result = Drive(mats, options, 10);
  EXPECT_NE(result.end, TrackEnd::kDone);
  EXPECT_LT(result.path.back().y_m, 0.08);
  EXPECT_TRUE(result.sensed.empty());
  EXPECT_EQ(result.share_within_1mm, 0.0);
  ExpectWithinLimits(result, options.head);
}

TEST(ClosedLoop, TheSecondLinesOfTheThreeLinesSensorWatchToo) {
  StripeSensorOptions sensor = QuietSensor();
  sensor.lines_ahead_m = {0.080, 0.090, 0.100};
  const double y = 0.2;
  const double base = Drive(WithObstacle(y), {}, 11).path.back().y_m;
  const TrackResult result = Drive(WithObstacle(y), {}, 11, sensor);
  EXPECT_EQ(result.end, TrackEnd::kObstacle);
  EXPECT_LT(result.path.back().y_m, base - 5e-3);  // a line further ahead sees it earlier
}

TEST(ClosedLoop, SendsACorrectionEveryPeriodAndEdgesThatAreWhereTheyWereSensed) {
  const MatOptions mats = PlainMats();
  TrackOptions options;
  options.tracker.method = DecisionMethod::kVoting;
  options.tracker.packet_period_s = 0.2;
  const TrackResult slow = Drive(mats, options, 12);
  EXPECT_NEAR(static_cast<double>(slow.packets.size()), slow.path.back().time_s / 0.2, 3.0);
  options.tracker.packet_period_s = 0.1;  // (section 3.4)
  const TrackResult result = Drive(mats, options, 12);
  const double duration_s = result.path.back().time_s;
  EXPECT_NEAR(static_cast<double>(result.packets.size()), duration_s / 0.1, 3.0);
  std::size_t valid = 0;
  double last_s = 0.0;
  for (const std::string& xml : result.packets) {
    const double time_s = std::stod(Element(xml, "time_s"));
    EXPECT_GE(time_s, last_s);
    last_s = time_s;
    valid += Element(xml, "valid") == "true" ? 1 : 0;
  }
  EXPECT_EQ(valid, result.sensed.size());
  EXPECT_GT(valid, result.packets.size() * 9 / 10);
  for (const TrackPoint& p : result.sensed) EXPECT_NEAR(p.x_m, 0.0, 0.3e-3);
}

TEST(ClosedLoop, DependsOnTheSeedAlone) {
  const MatOptions mats = RandomMats(EdgeShape::kStep, {}, true, 1300);
  TrackOptions options;
  options.length_m = 0.15;
  const auto positions = [&](std::uint64_t seed) {
    const TrackResult result = Drive(mats, options, seed, {});
    std::vector<double> numbers;
    for (const TrackPoint& p : result.path) {
      numbers.insert(numbers.end(), {p.x_m, p.y_m, p.heading_rad, p.distance_m});
    }
    return std::pair(numbers, result.packets);
  };
  EXPECT_EQ(positions(13), positions(13));
  EXPECT_NE(positions(13), positions(14));
}

constexpr double kWanted_m = 5e-3;
constexpr double kSlope = 0.1;

// A straight edge x = 0.1 y without fray, whose distance from a point is known in closed form.
MatOptions Straight() {
  MatOptions options;
  options.course.slope = kSlope;
  options.texture.fray_m = 0.0;
  return options;
}

// A path with one point per millimetre of y, each at the given distance from the edge on its low
// side.
TrackResult PathAt(const std::function<double(double t_m)>& distance_m) {
  const double n = std::hypot(1.0, kSlope);
  TrackResult result;
  for (int i = 0; i <= 400; ++i) {
    const double t = i * 1e-3;
    const double d = distance_m(t);
    result.path.push_back({t, kSlope * t - d / n, t + kSlope * d / n, 0.0, 0.0});
  }
  return result;
}

TEST(TrackScore, DistanceIsThatToTheNearestPointOfTheEdge) {
  auto result = PathAt([](double t) { return -2e-3 + 0.02 * t; });  // from its high to its low side
  ScoreTrack(Mats(Straight(), 1), kWanted_m, result);
  for (std::size_t i = 0; i < result.path.size(); ++i) {
    // The edge is a polyline whose points are rounded numbers on a straight line.
    EXPECT_NEAR(result.path[i].distance_m, -2e-3 + 0.02 * 1e-3 * static_cast<double>(i), 1e-9);
  }
}

// The path is 3 mm off within the first 100 mm, then 0.2 mm off, and 2 mm off at the end.
TEST(TrackScore, ErrorsAreMeansOverTheLengthAfterTheFirst100Mm) {
  auto result = PathAt([](double t) {
    if (t < 0.09) return kWanted_m + 3e-3;
    return kWanted_m + (t > 0.34 ? 2e-3 : 0.2e-3);
  });
  ScoreTrack(Mats(Straight(), 1), kWanted_m, result);
  // Two of 300 pieces may count for either part; the one that changes distance is longer.
  EXPECT_NEAR(result.share_within_1mm, 0.8, 0.02);
  EXPECT_NEAR(result.mean_error_m, 0.8 * 0.2e-3 + 0.2 * 2e-3, 0.02 * 2e-3);
  EXPECT_NEAR(result.max_error_m, 2e-3, 1e-9);
}

// From 0.3 m on the path is 2 mm off and its points are four times as dense. The length of the path
// counts, not the number of points.
TEST(TrackScore, ErrorsCountByLength) {
  auto coarse = PathAt([](double t) { return kWanted_m + (t > 0.3005 ? 2e-3 : 0.2e-3); });
  TrackResult result;
  for (std::size_t i = 0; i < coarse.path.size(); ++i) {
    const TrackPoint& p = coarse.path[i];
    result.path.push_back(p);
    if (i < 301 || i + 1 == coarse.path.size()) continue;
    const TrackPoint& q = coarse.path[i + 1];
    for (const double t : {0.25, 0.5, 0.75}) {
      result.path.push_back({p.time_s + t * (q.time_s - p.time_s), p.x_m + t * (q.x_m - p.x_m),
                             p.y_m + t * (q.y_m - p.y_m), 0.0, 0.0});
    }
  }
  ScoreTrack(Mats(Straight(), 1), kWanted_m, result);
  EXPECT_NEAR(result.mean_error_m, (0.2 * 0.2e-3 + 0.1 * 2e-3) / 0.3, 0.02e-3);
  EXPECT_NEAR(result.share_within_1mm, 2.0 / 3.0, 0.01);
}

TEST(TrackScore, AHazardIsReachedWhereTheNeedlePassesTheMatsEndOrMeetsAnObstacle) {
  const auto reached = [](const MatOptions& mats) {
    auto result = PathAt([](double) { return kWanted_m; });
    ScoreTrack(Mats(mats, 1), kWanted_m, result);
    return result.reached_hazard;
  };
  EXPECT_FALSE(reached(Straight()));
  MatOptions mats = Straight();
  mats.end_y_m = 0.39;
  EXPECT_TRUE(reached(mats));
  mats.end_y_m = 0.41;
  EXPECT_FALSE(reached(mats));
  const double needle_x = kSlope * 0.2 - kWanted_m;
  mats.obstacles = {{needle_x, 0.2, 4e-3, 4e-3, 5e-3}};
  EXPECT_TRUE(reached(mats));
  mats.obstacles[0].x_m += 3e-3;
  EXPECT_FALSE(reached(mats));
  // The path ends at 0.4005 m. The obstacle begins 1 mm behind its end.
  mats.obstacles = {{kSlope * 0.4 - kWanted_m, 0.4035, 4e-3, 4e-3, 5e-3}};
  EXPECT_FALSE(reached(mats));
  mats.obstacles[0].y_m -= 2e-3;
  EXPECT_TRUE(reached(mats));
}

}  // namespace
}  // namespace rangegrasp::seam
