#include "seam/stitching/closed_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "base/words.h"
#include "seam/stitching/correction.h"
#include "seam/stitching/random_mats.h"

namespace rangegrasp::stitching {
namespace {

constexpr double kStep_s = 0.01;

// A sensor that nothing disturbs.
StripeSensorOptions QuietSensor() {
  StripeSensorOptions options;
  options.row_sigma_px = 0.05;
  options.speckle = 0.0;
  options.outlier_share = 0.0;
  options.phantom_share = 0.0;
  return options;
}

// A mat of paper: a bright step without texture or fray.
MatOptions PlainMats() {
  MatOptions options;
  options.height_m = 0.8e-3;
  MatTexture& t = options.texture;
  t.weave_relief_m = t.fuzz_m = t.waviness_m = t.fray_m = 0.0;
  t.filaments_per_m = t.loose_filaments_per_m2 = t.detached_share = 0.0;
  t.gloss = t.darkness = 0.0;
  return options;
}

TrackResult Drive(const MatOptions& mats, const TrackOptions& options, std::uint64_t seed,
                  const StripeSensorOptions& sensor_options = QuietSensor()) {
  const StripeSensor sensor(sensor_options);
  base::Rng rng(base::DeriveSeed(seed, "calibration"));
  const seam::Calibration calibration = sensor.Calibrate(9, rng);
  return Track(Mats(mats, seed), sensor, calibration, options, seed);
}

void ExpectWithinLimits(const TrackResult& result, const HeadOptions& limits) {
  // Differences of positions of 0.5 m round to some 1e-16 / step^2.
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
  // It ends at rest.
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
  for (const auto method : {seam::DecisionMethod::kVoting, seam::DecisionMethod::kWeights}) {
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
    options.head.rotate = rotate;
    const TrackResult result = Drive(mats, options, 2);
    EXPECT_EQ(result.end, TrackEnd::kDone);
    // The seam's slope reaches 0.3: a lag of one correction period, 3 mm, would cost 0.9 mm.
    EXPECT_LT(result.max_error_m, 0.2e-3) << "rotate " << rotate;
  }
}

TEST(ClosedLoop, KeepsTheEdgeNearTheSameColumnByRotating) {
  MatOptions mats = PlainMats();
  mats.course.waves = {{8e-3, 0.2, 0.7}};
  const auto spread = [&](bool rotate) {
    TrackOptions options;
    options.head.rotate = rotate;
    const TrackResult result = Drive(mats, options, 3);
    double low = 1.0, high = -1.0;
    for (const seam::Reading& reading : result.readings) {
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
    options.wanted_distance_m = wanted;
    const TrackResult result = Drive(mats, options, 4);
    EXPECT_LT(result.max_error_m, 0.2e-3) << wanted;
  }
}

// Figure 3.25: the edge bulges in the shape of a half circle while CAD is straight.
TEST(ClosedLoop, FollowsAHalfCircle) {
  MatOptions mats = PlainMats();
  mats.course.half_circle_radius_m = 0.02;
  mats.course.half_circle_y_m = 0.22;
  for (const bool rotate : {true, false}) {
    TrackOptions options;
    options.head.rotate = rotate;
    const TrackResult result = Drive(mats, options, 5);
    EXPECT_EQ(result.end, TrackEnd::kDone);
    ExpectWithinLimits(result, options.head);
    // The path of equal distance has corners 24.5 mm before and behind the middle; rounding,
    // smoothing and the sampled vertical flanks reach some millimetres from there.
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
  // Flat things are no obstacles to the monitor: the needle goes through, and truth says so.
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
  EXPECT_LT(result.path.back().y_m, base - 5e-3);  // seen earlier by a line further ahead
}

TEST(ClosedLoop, SendsACorrectionEveryPeriodAndEdgesThatAreWhereTheyWereSensed) {
  const MatOptions mats = PlainMats();
  const TrackOptions options;
  const TrackResult result = Drive(mats, options, 12);
  const double duration_s = result.path.back().time_s;
  EXPECT_NEAR(static_cast<double>(result.packets.size()),
              duration_s / options.head.correction_period_s, 3.0);
  std::size_t valid = 0;
  double last_s = 0.0;
  for (const std::string& xml : result.packets) {
    const Correction correction = FromXml(xml);
    EXPECT_GE(correction.time_s, last_s);
    last_s = correction.time_s;
    valid += correction.valid ? 1 : 0;
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

TEST(ClosedLoop, OptionsOutOfRangeAreRefused) {
  const auto refuses = [](const std::function<void(TrackOptions&)>& change) {
    TrackOptions options;
    change(options);
    EXPECT_THROW(Drive(PlainMats(), options, 1), std::invalid_argument);
  };
  refuses([](TrackOptions& o) { o.head.speed_m_s = 0.0; });
  refuses([](TrackOptions& o) { o.head.max_lateral_speed_m_s = -1.0; });
  refuses([](TrackOptions& o) { o.head.max_acceleration_m_s2 = std::nan(""); });
  refuses([](TrackOptions& o) { o.head.max_rotation_rad_s = 0.0; });
  refuses([](TrackOptions& o) { o.head.max_rotation_acceleration_rad_s2 = 0.0; });
  refuses([](TrackOptions& o) { o.head.correction_period_s = 1e-3; });
  refuses([](TrackOptions& o) { o.wanted_distance_m = 0.0; });
  refuses([](TrackOptions& o) { o.length_m = 0.0; });
}

TEST(ClosedLoop, EndsHaveNames) {
  EXPECT_EQ(base::Word(TrackEnd::kDone), "done");
  EXPECT_EQ(base::Word(TrackEnd::kMatEnd), "mat_end");
  EXPECT_EQ(base::Word(TrackEnd::kObstacle), "obstacle");
  EXPECT_EQ(base::Word(TrackEnd::kLost), "lost");
}

}  // namespace
}  // namespace rangegrasp::stitching
