#include <gtest/gtest.h>

#include <algorithm>

#include "base/rng.h"
#include "sim/render.h"

namespace rangegrasp::sim {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> SomePoints(base::Rng& rng) {
  std::vector<Vector3d> points;
  const Vector3d middle(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.5, 0.5), rng.Uniform(0.0, 0.5));
  const double size = rng.Uniform(0.01, 0.6);
  for (int i = 0; i < 20; ++i) {
    const double x = rng.Uniform(-size, size);
    const double y = rng.Uniform(-size, size);
    points.push_back(middle + Vector3d(x, y, rng.Uniform(-size, size)));
  }
  return points;
}

Eigen::Matrix3d SomeAxes(base::Rng& rng) {
  const double x = rng.Uniform(-1.0, 1.0);
  return LookingAlong({x, rng.Uniform(0.1, 1.0), rng.Uniform(-1.0, 0.5)});
}

bool AllInPicture(const std::vector<Vector3d>& points, const PinholeView& view,
                  const FramingOptions& options, double margin) {
  return std::ranges::all_of(points, [&](const Vector3d& p) {
    const Eigen::Vector2d off = PixelOf(view, p) - view.center_px;
    return (view.X_WC.inverse() * p).z() > 0.0 &&
           std::abs(off.x()) <= 0.5 * options.width_px * (1.0 - margin) + 1e-6 &&
           std::abs(off.y()) <= 0.5 * options.height_px * (1.0 - margin) + 1e-6;
  });
}

class Seeded : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Framing, Seeded, testing::Range(0, 200));

TEST_P(Seeded, EveryPointIsInThePictureWithItsMargin) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()));
  const auto points = SomePoints(rng);
  const FramingOptions options{.width_px = 640, .height_px = 480, .margin = 0.1};
  EXPECT_TRUE(AllInPicture(points, FrameAll(points, SomeAxes(rng), options), options, 0.1));
}

// One millimetre closer, a point is outside the margin, wherever the camera moves sideways.
TEST_P(Seeded, NoPlaceIsNearer) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()));
  const auto points = SomePoints(rng);
  const FramingOptions options{
      .width_px = 640, .height_px = 480, .margin = 0.1, .min_distance_m = 0.0};
  const PinholeView view = FrameAll(points, SomeAxes(rng), options);
  for (const double aside_m : {-0.002, -0.0005, 0.0, 0.0005, 0.002}) {
    for (const double up_m : {-0.002, -0.0005, 0.0, 0.0005, 0.002}) {
      PinholeView nearer = view;
      nearer.X_WC.translate(Vector3d(aside_m, up_m, 0.001));
      EXPECT_FALSE(AllInPicture(points, nearer, options, 0.1));
    }
  }
}

TEST(FrameAll, KeepsItsDistanceFromASinglePoint) {
  const std::vector<Vector3d> point = {{0.1, 0.2, 0.3}};
  const FramingOptions options{.min_distance_m = 0.4};
  const PinholeView view = FrameAll(point, LookingAlong({1.0, 0.0, 0.0}), options);
  EXPECT_TRUE(view.X_WC.translation().isApprox(Vector3d(-0.3, 0.2, 0.3), 1e-12));
  EXPECT_TRUE(PixelOf(view, point[0]).isApprox(view.center_px, 1e-9));
  // Pixels have their centers at integers: the middle is as far from the first as from the last.
  EXPECT_EQ(2.0 * view.center_px.x(), options.width_px - 1);
  EXPECT_EQ(2.0 * view.center_px.y(), options.height_px - 1);
  EXPECT_THROW(FrameAll({}, view.X_WC.linear(), options), std::invalid_argument);
}

TEST(LookingAlong, IsUprightAndRightHanded) {
  const Eigen::Matrix3d R = LookingAlong({0.0, 2.0, 0.0});
  EXPECT_TRUE(R.col(0).isApprox(Vector3d::UnitX()));   // right
  EXPECT_TRUE(R.col(1).isApprox(-Vector3d::UnitZ()));  // down
  EXPECT_TRUE(R.col(2).isApprox(Vector3d::UnitY()));
  EXPECT_NEAR(LookingAlong({0.3, -0.4, 0.5}).determinant(), 1.0, 1e-12);
  EXPECT_THROW(LookingAlong({0.0, 0.0, -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::sim
