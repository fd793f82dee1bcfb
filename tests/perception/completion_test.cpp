#include "perception/internal/completion.h"

#include <gtest/gtest.h>

#include "base/units.h"
#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;
using samples::Joined;

constexpr double kCompletionRadius_m = 0.035;

/// A cylinder that lies along y at (0, 0, radius), with the part that a sensor towards +x sees.
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

TEST(SymmetricImage, OfALyingCylinderIsItsOtherSide) {
  const Analytic shape = LyingCylinder();
  const Given given(shape.cloud);
  const Part part = given.Describe(samples::All(shape.cloud));
  ASSERT_TRUE(part.top && part.top->ridge);
  const auto image = SymmetricImage(given.Context(), part);
  // No space behind the cylinder is known to be free. The seen part of the far side (a third) has
  // its image in front of the cylinder or on it; the image on it is as unseen as the surface.
  EXPECT_GT(image.size(), 0.9 * static_cast<double>(part.points.size()));
  double far = 0.0;
  for (const Vector3d& p : image) {
    EXPECT_NEAR(std::hypot(p.x(), p.z() - kCompletionRadius_m), kCompletionRadius_m, 1e-6);
    far = std::min(far, p.x());
  }
  EXPECT_NEAR(far, -kCompletionRadius_m, 1e-4);  // the seen side extends below the widest height
}

TEST(SymmetricImage, IsNotPutWhereTheSensorSawThrough) {
  const Analytic shape = LyingCylinder();
  // A wall far behind is measured all around, so the space behind the ridge is free.
  geometry::Points measured;
  for (int y = -300; y <= 300; ++y) {
    for (int z = -300; z <= 150; ++z) measured.emplace_back(-0.5, 0.002 * y, 0.002 * z);
  }
  const Given given(shape.cloud, measured);
  EXPECT_TRUE(SymmetricImage(given.Context(), given.Describe(samples::All(shape.cloud))).empty());
  Given off(shape.cloud);
  off.options.complete_by_symmetry = false;
  EXPECT_TRUE(SymmetricImage(off.Context(), off.Describe(samples::All(shape.cloud))).empty());
}

TEST(SymmetricImage, OfABodyWiderThanItsTopIsItsHalfTurn) {
  // A step towards the sensor: the top is 20 x 60 mm and the ledge extends to x = 40 mm.
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

/// Top and front of a box of 60 x 80 x 100 mm, centered at the origin.
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
  // The part's points, plus walls of posts on the outline, every 5 mm up to the top.
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
    points.push_back(shape.Add({-0.04 - 0.008 * k, 0.001 * k, 0.09 - 0.01 * k}, Vector3d::UnitX()));
  }
  const Given given(shape.cloud);
  const Completion box = CompleteOther(given.Context(), given.Describe(points), 0.0);
  EXPECT_NEAR(geometry::Volume(box.surface_C), 0.06 * 0.08 * 0.1, 1e-9);
}

/// The same box, rotated about its lower far edge, which stays on the table.
struct LeaningBox {
  explicit LeaningBox(double lean_rad) {
    points = AddBox(shape);
    for (Vector3d& p : shape.cloud.points) p += Vector3d(0.03, 0.0, 0.0);
    shape.Turn(Eigen::AngleAxisd(lean_rad, -Vector3d::UnitY()));
  }
  Analytic shape;
  Indices points;
};

TEST(CompleteOther, ALeaningBoxIsClosedSquareToItsTop) {
  const LeaningBox box(base::Deg(25.0));
  const Given given(box.shape.cloud);
  const Part part = given.Describe(box.points);
  ASSERT_TRUE(part.top);
  // The box is seen down to 10 mm above its bottom.
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
  for (std::size_t k = box.points.size(); k < closed.points_C.size(); ++k) {
    EXPECT_GE(closed.points_C[k].z(), 0.03 - 1e-9);
  }
}

// The other side of a roof is not a wall perpendicular to the first.
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
  // The hull adds the triangle between the arms. The slices overlap by 15 % and may fill a third of
  // the triangle.
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
  top.minor_m = 0.045;  // nearly square, so the footprint's own direction is used
  const Rectangle own = FootprintBox(frame, flat, top, {});
  EXPECT_NEAR(own.length_m, 0.1, 1e-12);
  EXPECT_NEAR(own.width_m, 0.04, 1e-12);
}

constexpr double kRevolutionRadius_m = 0.04;
constexpr double kInner_m = 0.036;
constexpr double kRevolutionHeight_m = 0.1;

/// A rotational part about the vertical through the origin with its top at kRevolutionHeight_m.
Part About(const Analytic& shape, Indices points, const Indices& top_points,
           double radius_m = kRevolutionRadius_m) {
  Part part;
  std::sort(points.begin(), points.end());
  part.points = std::move(points);
  part.top.emplace();
  part.top->plane = {Vector3d::UnitZ(), -kRevolutionHeight_m};
  part.top->center_C = {0.0, 0.0, kRevolutionHeight_m};
  part.top->points = top_points;
  for (const auto i : top_points) {
    if (shape.cloud.points[i].head<2>().norm() > radius_m - 1e-6) part.top->rim.push_back(i);
  }
  part.axis = RotationAxis{part.top->center_C, Vector3d::UnitZ(), radius_m, 1.0, 1.0};
  return part;
}

/// Area of a 36-sided polygon inscribed in a circle.
double Area(double radius_m) { return 18.0 * radius_m * radius_m * std::sin(base::Deg(10.0)); }

/// A can's lid, and its wall as seen from +x down to `low_m`.
struct Can {
  Analytic shape;
  Indices lid, wall;
  explicit Can(double low_m = 0.05) {
    lid = shape.AddDisc({0.0, 0.0, kRevolutionHeight_m}, kRevolutionRadius_m);
    wall = shape.AddWall({0.0, 0.0}, kRevolutionRadius_m, low_m, 0.096, -1.3, 1.3);
  }
  Completion Complete(const Indices& more, double base_m) const {
    return CompleteRotational(Given(shape.cloud).Context(),
                              About(shape, Joined(Joined(lid, wall), more), lid), base_m);
  }
};

TEST(CompleteRotational, TurnsACanDownToWhatItStandsOn) {
  for (const double base_m : {0.0, 0.03, 0.07}) {
    const Can can;
    const Given given(can.shape.cloud);
    const Part part = About(can.shape, Joined(can.lid, can.wall), can.lid);
    const Completion whole = CompleteRotational(given.Context(), part, base_m);
    EXPECT_NEAR(geometry::Volume(whole.surface_C),
                Area(kRevolutionRadius_m) * (kRevolutionHeight_m - base_m), 1e-12);
    for (const Vector3d& v : whole.surface_C.vertices) EXPECT_GE(v.z(), base_m - 1e-12);
    // Full rings from the rim to the base, at most a section apart.
    Vector3d sum = Vector3d::Zero();
    std::vector<double> heights;
    for (std::size_t k = part.points.size(); k < whole.points_C.size(); ++k) {
      const Vector3d& p = whole.points_C[k];
      EXPECT_NEAR(p.head<2>().norm(), kRevolutionRadius_m, 1e-12);
      sum += p;
      heights.push_back(p.z());
    }
    // The step is 5 deg with an error of 4e-8 rad; 72 steps give 3e-6 of the radius.
    EXPECT_LT(sum.head<2>().norm() / static_cast<double>(heights.size()),
              3e-6 * kRevolutionRadius_m);
    std::sort(heights.begin(), heights.end());
    EXPECT_NEAR(heights.front(), base_m, 1e-12);
    EXPECT_NEAR(heights.back(), kRevolutionHeight_m, 1e-12);
    for (std::size_t k = 1; k < heights.size(); ++k) {
      EXPECT_LE(heights[k] - heights[k - 1], given.options.axis.section_m + 1e-9);
    }
  }
}

TEST(CompleteRotational, FollowsTheRadiiOfACone) {
  // r = 0.05 - depth / 10, seen to a depth of 80 mm; below, the last radius continues.
  Analytic cone;
  base::Rng rng(1);
  const Indices lid = cone.AddDisc({0.0, 0.0, kRevolutionHeight_m}, 0.05);
  Indices points = lid;
  for (int i = 0; i < 4000; ++i) {
    const double depth = rng.Uniform(0.004, 0.08);
    const double angle = rng.Uniform(0.0, 2.0 * base::kPi);
    const double r = 0.05 - 0.1 * depth;
    points.push_back(
        cone.Add({r * std::cos(angle), r * std::sin(angle), kRevolutionHeight_m - depth},
                 {std::cos(angle), std::sin(angle), -0.1}));
  }
  const Completion whole =
      CompleteRotational(Given(cone.cloud).Context(), About(cone, points, lid, 0.05), 0.0);
  const double seen = 0.078;  // middle of the last section
  const double end = 0.05 - 0.1 * seen;
  const double expected =
      Area(1.0) * (seen * (0.05 * 0.05 + 0.05 * end + end * end) / 3.0 + end * end * (0.1 - seen));
  // Radii are right to 0.04 mm of 42 (see ProfileBody's test of a cone): 0.2 % of the volume.
  EXPECT_NEAR(geometry::Volume(whole.surface_C), expected, 0.002 * expected);
}

TEST(CompleteRotational, ALeaningBodyReachesItsBaseAlongItsAxis) {
  Can can;
  Part part = About(can.shape, Joined(can.lid, can.wall), can.lid);
  const Eigen::AngleAxisd lean(base::Deg(20.0), Vector3d::UnitY());
  can.shape.Turn(lean);
  const Vector3d direction = lean * Vector3d::UnitZ();
  part.axis->center_C = part.top->center_C = kRevolutionHeight_m * direction;
  part.axis->direction_C = direction;
  part.top->plane = {direction, -kRevolutionHeight_m};
  const double top_m = part.axis->center_C.z();
  const Given given(can.shape.cloud);
  const auto length_of = [&](double base_m) {
    double deepest = 0.0;
    const Completion whole = CompleteRotational(given.Context(), part, base_m);
    for (const Vector3d& v : whole.surface_C.vertices) {
      deepest = std::max(deepest, (part.axis->center_C - v).dot(direction));
      EXPECT_GE(v.z(), -1e-12);
    }
    for (const Vector3d& p : whole.points_C) EXPECT_GE(p.z(), -1e-12);
    return deepest;
  };
  EXPECT_NEAR(length_of(0.03), (top_m - 0.03) / std::cos(base::Deg(20.0)), 1e-9);
  length_of(0.0);  // its foot would be below the table
}

TEST(CompleteRotational, FewPointsOfASectionSayNothingOfItsRadius) {
  Can can;
  Indices strays;
  for (const double angle : {0.0, 0.3}) {
    const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    strays.push_back(can.shape.Add(0.06 * out + Vector3d(0.0, 0.0, 0.03), out));
  }
  EXPECT_NEAR(geometry::Volume(can.Complete(strays, 0.0).surface_C),
              Area(kRevolutionRadius_m) * kRevolutionHeight_m, 1e-12);
}

/// An open cup: its lip, its outer wall, and the requested part of its inside.
struct RevolutionCup {
  Analytic shape;
  Indices points, lip;
  RevolutionCup() {
    lip = shape.AddDisc({0.0, 0.0, kRevolutionHeight_m}, kRevolutionRadius_m, kInner_m);
    points = Joined(lip, shape.AddWall({0.0, 0.0}, kRevolutionRadius_m, 0.01, 0.096, -1.3, 1.3));
  }
  void AddInside(double low_m) {
    points = Joined(points, shape.AddWall({0.0, 0.0}, kInner_m, low_m, 0.096, 1.9, 4.4, true));
  }
  void AddFloor(double z_m, double radius_m) {
    points = Joined(points, shape.AddDisc({0.0, 0.0, z_m}, radius_m));
  }
  Completion Complete() const {
    Given given(shape.cloud);
    given.options.open_sphere_factor = 0.1;  // open, whatever lies in the cavity
    return CompleteRotational(given.Context(), About(shape, points, lip), 0.0);
  }
  /// Depth of the cavity, from the missing volume.
  double Cavity() const {
    return (Area(kRevolutionRadius_m) * kRevolutionHeight_m -
            geometry::Volume(Complete().surface_C)) /
           Area(kInner_m);
  }
};

TEST(CompleteRotational, ACavityGoesDownToTheFloorThatWasSeen) {
  RevolutionCup cup;
  cup.AddInside(0.05);
  cup.AddFloor(0.02, 0.01);
  EXPECT_NEAR(cup.Cavity(), 0.08, 1e-9);
}

TEST(CompleteRotational, WithoutAFloorACavityGoesAsDeepAsItsWallWasSeen) {
  RevolutionCup cup;
  cup.AddInside(0.05);  // the last of its 4 mm sections is at about 50 mm below the rim
  EXPECT_NEAR(cup.Cavity(), 0.05, 1e-9);
  Indices floor = cup.shape.AddDisc({0.0, 0.0, 0.02}, 0.01);
  floor.resize(9);  // too few for a floor
  cup.points = Joined(cup.points, floor);
  EXPECT_NEAR(cup.Cavity(), 0.05, 1e-9);
}

TEST(CompleteRotational, ACavityOfWhichNothingWasSeenIsAsDeepAsItIsWide) {
  // Its wall is assumed to be 4 mm.
  EXPECT_NEAR(RevolutionCup().Cavity(), kRevolutionRadius_m, 1e-9);
}

TEST(CompleteRotational, AFloorFacesUpInsideTheWallsAndBelowTheLip) {
  const auto with = [](const Vector3d& center, double radius_m, double inner_m,
                       const Vector3d& normal) {
    RevolutionCup cup;
    cup.AddInside(0.05);
    cup.AddFloor(0.02, 0.01);
    const Indices more = cup.shape.AddDisc(center, radius_m, inner_m);
    for (const auto i : more) cup.shape.cloud.normals[i] = normal;
    cup.points = Joined(cup.points, more);
    return cup.Cavity();
  };
  // These have more points than the floor: mixed points below the rim, a ledge on the wall, and
  // points that do not face up.
  EXPECT_NEAR(with({0.0, 0.0, 0.095}, 0.02, 0.0, Vector3d::UnitZ()), 0.08, 1e-9);
  EXPECT_NEAR(with({0.0, 0.0, 0.06}, 0.0355, 0.0325, Vector3d::UnitZ()), 0.08, 1e-9);
  EXPECT_NEAR(with({0.0, 0.0, 0.06}, 0.02, 0.0, Vector3d(1.0, 0.0, 1.0).normalized()), 0.08, 1e-9);
}

TEST(CompleteRotational, LeavesAWallUnderACavityAndNoneOfTheInsideBelowTheFloor) {
  RevolutionCup thin;
  thin.AddInside(0.05);
  thin.AddFloor(0.001, 0.01);
  EXPECT_NEAR(thin.Cavity(), kRevolutionHeight_m - 0.004, 1e-9);
  RevolutionCup raised;
  raised.AddInside(0.01);
  raised.AddFloor(0.05, 0.01);
  for (const Vector3d& v : raised.Complete().surface_C.vertices) {
    if (std::abs(v.head<2>().norm() - kInner_m) < 1e-6) {
      EXPECT_GE(v.z(), 0.05 - 1e-12);
    }
  }
}

/// Two faces of a block on the outside of a can: one 14 mm outside x = 46 mm (or -46 mm), 20 mm
/// wide and 40 mm high, and a level one from its upper edge to the can. Their hull is a wedge.
Indices AddHandle(Analytic& shape, double side) {
  return Joined(shape.AddRectangle({side * 0.060, 0.0, 0.05}, {0.0, 0.01, 0.0}, {0.0, 0.0, 0.02}),
                shape.AddRectangle({side * 0.053, 0.0, 0.07}, {0.007, 0.0, 0.0}, {0.0, 0.01, 0.0}));
}

TEST(CompleteRotational, AddsTheHullOfWhatIsAttached) {
  const double wedge = 0.5 * 0.014 * 0.04 * 0.02;
  const double body = Area(kRevolutionRadius_m) * kRevolutionHeight_m;
  Can one(0.02);
  EXPECT_NEAR(geometry::Volume(one.Complete(AddHandle(one.shape, 1.0), 0.0).surface_C),
              body + wedge, 1e-12);
  Can two(0.02);  // each has its own hull
  const Indices both = Joined(AddHandle(two.shape, 1.0), AddHandle(two.shape, -1.0));
  EXPECT_NEAR(geometry::Volume(two.Complete(both, 0.0).surface_C), body + 2.0 * wedge, 1e-12);
  Can knob;  // above the lid, nearer to the axis than its rim
  const Indices above =
      Joined(knob.shape.AddRectangle({0.0, 0.0, 0.12}, {0.01, 0.0, 0.0}, {0.0, 0.01, 0.0}),
             knob.shape.AddRectangle({0.01, 0.0, 0.113}, {0.0, 0.01, 0.0}, {0.0, 0.0, 0.007}));
  EXPECT_NEAR(geometry::Volume(knob.Complete(above, 0.0).surface_C),
              body + 0.5 * 0.02 * 0.014 * 0.02, 1e-12);
}

TEST(CompleteRotational, LeavesStrayPointsOut) {
  Can can(0.02);
  Indices strays = AddHandle(can.shape, 1.0);
  for (int k = 0; k < 14; ++k) {  // one fewer than an attachment needs
    strays.push_back(can.shape.Add(
        {-0.08 + 0.002 * (k % 2), 0.002 * (k % 3), 0.05 + 0.002 * (k % 5)}, Vector3d::UnitX()));
  }
  EXPECT_NEAR(geometry::Volume(can.Complete(strays, 0.0).surface_C),
              Area(kRevolutionRadius_m) * kRevolutionHeight_m + 0.5 * 0.014 * 0.04 * 0.02, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
