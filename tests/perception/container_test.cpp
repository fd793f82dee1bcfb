#include "perception/internal/container.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "analytic.h"
#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using samples::Analytic;

constexpr double kRim_m = 0.08;
const Vector2d kHalf_m(0.16, 0.11);  // inner half sides of the box

// Four thin walls, seen from both sides and from above, around the origin.
void AddOpenBox(Analytic& shape) {
  const Vector3d up(0.0, 0.0, 0.5 * kRim_m);
  for (const double sign : {-1.0, 1.0}) {
    for (int axis = 0; axis < 2; ++axis) {
      const Vector3d out = sign * Vector3d::Unit(axis);
      const Vector3d along = kHalf_m[1 - axis] * Vector3d::Unit(2).cross(out);
      const Vector3d middle = kHalf_m[axis] * out + up;
      shape.AddRectangle(middle, up, along);                               // faces inward
      shape.AddRectangle(middle + 0.004 * out, along, up);                 // faces outward
      shape.AddRectangle(middle + up + 0.002 * out, along, -0.002 * out);  // the rim
    }
  }
}

void AddRoundPot(double radius_m, Analytic& shape) {
  shape.AddWall(Vector2d::Zero(), radius_m, 0.004, kRim_m);
  shape.AddWall(Vector2d::Zero(), radius_m - 0.004, 0.004, kRim_m, 0.0, 2.0 * base::kPi, true);
  shape.AddDisc({0.0, 0.0, kRim_m}, radius_m, radius_m - 0.004);
}

// As a depth camera measures it: 2 mm of noise, normals 10 deg off.
void AddCameraNoise(base::Rng& rng, Analytic& shape) {
  const auto draw = [&] { return Vector3d(rng.Normal(), rng.Normal(), rng.Normal()); };
  for (Vector3d& p : shape.cloud.points) p += 0.002 * draw();
  for (Vector3d& n : shape.cloud.normals) n = (n + 0.17 * draw()).normalized();
}

ContainerOptions OptionsForNoise() {
  ContainerOptions options;
  options.wall_m = 0.014;
  options.rim_margin_m = 0.009;
  return options;
}

TEST(FindContainer, OfABoxWithThingsInItIsItsBorderAndRim) {
  const geometry::Plane table;
  for (int k = 0; k < 20; ++k) {
    base::Rng rng(static_cast<std::uint64_t>(k));
    Analytic shape;
    AddOpenBox(shape);
    shape.AddWall({0.05, 0.03}, 0.03, 0.004, 0.12);
    shape.AddDisc({0.05, 0.03, 0.12}, 0.03);
    shape.AddRectangle({-0.08, -0.04, 0.05}, {0.03, 0.01, 0.0}, {-0.01, 0.03, 0.0});
    const Eigen::AngleAxisd turn(rng.Uniform(0.0, base::kPi), Vector3d::UnitZ());
    shape.Turn(turn);
    const bool noisy = k % 2 == 1;
    if (noisy) AddCameraNoise(rng, shape);
    const ContainerOptions options = noisy ? OptionsForNoise() : ContainerOptions();
    const auto found = FindContainer(shape.cloud, table, options);
    ASSERT_TRUE(found) << k;
    // A side is at either face of a wall 4 mm thick, and within the tolerance of a wall.
    const Vector2d sides(found->walls.length_m, found->walls.width_m);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_GE(sides[axis], 2.0 * kHalf_m[axis] - options.wall_m) << k;
      EXPECT_LE(sides[axis], 2.0 * kHalf_m[axis] + 0.008 + options.wall_m) << k;
    }
    // A direction is refined: a wall of 320 mm is 0.6 mm off at its ends, with noise less than half
    // the tolerance of a wall. The highest points are up to three times the noise of 2 mm too high.
    const auto& [frame, walls, rim_m] = *found;
    const Vector3d axis = walls.axis.x() * frame.u + walls.axis.y() * frame.v;
    EXPECT_LE(axis.cross(turn * Vector3d::UnitX()).norm(), noisy ? 0.02 : 0.002) << k;
    EXPECT_NEAR(rim_m, kRim_m + options.rim_margin_m, noisy ? 0.006 : 0.001) << k;
  }
}

TEST(FindContainer, IsNoRoundPotOfAnySizeAlsoWithNoise) {
  const geometry::Plane table;
  for (int k = 0; k < 40; ++k) {
    base::Rng rng(static_cast<std::uint64_t>(k));
    Analytic shape;
    AddRoundPot(rng.Uniform(0.08, 0.14), shape);
    const bool noisy = k % 2 == 1;
    if (noisy) AddCameraNoise(rng, shape);
    EXPECT_FALSE(FindContainer(shape.cloud, table, noisy ? OptionsForNoise() : ContainerOptions()))
        << k;
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
