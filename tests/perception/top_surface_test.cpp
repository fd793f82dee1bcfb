#include "perception/internal/top_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;

constexpr double kAlpha_m = 0.006;

geometry::Plane TopSurfaceAt(double z) { return {Vector3d::UnitZ(), -z}; }

double TwiceArea(const geometry::PointCloud& cloud, const Indices& loop) {
  double twice = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector3d& a = cloud.points[loop[i]];
    const Vector3d& b = cloud.points[loop[(i + 1) % loop.size()]];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice;
}

Indices OuterRim(const geometry::PointCloud& cloud, const Indices& points,
                 const geometry::Plane& plane, double alpha_m) {
  return OuterRims(cloud, points, plane, {&alpha_m, 1}).front();
}

TEST(OuterRims, OfAGridIsItsBorderInOrder) {
  Analytic shape;
  const Indices points =
      shape.AddRectangle({0.1, 0.2, 0.05}, {0.03, 0.0, 0.0}, {0.0, 0.02, 0.0});  // 31 x 21
  const Indices rim = OuterRim(shape.cloud, points, TopSurfaceAt(0.05), kAlpha_m);
  EXPECT_EQ(std::set(rim.begin(), rim.end()).size(), 2u * (30u + 20u));
  EXPECT_EQ(rim.size(), 2u * (30u + 20u));
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Vector3d d = shape.cloud.points[rim[i]] - Vector3d(0.1, 0.2, 0.05);
    EXPECT_NEAR(std::max(std::abs(d.x()) / 0.03, std::abs(d.y()) / 0.02), 1.0, 1e-9);
    const Vector3d& next = shape.cloud.points[rim[(i + 1) % rim.size()]];
    EXPECT_NEAR((next - shape.cloud.points[rim[i]]).norm(), samples::kStep_m, 1e-9);
  }
  EXPECT_NEAR(TwiceArea(shape.cloud, rim), 2.0 * 0.06 * 0.04, 1e-9);
}

TEST(OuterRims, OfARingIsItsOuterCircleAlone) {
  Analytic ring;
  const Indices points = ring.AddDisc({0.0, 0.0, 0.08}, 0.04, 0.03);
  const Indices rim = OuterRim(ring.cloud, points, TopSurfaceAt(0.08), kAlpha_m);
  EXPECT_GE(rim.size(), 125u);  // 2 pi 40 mm / 2 mm
  for (const auto i : rim) EXPECT_NEAR(ring.cloud.points[i].head<2>().norm(), 0.04, 1e-9);
}

TEST(OuterRims, BridgesGapsWithAWiderAlpha) {
  // A thin ring with a gap of 20 mm: as it is the shape's rim runs inside and out.
  Analytic ring;
  const Indices points = ring.AddWall({0.0, 0.0}, 0.04, 0.08, 0.082, 0.0, 2.0 * base::kPi - 0.5);
  const Indices more = ring.AddWall({0.0, 0.0}, 0.038, 0.08, 0.082, 0.0, 2.0 * base::kPi - 0.5);
  const Indices all = samples::Joined(points, more);
  const std::array<double, 2> alphas_m{kAlpha_m, 0.030};
  const auto rims = OuterRims(ring.cloud, all, TopSurfaceAt(0.081), alphas_m);
  EXPECT_GT(rims[0].size(), points.size() * 9 / 5);
  EXPECT_LT(rims[1].size(), 1.2 * static_cast<double>(points.size()));
}

TEST(OuterRims, OfPointsTooFarApartIsTheirHull) {
  Analytic corners;
  for (const auto& [x, y] :
       {std::pair(0.0, 0.0), {0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}, {0.05, 0.04}}) {
    corners.Add({x, y, 0.0}, Vector3d::UnitZ());
  }
  Indices rim = OuterRim(corners.cloud, {0, 1, 2, 3, 4}, TopSurfaceAt(0.0), kAlpha_m);
  std::sort(rim.begin(), rim.end());
  EXPECT_EQ(rim, (Indices{0, 1, 2, 3}));
  EXPECT_TRUE(OuterRim(corners.cloud, {}, TopSurfaceAt(0.0), kAlpha_m).empty());
}

TEST(TopHeight, PassesOverFourStrayPoints) {
  Analytic shape;
  Indices points = shape.AddRectangle({0.0, 0.0, 0.05}, {0.02, 0.0, 0.0}, {0.0, 0.02, 0.0});
  for (int stray = 0; stray < 5; ++stray) {
    EXPECT_NEAR(TopHeight(shape.cloud, points, TopSurfaceAt(0.0)), 0.05, 1e-12) << stray;
    points.push_back(static_cast<std::uint32_t>(shape.cloud.size()));
    shape.Add({0.0, 0.0, 0.06 + 0.001 * stray}, Vector3d::UnitZ());
  }
  EXPECT_NEAR(TopHeight(shape.cloud, points, TopSurfaceAt(0.0)), 0.06, 1e-12);
  EXPECT_NEAR(BaseHeight(shape.cloud, points, TopSurfaceAt(0.0)), 0.05, 1e-12);
}

TEST(FindTopSurface, IsTheRimAboveTheFullerFloor) {
  Analytic bowl;
  Indices all = bowl.AddDisc({0.0, 0.0, 0.02}, 0.05);
  const Indices rim = bowl.AddDisc({0.0, 0.0, 0.06}, 0.06, 0.052);
  all = samples::Joined(all, rim);
  base::Rng rng(1);
  FeatureOptions options;
  const auto top = FindTopSurface(bowl.cloud, all, TopSurfaceAt(0.0), options, rng);
  ASSERT_TRUE(top);
  EXPECT_EQ(top->points, rim);
  EXPECT_NEAR(top->center_C.head<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(top->major_m, 0.12, 0.001);
  options.top_plane_share = 1.0;  // as published
  const auto published = FindTopSurface(bowl.cloud, all, TopSurfaceAt(0.0), options, rng);
  ASSERT_TRUE(published);
  EXPECT_NEAR(published->center_C.z(), 0.02, 1e-9);
}

// A lip with a notch: its rim runs in at the notch and back along the inside, the bridged one round
// the outside alone.
TEST(FindTopSurface, HasABridgedRimWhereThatIsAskedFor) {
  Analytic lip;
  Indices all = lip.AddDisc({0.0, 0.0, 0.06}, 0.06, 0.050);
  std::erase_if(all, [&](auto i) {
    const Vector3d& p = lip.cloud.points[i];
    return p.x() > 0.0 && std::abs(p.y()) < 0.01;
  });
  FeatureOptions options;
  const auto find = [&](bool bridged_rims) {
    base::Rng rng(1);
    options.bridged_rims = bridged_rims;
    return FindTopSurface(lip.cloud, all, TopSurfaceAt(0.0), options, rng);
  };
  const auto top = find(true);
  ASSERT_TRUE(top);
  const auto innermost = [&](const Indices& rim) {
    double least_m = 1.0;
    for (const auto i : rim) least_m = std::min(least_m, lip.cloud.points[i].head<2>().norm());
    return least_m;
  };
  EXPECT_LT(innermost(top->rim), 0.053);
  EXPECT_GT(innermost(top->bridged_rim), 0.0595 * std::cos(0.2)) << "a chord over the notch";
  const auto without = find(false);
  ASSERT_TRUE(without);
  EXPECT_EQ(without->rim, top->rim);
  EXPECT_TRUE(without->bridged_rim.empty());
}

}  // namespace
}  // namespace rangegrasp::perception::internal
