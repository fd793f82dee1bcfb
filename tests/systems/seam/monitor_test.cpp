#include "seam/monitor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rng.h"
#include "base/words.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

constexpr double kSigma_m = 0.08e-3;
constexpr double kRadius_m = 0.03;
constexpr double kSeen_m = 0.022;  // on a cylinder, to either side; the flanks deflect the light

struct Scene {
  double cylinder = 0.0;  // 1 convex, -1 concave
  double seen_m = kSeen_m;
  double flank_lost = 0.98;
  double step_m = 0.0;
  double edge_m = 0.0;
  double lost = 0.05;
  double phantoms = 0.0;  // share of the lost points
  double outliers = 0.01;
  int filaments = 0;
  double obstacle_x_m = 0.0, obstacle_width_m = 0.0, obstacle_height_m = 0.0;
};

double SurfaceAt(const Scene& scene, double x) {
  double z = 0.02 * x + (x > scene.edge_m ? scene.step_m : 0.0);
  if (scene.cylinder == 0.0) return z;
  const double inside = std::clamp(x - scene.edge_m, -kSeen_m, kSeen_m);
  return z + scene.cylinder * (std::sqrt(kRadius_m * kRadius_m - inside * inside) - kRadius_m);
}

PreparedProfile Scan(const Scene& scene, const LineGeometry& line, Rng& rng) {
  PreparedProfile profile;
  int run = 0;
  double off = 0.0;
  for (int i = 0; i < line.columns; ++i) {
    const double x = line.ToMeters(i);
    const bool obstacle = std::abs(x - scene.obstacle_x_m) < 0.5 * scene.obstacle_width_m;
    const bool flank = scene.cylinder != 0.0 && std::abs(x - scene.edge_m) > scene.seen_m;
    const bool lost = flank ? rng.Uniform() < scene.flank_lost : rng.Uniform() < scene.lost;
    double z = SurfaceAt(scene, x) + (obstacle ? scene.obstacle_height_m : 0.0);
    z += kSigma_m * rng.Normal();
    if (run <= 0 && rng.Uniform() < scene.outliers / 4.0) {
      run = 1 + static_cast<int>(-4.0 * std::log(1.0 - rng.Uniform()));
      off = 6e-3 * rng.Normal();
    }
    if (run-- > 0) z += off;
    if (lost && !obstacle) {
      const bool phantom = !flank && rng.Uniform() < scene.phantoms;
      z = phantom ? rng.Uniform(-0.075, 0.075) : std::numeric_limits<double>::quiet_NaN();
    }
    profile.original_m.push_back(static_cast<float>(z));
  }
  for (int k = 0; k < scene.filaments; ++k) {
    const auto at = rng.Index(profile.original_m.size() - 5);
    for (std::size_t i = at; i < at + 5; ++i) profile.original_m[i] += 1.5e-3F;
  }
  return profile;
}

Scene RandomScene(Rng& rng) {
  Scene scene;
  scene.cylinder = std::floor(rng.Uniform(-1.0, 2.0));
  scene.step_m = rng.Uniform(0.3e-3, 1.1e-3);
  scene.edge_m = rng.Uniform(-0.012, 0.012);
  return scene;
}

struct Protrusion {
  double height_m = 0.0;
  std::size_t column = 0;
};

// The highest stretch of 2 mm, rated by its lowest point. Half of its points may be missing.
Protrusion HighestStretch(const PreparedProfile& profile, const LineGeometry& line) {
  const auto above = HeightAboveSurface(profile);
  const auto width = static_cast<std::size_t>(2e-3 * line.columns_per_m);
  Protrusion best;
  for (std::size_t begin = 0; begin + width <= above.size(); ++begin) {
    std::vector<float> points;
    std::copy_if(above.begin() + static_cast<std::ptrdiff_t>(begin),
                 above.begin() + static_cast<std::ptrdiff_t>(begin + width),
                 std::back_inserter(points), [](float z) { return std::isfinite(z); });
    if (2 * points.size() < width) continue;
    const auto low = static_cast<double>(*std::min_element(points.begin(), points.end()));
    if (low > best.height_m) best = {low, begin + width / 2};
  }
  return best;
}

Reading Told(ProfileStatus status) {
  Reading reading;
  reading.status = status;
  if (status == ProfileStatus::kEdge) reading.step_m = 0.5e-3;
  return reading;
}

// Updates a monitor with a profile and the detectors' status for it; by default they see an edge.
std::optional<StopReason> Update(SurfaceMonitor& monitor, const PreparedProfile& profile,
                                 ProfileStatus told = ProfileStatus::kEdge) {
  return monitor.Update(profile, Told(told));
}

TEST(HeightAboveSurface, MeasuresAnObstacleOnAFlatMat) {
  const LineGeometry line;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    Scene scene;
    scene.outliers = 0.0;
    scene.obstacle_x_m = rng.Uniform(-0.03, 0.03);
    scene.obstacle_width_m = 0.006;
    scene.obstacle_height_m = rng.Uniform(3e-3, 20e-3);
    const auto found = HighestStretch(Scan(scene, line, rng), line);
    // The lowest of its 24 columns counts, which is within four standard deviations of the noise.
    EXPECT_NEAR(found.height_m, scene.obstacle_height_m, 4.0 * kSigma_m) << seed;
    EXPECT_NEAR(line.ToMeters(static_cast<double>(found.column)), scene.obstacle_x_m, 0.003)
        << seed;
  }
}

TEST(HeightAboveSurface, IsNoHigherThanMatEdgesAndFilamentsAre) {
  const LineGeometry line;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    Rng rng(seed);
    Scene scene = RandomScene(rng);
    scene.outliers = 0.0;
    scene.filaments = 8;
    EXPECT_LT(HighestStretch(Scan(scene, line, rng), line).height_m, 2.5e-3) << seed;
  }
}

TEST(HeightAboveSurface, TakesNoNoiseForASurfaceEvenIfAThirdIsNoise) {
  const LineGeometry line;
  int seen = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    Scene scene = RandomScene(rng);
    scene.lost = 0.4;
    scene.phantoms = 0.8;
    seen += HighestStretch(Scan(scene, line, rng), line).height_m >= 3e-3 ? 1 : 0;
  }
  // Long runs of outliers are exp(-23/4) of the 2.6 runs per profile, and a third of them are high:
  // 0.3 % of 300 profiles. More than nine do not occur by chance, only if noise is taken for a
  // surface.
  EXPECT_LE(seen, 9);
}

TEST(HeightAboveSurface, FindsAnObstacleOfAThirdOfTheLine) {
  const LineGeometry line;
  Rng rng(4);
  Scene scene;
  scene.obstacle_width_m = 0.028;
  scene.obstacle_height_m = 5e-3;
  const auto found = HighestStretch(Scan(scene, line, rng), line);
  EXPECT_NEAR(found.height_m, 5e-3, 4.0 * kSigma_m);
}

TEST(HeightAboveSurface, TakesEmptyAndShortProfiles) {
  LineGeometry line;
  PreparedProfile profile;
  EXPECT_EQ(HighestStretch(profile, line).height_m, 0.0);
  profile.original_m.assign(1024, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(HighestStretch(profile, line).height_m, 0.0);
  profile.original_m.assign(5, 0.0F);
  EXPECT_EQ(HeightAboveSurface(profile), std::vector<float>(5, 0.0F));
}

TEST(RisingColumns, AreThoseOfBruteForce) {
  constexpr float kNoEdgeSeen = std::numeric_limits<float>::quiet_NaN();
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    std::vector<float> above(40);
    for (float& z : above)
      z = rng.Uniform() < 0.2 ? kNoEdgeSeen : (rng.Uniform() < 0.85 ? 4.0F : 2.0F);
    const std::size_t width = 1 + rng.Index(8);
    std::vector<bool> expected(above.size(), false);
    for (std::size_t begin = 0; begin + width <= above.size(); ++begin) {
      std::size_t high = 0;
      std::size_t missing = 0;
      for (std::size_t i = begin; i < begin + width; ++i) {
        high += above[i] == 4.0F ? 1 : 0;
        missing += std::isnan(above[i]) ? 1 : 0;
      }
      if (high + missing < width || 6 * missing > width) continue;
      for (std::size_t i = begin; i < begin + width; ++i) expected[i] = true;
    }
    EXPECT_EQ(RisingColumns(above, width, 3.0), expected) << seed;
  }
  EXPECT_EQ(RisingColumns(std::vector<float>(3, 9.0F), 4, 3.0), std::vector<bool>(3, false));
}

TEST(SurfaceMonitor, StopsForEveryObstacleOfThreeMillimetres) {
  const LineGeometry line;
  int missed = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    Scene scene = RandomScene(rng);
    scene.obstacle_x_m = scene.edge_m + rng.Uniform(-0.01, 0.01);
    scene.obstacle_width_m = rng.Uniform(0.003, 0.012);
    scene.obstacle_height_m = rng.Uniform(3.3e-3, 20e-3);
    SurfaceMonitor monitor(line, {});
    std::optional<StopReason> stop;
    for (int i = 0; i < 4; ++i) stop = Update(monitor, Scan(scene, line, rng));
    missed += stop == StopReason::kObstacle ? 0 : 1;
  }
  EXPECT_EQ(missed, 0);
}

TEST(SurfaceMonitor, GoesOnOverMatsWithoutObstacle) {
  const LineGeometry line;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    Scene scene = RandomScene(rng);
    scene.filaments = 5;
    SurfaceMonitor monitor(line, {});
    for (int i = 0; i < 50; ++i) ASSERT_FALSE(Update(monitor, Scan(scene, line, rng))) << seed;
  }
}

TEST(SurfaceMonitor, WantsAnObstacleInOnePlace) {
  const LineGeometry line;
  Rng rng(5);
  SurfaceMonitor monitor(line, {});
  Scene scene;
  scene.outliers = 0.0;
  scene.obstacle_width_m = 0.004;
  scene.obstacle_height_m = 8e-3;
  for (int i = 0; i < 10; ++i) {
    scene.obstacle_x_m = -0.03 + 0.0065 * i;
    EXPECT_FALSE(Update(monitor, Scan(scene, line, rng))) << i;
  }
}

// A level mat with a block 8 mm high in the columns from `begin` to `end`.
PreparedProfile WithBlock(std::size_t begin, std::size_t end) {
  PreparedProfile profile;
  profile.original_m.assign(1024, 0.0F);
  for (std::size_t i = begin; i < end; ++i) profile.original_m[i] = 8e-3F;
  return profile;
}

TEST(SurfaceMonitor, StopsAtTheProfileThatMakesTheCountWithinTheWindow) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  const auto block = WithBlock(500, 560);
  const auto level = WithBlock(0, 0);
  for (int i = 1; i < options.obstacle_profiles; ++i) EXPECT_FALSE(Update(monitor, block)) << i;
  for (int i = 1; i < options.window; ++i) EXPECT_FALSE(Update(monitor, level)) << i;
  for (int i = 1; i < options.obstacle_profiles; ++i) EXPECT_FALSE(Update(monitor, block)) << i;
  EXPECT_EQ(Update(monitor, block), StopReason::kObstacle);
}

// A block over most of the line is taken for the surface. It stands out from earlier profiles.
TEST(SurfaceMonitor, SeesAnObstacleThatIsWiderThanWhatIsLeftOfTheSurface) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(Update(monitor, WithBlock(0, 0)));
  std::optional<StopReason> stop;
  for (int i = 0; i < options.obstacle_profiles; ++i) stop = Update(monitor, WithBlock(300, 1024));
  EXPECT_EQ(stop, StopReason::kObstacle);
}

// When the head steers, the line moves along itself. Columns then rise because of the mould's
// flanks, although the mats do not change.
TEST(SurfaceMonitor, AMouldThatTheLineMovesOverIsNoObstacleButOneOnItIs) {
  const LineGeometry line;
  const MonitorOptions options;
  constexpr double kMoved_m = 0.2e-3;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    Scene scene = RandomScene(rng);
    scene.cylinder = seed % 2 == 0 ? 1.0 : -1.0;
    SurfaceMonitor monitor(line, options);
    const auto update = [&] {
      auto profile = Scan(scene, line, rng);
      profile.moved_m = kMoved_m;
      scene.edge_m -= kMoved_m;
      return Update(monitor, profile);
    };
    for (int i = 0; i < 2 * options.window; ++i) ASSERT_FALSE(update()) << seed << " " << i;
    // The obstacle covers all that returns light, so only the earlier profiles reveal it.
    scene.obstacle_x_m = scene.edge_m;
    scene.obstacle_width_m = 2.0 * kSeen_m - 2e-3;
    scene.obstacle_height_m = 5e-3;
    std::optional<StopReason> stop;
    for (int i = 0; i < options.obstacle_profiles; ++i) stop = update();
    EXPECT_EQ(stop, StopReason::kObstacle) << seed;
  }
}

// On a dark flank an obstacle is an isolated patch of points. A parabola through its top and the
// mat, with no points in between, has the most support. The earlier profiles show no obstacle.
TEST(SurfaceMonitor, StopsForAnObstacleOnAFlankThatReturnsNoLight) {
  const LineGeometry line;
  const MonitorOptions options;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    Scene scene;
    scene.cylinder = seed % 2 == 0 ? 1.0 : -1.0;
    scene.seen_m = 0.011;
    scene.flank_lost = 1.0;
    scene.step_m = rng.Uniform(0.3e-3, 1.1e-3);
    SurfaceMonitor monitor(line, options);
    const auto update = [&] { return Update(monitor, Scan(scene, line, rng)); };
    for (int i = 0; i < 2 * options.window; ++i) ASSERT_FALSE(update()) << seed << " " << i;
    scene.obstacle_x_m = scene.edge_m + (seed % 4 < 2 ? -0.018 : 0.018);
    scene.obstacle_width_m = 0.005;
    scene.obstacle_height_m = 3.5e-3;
    std::optional<StopReason> stop;
    for (int i = 0; i < options.obstacle_profiles; ++i) stop = update();
    EXPECT_EQ(stop, StopReason::kObstacle) << seed;
  }
}

// After an outage the earlier surface is unknown. It must not be taken for a level surface at 0.
TEST(SurfaceMonitor, TakesNoMatForAnObstacleBecauseNothingWasSeenBefore) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  PreparedProfile profile;
  profile.original_m.assign(1024, std::numeric_limits<float>::quiet_NaN());
  for (int i = 0; i < options.outage_profiles; ++i) {
    Update(monitor, profile, ProfileStatus::kUnusable);
  }
  profile.original_m.assign(1024, 8e-3F);
  for (int i = 0; i < 2 * options.window; ++i) ASSERT_FALSE(Update(monitor, profile)) << i;
}

// Detectors may lose an edge that is there. If a fit still sees the edge, the mats have not ended.
TEST(SurfaceMonitor, AnEdgeThatIsFollowedHasNoEnd) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  EXPECT_FALSE(Update(monitor, WithBlock(0, 0)));
  Reading followed = Told(ProfileStatus::kNoEdge);
  followed.followed_step_m = 0.4e-3;
  for (int i = 0; i < 3 * options.window; ++i) {
    EXPECT_FALSE(monitor.Update(WithBlock(0, 0), followed)) << i;
  }
  EXPECT_TRUE(monitor.SeesEdge());
  // A step far below the edge's usual height is not that edge any more.
  followed.followed_step_m = 0.2 * Told(ProfileStatus::kEdge).step_m;
  std::optional<StopReason> stop;
  for (int i = 0; i < options.mat_end_profiles; ++i) {
    stop = monitor.Update(WithBlock(0, 0), followed);
  }
  EXPECT_EQ(stop, StopReason::kMatEnd);
  EXPECT_FALSE(monitor.SeesEdge());
}

// The obstacle is on the low mat. The surface between both mats is half a millimetre higher.
TEST(SurfaceMonitor, StopsForAnObstacleOfThreeByOneMillimetre) {
  const LineGeometry line;
  MonitorOptions options;
  options.obstacle_width_m = 0.5e-3;
  options.obstacle_profiles = 1;
  int missed = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    Scene scene = RandomScene(rng);
    scene.outliers = 0.0;
    scene.obstacle_x_m = scene.edge_m - rng.Uniform(0.002, 0.01);
    scene.obstacle_width_m = 0.7e-3;  // 1 mm without its borders
    scene.obstacle_height_m = 3e-3;
    SurfaceMonitor monitor(line, options);
    missed += Update(monitor, Scan(scene, line, rng)) ? 0 : 1;
  }
  EXPECT_EQ(missed, 0);
}

// For the monitor, an edge that continues with a step too low for a new edge has ended.
TEST(SurfaceMonitor, TheMatsEndThoughALowStepGoesOn) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  Reading low = Told(ProfileStatus::kEdge);
  low.step_m = 0.9 * options.min_step_m;
  for (int i = 1; i < options.mat_end_profiles; ++i) {
    EXPECT_FALSE(monitor.Update(WithBlock(0, 0), low)) << i;
  }
  EXPECT_EQ(monitor.Update(WithBlock(0, 0), low), StopReason::kMatEnd);
}

TEST(SurfaceMonitor, AnEdgeThatOnlyEarlierProfilesBearOutHasEnded) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  Reading reading = Told(ProfileStatus::kEdge);
  for (int i = 0; i < 2 * options.window; ++i)
    EXPECT_FALSE(monitor.Update(WithBlock(0, 0), reading));
  reading.goes_on = false;
  for (int i = 1; i < options.mat_end_profiles; ++i) {
    EXPECT_FALSE(monitor.Update(WithBlock(0, 0), reading)) << i;
  }
  EXPECT_EQ(monitor.Update(WithBlock(0, 0), reading), StopReason::kMatEnd);
}

TEST(SurfaceMonitor, TellsTheMatEndOnceAnEdgeWasSeenAndStays) {
  const LineGeometry line;
  PreparedProfile flat;
  flat.original_m.assign(1024, 0.0F);
  MonitorOptions options;
  SurfaceMonitor monitor(line, options);
  for (int i = 0; i < 2 * options.window; ++i) {
    EXPECT_FALSE(Update(monitor, flat, ProfileStatus::kNoEdge));  // no edge has been seen yet
  }
  EXPECT_FALSE(Update(monitor, flat));
  for (int i = 1; i < options.mat_end_profiles; ++i) {
    EXPECT_FALSE(Update(monitor, flat, ProfileStatus::kNoEdge)) << i;
    EXPECT_FALSE(Update(monitor, flat, ProfileStatus::kUnusable)) << i;
  }
  EXPECT_EQ(Update(monitor, flat, ProfileStatus::kNoEdge), StopReason::kMatEnd);
  EXPECT_EQ(Update(monitor, flat), StopReason::kMatEnd);
}

// A low stretch of an edge looks like its end until the edge comes back. A step that appears much
// later may be something else.
TEST(SurfaceMonitor, AMatEndIsTakenBackIfTheEdgeIsSoonThereBeyondDoubt) {
  const MonitorOptions options;
  for (const bool soon : {true, false}) {
    SurfaceMonitor monitor({}, options);
    const auto update = [&](ProfileStatus status, std::optional<bool> sure) {
      Reading reading = Told(status);
      reading.sure = sure;
      return monitor.Update(WithBlock(0, 0), reading);
    };
    EXPECT_FALSE(update(ProfileStatus::kEdge, true));
    std::optional<StopReason> stop;
    for (int i = 0; i < options.mat_end_profiles; ++i) stop = update(ProfileStatus::kNoEdge, false);
    EXPECT_EQ(stop, StopReason::kMatEnd);
    for (int i = 0; i < (soon ? 1 : 2) * options.window; ++i) {
      EXPECT_EQ(update(ProfileStatus::kEdge, false), StopReason::kMatEnd) << i;
    }
    EXPECT_EQ(update(ProfileStatus::kEdge, true).has_value(), !soon);
  }
}

// "No possible edge ... with a minimum size of 0.3mm" (section 3.7), whatever the edge's usual
// height. With our own method a step of less than 0.4 of the usual height is not the edge; after
// 60 profiles at 1.1 mm the mean is 0.94 mm.
TEST(MonitorFor, AsPublishedTheMatsEndWhereNoEdgeHas03Mm) {
  for (const auto method : base::ValuesOf<DecisionMethod>()) {
    const MonitorOptions options = MonitorFor({}, method);
    SurfaceMonitor monitor({}, options);
    const auto after = [&](double step_m, int profiles) {
      Reading reading = Told(ProfileStatus::kEdge);
      reading.step_m = step_m;
      std::optional<StopReason> stop;
      for (int i = 0; i < profiles; ++i) stop = monitor.Update(WithBlock(0, 0), reading);
      return stop;
    };
    EXPECT_FALSE(after(1.1e-3, 60));
    EXPECT_EQ(after(0.31e-3, options.window).has_value(), method == DecisionMethod::kSteps);
    EXPECT_EQ(after(0.29e-3, options.mat_end_profiles), StopReason::kMatEnd);
  }
}

// A sensor that sees nothing for a while has not seen the mats end.
TEST(SurfaceMonitor, AnOutageIsToldAsLongAsItLasts) {
  const MonitorOptions options;
  SurfaceMonitor monitor({}, options);
  PreparedProfile nothing;
  nothing.original_m.assign(1024, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(Update(monitor, WithBlock(0, 0)));
  for (int i = 1; i < options.outage_profiles; ++i) {
    EXPECT_FALSE(Update(monitor, nothing, ProfileStatus::kUnusable)) << i;
  }
  for (int i = 0; i < 2 * options.window; ++i) {
    EXPECT_EQ(Update(monitor, nothing, ProfileStatus::kUnusable), StopReason::kOutage) << i;
  }
  EXPECT_FALSE(Update(monitor, WithBlock(0, 0)));
}

}  // namespace
}  // namespace rangegrasp::seam
