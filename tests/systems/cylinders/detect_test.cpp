#include "cylinders/detect.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "cylinders/fit.h"
#include "cylinders/task/tabletop_scan.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;
using samples::Lying;
using samples::Scan;
using samples::Standing;
using samples::StandingBox;
using samples::Tabletop;

const std::vector<GivenCylinder> kGiven = {{0.02575, 0.173}, {0.02675, 0.134}};

CylinderScene Detect(const geometry::Observation& observation,
                     const std::vector<GivenCylinder>& given = kGiven,
                     const DetectOptions& options = {}) {
  base::Rng rng(1);
  return DetectCylinders(observation, given, options, rng);
}

const FoundCylinder* Find(const CylinderScene& scene, std::size_t given, const Cylinder& truth) {
  for (const FoundCylinder& found : scene.cylinders) {
    const double off = (found.cylinder_C.center - truth.center).norm();
    if (found.given == given && off < 0.01) return &found;
  }
  return nullptr;
}

void ExpectFound(const CylinderScene& scene, std::size_t given, const Cylinder& truth) {
  const FoundCylinder* found = Find(scene, given, truth);
  ASSERT_TRUE(found) << given;
  EXPECT_NEAR(found->cylinder_C.radius_m, truth.radius_m, 0.0005);
  EXPECT_LT(AngleBetween(found->cylinder_C.axis, truth.axis), base::Deg(1.0));
  EXPECT_LT((found->cylinder_C.center - truth.center).norm(), 0.002);
}

/// Both given cylinders standing, boxes, and a cylinder that was not given.
Tabletop Standing2() {
  return {{Standing(0.0, -0.07, 0.02575, 0.173), Standing(0.05, 0.08, 0.02675, 0.134),
           Standing(-0.08, 0.06, 0.035, 0.15)},
          {StandingBox(-0.05, -0.12, 0.4, {0.06, 0.05, 0.10}),
           StandingBox(0.09, 0.0, 1.1, {0.05, 0.04, 0.06})}};
}

TEST(DetectCylinders, SideOfThePlaneIsThatOfTheEquations) {
  base::Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const Vector3d n = geometry::samples::RandomDirection(rng);
    const Vector3d on = geometry::samples::RandomVector(rng);
    const Vector3d o = geometry::samples::RandomVector(rng);
    const Vector3d p = geometry::samples::RandomVector(rng);
    const double d = -n.x() * on.x() - n.y() * on.y() - n.z() * on.z();    // eq. 4.2
    const double f_c = n.x() * o.x() + n.y() * o.y() + n.z() * o.z() + d;  // eq. 4.3
    const double f_p = n.x() * p.x() + n.y() * p.y() + n.z() * p.z() + d;  // eq. 4.4
    EXPECT_EQ(IsOnSensorSide({n, -n.dot(on)}, o, p), f_p * f_c > 0.0);
    EXPECT_NEAR((geometry::Plane{n, -n.dot(on)}.Distance(on)), 0.0, 1e-12);  // eq. 4.1
  }
}

class SeededScene : public testing::TestWithParam<int> {};

TEST_P(SeededScene, BothGivenCylindersAreFoundStanding) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()));
  const Tabletop tabletop = Standing2();
  const auto scene = Detect(Scan(tabletop, {}, rng));
  EXPECT_EQ(scene.cylinders.size(), 2u);  // the third one is ignored
  ExpectFound(scene, 0, tabletop.cylinders[0]);
  ExpectFound(scene, 1, tabletop.cylinders[1]);
  EXPECT_FALSE(scene.cylinders.front().lies);
}

TEST_P(SeededScene, AndLyingInAnyDirection) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()));
  const double turn = base::kPi / 8.0 * GetParam();
  const Tabletop tabletop = {
      {Lying(-0.02, -0.08, turn, 0.02575, 0.173), Lying(0.02, 0.10, turn + 0.5, 0.02675, 0.134)},
      {StandingBox(0.12, 0.0, 0.3, {0.03, 0.03, 0.03})}};
  const auto scene = Detect(Scan(tabletop, {}, rng));
  EXPECT_EQ(scene.cylinders.size(), 2u);
  ExpectFound(scene, 0, tabletop.cylinders[0]);
  ExpectFound(scene, 1, tabletop.cylinders[1]);
  for (const auto& found : scene.cylinders) EXPECT_TRUE(found.lies);
}
INSTANTIATE_TEST_SUITE_P(Seeds, SeededScene, testing::Range(1, 9));

// The published method fits a fragment's circle only with luck: the points form a band of a few mm
// over half of the rim, and many spheres lie near to them. The cylinders it finds must exist.
TEST(DetectCylinders, AsPublishedFindsStandingCylindersInTheSensorsFrame) {
  const Tabletop tabletop = {
      {Standing(0.0, -0.07, 0.02575, 0.173), Standing(0.05, 0.08, 0.03675, 0.134)}, {}};
  int found_there = 0;
  int found = 0;
  int off_barrel = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    base::Rng rng(seed);
    const auto scene = Detect(Scan(tabletop, {.profiles = 360, .samples = 360}, rng),
                              {{0.02575, 0.173}, {0.03675, 0.134}}, AsPublished());
    EXPECT_EQ(scene.sampling.noise_m, 0.0);
    EXPECT_GE(scene.fragments.size(), 2u);
    for (const auto& one : scene.cylinders) {
      const Cylinder& truth = tabletop.cylinders[one.given];
      EXPECT_GT(one.rim_share, 0.8);
      const bool there = std::abs(one.cylinder_C.radius_m - truth.radius_m) < 0.002 &&
                         (one.cylinder_C.center - truth.center).norm() < 0.005 &&
                         AngleBetween(one.cylinder_C.axis, truth.axis) < base::Deg(5.0);
      found_there += there;
      ++found;
      off_barrel += static_cast<int>(std::ranges::count_if(one.barrel, [&](std::uint32_t i) {
        return std::ranges::none_of(scene.rims, [&](const Rim& rim) {
          return rim.share == one.rim_share &&
                 IsRadial(scene.cloud.normals[i], rim.circle_C.normal);
        });
      }));
    }
  }
  // Of 400 cylinders (seeds 1 to 200), all were found, 385 at the right place: for 80 cylinders, 72
  // to 80 within three standard deviations.
  EXPECT_GE(found_there, 72);
  EXPECT_LE(found - found_there, 8);
  // Algorithm 1 calculates the axis from barrel points: none is on the visible end.
  EXPECT_EQ(off_barrel, 0);
}

TEST(DetectCylinders, AsPublishedTakesNoRimAtAnotherHeight) {
  std::size_t rims = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    base::Rng rng(seed);
    const auto scene = Detect(
        Scan({{Standing(0.0, 0.0, 0.02575, 0.12)}, {}}, {.profiles = 360, .samples = 360}, rng),
        {{0.02575, 0.173}}, AsPublished());
    rims += scene.rims.size();
    EXPECT_TRUE(scene.cylinders.empty()) << seed;
  }
  EXPECT_GT(rims, 0u);
}

TEST(DetectCylinders, OneThatWasNotGivenIsLeftAlone) {
  base::Rng rng(4);
  // Right radius with wrong height, wrong radius with right height; standing and lying.
  const Tabletop tabletop = {
      {Standing(0.0, -0.09, 0.02575, 0.150), Standing(0.0, 0.0, 0.02575, 0.2),
       Standing(0.0, 0.09, 0.0285, 0.173), Lying(0.10, 0.0, 1.5, 0.02575, 0.14)},
      {}};
  EXPECT_TRUE(Detect(Scan(tabletop, {}, rng), {{0.02575, 0.173}}).cylinders.empty());
}

TEST(DetectCylinders, TouchingBoxesDoNotHideThem) {
  base::Rng rng(5);
  const Tabletop tabletop = {
      {Standing(0.0, 0.0, 0.02575, 0.173), Lying(0.10, 0.02, 1.4, 0.02675, 0.134)},
      {StandingBox(0.0, 0.0508, 0.0, {0.05, 0.05, 0.12}),
       StandingBox(0.0, -0.0508, 0.0, {0.04, 0.05, 0.173})}};
  const auto scene = Detect(Scan(tabletop, {}, rng));
  ExpectFound(scene, 0, tabletop.cylinders[0]);
  ExpectFound(scene, 1, tabletop.cylinders[1]);
  EXPECT_EQ(scene.cylinders.size(), 2u);
}

TEST(DetectCylinders, AnEndThatIsHiddenIsTakenToBeThere) {
  base::Rng rng(6);
  // A box in front hides the lower half of the cylinder.
  const Tabletop tabletop = {{Standing(0.0, -0.06, 0.02575, 0.173)},
                             {StandingBox(0.07, -0.06, 0.0, {0.02, 0.09, 0.12})}};
  const auto scene = Detect(Scan(tabletop, {}, rng));
  ExpectFound(scene, 0, tabletop.cylinders[0]);
}

TEST(DetectCylinders, AnyFrameWillDo) {
  base::Rng rng(7);
  const Tabletop tabletop = Standing2();
  auto observation = Scan(tabletop, {}, rng);
  const base::Pose X_CW = base::MakePose(
      Eigen::AngleAxisd(2.1, Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix(),
      {0.4, -1.0, 2.0});
  geometry::RangeImage& image = observation.views.front().image;
  for (auto& p : image.points_C) p = X_CW * p;
  for (auto& p : image.origins_C) p = X_CW * p;
  const auto scene = Detect(observation);
  EXPECT_EQ(scene.cylinders.size(), 2u);
  for (std::size_t given = 0; given < 2; ++given) {
    Cylinder truth = tabletop.cylinders[given];
    truth.center = X_CW * truth.center;
    truth.axis = X_CW.linear() * truth.axis;
    ExpectFound(scene, given, truth);
  }
}

TEST(DetectCylinders, WithoutScanOrderThereAreNoLineEdgesAndTheRestWorks) {
  base::Rng rng(8);
  const Tabletop tabletop = Standing2();
  auto observation = Scan(tabletop, {}, rng);
  EXPECT_TRUE(Detect(observation).scan_order);
  EXPECT_FALSE(Detect(observation).edges.empty());
  geometry::RangeImage& image = observation.views.front().image;
  image.samples *= image.profiles;
  image.profiles = 1;
  const auto scene = Detect(observation);
  EXPECT_FALSE(scene.scan_order);
  EXPECT_TRUE(scene.edges.empty());
  ExpectFound(scene, 0, tabletop.cylinders[0]);
  ExpectFound(scene, 1, tabletop.cylinders[1]);
}

TEST(DetectCylinders, TwoOfOneKindAreBothFound) {
  base::Rng rng(9);
  const Tabletop tabletop = {
      {Standing(0.0, -0.07, 0.02575, 0.173), Lying(0.03, 0.08, 1.0, 0.02575, 0.173)}, {}};
  const auto scene = Detect(Scan(tabletop, {}, rng));
  EXPECT_EQ(scene.cylinders.size(), 2u);
  ExpectFound(scene, 0, tabletop.cylinders[0]);
  ExpectFound(scene, 0, tabletop.cylinders[1]);
}

// If another object touches a cylinder, a piece of the barrel alone may be fitted. The rest still
// belongs to the same cylinder.
TEST(DetectCylinders, APieceIsNotFoundBesideTheWhole) {
  const Tabletop tabletop = {
      {Standing(0.10209, -0.10672, 0.02575, 0.173), Standing(0.05268, -0.12590, 0.02675, 0.134)},
      {StandingBox(0.022, -0.047, 0.3, {0.0569, 0.0336, 0.1171})}};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    base::Rng rng(seed);
    const auto scene = Detect(Scan(tabletop, {}, rng));
    EXPECT_EQ(std::ranges::count(scene.cylinders, 0u, &FoundCylinder::given), 1) << seed;
  }
}

TEST(DetectCylinders, SameSeedSameResult) {
  base::Rng rng(10);
  const auto observation = Scan(Standing2(), {}, rng);
  const auto a = Detect(observation);
  const auto b = Detect(observation);
  ASSERT_EQ(a.cylinders.size(), b.cylinders.size());
  for (std::size_t i = 0; i < a.cylinders.size(); ++i) {
    EXPECT_EQ(a.cylinders[i].cylinder_C.center, b.cylinders[i].cylinder_C.center);
    EXPECT_EQ(a.cylinders[i].barrel, b.cylinders[i].barrel);
  }
}

TEST(DetectCylinders, BadInputIsToldAndWhatIsTooLargeIsNotFound) {
  base::Rng rng(11);
  const auto observation = Scan(Standing2(), {}, rng);
  EXPECT_THROW(Detect(geometry::ObservationOf({0, 0, {}, {Vector3d::Zero()}})), base::InputError);
  EXPECT_TRUE(Detect(observation, {{2.0, 10.0}}).cylinders.empty());
  EXPECT_TRUE(Detect(observation, {{0.0001, 0.0001}}).cylinders.empty());
  geometry::RangeImage cloud{1, 3000, {}, {Vector3d(0, 0, 5)}};
  for (int i = 0; i < cloud.samples; ++i) {
    cloud.points_C.push_back(geometry::samples::RandomInUnitCube(rng));
  }
  EXPECT_THROW(Detect(geometry::ObservationOf(cloud), kGiven, AsPublished()), base::InputError);
  // Only a table.
  EXPECT_TRUE(Detect(Scan({}, {}, rng)).cylinders.empty());
}

}  // namespace
}  // namespace rangegrasp::cylinders
