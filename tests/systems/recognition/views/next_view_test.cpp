#include "recognition/views/next_view.h"

#include <gtest/gtest.h>

#include "base/units.h"
#include "geometry/box_scan.h"

namespace rangegrasp::views {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using geometry::samples::LookFrom;
using geometry::samples::ScanBox;

const AlignedBox3d kNextViewBox(Vector3d(-0.05, -0.04, 0.0), Vector3d(0.05, 0.04, 0.12));
const Vector3d kNextViewMiddle(0.0, 0.0, 0.06);

const robot::Robot& Wrist() {
  static const auto robot = robot::Robot::Load(RANGEGRASP_SOURCE_DIR "/scenes/tabletop_wrist.xml");
  return robot;
}

ViewRequest RequestFor(const robot::Robot& robot) {
  ViewRequest request;
  request.region_C = {Vector3d(-0.15, -0.15, 0.005), Vector3d(0.15, 0.15, 0.165)};
  request.obstacles_C = {Vector3d(-0.28, -0.28, 0.0), Vector3d(0.28, 0.28, 0.35)};
  request.field = {base::Deg(20.0), base::Deg(18.0), 0.22, 1.0};
  request.X_HS = *robot.X_HWristScanner;
  request.q_now = robot.home;
  return request;
}

geometry::Observation SeenFrom(const Vector3d& place) {
  base::Rng rng(1);
  geometry::Observation observation;
  observation.views.push_back(ScanBox(LookFrom(place, kNextViewMiddle), kNextViewBox, 0.0003, rng));
  return observation;
}

TEST(NextView, ASensorAtACandidateLooksAtTheMiddle) {
  for (const base::Pose& X : PosesAbout(kNextViewMiddle, {})) {
    EXPECT_TRUE(X.linear().col(2).isApprox((kNextViewMiddle - X.translation()).normalized(), 1e-9));
    EXPECT_NEAR(X.linear().determinant(), 1.0, 1e-9);
    EXPECT_GT(X.translation().z(), kNextViewMiddle.z());
  }
}

// The fixed scanner sees the box from x > 0. The hidden side faces the arm.
TEST(NextView, LooksAtTheFarSideOfABox) {
  const auto& robot = Wrist();
  const auto so_far = SeenFrom({0.55, 0.0, 0.45});
  const ViewRequest request = RequestFor(robot);
  base::Rng rng(1);
  const auto look = NextBestView(robot, so_far, request, {}, {}, rng);
  ASSERT_TRUE(look);
  EXPECT_LT(look->X_CS.translation().x(), 0.0);
  EXPECT_GT(look->gain_m3, 125e-6);
  EXPECT_GT(look->unseen_m3, look->gain_m3);
  // The arm holds the sensor at that pose, and the path leads to it.
  const base::Pose X = robot.HandPose(look->q) * request.X_HS;
  EXPECT_LT((X.translation() - look->X_CS.translation()).norm(), 1e-4);
  EXPECT_TRUE(look->way.positions.front().isApprox(robot.home));
  EXPECT_TRUE(look->way.positions.back().isApprox(look->q));

  // After that look there is less left to see.
  geometry::Observation both = so_far;
  both.views.push_back(ScanBox(look->X_CS, kNextViewBox, 0.0003, rng));
  const auto next = NextBestView(robot, both, request, {}, {}, rng);
  EXPECT_LT(next ? next->gain_m3 : 0.0, 0.6 * look->gain_m3);
}

TEST(NextView, StopsWhereThereIsLittleToSee) {
  const auto& robot = Wrist();
  NextViewOptions options;
  options.min_gain_m3 = 0.01;  // more than the region's volume
  base::Rng rng(1);
  EXPECT_FALSE(
      NextBestView(robot, SeenFrom({0.55, 0.0, 0.45}), RequestFor(robot), options, {}, rng));
}

TEST(NextView, TheSameArgumentsGiveTheSameWay) {
  const auto& robot = Wrist();
  const auto so_far = SeenFrom({0.55, 0.0, 0.45});
  std::vector<PlannedView> looks;
  for (int i = 0; i < 2; ++i) {
    base::Rng rng(7);
    auto look = NextBestView(robot, so_far, RequestFor(robot), {}, {}, rng);
    ASSERT_TRUE(look);
    looks.push_back(std::move(*look));
  }
  EXPECT_EQ(looks[0].q, looks[1].q);
  EXPECT_EQ(looks[0].way.positions, looks[1].way.positions);
}

}  // namespace
}  // namespace rangegrasp::views
