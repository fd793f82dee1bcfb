#include <gtest/gtest.h>

#include "perception/analytic.h"
#include "perception/internal/merging.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;

/// A can about (x, y) as seen from +x, with its points split at the line y = middle; points within
/// 5 mm of the line are left out.
void AddCan(Analytic& shape, const Vector2d& center, double radius_m, double middle, Indices& left,
            Indices& right) {
  const auto lid = shape.AddDisc({center.x(), center.y(), 0.1}, radius_m);
  const auto wall = shape.AddWall(center, radius_m, 0.01, 0.096, -1.3, 1.3);
  for (const auto i : samples::Joined(lid, wall)) {
    const double offset = shape.cloud.points[i].y() - middle;
    if (std::abs(offset) > 0.005) (offset < 0.0 ? left : right).push_back(i);
  }
}

std::vector<Part> MergedParts(const Given& given, std::vector<Part> parts) {
  base::Rng rng(1);
  MergeRotational(given.Context(), parts, rng);
  return parts;
}

std::vector<Part> Merged(const Given& given, const std::vector<Indices>& segments) {
  std::vector<Part> parts;
  for (const Indices& points : segments) parts.push_back(given.Describe(points));
  return MergedParts(given, std::move(parts));
}

TEST(MergeRotational, JoinsTheHalvesOfACanWhereverItIsCut) {
  for (int step = -2; step <= 2; ++step) {
    Analytic shape;
    Indices left, right;
    AddCan(shape, {0.01, 0.02}, 0.04, 0.02 + 0.006 * step, left, right);
    const Given given(shape.cloud);
    const auto parts = Merged(given, {left, right});
    ASSERT_EQ(parts.size(), 1u) << step;
    ASSERT_TRUE(parts[0].axis);
    EXPECT_EQ(parts[0].points.size(), left.size() + right.size());
    EXPECT_NEAR((parts[0].axis->center_C.head<2>() - Vector2d(0.01, 0.02)).norm(), 0.0, 1e-6);
    EXPECT_NEAR(parts[0].axis->radius_m, 0.04, 1e-6);
  }
}

TEST(MergeRotational, LeavesTwoCansApart) {
  Analytic shape;
  std::vector<Indices> cans(2);
  AddCan(shape, {0.0, -0.045}, 0.04, 1.0, cans[0], cans[0]);
  AddCan(shape, {0.0, 0.045}, 0.04, 1.0, cans[1], cans[1]);
  EXPECT_EQ(Merged(Given(shape.cloud), cans).size(), 2u);
}

TEST(MergeRotational, LeavesHalvesOfDifferentCansApart) {
  // The halves face each other and have the same height, but are on two circles.
  Analytic shape;
  Indices left, right, other_left, other_right;
  AddCan(shape, {0.0, 0.0}, 0.040, 0.0, left, right);
  AddCan(shape, {0.015, 0.0}, 0.030, 0.0, other_left, other_right);
  EXPECT_EQ(Merged(Given(shape.cloud), {left, other_right}).size(), 2u);
}

TEST(MergeRotational, LeavesABoxBesideACan) {
  Analytic shape;
  Indices can;
  AddCan(shape, {0.0, 0.0}, 0.04, 1.0, can, can);
  const Indices box =
      samples::Joined(shape.AddRectangle({0.0, 0.075, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0}),
                      shape.AddRectangle({0.03, 0.075, 0.05}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.045}));
  const auto parts = Merged(Given(shape.cloud), {can, box});
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(parts[0].axis);
  EXPECT_FALSE(parts[1].axis);
}

constexpr double kMergeRotationalRadius_m = 0.04;
/// Angle between two columns of the wall. The lid's edge has the same columns: 126 around the can.
const double kColumn_rad =
    2.0 * base::kPi / std::lround(2.0 * base::kPi * kMergeRotationalRadius_m / samples::kStep_m);

/// A can seen from all sides and its sectors, each from one angle to the next; the last one ends at
/// the first angle. The angles lie between two columns.
struct CutCan {
  Analytic shape;
  std::vector<Indices> sectors;

  explicit CutCan(const std::vector<int>& columns) : sectors(columns.size()) {
    const auto lid = shape.AddDisc({0.0, 0.0, 0.1}, kMergeRotationalRadius_m);
    for (const auto i :
         samples::Joined(lid, shape.AddWall({0.0, 0.0}, kMergeRotationalRadius_m, 0.01, 0.096))) {
      const Eigen::Vector3d& p = shape.cloud.points[i];
      double column = std::atan2(p.y(), p.x()) / kColumn_rad + 0.5;
      if (column < 0.0) column += 2.0 * base::kPi / kColumn_rad;
      const auto after = std::upper_bound(columns.begin(), columns.end(), column);
      const auto at = static_cast<std::size_t>(after - columns.begin());
      sectors[at == 0 ? columns.size() - 1 : at - 1].push_back(i);
    }
  }
  /// Adds a point to a sector.
  void Add(std::size_t sector, const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    sectors[sector].push_back(shape.Add(p, normal));
  }
  /// The sectors without known axes.
  std::vector<Part> Parts(const Given& given) const {
    std::vector<Part> parts;
    for (const Indices& points : sectors) {
      parts.push_back(given.Describe(points));
      parts.back().axis.reset();
    }
    return parts;
  }
};

std::size_t CountMerged(const Given& given, const std::vector<Part>& parts) {
  return MergedParts(given, parts).size();
}

TEST(MergeRotational, AsksForTopsOfOneHeight) {
  for (const std::size_t with_knob : {0u, 1u}) {
    for (const double height : {0.0099, 0.0101}) {  // the limit is 10 mm
      CutCan can({0, 63});
      for (int k = 0; k < 5; ++k) {  // fewer would be stray points
        can.Add(with_knob, {0.002 * k, 0.0, 0.1 + height}, Eigen::Vector3d::UnitZ());
      }
      const Given given(can.shape.cloud);
      EXPECT_EQ(CountMerged(given, can.Parts(given)), height < 0.01 ? 1u : 2u) << height;
    }
  }
}

TEST(MergeRotational, AsksForTops) {
  const CutCan can({0, 63});
  const Given given(can.shape.cloud);
  for (const std::size_t without : {0u, 1u}) {
    auto parts = can.Parts(given);
    parts[without].top.reset();
    EXPECT_EQ(CountMerged(given, parts), 2u);
  }
}

TEST(MergeRotational, AsksForTopsWithinTheWidestCircle) {
  const CutCan can({0, 63});
  const Given given(can.shape.cloud);
  for (const double apart : {0.299, 0.301}) {  // the limit is twice 150 mm
    auto parts = can.Parts(given);
    parts[1].top->center_C = parts[0].top->center_C + apart * Eigen::Vector3d::UnitY();
    EXPECT_EQ(CountMerged(given, parts), apart < 0.3 ? 1u : 2u) << apart;
  }
}

TEST(MergeRotational, AsksForNearAxesWhereBothHaveOne) {
  const CutCan can({0, 63});
  const Given given(can.shape.cloud);
  const auto with_axis_at = [](Part& part, double x) {
    part.axis =
        RotationAxis{{x, 0.0, 0.1}, Eigen::Vector3d::UnitZ(), kMergeRotationalRadius_m, 1.0, 1.0};
  };
  for (const double apart : {0.0099, 0.0101}) {  // the limit is 10 mm
    auto parts = can.Parts(given);
    with_axis_at(parts[0], 0.0);
    with_axis_at(parts[1], apart);
    EXPECT_EQ(CountMerged(given, parts), apart < 0.01 ? 1u : 2u) << apart;
  }
  for (const std::size_t one : {0u, 1u}) {
    auto parts = can.Parts(given);
    with_axis_at(parts[one], 0.05);
    EXPECT_EQ(CountMerged(given, parts), 1u) << one;
  }
}

TEST(MergeRotational, AsksForFourFifthsOfEachPartsRimOnTheCircle) {
  // Half the rim has 63 points. A bump of n columns puts n points 5 mm outside the circle and up to
  // one more on each side. A circle of 30 mm that rolls around it leaves out up to 14 mm = 7
  // columns on each side. So 7 columns are at most 9 / 49 = 18 % of the part's rim and 16 columns
  // at least 16 / 63 = 25 %, but they are at most 18 / 112 = 16 % of the union's rim.
  for (const std::size_t bumped : {0u, 1u}) {
    for (const int columns : {7, 16}) {
      CutCan can({0, 63});
      for (int k = 0; k < columns; ++k) {
        const double a = (31 - columns / 2 + k + 63 * static_cast<int>(bumped)) * kColumn_rad;
        for (const double out : {0.0025, 0.005}) {
          can.Add(bumped,
                  {(kMergeRotationalRadius_m + out) * std::cos(a),
                   (kMergeRotationalRadius_m + out) * std::sin(a), 0.1},
                  Eigen::Vector3d::UnitZ());
        }
      }
      const Given given(can.shape.cloud);
      EXPECT_EQ(CountMerged(given, can.Parts(given)), columns == 7 ? 1u : 2u)
          << bumped << ' ' << columns;
    }
  }
}

TEST(MergeRotational, AsksForARimOfEachPart) {
  // A piece of the wall without any of the lid is round, but has no points on the rim.
  CutCan can({0, 30});
  for (auto& sector : can.sectors) {
    std::erase_if(sector, [&](auto i) {
      const auto& p = can.shape.cloud.points[i];
      return &sector == &can.sectors[0] && p.z() > 0.0945;
    });
  }
  const auto lid = can.shape.AddDisc({0.0, 0.0, 0.1}, kMergeRotationalRadius_m);
  can.sectors[1] = samples::Joined(can.sectors[1], lid);
  const Given given(can.shape.cloud);
  EXPECT_EQ(CountMerged(given, can.Parts(given)), 2u);
}

TEST(MergeRotational, AsksForHalfOfEachPartsBodyOnTheCircle) {
  // A sector of 10 columns with a handle of 9 to 11 columns 20 mm outside of it; nine tenths of the
  // union's body agree.
  for (const bool first : {false, true}) {
    for (const int handle : {9, 10, 11}) {
      CutCan can({0, 10});
      const double width = handle * samples::kStep_m / 0.06;
      can.sectors[0] = samples::Joined(
          can.sectors[0], can.shape.AddWall({0.0, 0.0}, 0.06, 0.01, 0.096, 0.0, width));
      if (!first) std::swap(can.sectors[0], can.sectors[1]);
      const Given given(can.shape.cloud);
      EXPECT_EQ(CountMerged(given, can.Parts(given)), handle <= 10 ? 1u : 2u) << handle;
    }
  }
}

TEST(MergeRotational, TakesForTheUnionWhatItDidNotTakeAlone) {
  // A sixth and a twentieth of a can give no circle; together with the rest the first does.
  CutCan can({0, 21, 27});
  const Given given(can.shape.cloud);
  const auto parts = can.Parts(given);
  EXPECT_EQ(CountMerged(given, {parts[0], parts[1]}), 2u);
  EXPECT_EQ(CountMerged(given, parts), 1u);
  // The order does not matter: the first part is compared again with the union of the others.
  EXPECT_EQ(CountMerged(given, {parts[1], parts[0], parts[2]}), 1u);
  EXPECT_EQ(CountMerged(given, {parts[1], parts[2], parts[0]}), 1u);
  EXPECT_EQ(CountMerged(given, {parts[2], parts[1], parts[0]}), 1u);
}

TEST(MergeRotational, KeepsThePlaceOfTheFirst) {
  CutCan can({0, 63});
  const Indices box = can.shape.AddRectangle({0.0, 0.2, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0});
  const Given given(can.shape.cloud);
  const auto halves = can.Parts(given);
  base::Rng rng(1);
  for (const std::size_t place : {0u, 1u, 2u}) {
    std::vector<Part> parts = halves;
    parts.insert(parts.begin() + static_cast<std::ptrdiff_t>(place), given.Describe(box));
    MergeRotational(given.Context(), parts, rng);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[place == 0 ? 0 : 1].points, box) << place;
  }
}

TEST(MergeRotational, AsksNoRimOfACupWhoseAxisIsItsBodys) {
  // An arc of 100 deg of the lip is seen; on one half it is 7 mm inside the wall.
  Analytic cup;
  const auto ring = cup.AddDisc({0.0, 0.0, 0.1}, kMergeRotationalRadius_m, 0.036);
  Indices points = samples::Joined(
      cup.AddWall({0.0, 0.0}, kMergeRotationalRadius_m, 0.01, 0.096, -1.3, 1.3),
      cup.AddWall({0.0, 0.0}, 0.036, 0.05, 0.096, base::kPi - 1.3, base::kPi + 1.3, true));
  for (const auto i : ring) {
    const auto& p = cup.cloud.points[i];
    const double angle = std::atan2(p.y(), p.x());
    if (angle < 0.0 && angle > base::Deg(-50.0)) points.push_back(i);
  }
  for (const double r : {0.031, 0.033}) {
    for (double a = 0.02; a < base::Deg(50.0); a += 0.06) {
      points.push_back(cup.Add({r * std::cos(a), r * std::sin(a), 0.1}, Eigen::Vector3d::UnitZ()));
    }
  }
  const Given given(cup.cloud);
  const Part whole = given.Describe(points);
  ASSERT_TRUE(whole.axis);
  ASSERT_EQ(whole.axis->rim_fraction, 0.0);
  std::vector<Indices> halves(2);
  for (const auto i : points) halves[cup.cloud.points[i].y() < 0.0].push_back(i);
  EXPECT_EQ(Merged(given, halves).size(), 1u);
}

/// A piece of a cylinder of 70 mm that lies along x, up to an angle from the top.
Indices AddLying(Analytic& shape, double from_m, double to_m, double to_rad = 1.7) {
  constexpr double kLying_m = 0.035;
  Indices added;
  for (double x = from_m; x < to_m; x += samples::kStep_m) {
    for (double a = -0.6; a < to_rad; a += samples::kStep_m / kLying_m) {
      const Eigen::Vector3d out(0.0, std::sin(a), std::cos(a));
      added.push_back(shape.Add(Eigen::Vector3d(x, 0.0, kLying_m) + kLying_m * out, out));
    }
  }
  return added;
}

TEST(MergeRotational, APieceThatIsNotOnTheBodyIsOfAnotherThing) {
  // A small plate as high as a lying cylinder leans away from its end. Hardly any of its points
  // differs from the body.
  for (const double beyond_m : {0.02, 0.05}) {
    Analytic shape;
    const Indices cylinder = AddLying(shape, -0.06, 0.06);
    const Indices plate = shape.AddRectangle({0.06 + beyond_m, 0.01, 0.064}, {0.0, 0.008, 0.0},
                                             {-0.0068, 0.0, 0.0068});
    EXPECT_EQ(Merged(Given(shape.cloud), {cylinder, plate}).size(), 2u) << beyond_m;
  }
}

TEST(MergeRotational, APieceOfALyingBodyIsNoFurtherFromItThanItIsThick) {
  for (const double gap_m : {0.02, 0.05, 0.10}) {
    Analytic shape;
    const Indices body = AddLying(shape, -0.06, 0.04);
    // The arc is too short for its own axis.
    const Indices piece = AddLying(shape, 0.04 + gap_m, 0.07 + gap_m, 0.4);
    EXPECT_EQ(Merged(Given(shape.cloud), {body, piece}).size(), gap_m < 0.07 ? 1u : 2u) << gap_m;
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
