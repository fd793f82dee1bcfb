#include <gtest/gtest.h>

#include "perception/analytic.h"
#include "perception/internal/planar.h"
#include "perception/internal/rotation_axis.h"
#include "perception/internal/top_surface.h"
#include "perception/perception_options.h"
#include "perception/preprocess.h"
#include "perception/segment.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::All;
using samples::Analytic;
using samples::Given;
using samples::LevelAt;

FeatureOptions AsPublished() {
  FeatureOptions options;
  base::SwitchAll<FeatureAdditions>(false, options);
  return options;
}

/// The published features with one addition enabled.
FeatureOptions With(bool FeatureAdditions::*on) {
  FeatureOptions options = AsPublished();
  options.*on = true;
  return options;
}

// With eq. 5.5 as printed, the floor of a bowl is taken, since it has more points than the rim.
TEST(HigherTops, AloneTakeTheRimInPlaceOfTheFloor) {
  Analytic bowl;
  bowl.AddDisc({0.0, 0.0, 0.02}, 0.05);
  bowl.AddDisc({0.0, 0.0, 0.06}, 0.06, 0.052);
  const auto height = [&](const FeatureOptions& options) {
    base::Rng rng(1);
    return FindTopSurface(Given(bowl.cloud, options).Context(), All(bowl.cloud), rng)->center_C.z();
  };
  EXPECT_NEAR(height(AsPublished()), 0.02, 1e-9);
  EXPECT_NEAR(height(With(&FeatureAdditions::higher_tops)), 0.06, 1e-9);
}

/// A face of 60 deg. Each third normal seems to lean by third_deg.
Analytic SteepRoof(double third_deg) {
  Analytic roof;
  const Vector3d slope(0.0, std::cos(base::Deg(60.0)), -std::sin(base::Deg(60.0)));
  for (int i = 0; i < 60; ++i) {
    for (int k = 0; k < 25; ++k) {
      const double seems_rad = base::Deg((i + k) % 3 == 0 ? third_deg : 60.0);
      roof.Add(Vector3d(0.002 * i, 0.0, 0.052) + 0.002 * k * slope,
               Vector3d(0.0, std::sin(seems_rad), std::cos(seems_rad)));
    }
  }
  return roof;
}

// A steep roof has no normal near the table's normal, so it has no top as published.
TEST(SlabTops, AloneGiveASteepRoofATop) {
  const Analytic roof = SteepRoof(60.0);
  base::Rng rng(1);
  EXPECT_FALSE(FindTopSurface(Given(roof.cloud, AsPublished()).Context(), All(roof.cloud), rng));
  const Given with_slabs(roof.cloud, With(&FeatureAdditions::slab_tops));
  const auto top = FindTopSurface(with_slabs.Context(), All(roof.cloud), rng);
  ASSERT_TRUE(top);
  EXPECT_GT(top->center_C.z(), 0.045);
}

// On a face of 60 deg, noise turns some normals up. As published their plane is a top.
TEST(LevelTops, AloneRefuseThePlaneOfAFaceOfWhichSomePointsSeemToFaceUp) {
  const Analytic roof = SteepRoof(40.0);
  base::Rng rng(1);
  const auto top = FindTopSurface(Given(roof.cloud, AsPublished()).Context(), All(roof.cloud), rng);
  ASSERT_TRUE(top);
  EXPECT_NEAR(top->plane.normal.z(), std::cos(base::Deg(60.0)), 1e-6);
  const Given level(roof.cloud, With(&FeatureAdditions::level_tops));
  EXPECT_FALSE(FindTopSurface(level.Context(), All(roof.cloud), rng));
}

// Only an L-shaped part of a rectangle is seen. The minimum-area rectangle keeps the sides; the
// axes of the covariance turn towards the seen part.
TEST(RectangleAxes, AloneKeepTheSidesOfATopThatIsSeenInPart) {
  Analytic shape;
  shape.AddRectangle({0.0, 0.0, 0.05}, {0.04, 0.0, 0.0}, {0.0, 0.006, 0.0});
  shape.AddRectangle({-0.03, 0.03, 0.05}, {0.01, 0.0, 0.0}, {0.0, 0.022, 0.0});
  const auto tilt = [&](const FeatureOptions& options) {
    base::Rng rng(1);
    const auto top = FindTopSurface(Given(shape.cloud, options).Context(), All(shape.cloud), rng);
    return std::abs(top->major_C.y());
  };
  EXPECT_GT(tilt(AsPublished()), std::sin(base::Deg(10.0)));
  EXPECT_LT(tilt(With(&FeatureAdditions::rectangle_axes)), 1e-9);
}

// Points on an ellipse with known axes; in these axes the covariance is diag(a^2, b^2) / 2.
TEST(PrincipalRectangle, LiesAlongTheLongAxisOfAnEllipse) {
  for (const double turn : {0.0, 0.4, 1.2, 2.5}) {
    const Eigen::Vector2d axis(std::cos(turn), std::sin(turn));
    const Eigen::Vector2d across(-axis.y(), axis.x());
    std::vector<Eigen::Vector2d> points;
    for (int k = 0; k < 360; ++k) {
      const double t = base::Deg(k);
      points.push_back(Eigen::Vector2d(0.1, 0.2) + 0.05 * std::cos(t) * axis +
                       0.03 * std::sin(t) * across);
    }
    const Rectangle box = PrincipalRectangle(points);
    EXPECT_NEAR(std::abs(box.axis.dot(axis)), 1.0, 1e-12);
    EXPECT_NEAR(box.length_m, 0.10, 1e-12);
    EXPECT_NEAR(box.width_m, 0.06, 1e-12);
    EXPECT_NEAR((box.center - Eigen::Vector2d(0.1, 0.2)).norm(), 0.0, 1e-12);
  }
}

// A quarter of a lid lies on a circle just as the whole lid does.
TEST(ArcRule, AloneRefusesAQuarterOfALid) {
  Analytic quarter;
  for (double r = 0.002; r <= 0.0401; r += 0.002) {
    const int n = static_cast<int>(std::ceil(r * base::kPi / 2.0 / 0.002)) + 1;
    for (int k = 0; k < n; ++k) {
      const double t = base::kPi / 2.0 * k / std::max(1, n - 1);
      quarter.Add({r * std::cos(t), r * std::sin(t), 0.1}, Vector3d::UnitZ());
    }
  }
  // Only the arc matters here, so the rim of this top is just the arc.
  TopSurface top;
  top.plane = LevelAt(0.1);
  top.points = All(quarter.cloud);
  for (const auto i : top.points) {
    if (quarter.cloud.points[i].head<2>().norm() > 0.0399) top.rim.push_back(i);
  }
  const auto found = [&](const FeatureOptions& options) {
    base::Rng rng(1);
    return FindRotationAxis(Given(quarter.cloud, options).Context(), top.points, top, rng)
        .has_value();
  };
  EXPECT_TRUE(found(AsPublished()));
  EXPECT_FALSE(found(With(&FeatureAdditions::arc_rule)));
}

// With eq. 5.9 as printed, one point in the sphere makes an object closed.
TEST(OpenStrays, AloneForgiveAPointInTheSphere) {
  Analytic cup;
  const Indices rim = cup.AddDisc({0.0, 0.0, 0.1}, 0.04, 0.030);
  Indices all = rim;
  all.push_back(cup.Add({0.0, 0.001, 0.1}, Vector3d::UnitZ()));
  TopSurface top;
  top.plane = LevelAt(0.1);
  top.center_C = {0.0, 0.0, 0.1};
  top.points = rim;
  top.rim = rim;
  const auto is_open = [&](const Indices& object, const FeatureOptions& options) {
    return IsOpen(Given(cup.cloud, options).Context(), object, top);
  };
  EXPECT_TRUE(is_open(rim, AsPublished()));
  EXPECT_FALSE(is_open(all, AsPublished()));
  EXPECT_TRUE(is_open(all, With(&FeatureAdditions::open_strays)));
}

TEST(SegmentAdditions, BoundAlphaAndDropSmallSegments) {
  SegmentOptions options;
  base::SwitchAll<SegmentAdditions>(false, options);
  EXPECT_EQ(MeshAlpha(0.0005, options), 0.0005);
  EXPECT_EQ(MeshAlpha(0.05, options), 0.05) << "d_max as it is (section 5.1.2)";
  // Two patches of 25 and 441 points.
  geometry::Points points;
  for (int x = 0; x < 21; ++x) {
    for (int y = 0; y < 21; ++y) points.emplace_back(0.002 * x, 0.002 * y, 0.0);
  }
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 5; ++y) points.emplace_back(0.2 + 0.002 * x, 0.002 * y, 0.0);
  }
  EXPECT_EQ(SegmentByMesh(points, options).size(), 2u);
  options.drop_small_segments = true;
  EXPECT_EQ(SegmentByMesh(points, options).size(), 1u);
}

// A grid with two stray points; the far one hides the near one from the first pass. The test as
// printed also removes points of the surface.
TEST(OutlierFilterOptions, SinglePassAndPrintedTest) {
  geometry::Points points;
  base::Rng rng(3);
  for (int x = 0; x < 30; ++x) {
    for (int y = 0; y < 30; ++y) {
      const double dx = rng.Uniform(-0.0004, 0.0004);
      points.emplace_back(0.002 * x + dx, 0.002 * y + rng.Uniform(-0.0004, 0.0004), 0.0);
    }
  }
  points.emplace_back(0.03, 0.03, 0.5);
  points.emplace_back(0.03, 0.03, 0.02);
  const auto removed = [&](const OutlierFilterOptions& options) {
    return points.size() - CompressionRateFilter(points, options).size();
  };
  EXPECT_EQ(removed({.isolated_only = true, .repeated = true}), 2u);
  EXPECT_EQ(removed({.isolated_only = true, .repeated = false}), 1u);
  EXPECT_GT(removed({.isolated_only = false, .repeated = false}), 20u)
      << "of 902, points of the grid; the dissertation removed 38 of 22,377";
}

}  // namespace
}  // namespace rangegrasp::perception::internal
