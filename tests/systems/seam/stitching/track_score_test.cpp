#include "seam/stitching/internal/track_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace rangegrasp::stitching::internal {
namespace {

constexpr double kWanted_m = 5e-3;
constexpr double kSlope = 0.1;

// A straight edge x = 0.1 y without fray, whose distance from a point is known in closed form.
MatOptions Straight() {
  MatOptions options;
  options.course.slope = kSlope;
  options.texture.fray_m = 0.0;
  return options;
}

// Points every millimetre of y, each at the distance from the edge that is asked for, on its low
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
  Score(Mats(Straight(), 1), kWanted_m, result);
  for (std::size_t i = 0; i < result.path.size(); ++i) {
    // The edge's points are a polyline of rounded numbers on a straight line.
    EXPECT_NEAR(result.path[i].distance_m, -2e-3 + 0.02 * 1e-3 * static_cast<double>(i), 1e-9);
  }
}

// 3 mm off before the first 100 mm are over, then 0.2 mm off, and 2 mm off at the end.
TEST(TrackScore, ErrorsAreMeansOverTheLengthAfterTheFirst100Mm) {
  const auto scored = [](double share_off) {
    auto result = PathAt([&](double t) {
      if (t < 0.09) return kWanted_m + 3e-3;
      return kWanted_m + (t > 0.4 - 0.3 * share_off ? 2e-3 : 0.2e-3);
    });
    Score(Mats(Straight(), 1), kWanted_m, result);
    return result;
  };
  const TrackResult fifth = scored(0.2);
  // Two pieces of 300, of which the one that leaves the path is longer, may count on either side.
  EXPECT_NEAR(fifth.share_within_1mm, 0.8, 0.02);
  EXPECT_NEAR(fifth.mean_error_m, 0.8 * 0.2e-3 + 0.2 * 2e-3, 0.02 * 2e-3);
  EXPECT_NEAR(fifth.p95_error_m, 2e-3, 1e-9);
  EXPECT_NEAR(fifth.max_error_m, 2e-3, 1e-9);
  EXPECT_NEAR(scored(0.03).p95_error_m, 0.2e-3, 1e-9);
}

// Points stand four times as close where it is 2 mm off, from 0.3 m on: its length counts, not
// their number.
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
  Score(Mats(Straight(), 1), kWanted_m, result);
  EXPECT_NEAR(result.mean_error_m, (0.2 * 0.2e-3 + 0.1 * 2e-3) / 0.3, 0.02e-3);
  EXPECT_NEAR(result.share_within_1mm, 2.0 / 3.0, 0.01);
}

TEST(TrackScore, AHazardIsReachedWhereTheNeedlePassesTheMatsEndOrMeetsAnObstacle) {
  const auto reached = [](const MatOptions& mats) {
    auto result = PathAt([](double) { return kWanted_m; });
    Score(Mats(mats, 1), kWanted_m, result);
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
  // The path ends at 0.4005 m, before an obstacle that begins 1 mm further on.
  mats.obstacles = {{kSlope * 0.4 - kWanted_m, 0.4035, 4e-3, 4e-3, 5e-3}};
  EXPECT_FALSE(reached(mats));
  mats.obstacles[0].y_m -= 2e-3;
  EXPECT_TRUE(reached(mats));
}

}  // namespace
}  // namespace rangegrasp::stitching::internal
