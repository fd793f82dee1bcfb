#include "perception/internal/body_profile.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;

constexpr double kHeight_m = 0.1;

BodyProfile Profile(const Analytic& shape, const Indices& points) {
  return ProfileBody(samples::Given(shape.cloud).Context(), points, samples::LevelAt(kHeight_m),
                     {{0.0, 0.0, kHeight_m}, Vector3d::UnitZ()});
}

TEST(ProfileBody, GivesTheRadiiOfACone) {
  // r = 0.05 - depth / 10: a section of 4 mm spans 0.4 mm of radius.
  Analytic cone;
  base::Rng rng(1);
  Indices points;
  for (int i = 0; i < 4000; ++i) {
    const double depth = rng.Uniform(0.004, 0.08);
    const double angle = rng.Uniform(0.0, 2.0 * base::kPi);
    const double r = 0.05 - 0.1 * depth;
    points.push_back(cone.Add({r * std::cos(angle), r * std::sin(angle), kHeight_m - depth},
                              {std::cos(angle), std::sin(angle), -0.1}));
  }
  const BodyProfile profile = Profile(cone, points);
  EXPECT_EQ(profile.fraction, 1.0);
  EXPECT_EQ(profile.agreeing, points);
  ASSERT_EQ(profile.sections.size(), 19u);  // from 4 to 80 mm
  for (std::size_t k = 0; k < profile.sections.size(); ++k) {
    const Section& s = profile.sections[k];
    EXPECT_NEAR(s.depth_m, 0.004 * (static_cast<double>(k) + 1.5), 1e-12);
    // For the mean of 210 radii, uniform over 0.4 mm, five standard errors are 0.04 mm.
    EXPECT_NEAR(s.outer_m, 0.05 - 0.1 * s.depth_m, 0.00004);
    EXPECT_EQ(s.inner_points, 0u);
  }
}

TEST(ProfileBody, KeepsBothSidesOfAWallApart) {
  Analytic cup;
  const Indices outer = cup.AddWall({0.0, 0.0}, 0.040, 0.02, 0.096);
  const Indices inner = cup.AddWall({0.0, 0.0}, 0.037, 0.02, 0.096, 0.0, 2.0 * base::kPi, true);
  const BodyProfile profile = Profile(cup, samples::Joined(outer, inner));
  EXPECT_EQ(profile.fraction, 1.0);
  for (const Section& s : profile.sections) {
    EXPECT_NEAR(s.outer_m, 0.040, 1e-12);
    EXPECT_NEAR(s.inner_m, 0.037, 1e-12);
    EXPECT_GT(s.outer_points, s.inner_points);
  }
}

TEST(ProfileBody, AHandleDiffers) {
  Analytic mug;
  const Indices wall = mug.AddWall({0.0, 0.0}, 0.040, 0.02, 0.09);
  const Indices handle = mug.AddWall({0.0, 0.0}, 0.055, 0.03, 0.08, 0.0, 0.3);
  const BodyProfile profile = Profile(mug, samples::Joined(wall, handle));
  EXPECT_EQ(profile.agreeing, wall);
  EXPECT_EQ(profile.differing, handle);
  EXPECT_DOUBLE_EQ(profile.fraction, static_cast<double>(wall.size()) /
                                         static_cast<double>(wall.size() + handle.size()));
}

TEST(ProfileBody, TheFullestBandOfTwiceTheDistanceAgrees) {
  // 3 mm apart is within twice 2 mm; a dent of 10 mm is not.
  Analytic vase;
  const Indices wide = vase.AddWall({0.0, 0.0}, 0.043, 0.05, 0.09, 0.0, 3.0);
  const Indices narrow = vase.AddWall({0.0, 0.0}, 0.040, 0.05, 0.09, 3.0, 6.0);
  const Indices dent = vase.AddWall({0.0, 0.0}, 0.030, 0.05, 0.09, 6.0, 6.28);
  const BodyProfile profile = Profile(vase, samples::Joined(samples::Joined(wide, narrow), dent));
  EXPECT_EQ(profile.differing, dent);
  for (const Section& s : profile.sections) {
    EXPECT_GT(s.outer_m, 0.040);
    EXPECT_LT(s.outer_m, 0.043);
  }
}

TEST(ProfileBody, LeavesOutTheLipThatIsOfTheTop) {
  Analytic can;
  const Indices wall = can.AddWall({0.0, 0.0}, 0.04, 0.02, 0.09);
  const Indices lip = can.AddWall({0.0, 0.0}, 0.05, 0.098, 0.102);  // within 2 mm of the top
  const BodyProfile profile = Profile(can, samples::Joined(wall, lip));
  EXPECT_EQ(profile.agreeing, wall);
  EXPECT_TRUE(profile.differing.empty());
}

TEST(ProfileBody, LeavesTheTopAndLevelSurfacesOut) {
  Analytic can;
  const Indices wall = can.AddWall({0.0, 0.0}, 0.04, 0.02, 0.09);
  const Indices top = can.AddDisc({0.0, 0.0, kHeight_m}, 0.04);
  const Indices shoulder = can.AddDisc({0.0, 0.0, 0.05}, 0.06, 0.04);
  const BodyProfile profile = Profile(can, samples::Joined(samples::Joined(wall, top), shoulder));
  EXPECT_EQ(profile.agreeing, wall);
  EXPECT_TRUE(profile.differing.empty());
}

TEST(ProfileBody, CountsNormalsThatPassTheAxisApart) {
  // Normals turned by 15 deg (sine 0.26) can be noise; by 25 deg (0.42) they belong to something
  // else. The distances agree in both cases (eq. 5.8 requires no more).
  for (const auto& [turn, agrees] : {std::pair(15.0, true), std::pair(25.0, false)}) {
    Analytic wall;
    const Indices points = wall.AddWall({0.0, 0.0}, 0.04, 0.02, 0.09);
    const Eigen::AngleAxisd turned(base::Deg(turn), Vector3d::UnitZ());
    for (Vector3d& normal : wall.cloud.normals) normal = turned * normal;
    const BodyProfile profile = Profile(wall, points);
    EXPECT_EQ(profile.fraction, 1.0);
    EXPECT_EQ(profile.normal_fraction, agrees ? 1.0 : 0.0) << turn;
    EXPECT_EQ(agrees ? profile.agreeing : profile.turned, points);
    EXPECT_EQ(OnCircle(profile), points);
  }
}

TEST(ProfileBody, FewPointsSayNothing) {
  // The first rows of two walls: one section with two radii; only one can be right.
  Analytic walls;
  Indices points = walls.AddWall({0.0, 0.0}, 0.04, 0.05, 0.06);
  const Indices other = walls.AddWall({0.0, 0.0}, 0.08, 0.05, 0.06);
  points.resize(10);
  points.insert(points.end(), other.begin(), other.begin() + 9);
  EXPECT_EQ(Profile(walls, points).fraction, 1.0);
  points.push_back(other[9]);  // twenty are enough
  EXPECT_EQ(Profile(walls, points).fraction, 0.5);
  const Analytic wall;
  EXPECT_TRUE(Profile(wall, {}).sections.empty());
}

}  // namespace
}  // namespace rangegrasp::perception::internal
