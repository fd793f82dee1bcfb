#include "perception/internal/completion.h"

#include <gtest/gtest.h>

#include "base/units.h"
#include "perception/analytic.h"
#include "perception/internal/symmetry.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;
using samples::Joined;

constexpr double kCompletionRadius_m = 0.035;

/// A cylinder that lies along y at (0, 0, radius), as far round as a sensor towards +x sees it.
Analytic LyingCylinder() {
  Analytic shape;
  for (int row = -30; row <= 30; ++row) {
    for (int k = 0; k <= 70; ++k) {
      const double t = -0.6 + 2.3 * k / 70;  // from the far side over the ridge to the near one
      const Vector3d n(std::sin(t), 0.0, std::cos(t));
      shape.Add(Vector3d(0.0, 0.002 * row, kCompletionRadius_m) + kCompletionRadius_m * n, n);
    }
  }
  return shape;
}

Indices CompletionAll(const Analytic& shape) {
  Indices all(shape.cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

TEST(SymmetricImage, OfALyingCylinderIsItsOtherSide) {
  const Analytic shape = LyingCylinder();
  const Given given(shape.cloud);
  const Part part = given.Describe(CompletionAll(shape));
  ASSERT_TRUE(part.top && part.top->ridge);
  const auto image = SymmetricImage(given.Context(), part);
  // Nothing is known to be free behind the cylinder. What is seen on the far side (a third) has its
  // image in front of the cylinder or on it; that on it is as unseen as the surface.
  EXPECT_GT(image.size(), 0.9 * static_cast<double>(part.points.size()));
  double far = 0.0;
  for (const Vector3d& p : image) {
    EXPECT_NEAR(std::hypot(p.x(), p.z() - kCompletionRadius_m), kCompletionRadius_m, 1e-6);
    far = std::min(far, p.x());
  }
  EXPECT_NEAR(far, -kCompletionRadius_m, 1e-4);  // the seen side goes down past where it is widest
}

TEST(SymmetricImage, IsNotPutWhereTheSensorSawThrough) {
  const Analytic shape = LyingCylinder();
  // A wall far behind, measured all round: the space behind the ridge is free.
  geometry::Points measured;
  for (int y = -300; y <= 300; ++y) {
    for (int z = -300; z <= 150; ++z) measured.emplace_back(-0.5, 0.002 * y, 0.002 * z);
  }
  const Given given(shape.cloud, measured);
  EXPECT_TRUE(SymmetricImage(given.Context(), given.Describe(CompletionAll(shape))).empty());
  Given off(shape.cloud);
  off.options.complete_by_symmetry = false;
  EXPECT_TRUE(SymmetricImage(off.Context(), off.Describe(CompletionAll(shape))).empty());
}

TEST(SymmetricImage, OfABodyWiderThanItsTopIsItsHalfTurn) {
  // A step towards the sensor: the top is 20 x 60 mm, the ledge reaches to x = 40 mm.
  Analytic shape;
  Indices points = shape.AddRectangle({0.0, 0.0, 0.08}, {0.01, 0.0, 0.0}, {0.0, 0.03, 0.0});
  for (const Indices& more :
       {shape.AddRectangle({0.01, 0.0, 0.065}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.011}),
        shape.AddRectangle({0.025, 0.0, 0.05}, {0.015, 0.0, 0.0}, {0.0, 0.03, 0.0}),
        shape.AddRectangle({0.04, 0.0, 0.025}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.02})}) {
    points = Joined(points, more);
  }
  const Given given(shape.cloud);
  const Part part = given.Describe(points);
  ASSERT_TRUE(part.top && !part.top->ridge);
  ASSERT_NEAR(part.top->center_C.x(), 0.0, 1e-9);
  const auto image = SymmetricImage(given.Context(), part);
  ASSERT_EQ(image.size(), points.size());
  for (std::size_t k = 0; k < image.size(); ++k) {
    const Vector3d& p = shape.cloud.points[part.points[k]];
    EXPECT_NEAR((image[k] - Vector3d(-p.x(), -p.y(), p.z())).norm(), 0.0, 1e-9);
  }
}

/// A box's top and front, 60 x 80 x 100 mm, its middle at the origin.
Indices AddBox(Analytic& shape) {
  return Joined(shape.AddRectangle({0.0, 0.0, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.04, 0.0}),
                shape.AddRectangle({0.03, 0.0, 0.055}, {0.0, 0.04, 0.0}, {0.0, 0.0, 0.045}));
}

TEST(CompleteOther, ClosesABoxDownToTheTable) {
  Analytic shape;
  const Indices points = AddBox(shape);
  const Given given(shape.cloud);
  const Completion box = CompleteOther(given.Context(), given.Describe(points), 0.0);
  EXPECT_NEAR(geometry::Volume(box.surface_C), 0.06 * 0.08 * 0.1, 1e-9);
  // The part's points, and walls of posts on the outline, every 5 mm up to the top.
  EXPECT_GT(box.points_C.size(), points.size() + 2 * (12 + 16) * 18);
  for (std::size_t k = points.size(); k < box.points_C.size(); ++k) {
    const Vector3d& p = box.points_C[k];
    EXPECT_NEAR(std::max(std::abs(p.x()) / 0.03, std::abs(p.y()) / 0.04), 1.0, 1e-9);
    EXPECT_GE(p.z(), -1e-12);
    EXPECT_LE(p.z(), 0.1);
  }
}

TEST(CompleteOther, StandsOnItsBase) {
  Analytic shape;
  const Indices points = shape.AddRectangle({0.0, 0.0, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.04, 0.0});
  const Given given(shape.cloud);
  const Completion slab = CompleteOther(given.Context(), given.Describe(points), 0.07);
  EXPECT_NEAR(geometry::Volume(slab.surface_C), 0.06 * 0.08 * 0.03, 1e-9);
  for (const Vector3d& p : slab.points_C) EXPECT_GE(p.z(), 0.07 - 1e-12);
}

TEST(CompleteOther, LeavesPointsOutThatHangOffItsEndsSingly) {
  Analytic shape;
  Indices points = AddBox(shape);
  for (int k = 0; k < 3; ++k) {  // mixed points behind the box
    points.push_back(static_cast<std::uint32_t>(shape.cloud.size()));
    shape.Add({-0.04 - 0.008 * k, 0.001 * k, 0.09 - 0.01 * k}, Vector3d::UnitX());
  }
  const Given given(shape.cloud);
  Part part = given.Describe(points);
  const Completion box = CompleteOther(given.Context(), part, 0.0);
  EXPECT_NEAR(geometry::Volume(box.surface_C), 0.06 * 0.08 * 0.1, 1e-9);
}

/// The same box turned by an angle about its lower edge on the far side, which stays on the table.
struct LeaningBox {
  explicit LeaningBox(double lean_rad) {
    const Eigen::AngleAxisd turn(lean_rad, -Vector3d::UnitY());
    Analytic upright;
    points = AddBox(upright);
    for (std::size_t i = 0; i < upright.cloud.size(); ++i) {
      const Vector3d p = upright.cloud.points[i] + Vector3d(0.03, 0.0, 0.0);
      shape.Add(turn * p, turn * upright.cloud.normals[i]);
    }
  }
  Analytic shape;
  Indices points;
};

TEST(CompleteOther, ALeaningBoxIsClosedSquareToItsTop) {
  const LeaningBox box(base::Deg(25.0));
  const Given given(box.shape.cloud);
  const Part part = given.Describe(box.points);
  ASSERT_TRUE(part.top);
  // Seen down to 10 mm above its bottom.
  const Completion closed = CompleteOther(given.Context(), part, 0.0);
  EXPECT_NEAR(geometry::Volume(closed.surface_C), 0.06 * 0.08 * 0.09, 1e-6);
  for (const Vector3d& p : closed.points_C) EXPECT_GE(p.z(), -1e-9);

  Given off(box.shape.cloud);
  off.options.complete_leaning = false;
  EXPECT_GT(geometry::Volume(CompleteOther(off.Context(), part, 0.0).surface_C),
            1.2 * 0.06 * 0.08 * 0.1);
}

TEST(CompleteOther, ALeaningBoxEndsAtWhatItStandsOn) {
  const LeaningBox box(base::Deg(25.0));
  const Given given(box.shape.cloud);
  const Completion closed = CompleteOther(given.Context(), given.Describe(box.points), 0.03);
  const std::size_t seen = box.points.size();
  for (std::size_t k = seen; k < closed.points_C.size(); ++k) {
    EXPECT_GE(closed.points_C[k].z(), 0.03 - 1e-9);
  }
}

// A roof's other side is no wall square to the first.
TEST(CompleteOther, WhatSlopesAwayFromALeaningTopIsNotSquareToIt) {
  Analytic shape;
  const Vector3d down_left(-0.03, 0.0, -0.0173);
  const Vector3d down_right(0.04, 0.0, -0.04);
  const Vector3d ridge(0.0, 0.04, 0.0);
  Indices points = shape.AddRectangle(Vector3d(0.0, 0.0, 0.1) + down_left, down_left, ridge);
  points =
      Joined(points, shape.AddRectangle(Vector3d(0.0, 0.0, 0.1) + down_right, down_right, ridge));
  const Given given(shape.cloud);
  const Part part = given.Describe(points);
  Given off(shape.cloud);
  off.options.complete_leaning = false;
  EXPECT_EQ(geometry::Volume(CompleteOther(given.Context(), part, 0.0).surface_C),
            geometry::Volume(CompleteOther(off.Context(), part, 0.0).surface_C));
}

TEST(CompleteOther, AnAngleIsNotFilled) {
  // Two arms of 120 x 20 mm, 50 mm high.
  Analytic shape;
  const Indices points =
      Joined(shape.AddRectangle({0.0, -0.05, 0.05}, {0.06, 0.0, 0.0}, {0.0, 0.01, 0.0}),
             shape.AddRectangle({-0.05, 0.01, 0.05}, {0.01, 0.0, 0.0}, {0.0, 0.05, 0.0}));
  const Given given(shape.cloud);
  const Completion angle = CompleteOther(given.Context(), given.Describe(points), 0.0);
  // The hull adds the triangle between the arms; of it the slices, which overlap by 15 %, may fill
  // a third.
  const double true_volume = (0.12 * 0.02 + 0.10 * 0.02) * 0.05;
  const double between = 0.5 * 0.10 * 0.10 * 0.05;
  EXPECT_GT(geometry::Volume(angle.surface_C), true_volume);
  EXPECT_LT(geometry::Volume(angle.surface_C), true_volume + between / 3.0);
}

TEST(FootprintBox, FollowsTheTopWhereItHasADirection) {
  const PlanarFrame frame{Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitY(),
                          Vector3d::UnitZ()};
  const std::vector<Eigen::Vector2d> flat{{0.0, 0.0}, {0.1, 0.0}, {0.1, 0.04}, {0.0, 0.04}};
  TopSurface top;
  top.major_C = Vector3d(2.0, 1.0, 0.0).normalized();
  top.major_m = 0.05;
  top.minor_m = 0.02;
  const Rectangle along = FootprintBox(frame, flat, top, {});
  EXPECT_NEAR(std::abs(along.axis.dot(Eigen::Vector2d(2.0, 1.0).normalized())), 1.0, 1e-12);
  top.minor_m = 0.045;  // nearly square: the footprint's own direction
  const Rectangle own = FootprintBox(frame, flat, top, {});
  EXPECT_NEAR(own.length_m, 0.1, 1e-12);
  EXPECT_NEAR(own.width_m, 0.04, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
