#include "parts/hierarchy/hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "parts/hierarchy/internal/cells.h"
#include "parts/hierarchy/internal/cuts.h"
#include "parts/metrics/human_score.h"
#include "parts/rewritten.h"
#include "parts/shape/segmentation.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;
using samples::FaceCenter;

std::uint32_t FaceNear(const Shape& shape, const Vector3d& p) {
  std::uint32_t best = 0;
  for (std::uint32_t f = 1; f < shape.faces.size(); ++f) {
    if ((FaceCenter(shape, f) - p).norm() < (FaceCenter(shape, best) - p).norm()) best = f;
  }
  return best;
}

/// A tube about the x axis with a given profile (x, radius), meshed between consecutive rings.
Shape Lathe(const std::vector<std::pair<double, double>>& profile, std::uint32_t around) {
  const auto at = [&](double t) {
    const double s = std::clamp(t, 0.0, 1.0) * static_cast<double>(profile.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(s), profile.size() - 2);
    const double u = s - static_cast<double>(k);
    return std::pair((1.0 - u) * profile[k].first + u * profile[k + 1].first,
                     (1.0 - u) * profile[k].second + u * profile[k + 1].second);
  };
  return samples::Tube(
      static_cast<std::uint32_t>(profile.size()), around,
      [&](double t) { return Vector3d(at(t).first + 1e-6 * t, 0.0, 0.0); },
      [&](double t) { return at(t).second; });
}

/// Two unit balls around x = -1.3 and 1.3, joined by a neck of about a third of their width.
Shape HierarchyDumbbell() {
  std::vector<std::pair<double, double>> profile;
  for (int k = 0; k <= 120; ++k) {
    const double x = 2.295 * (k / 60.0 - 1.0);
    const double to_ball = std::abs(x) - 1.3;
    profile.emplace_back(x, std::max(std::abs(x) < 1.3 ? 0.35 : 0.0,
                                     std::sqrt(std::max(0.0, 1.0 - to_ball * to_ball))));
  }
  return Lathe(profile, 48);
}

/// A box around the origin.
Shape Box(const Vector3d& size, std::uint32_t cells) {
  Shape box = samples::Ball(cells, [](const Vector3d& n) { return 1.0 / n.cwiseAbs().maxCoeff(); });
  for (Vector3d& p : box.points) p = p.cwiseProduct(0.5 * size);
  return box;
}

/// A ball intersected by a ring: a pot with one handle.
Shape PotWithHandle() {
  return samples::Isosurface(
      Vector3d(-1.2, -1.2, -1.2), Vector3d(2.2, 1.2, 1.2), 0.075, [](const Vector3d& p) {
        const Vector3d q = p - Vector3d(1.2, 0.0, 0.0);
        const double ring = std::hypot(std::hypot(q.x(), q.z()) - 0.65, q.y()) - 0.17;
        return std::min(p.norm() - 1.0, ring);
      });
}

TEST(Hierarchy, ABallABoxAndAnEggAreOnePart) {
  for (const Shape& shape :
       {samples::Ball(20, [](const Vector3d&) { return 1.0; }), Box(Vector3d(1, 2, 3), 20),
        samples::Ball(20, [](const Vector3d& n) { return 1.0 + 0.5 * n.x() * n.x(); })}) {
    const Segmentation result = SegmentHierarchy(shape, {});
    EXPECT_EQ(result.parts, 1);
    EXPECT_FALSE(result.has_core);
    EXPECT_FALSE(result.note.empty());
    EXPECT_EQ(result.label, std::vector<std::int32_t>(shape.faces.size(), 0));
  }
}

TEST(Hierarchy, TwoBallsComeApartAtTheirNeck) {
  const Shape shape = HierarchyDumbbell();
  const Segmentation result = SegmentHierarchy(shape, {});
  ASSERT_GE(result.parts, 2);
  ASSERT_LE(result.parts, 3);  // the neck may be a part
  const std::int32_t left = result.label[FaceNear(shape, Vector3d(-1.3, 1.0, 0.0))];
  const std::int32_t right = result.label[FaceNear(shape, Vector3d(1.3, 1.0, 0.0))];
  EXPECT_NE(left, right);
  for (std::uint32_t f = 0; f < shape.faces.size(); ++f) {
    // The balls' surface ends 0.36 from the middle; a border is off by a few faces of 0.04 at most.
    const double x = FaceCenter(shape, f).x();
    if (std::abs(x) > 0.5) {
      EXPECT_EQ(result.label[f], x < 0.0 ? left : right) << x;
    }
  }
}

TEST(Hierarchy, EachStepOfAShaftIsAPart) {
  std::vector<std::pair<double, double>> profile;
  for (int step = 0; step < 3; ++step) {
    const double radius = 1.0 - 0.3 * step;
    for (int k = 0; k < 40; ++k) profile.emplace_back(2.0 * step + k / 20.0, radius);
    for (int k = 0; k < 6; ++k) profile.emplace_back(2.0 * step + 2.0, radius - 0.05 * k);
  }
  const Shape shape = Lathe(profile, 40);
  const Segmentation result = SegmentHierarchy(shape, {});
  EXPECT_EQ(result.parts, 3);
  std::set<std::int32_t> seen;
  for (const double x : {1.0, 3.0, 5.0}) {
    seen.insert(result.label[FaceNear(shape, Vector3d(x, 0.7, 0.0))]);
  }
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_EQ(result.label[FaceNear(shape, Vector3d(1.0, 1.0, 0.0))], 0);  // the largest
}

TEST(Hierarchy, BentFingersComeOffThePalm) {
  const samples::Hand hand = samples::BentHand();
  const Segmentation result = SegmentHierarchy(hand.shape, {});
  const std::int32_t palm = result.label[FaceNear(hand.shape, Vector3d(0, 0, -1))];
  std::set<std::int32_t> roots;
  for (const auto& [a, b, c] : hand.fingers) {
    roots.insert(result.label[FaceNear(hand.shape, 0.4 * a + 0.6 * b - Vector3d(0, 0, 0.25))]);
  }
  EXPECT_EQ(roots.size(), 5u);
  EXPECT_FALSE(roots.contains(palm));
  EXPECT_EQ(result.label[FaceNear(hand.shape, Vector3d(0, 0, 1))], palm);
  EXPECT_LE(result.parts, 11);  // a finger may be split at its bend
}

TEST(Hierarchy, AHandleComesOffAtBothOfItsEnds) {
  const Shape shape = PotWithHandle();
  const Segmentation result = SegmentHierarchy(shape, {});
  EXPECT_GE(result.parts, 2);
  EXPECT_LE(result.parts, 3);  // a handle may be split at its bend
  for (std::uint32_t f = 0; f < shape.faces.size(); ++f) {
    const Vector3d p = FaceCenter(shape, f);
    if (p.norm() < 1.01 && p.x() < 0.6) {
      EXPECT_EQ(result.label[f], 0);
    }
    if (p.norm() > 1.2) {
      EXPECT_NE(result.label[f], 0);
    }
  }
}

TEST(Hierarchy, PartsAreTheSameHoweverTheMeshLiesAndIsWrittenDown) {
  for (const Shape& shape : {samples::BentHand().shape, HierarchyDumbbell(), PotWithHandle()}) {
    const Segmentation first = SegmentHierarchy(shape, {});
    std::vector<std::uint32_t> face;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      const Segmentation second = SegmentHierarchy(samples::Rewritten(shape, seed, face), {});
      ASSERT_EQ(second.parts, first.parts);
      std::vector<std::int32_t> label;
      for (const std::uint32_t f : face) label.push_back(second.label[f]);
      EXPECT_EQ(RandError(first.label, label), 0.0);
    }
  }
}

TEST(Hierarchy, PartsAreTheSameHoweverFlatPiecesAreCut) {
  for (const Shape& shape : {samples::BentHand().shape, PotWithHandle()}) {
    const Segmentation first = SegmentHierarchy(shape, {});
    const Segmentation second = SegmentHierarchy(samples::Subdivided(shape), {});
    ASSERT_EQ(second.parts, first.parts);
    std::vector<std::int32_t> label;
    for (const std::int32_t l : first.label) label.insert(label.end(), 4, l);
    EXPECT_LT(RandError(label, second.label), 0.005);  // faces at borders
  }
}

TEST(Hierarchy, GivesAsManyPartsAsAsked) {
  const Shape shape = samples::BentHand().shape;
  for (const int parts : {1, 2, 4, 6}) {
    HierarchyOptions options;
    options.parts = parts;
    EXPECT_EQ(SegmentHierarchy(shape, options).parts, parts);
  }
}

TEST(Hierarchy, TakesWhatIsBarelyAMeshOrACloud) {
  Shape shape;
  shape.points = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)};
  EXPECT_EQ(SegmentHierarchy(shape, {}).label, std::vector<std::int32_t>(4, 0));
  shape.faces = {{0, 1, 2}};
  EXPECT_EQ(SegmentHierarchy(shape, {}).parts, 1);
  shape.faces = {{0, 1, 2}, {0, 2, 1}};  // the same face twice, back to back
  EXPECT_EQ(SegmentHierarchy(shape, {}).label.size(), 2u);
  shape.faces = {{0, 1, 2}, {0, 1, 3}, {1, 0, 2}};  // three faces at an edge
  EXPECT_EQ(SegmentHierarchy(shape, {}).label.size(), 3u);
}

TEST(Hierarchy, PiecesThatAreNotJoinedAreParts) {
  const Shape two = samples::Twice(samples::Ball(8, [](const Vector3d&) { return 1.0; }));
  const std::size_t faces = two.faces.size() / 2;
  const Segmentation result = SegmentHierarchy(two, {});
  EXPECT_EQ(result.parts, 2);
  std::vector<std::int32_t> expected(faces, 0);
  expected.resize(2 * faces, 1);
  EXPECT_EQ(RandError(result.label, expected), 0.0);
}

TEST(EdgeBends, OfALoneCreaseIsItsAngle) {
  // Two squares of 10 x 10 cells that meet at 90 degrees, concave on their upper side.
  Shape corner;
  constexpr std::uint32_t kCells = 10;
  const auto add_square = [&](const Vector3d& along) {
    const auto first = static_cast<std::uint32_t>(corner.points.size());
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      for (std::uint32_t j = 0; j <= kCells; ++j) {
        corner.points.emplace_back(0.1 * i * along + 0.1 * j * Vector3d::UnitY());
      }
    }
    return first;
  };
  add_square(Vector3d::UnitX());
  const std::uint32_t second = add_square(Vector3d::UnitZ());
  for (const std::uint32_t first : {0u, second}) {
    for (std::uint32_t i = 0; i < kCells; ++i) {
      for (std::uint32_t j = 0; j < kCells; ++j) {
        const auto at = [&](std::uint32_t u, std::uint32_t v) {
          // The row on the crease belongs to the first square.
          return (u == 0 ? 0u : first) + u * (kCells + 1) + v;
        };
        std::array<std::uint32_t, 3> a = {at(i, j), at(i + 1, j), at(i + 1, j + 1)};
        std::array<std::uint32_t, 3> b = {at(i, j), at(i + 1, j + 1), at(i, j + 1)};
        if (first != 0) std::swap(a[1], a[2]), std::swap(b[1], b[2]);
        corner.faces.push_back(a);
        corner.faces.push_back(b);
      }
    }
  }
  const auto bend = [&](bool turned) {
    Shape shape = corner;
    if (turned) {
      for (auto& face : shape.faces) std::swap(face[0], face[1]);
    }
    const FaceGraph faces = BuildFaceGraph(shape);
    const std::vector<double> bends = EdgeBends(shape, faces, BuildFaceFrames(shape), 0.25);
    double at_middle = 0.0;
    for (std::size_t k = 0; k < bends.size(); ++k) {
      const Vector3d p = 0.5 * (shape.points[faces.edge[k][0]] + shape.points[faces.edge[k][1]]);
      if (p.x() + p.z() < 1e-9 && std::abs(p.y() - 0.45) < 1e-9) at_middle = bends[k];
      if (p.x() > 0.3 || p.z() > 0.3) {
        EXPECT_NEAR(bends[k], 0.0, 1e-9);
      }
    }
    return at_middle;
  };
  // Weights 2 (1 - d / 0.25) at the middles of edges of 0.1: d = 0, +-0.1, +-0.2 sum to 5.2.
  EXPECT_NEAR(bend(false), 0.52 / 0.5 * std::numbers::pi / 2, 1e-9);
  EXPECT_NEAR(bend(true), -0.52 / 0.5 * std::numbers::pi / 2, 1e-9);
}

// At a box's edges the normals of the walls are perpendicular, and if a face is folded back onto
// its neighbor, rounding decides which one is above.
TEST(EdgeBends, DoNotHangOnTheLastDigits) {
  Shape shape = Box(Vector3d(1, 2, 3), 12);
  // Offset, so that no face lies in a plane of the patch grid.
  for (Vector3d& p : shape.points) p += Vector3d(0.0131, 0.0273, 0.0417);
  for (std::uint32_t f = 0; f < 200; f += 10) {
    const auto [a, b, c] = shape.faces[f];
    const Vector3d middle = (shape.points[a] + shape.points[b] + shape.points[c]) / 3.0;
    shape.faces.push_back({b, a, static_cast<std::uint32_t>(shape.points.size())});
    shape.points.push_back(middle);
  }
  const FaceGraph faces = BuildFaceGraph(shape);
  const std::vector<double> first = EdgeBends(shape, faces, BuildFaceFrames(shape), 0.4);
  for (int turn = 1; turn < 8; ++turn) {
    const Eigen::AngleAxisd X(0.1 * turn, Vector3d(0.3, 0.5, 0.7).normalized());
    Shape near = shape;
    // Rounds to single precision and turns back, so that the same edges share a patch.
    for (Vector3d& p : near.points) {
      p = X.inverse() * (X * p).cast<float>().cast<double>();
    }
    const std::vector<double> second = EdgeBends(near, faces, BuildFaceFrames(near), 0.4);
    for (std::size_t k = 0; k < first.size(); ++k) EXPECT_NEAR(first[k], second[k], 1e-3) << k;
  }
}

struct CellsOf {
  explicit CellsOf(const Shape& shape)
      : faces(BuildFaceGraph(shape)), frames(BuildFaceFrames(shape)) {
    bends = EdgeBends(shape, faces, frames, 0.02 * std::sqrt(frames.total_area));
    costs = BendCosts(shape, faces, bends, 2.0);
    cells = BuildCells(shape, faces, frames, bends, costs, 300, 3.0);
  }
  FaceGraph faces;
  FaceFrames frames;
  std::vector<double> bends, costs;
  Cells cells;
};

TEST(Cells, CoverTheSurfaceAndSeeABallsMiddle) {
  const CellsOf ball(samples::Ball(20, [](const Vector3d&) { return 2.0; }));
  // About 300: one for each cube of the grid that contains a large patch of the surface.
  ASSERT_GT(ball.cells.size(), 200u);
  ASSERT_LT(ball.cells.size(), 450u);
  double area = 0.0;
  for (std::uint32_t c = 0; c < ball.cells.size(); ++c) {
    area += ball.cells.area[c];
    EXPECT_GT(ball.cells.area[c], 0.0);
    for (std::uint32_t k = ball.cells.begin[c]; k < ball.cells.begin[c + 1]; ++k) {
      const auto back = ball.cells.NeighborsOf(ball.cells.neighbor[k]);
      const auto own = std::ranges::find(back, c);
      ASSERT_NE(own, back.end());
      const auto other = static_cast<std::size_t>(&*own - ball.cells.neighbor.data());
      EXPECT_EQ(ball.cells.border[other].cost, ball.cells.border[k].cost);
      EXPECT_EQ(ball.cells.border[other].length, ball.cells.border[k].length);
    }
    // A ball's inscribed ball is the ball itself; cells are flat, so they lie a few percent inside.
    EXPECT_LT(InnerCenter(ball.cells, c).norm(), 0.2);
  }
  EXPECT_NEAR(area, ball.frames.total_area, 1e-9);
}

// A ball's cells see all but adjacent ones; cells of different balls do not see each other.
TEST(Sight, IsThroughTheInside) {
  const Shape two = samples::Twice(samples::Ball(20, [](const Vector3d&) { return 1.0; }));
  const CellsOf balls(two);
  Sight sight(two, balls.frames, balls.cells);
  std::vector<Sight::Pair> pairs;
  for (std::uint32_t a = 0; a < balls.cells.size(); ++a) {
    for (std::uint32_t b = 0; b < a; ++b) pairs.emplace_back(b, a);
  }
  std::vector<std::uint8_t> sees;
  sight.Look(pairs, sees);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& [a, b] = pairs[k];
    const double apart = (balls.cells.center[a] - balls.cells.center[b]).norm();
    if (apart > 0.7) {
      EXPECT_EQ(sees[k], apart < 2.0) << apart;
    }
  }
}

TEST(Split, SolidityTellsBallsFromPatchesAndDents) {
  const CellsOf ball(samples::Ball(20, [](const Vector3d&) { return 2.0; }));
  const Sides all(ball.cells.size(), 1);
  EXPECT_NEAR(Solidity(ball.cells, all), 1.0 / std::sqrt(4.0 * std::numbers::pi), 0.01);
  Cells dent = ball.cells;
  for (Vector3d& n : dent.normal) n = -n;
  EXPECT_LT(Solidity(dent, all), 0.0);
  const CellsOf box(Box(Vector3d(1, 1, 1), 20));
  Sides face(box.cells.size());
  for (std::uint32_t c = 0; c < box.cells.size(); ++c) face[c] = box.cells.center[c].x() > 0.499;
  EXPECT_NEAR(Solidity(box.cells, face), 0.0, 0.02);
}

TEST(Split, OnlyAHandleHasTwoLoops) {
  const CellsOf pot(PotWithHandle());
  Sides handle(pot.cells.size()), slice(pot.cells.size());
  for (std::uint32_t c = 0; c < pot.cells.size(); ++c) {
    handle[c] = pot.cells.center[c].norm() > 1.15;
    slice[c] = pot.cells.center[c].x() < -0.3 && pot.cells.center[c].x() > -0.7;
  }
  EXPECT_EQ(HandleLoops(pot.cells, handle), 2.0);
  EXPECT_EQ(HandleLoops(pot.cells, slice), 1.0);  // has two borders, but the rest falls apart
}

TEST(Borders, MoveIntoTheGrooveWithinReach) {
  const Shape rod = samples::Tube(
      81, 24, [](double t) { return Vector3d(4.0 * t, 0.0, 0.0); },
      [](double t) { return 0.5 - 0.2 * std::exp(-std::pow(40.0 * (t - 0.5), 2)); });
  const FaceGraph faces = BuildFaceGraph(rod);
  const FaceFrames frames = BuildFaceFrames(rod);
  const std::vector<double> costs = BendCosts(rod, faces, EdgeBends(rod, faces, frames, 0.1), 2.0);
  const auto moved = [&](double width) {
    std::vector<std::int32_t> label;
    for (std::uint32_t f = 0; f < rod.faces.size(); ++f) {
      label.push_back(FaceCenter(rod, f).x() > 1.8 ? 1 : 0);
    }
    MoveBorders(faces, frames, costs, width, label);
    double area = 0.0;
    for (std::uint32_t f = 0; f < rod.faces.size(); ++f) {
      if (label[f] == 0 && FaceCenter(rod, f).x() > 1.9) area += frames.area[f];
    }
    return area;
  };
  EXPECT_GT(moved(0.6), 0.1);        // 0.1 long, circumference 0.6 * pi
  EXPECT_NEAR(moved(0.05), 0.0, 0);  // too far
}

}  // namespace
}  // namespace rangegrasp::parts
