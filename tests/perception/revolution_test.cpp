#include "perception/internal/revolution.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;
using samples::Joined;

constexpr double kRevolutionRadius_m = 0.04;
constexpr double kInner_m = 0.036;
constexpr double kRevolutionHeight_m = 0.1;

/// A part that is rotational about the vertical through the origin, its top at kRevolutionHeight_m.
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

/// Of the polygon of 36 sides in a circle.
double Area(double radius_m) { return 18.0 * radius_m * radius_m * std::sin(base::Deg(10.0)); }

/// A can's lid and its wall on the side of a sensor towards +x, down to `low_m`.
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
    // Rings all round, no further apart than a section, from the rim to the base.
    Vector3d sum = Vector3d::Zero();
    std::vector<double> heights;
    for (std::size_t k = part.points.size(); k < whole.points_C.size(); ++k) {
      const Vector3d& p = whole.points_C[k];
      EXPECT_NEAR(p.head<2>().norm(), kRevolutionRadius_m, 1e-12);
      sum += p;
      heights.push_back(p.z());
    }
    // The step is 5 deg to 4e-8 rad: over 72 of them that is 3e-6 of the radius.
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
  // r = 0.05 - depth / 10, seen to a depth of 80 mm; below it goes on as wide as it was last.
  Analytic cone;
  base::Rng rng(1);
  const Indices lid = cone.AddDisc({0.0, 0.0, kRevolutionHeight_m}, 0.05);
  Indices points = lid;
  for (int i = 0; i < 4000; ++i) {
    const double depth = rng.Uniform(0.004, 0.08);
    const double angle = rng.Uniform(0.0, 2.0 * base::kPi);
    const double r = 0.05 - 0.1 * depth;
    points.push_back(static_cast<std::uint32_t>(cone.cloud.size()));
    cone.Add({r * std::cos(angle), r * std::sin(angle), kRevolutionHeight_m - depth},
             {std::cos(angle), std::sin(angle), -0.1});
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
  for (Vector3d& p : can.shape.cloud.points) p = lean * p;
  for (Vector3d& n : can.shape.cloud.normals) n = lean * n;
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
  length_of(0.0);  // its foot would reach under the table
}

TEST(CompleteRotational, FewPointsOfASectionSayNothingOfItsRadius) {
  Can can;
  Indices strays;
  for (const double angle : {0.0, 0.3}) {
    strays.push_back(static_cast<std::uint32_t>(can.shape.cloud.size()));
    const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    can.shape.Add(0.06 * out + Vector3d(0.0, 0.0, 0.03), out);
  }
  EXPECT_NEAR(geometry::Volume(can.Complete(strays, 0.0).surface_C),
              Area(kRevolutionRadius_m) * kRevolutionHeight_m, 1e-12);
}

/// An open cup: its lip, the outer wall, and as much of the inside as is asked for.
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
  Indices AddFloor(double z_m, double radius_m) {
    const Indices floor = shape.AddDisc({0.0, 0.0, z_m}, radius_m);
    points = Joined(points, floor);
    return floor;
  }
  Completion Complete() const {
    Given given(shape.cloud);
    given.options.open_sphere_factor = 0.1;  // open, whatever lies in the cavity
    return CompleteRotational(given.Context(), About(shape, points, lip), 0.0);
  }
  /// How deep the cavity is, from the volume that is missing.
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
  cup.AddInside(0.05);  // the last of its sections of 4 mm is that about 50 mm under the rim
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
  // Each has more points than the floor: mixed points under the rim, a ledge of the wall, and
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

/// A quarter of a block outside of a can: one face 14 mm outside of x = 46 mm (or -46 mm), 20 mm
/// wide and 40 mm high, and the level one from its upper edge to the can. Their hull is a wedge.
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
  Can two(0.02);  // each a hull of its own
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
  for (int k = 0; k < 14; ++k) {  // one fewer than an attachment has
    strays.push_back(static_cast<std::uint32_t>(can.shape.cloud.size()));
    can.shape.Add({-0.08 + 0.002 * (k % 2), 0.002 * (k % 3), 0.05 + 0.002 * (k % 5)},
                  Vector3d::UnitX());
  }
  EXPECT_NEAR(geometry::Volume(can.Complete(strays, 0.0).surface_C),
              Area(kRevolutionRadius_m) * kRevolutionHeight_m + 0.5 * 0.014 * 0.04 * 0.02, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
