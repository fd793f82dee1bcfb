#include "perception/internal/merging.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "base/rng.h"
#include "geometry/random_points.h"
#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using geometry::samples::RandomInUnitCube;
using samples::Analytic;
using samples::Given;
using samples::Joined;

/// A box about (x, y) as seen from +x: its top and its front face, which starts `gap_m` below the
/// top.
struct BoxFaces {
  Indices top;
  Indices front;
};
BoxFaces FragmentsAddBox(Analytic& shape, double x, double y, double height_m, double gap_m = 0.0) {
  BoxFaces faces;
  faces.top = shape.AddRectangle({x, y, height_m}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0});
  const double low = 0.01;
  const double high = height_m - gap_m;
  faces.front = shape.AddRectangle({x + 0.03, y, 0.5 * (low + high)}, {0.0, 0.03, 0.0},
                                   {0.0, 0.0, 0.5 * (high - low)});
  return faces;
}

Kinship KinshipOf(const Given& given, const Indices& fragment, const Indices& host) {
  return FindKinship(given.Context(), given.Describe(fragment), given.Describe(host));
}

/// A description that only states whether the part is rotational.
Part Described(const Given& given, const Indices& points, bool rotational) {
  Part part = given.Describe(points);
  part.axis.reset();
  if (rotational) part.axis.emplace();
  return part;
}

Kinship KinshipOf(const Given& given, const Indices& fragment, const Indices& host,
                  bool rotational) {
  return FindKinship(given.Context(), Described(given, fragment, false),
                     Described(given, host, rotational));
}

TEST(FindKinship, AFrontFaceUnderItsTopGoesOnFromIt) {
  for (const auto& [gap, kinship] :
       {std::pair(0.002, Kinship::kSurface), std::pair(0.010, Kinship::kSurface),
        std::pair(0.014, Kinship::kNone)}) {  // the gap is 12 mm
    Analytic shape;
    const BoxFaces box = FragmentsAddBox(shape, 0.0, 0.0, 0.1, gap);
    const Given given(shape.cloud);
    EXPECT_EQ(KinshipOf(given, box.front, box.top), kinship) << gap;
  }
}

TEST(FindKinship, TheFarInsideOfALyingCupIsWithinIt) {
  // The sensor sees half of the outside and, through the mouth, the other half of the inside. Or it
  // sees an object that stands behind the cup or lies under its flank.
  Analytic shape;
  const auto add_wall = [&](double radius_m, double from_m, double to_m, double from_rad,
                            double to_rad, double side) {
    Indices added;
    for (double x = from_m; x < to_m; x += samples::kStep_m) {
      for (double a = from_rad; a < to_rad; a += samples::kStep_m / radius_m) {
        const Vector3d out(0.0, std::sin(a), std::cos(a));
        added.push_back(shape.Add(Vector3d(x, 0.0, 0.035) + radius_m * out, side * out));
      }
    }
    return added;
  };
  const Indices outside = add_wall(0.035, -0.05, 0.05, -0.6, 1.7, 1.0);
  const Indices inside = add_wall(0.031, 0.02, 0.05, 3.4, 5.2, -1.0);
  const Indices beyond =
      shape.AddRectangle({0.03, -0.05, 0.03}, {0.02, 0.0, 0.0}, {0.0, 0.0, 0.02});
  const Indices under =
      shape.AddRectangle({0.0, 0.033, 0.004}, {0.0, 0.0, 0.004}, {0.02, 0.0, 0.0});
  const Given given(shape.cloud);
  ASSERT_TRUE(given.Describe(outside).axis);
  EXPECT_EQ(KinshipOf(given, inside, outside), Kinship::kWithin);
  EXPECT_EQ(KinshipOf(given, beyond, outside), Kinship::kNone);
  EXPECT_EQ(KinshipOf(given, under, outside), Kinship::kNone);
}

/// A round cap at the end of a flat bottle.
struct Cap {
  double aside_m = 0.0;  ///< offset from the bottle's center, across
  double over_m = 0.0;   ///< offset towards its broad face
  double gap_m = 0.002;  ///< gap to the bottle's end
  double length_m = 0.03;
  double radius_m = 0.012;
};
Indices AddCap(Analytic& shape, const Vector3d& end, const Vector3d& axis, const Vector3d& face,
               const Cap& cap) {
  const Vector3d side = axis.cross(face);
  const Vector3d start = end + cap.gap_m * axis + cap.aside_m * side + cap.over_m * face;
  Indices points;
  for (int row = 0; row * samples::kStep_m <= cap.length_m; ++row) {
    for (double a = -1.5; a < 1.5; a += samples::kStep_m / cap.radius_m) {
      const Vector3d out = std::cos(a) * face + std::sin(a) * side;
      points.push_back(shape.Add(start + row * samples::kStep_m * axis + cap.radius_m * out, out));
    }
  }
  return points;
}

/// A flat bottle that ends at `end`: its broad face, 60 mm wide and 100 mm long, and its end, 40 mm
/// thick.
Indices AddFlatBottle(Analytic& shape, const Vector3d& end, const Vector3d& axis,
                      const Vector3d& face) {
  const Vector3d side = axis.cross(face);
  return Joined(shape.AddRectangle(end - 0.05 * axis + 0.02 * face, 0.03 * side, 0.05 * axis),
                shape.AddRectangle(end, 0.02 * face, 0.03 * side));
}

/// Kinship for a lying bottle, seen from beyond its end, where the segmentation cuts.
/// @param rotational  whether the bottle is round; by default as it is described
Kinship KinshipOf(const Cap& cap, std::optional<bool> rotational = {}) {
  Analytic shape;
  const Vector3d end(0.0, 0.05, 0.02);
  const Indices body = AddFlatBottle(shape, end, Vector3d::UnitY(), Vector3d::UnitZ());
  const Indices points = AddCap(shape, end, Vector3d::UnitY(), Vector3d::UnitZ(), cap);
  Given given(shape.cloud, {}, {0.0, 0.8, 0.62});
  given.options.merge.cut_m = 0.004;
  return rotational ? KinshipOf(given, points, body, *rotational) : KinshipOf(given, points, body);
}

TEST(FindKinship, ACapIsOfItsBottleWhetherThatStandsLiesOrLeans) {
  const Vector3d up = Vector3d::UnitZ();
  const Vector3d leaning(0.0, 0.8, 0.6);
  for (const auto& [axis, face] : {std::pair<Vector3d, Vector3d>(up, Vector3d::UnitX()),
                                   std::pair<Vector3d, Vector3d>(Vector3d::UnitY(), up),
                                   std::pair<Vector3d, Vector3d>(-Vector3d::UnitY(), up),
                                   std::pair<Vector3d, Vector3d>(leaning, {0.0, -0.6, 0.8})}) {
    for (const double cut_m : {0.0, 0.004}) {
      Analytic shape;
      const Vector3d end(0.0, 0.0, 0.12);
      const Indices body = AddFlatBottle(shape, end, axis, face);
      const Indices cap = AddCap(shape, end, axis, face, {});
      Given given(shape.cloud);
      given.options.merge.cut_m = cut_m;
      EXPECT_EQ(KinshipOf(given, cap, body), Kinship::kCap) << axis.transpose() << ' ' << cut_m;
    }
  }
}

TEST(FindKinship, ACapIsInTheMiddleOfTheEndSmallAndNear) {
  // One row of points (2 mm) on either side of each bound.
  const std::vector<std::pair<Cap, Cap>> caps = {
      {{.aside_m = 0.008}, {.aside_m = 0.010}},  // 0.15 of 60 mm
      {{.aside_m = -0.008}, {.aside_m = -0.010}},
      {{.over_m = 0.012}, {.over_m = 0.016}},      // half of it over the section and its margin
      {{.gap_m = 0.011}, {.gap_m = 0.013}},        // the limit is 12 mm
      {{.gap_m = -0.004}, {.gap_m = -0.012}},      // 5 mm
      {{.length_m = 0.042}, {.length_m = 0.048}},  // 0.45 of 100 mm
      {{.radius_m = 0.020}, {.radius_m = 0.022}},  // 0.7 of 60 mm
  };
  for (std::size_t i = 0; i < caps.size(); ++i) {
    EXPECT_EQ(KinshipOf(caps[i].first), Kinship::kCap) << i;
    EXPECT_NE(KinshipOf(caps[i].second), Kinship::kCap) << i;
  }
}

TEST(FindKinship, WhatLiesOnABottleOrBesideItIsNoCap) {
  Analytic shape;
  const Indices bottle =
      AddFlatBottle(shape, {0.0, 0.05, 0.02}, Vector3d::UnitY(), Vector3d::UnitZ());
  const Indices on = AddCap(shape, {0.0, -0.01, 0.052}, Vector3d::UnitY(), Vector3d::UnitZ(), {});
  const Indices beside =
      AddCap(shape, {0.034, 0.0, 0.02}, Vector3d::UnitX(), Vector3d::UnitZ(), {});
  Given given(shape.cloud);
  given.options.merge.cut_m = 0.004;
  EXPECT_EQ(KinshipOf(given, on, bottle), Kinship::kNone);
  EXPECT_EQ(KinshipOf(given, beside, bottle), Kinship::kNone);
}

// The cap is behind a shoulder that was not seen.
TEST(FindKinship, ARoundBottlesShoulderMayBeHidden) {
  EXPECT_EQ(KinshipOf({.gap_m = 0.028, .length_m = 0.02}, true), Kinship::kCap);
  EXPECT_EQ(KinshipOf({.gap_m = 0.032, .length_m = 0.02}, true), Kinship::kNone);
  EXPECT_EQ(KinshipOf({.gap_m = 0.028, .length_m = 0.02}, false), Kinship::kNone);
}

TEST(FindKinship, ASlopeGoesOnAcrossAGapUpwardsAndNotSideways) {
  // A slope of 45 deg towards the sensor, in three pieces 10 mm apart.
  Analytic shape;
  const Vector3d y(0.0, 0.03, 0.0);
  const Vector3d up = 0.02 * Vector3d(-1.0, 0.0, 1.0).normalized();
  const Vector3d low_center(0.0, 0.0, 0.03);
  const Indices low = shape.AddRectangle(low_center, y, up);
  const Indices high = shape.AddRectangle(low_center + 2.5 * up, y, up);
  const Indices beside = shape.AddRectangle(low_center + Vector3d(0.0, 0.07, 0.0), y, up);
  const Given given(shape.cloud);
  EXPECT_EQ(KinshipOf(given, high, low), Kinship::kSurface);
  EXPECT_EQ(KinshipOf(given, beside, low), Kinship::kNone);
}

TEST(FindKinship, AConcaveJunctionIsTwoObjects) {
  // The foot of a wall that stands behind a lower box's top, 10 mm from it.
  Analytic shape;
  const Indices top = shape.AddRectangle({0.04, 0.0, 0.05}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0});
  const Indices wall = shape.AddRectangle({0.0, 0.0, 0.09}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.035});
  const Given given(shape.cloud);
  EXPECT_EQ(KinshipOf(given, wall, top), Kinship::kNone);
  EXPECT_EQ(KinshipOf(given, top, wall), Kinship::kNone);
}

TEST(FindKinship, BoxesBesideEachOtherHaveNone) {
  for (int step = 0; step < 12; ++step) {
    const double a = base::kPi * step / 6;
    Analytic shape;
    const BoxFaces one = FragmentsAddBox(shape, 0.0, 0.0, 0.08);
    const BoxFaces other = FragmentsAddBox(shape, 0.09 * std::cos(a), 0.09 * std::sin(a), 0.06);
    const Given given(shape.cloud);
    EXPECT_EQ(KinshipOf(given, Joined(other.top, other.front), Joined(one.top, one.front)),
              Kinship::kNone)
        << step;
  }
}

TEST(MergeFragments, JoinsWhatIsKinAndLeavesTheRest) {
  Analytic shape;
  const BoxFaces one = FragmentsAddBox(shape, 0.0, -0.06, 0.1, 0.008);
  const BoxFaces two = FragmentsAddBox(shape, 0.0, 0.06, 0.08, 0.008);
  const Given given(shape.cloud);
  std::vector<Part> parts;
  for (const Indices& points : {one.top, two.front, two.top, one.front}) {
    parts.push_back(given.Describe(points));
  }
  base::Rng rng(1);
  MergeFragments(given.Context(), parts, rng);
  ASSERT_EQ(parts.size(), 2u);
  for (const Part& part : parts) {
    const BoxFaces& box = part.points.front() == one.top.front() ? one : two;
    Indices expected = Joined(box.top, box.front);
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(part.points, expected);
    EXPECT_TRUE(part.top);
  }
}

TEST(FindKinship, ACrumbUnderTheTopIsWithinAndMoreIsNot) {
  // Two or four rows of points behind the edge of a top with 31 x 31 points, 8 mm below it. The gap
  // runs sideways, so neither is part of its surface.
  for (const double half_m : {0.001, 0.003}) {
    Analytic shape;
    const Indices top = shape.AddRectangle({0.0, 0.0, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0});
    const Indices under =
        shape.AddRectangle({0.0, 0.033, 0.092}, {0.018, 0.0, 0.0}, {0.0, 0.0, half_m});
    EXPECT_EQ(KinshipOf(Given(shape.cloud), under, top),
              half_m < 0.002 ? Kinship::kWithin : Kinship::kNone);
  }
}

TEST(FindKinship, ADeepFloorIsWithinARotationalHostOnly) {
  Analytic shape;
  const Indices ring = shape.AddDisc({0.0, 0.0, 0.1}, 0.05, 0.015);
  const Indices floor = shape.AddDisc({0.0, 0.0, 0.03}, 0.03);
  const Given given(shape.cloud);
  EXPECT_EQ(KinshipOf(given, floor, ring, true), Kinship::kWithin);
  EXPECT_EQ(KinshipOf(given, floor, ring, false), Kinship::kNone);
}

/// 31 rows along x; `over` of them are above a host that ends at x = 0, or within `margin_m` of it.
Indices AddRowsOver(Analytic& shape, int over, double margin_m, double height_m) {
  return shape.AddRectangle({margin_m + 0.002 * (15.5 - over), 0.0, height_m}, {0.03, 0.0, 0.0},
                            {0.0, 0.01, 0.0});
}

TEST(FindKinship, SevenTenthsOverTheFootprintAreWithin) {
  // The middle between two rows is on the border of the margin of 5 mm. Rows half a step further in
  // are inside the margin, rows half a step further out are outside.
  constexpr double kMargin_m = 0.005;
  for (const auto& [over, kinship] :
       {std::pair(21, Kinship::kNone), std::pair(22, Kinship::kWithin)}) {
    for (const double shift : {-0.0009, 0.0, 0.0009}) {
      Analytic shape;
      const Indices host =
          shape.AddRectangle({-0.06, 0.0, 0.1}, {0.06, 0.0, 0.0}, {0.0, 0.06, 0.0});
      const Indices floor = AddRowsOver(shape, over, kMargin_m + shift, 0.05);
      EXPECT_EQ(KinshipOf(Given(shape.cloud), floor, host, true), kinship) << over << ' ' << shift;
    }
  }
}

TEST(FindKinship, IsWithinUpToAMarginOverTheTop) {
  for (const double over : {0.0029, 0.0031}) {  // the limit is 3 mm
    Analytic shape;
    const Indices ring = shape.AddDisc({0.0, 0.0, 0.1}, 0.06, 0.05);
    const Indices post = shape.AddRectangle({0.0, 0.0, 0.5 * (0.15 + over)}, {0.0, 0.02, 0.0},
                                            {0.0, 0.0, 0.5 * (0.05 + over)});
    EXPECT_EQ(KinshipOf(Given(shape.cloud), post, ring, true),
              over < 0.003 ? Kinship::kWithin : Kinship::kNone);
  }
}

/// Two edges of a slope of 45 deg towards the sensor, whose points face each other across a gap.
struct Edges {
  Analytic shape;
  Indices low, high;
  Vector3d up = Vector3d(-1.0, 0.0, 1.0).normalized();
  Vector3d normal = Vector3d(1.0, 0.0, 1.0).normalized();

  Edges(int points, double gap_m) {
    for (int k = 0; k < points; ++k) {
      const Vector3d p(0.0, 0.002 * (k - 0.5 * points), 0.05);
      for (int row = 0; row < 5; ++row) low.push_back(shape.Add(p - 0.002 * row * up, normal));
      high.push_back(shape.Add(p + gap_m * up, normal));
    }
  }
  /// Turns the normals of this many points of an edge towards the gap (positive sines) or away.
  void Turn(bool of_high, int points, double sine) {
    for (int k = 0; k < points; ++k) {
      const auto i =
          of_high ? high[static_cast<std::size_t>(k)] : low[static_cast<std::size_t>(5 * k)];
      shape.cloud.normals[i] =
          std::sqrt(1.0 - sine * sine) * normal + (of_high ? -sine : sine) * up;
    }
  }
  Kinship Find() const { return KinshipOf(Given(shape.cloud), high, low, false); }
};

TEST(FindKinship, ASurfaceGoesOnFromEightPointsAcrossTheGap) {
  EXPECT_EQ(Edges(7, 0.010).Find(), Kinship::kNone);
  EXPECT_EQ(Edges(8, 0.010).Find(), Kinship::kSurface);
  EXPECT_EQ(Edges(20, 0.0119).Find(), Kinship::kSurface);  // the limit is 12 mm
  EXPECT_EQ(Edges(20, 0.0121).Find(), Kinship::kNone);
}

TEST(FindKinship, MoreThanHalfOfTheSurfaceGoesOn) {
  for (const int broken : {9, 10}) {
    Edges edges(20, 0.010);
    edges.Turn(true, broken, 0.5);
    EXPECT_EQ(edges.Find(), broken == 9 ? Kinship::kSurface : Kinship::kNone);
  }
}

TEST(FindKinship, NeitherSideIsInFrontOfTheOther) {
  // 1.5 mm in front across 10 mm is a sine of 0.15. Behind, any fold is convex.
  for (const bool of_high : {false, true}) {
    for (const double sine : {-0.9, -0.2, 0.14, 0.16, 0.5}) {
      Edges edges(20, 0.010);
      edges.Turn(of_high, 20, sine);
      EXPECT_EQ(edges.Find(), sine < 0.15 ? Kinship::kSurface : Kinship::kNone)
          << of_high << ' ' << sine;
    }
  }
}

TEST(FindKinship, AGapRunsAlongTheViewOfTheSensorThatSawIt) {
  // Level points far from each other, each with a host point 10 mm away. Its direction is rotated
  // from the sensor's direction by 29 or 31 deg (30 deg is allowed).
  const std::vector<Vector3d> sensors = {{0.8, 0.0, 0.62}, {0.1, -0.9, 0.62}};
  for (const std::uint32_t place : {0u, 1u}) {
    for (const double turn : {0.0, 29.0, -29.0, 151.0, -151.0, 31.0, -31.0, 149.0, 90.0}) {
      Analytic shape;
      Indices fragment, host;
      const Vector3d row = place == 0 ? Vector3d::UnitY() : Vector3d::UnitX();
      for (std::uint32_t k = 0; k < 8; ++k) {
        const Vector3d p = (0.03 * k - 0.1) * row + 0.05 * Vector3d::UnitZ();
        Vector3d view = sensors[place] - p;
        view.z() = 0.0;
        shape.Add(p, Vector3d::UnitZ());
        shape.Add(
            p + 0.010 * (Eigen::AngleAxisd(base::Deg(turn), Vector3d::UnitZ()) * view.normalized()),
            Vector3d::UnitZ());
        fragment.push_back(2 * k);
        host.push_back(2 * k + 1);
      }
      Given given(shape.cloud);
      given.views.places.emplace_back(shape.cloud.points, sensors[1]);
      for (auto& of : given.views.place_of) of = place;
      const double from_view = std::min(std::abs(turn), 180.0 - std::abs(turn));
      const Kinship kinship = KinshipOf(given, fragment, host, false);
      // At right angles to the view, the points lie above each other's footprints.
      EXPECT_EQ(kinship == Kinship::kSurface, from_view < 30.0) << place << ' ' << turn;
    }
  }
}

TEST(MergeFragments, LooksAgainAtAHostThatHasGrown) {
  // The cap is too far from the bottle, but at its end once the neck is merged.
  Analytic shape;
  const Vector3d end(0.0, 0.05, 0.02);
  const Vector3d axis = Vector3d::UnitY();
  const Vector3d face = Vector3d::UnitZ();
  const Indices bottle = AddFlatBottle(shape, end, axis, face);
  const Indices neck =
      AddCap(shape, end, axis, face, {.gap_m = 0.002, .length_m = 0.012, .radius_m = 0.020});
  const Indices cap = AddCap(shape, end, axis, face, {.gap_m = 0.016, .length_m = 0.010});
  const Given given(shape.cloud);
  base::Rng rng(1);
  std::vector<Part> apart = {given.Describe(cap), given.Describe(bottle)};
  MergeFragments(given.Context(), apart, rng);
  EXPECT_EQ(apart.size(), 2u);
  EXPECT_EQ(KinshipOf(given, cap, neck), Kinship::kNone);
  std::vector<Part> parts = {given.Describe(cap), given.Describe(bottle), given.Describe(neck)};
  MergeFragments(given.Context(), parts, rng);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].points.size(), shape.cloud.size());
}

/// Number of parts that MergeLone makes of the segments; it loses no point.
std::size_t PartsOfLone(const Analytic& shape, const std::vector<Indices>& segments) {
  const Given given(shape.cloud);
  std::vector<Part> parts;
  for (const Indices& segment : segments) parts.push_back(given.Describe(segment));
  base::Rng rng(1);
  MergeLone(given.Context(), parts, rng);
  std::size_t points = 0;
  for (const Part& part : parts) points += part.points.size();
  EXPECT_EQ(points, shape.cloud.size());
  return parts.size();
}

/// Two faces that meet in a valley above the table, with options for the rest of the scene.
struct Valley {
  double crease_deg = 40.0;
  double half_width_m = 0.03;
  double half_length_m = 0.03;  ///< of each
  double gap_m = 0.002;         ///< between them
  double height_m = 0.05;
  bool neighbor = false;  ///< a box stands at the end of one face, and a hand's width beyond

  std::size_t Parts() const {
    Analytic shape;
    std::vector<Indices> segments;
    const double slope = 0.5 * base::Deg(crease_deg);
    const double middle_m = 0.5 * gap_m + half_length_m * std::cos(slope);
    for (const double side : {-1.0, 1.0}) {
      segments.push_back(
          shape.AddRectangle({side * middle_m, 0.0, height_m},
                             half_length_m * Vector3d(std::cos(slope), 0.0, side * std::sin(slope)),
                             {0.0, half_width_m, 0.0}));
    }
    if (neighbor) {
      const double end_m = middle_m + half_length_m * std::cos(slope);
      segments.push_back(
          shape.AddRectangle({end_m + 0.105, 0.0, 0.06}, {0.1, 0.0, 0.0}, {0.0, 0.03, 0.0}));
    }
    return PartsOfLone(shape, segments);
  }
};

TEST(MergeLone, JoinsWhatStandsAloneAndFitsAHand) {
  EXPECT_EQ(Valley{}.Parts(), 1U);
  EXPECT_EQ(Valley{.crease_deg = 50.0}.Parts(), 1U);
  EXPECT_EQ(Valley{.crease_deg = 60.0}.Parts(), 2U);
  EXPECT_EQ(Valley{.crease_deg = -120.0}.Parts(), 1U);  // a ridge
  EXPECT_EQ(Valley{.half_width_m = 0.048}.Parts(), 1U);
  EXPECT_EQ((Valley{.half_width_m = 0.052, .half_length_m = 0.058}.Parts()), 2U);
  EXPECT_EQ(Valley{.half_length_m = 0.064}.Parts(), 1U);
  EXPECT_EQ(Valley{.half_length_m = 0.072}.Parts(), 2U);
  EXPECT_EQ(Valley{.height_m = 0.105}.Parts(), 1U);
  EXPECT_EQ(Valley{.height_m = 0.115}.Parts(), 2U);
  EXPECT_EQ(Valley{.gap_m = 0.010}.Parts(), 1U);
  EXPECT_EQ(Valley{.gap_m = 0.014}.Parts(), 2U);
  EXPECT_EQ(Valley{.neighbor = true}.Parts(), 3U);
}

/// A flat body of 80 x 60 mm with a square limb at each of its sides.
struct Limbed {
  double half_m = 0.012;  ///< half a limb's side
  double gap_m = 0.015;   ///< between body and limb
  double rise_deg = 0.0;  ///< how steeply the limbs rise from the body
  std::size_t limbs = 4;

  std::size_t Parts() const {
    Analytic shape;
    std::vector<Indices> segments = {
        shape.AddRectangle({0.0, 0.0, 0.05}, {0.04, 0.0, 0.0}, {0.0, 0.03, 0.0})};
    const double rise = base::Deg(rise_deg);
    for (std::size_t k = 0; k < limbs; ++k) {
      const Vector3d out =
          Eigen::AngleAxisd(base::Deg(90.0 * static_cast<double>(k)), Vector3d::UnitZ()) *
          Vector3d::UnitX();
      const Vector3d along = half_m * (std::cos(rise) * out + std::sin(rise) * Vector3d::UnitZ());
      const double edge_m = k % 2 == 0 ? 0.04 : 0.03;
      segments.push_back(
          shape.AddRectangle(Vector3d(0.0, 0.0, 0.05) + (edge_m + gap_m) * out + along, along,
                             half_m * Vector3d::UnitZ().cross(out)));
    }
    return PartsOfLone(shape, segments);
  }
};

TEST(MergeLone, JoinsLimbsWithTheirBody) {
  EXPECT_EQ(Limbed{}.Parts(), 1U);
  EXPECT_EQ(Limbed{.gap_m = 0.024}.Parts(), 5U);
  EXPECT_EQ((Limbed{.gap_m = 0.002, .rise_deg = 80.0}.Parts()), 1U);
  EXPECT_EQ((Limbed{.half_m = 0.022, .limbs = 1}.Parts()), 1U);
  EXPECT_EQ((Limbed{.half_m = 0.022, .gap_m = 0.018}.Parts()), 5U);  // wider than 0.16 m
}

TEST(MergeLone, DoesNotJoinThingsThatAreAlike) {
  EXPECT_EQ((Limbed{.half_m = 0.027, .limbs = 1}.Parts()), 2U);
  EXPECT_EQ((Limbed{.half_m = 0.027, .gap_m = 0.002, .rise_deg = 80.0, .limbs = 1}.Parts()), 2U);
}

// Compares with all distances. Only one half of the cube of side 1 has points of the part, so
// queries lie within and beyond the gap, and inside and outside the box.
TEST(PartSurface, GivesTheNearestPointWithinTheGapAndNoOther) {
  base::Rng rng(7);
  geometry::Points part;
  for (int i = 0; i < 200; ++i) {
    part.push_back(RandomInUnitCube(rng).cwiseProduct(Vector3d(0.5, 1, 1)));
  }
  PartSurface surface(part);
  constexpr double kGap_m = 0.1;
  int within = 0;
  constexpr int kQueries = 500;
  for (int k = 0; k < kQueries; ++k) {
    const Vector3d p = RandomInUnitCube(rng);
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if ((part[i] - p).norm() < (part[nearest] - p).norm()) nearest = i;
    }
    const bool is_within = (part[nearest] - p).norm() <= kGap_m;
    within += is_within ? 1 : 0;
    const auto found = surface.NearestWithin(p, kGap_m);
    ASSERT_EQ(found.has_value(), is_within) << k;
    if (found) {
      EXPECT_EQ(*found, nearest) << k;
    }
  }
  EXPECT_GT(within, 0);
  EXPECT_LT(within, kQueries);
}

TEST(PartSurface, APartWithoutPointsIsNearNothing) {
  PartSurface surface({});
  EXPECT_FALSE(surface.NearestWithin(Vector3d::Zero(), std::numeric_limits<double>::infinity()));
}

}  // namespace
}  // namespace rangegrasp::perception::internal
