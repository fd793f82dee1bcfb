#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/rng.h"
#include "parts/baselines/baselines.h"
#include "parts/graphs.h"
#include "parts/shape/shape_graph.h"
#include "parts/solids.h"
#include "parts/stretched/embedding.h"

namespace rangegrasp::parts {
namespace {

/// Three arms from node 0 with `length` links of 1 each; arm a has nodes from 1 + a * length.
VertexGraph Star(std::uint32_t length) {
  std::vector<std::vector<std::uint32_t>> links(1 + 3 * length);
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    links[a].push_back(b);
    links[b].push_back(a);
  };
  for (std::uint32_t arm = 0; arm < 3; ++arm) {
    const std::uint32_t first = 1 + arm * length;
    join(0, first);
    for (std::uint32_t k = 1; k < length; ++k) join(first + k - 1, first + k);
  }
  return samples::GraphOf(links);
}

bool IsTip(std::uint32_t node, std::uint32_t length) { return node > 0 && node % length == 0; }

// With every node a landmark, the distances and neighbors are those of the graph.
TEST(LandmarkForm, OfAStarHasTheArmsTipsAsFeaturePoints) {
  constexpr std::uint32_t kLength = 6;
  const VertexGraph star = Star(kLength);
  std::vector<bool> cut(star.Size(), false);
  const LandmarkForm form = MakeLandmarkForm(star, cut, static_cast<int>(star.Size()));
  ASSERT_EQ(form.size(), star.Size());
  const std::vector<bool> all(form.size(), true);
  const std::vector<bool> feature = FeaturePoints(form, all);
  for (std::uint32_t i = 0; i < form.size(); ++i) {
    const std::uint32_t node = form.spread.landmark[i];
    EXPECT_EQ(feature[i], IsTip(node, kLength)) << node;
    EXPECT_EQ(form.neighbors[i].size(), star.begin[node + 1] - star.begin[node]) << node;
  }
  // Nodes that are not on the hull or that lie at a cut are not feature points.
  EXPECT_EQ(std::count(feature.begin(), feature.end(), true), 3);
  const auto none = FeaturePoints(form, std::vector<bool>(form.size(), false));
  EXPECT_EQ(std::count(none.begin(), none.end(), true), 0);
  cut[kLength] = true;  // the first arm's tip
  const LandmarkForm cut_form = MakeLandmarkForm(star, cut, static_cast<int>(star.Size()));
  const auto two = FeaturePoints(cut_form, all);
  EXPECT_EQ(std::count(two.begin(), two.end(), true), 2);
}

using Eigen::Vector3d;

const std::vector<Vector3d> kLimbs = {
    Vector3d(1, 0, 0.2).normalized(), Vector3d(-1, 0.1, 0).normalized(),
    Vector3d(0, 1, 0.3).normalized(), Vector3d(0.2, -1, 0).normalized(),
    Vector3d(0, 0.1, 1).normalized()};

/// A unit ball with five limbs, each 2 long and about 0.5 wide.
Shape FiveLimbs() {
  return samples::Ball(40, [](const Vector3d& n) {
    double radius = 1.0;
    for (const Vector3d& limb : kLimbs) {
      const double angle = std::acos(std::clamp(n.dot(limb), -1.0, 1.0));
      radius += 2.0 * std::exp(-std::pow(angle / 0.18, 4));
    }
    return radius;
  });
}

std::uint32_t FaceTowards(const Shape& shape, const Vector3d& direction) {
  const auto along = [&](std::uint32_t f) {
    return samples::FaceCenter(shape, f).normalized().dot(direction);
  };
  std::uint32_t best = 0;
  for (std::uint32_t f = 1; f < shape.faces.size(); ++f) {
    if (along(f) > along(best)) best = f;
  }
  return best;
}

TEST(CoreExtraction, ABallWithFiveLimbsHasSixParts) {
  const Shape shape = FiveLimbs();
  const Segmentation result = SegmentByCoreExtraction(shape, 1);
  EXPECT_EQ(result.parts, 6);
  EXPECT_TRUE(result.has_core);
  ASSERT_EQ(result.label.size(), shape.faces.size());
  std::set<std::int32_t> tips;
  for (const Vector3d& limb : kLimbs) tips.insert(result.label[FaceTowards(shape, limb)]);
  EXPECT_EQ(tips.size(), 5u);
  EXPECT_FALSE(tips.contains(0));
  // The limbs' roots are where the surface bends outward from the ball: the ball well between the
  // limbs is all core, and the outer halves of the limbs are not core.
  for (std::uint32_t f = 0; f < shape.faces.size(); ++f) {
    double radius = 0.0;
    for (const std::uint32_t v : shape.faces[f]) radius = std::max(radius, shape.points[v].norm());
    if (radius < 1.02) {
      EXPECT_EQ(result.label[f], 0);
    } else if (radius > 2.0) {
      EXPECT_NE(result.label[f], 0);
    }
  }
}

TEST(CoreExtraction, KnowsNoTurnShiftAndScaleAndIsTheSameEachTime) {
  const Shape shape = FiveLimbs();
  const Segmentation first = SegmentByCoreExtraction(shape);
  EXPECT_EQ(SegmentByCoreExtraction(shape).label, first.label);
  Shape moved = shape;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.8, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  for (Vector3d& p : moved.points) p = 0.001 * (turn * p) + Vector3d(1, 2, 3);
  const Segmentation second = SegmentByCoreExtraction(moved);
  ASSERT_EQ(second.label.size(), first.label.size());
  // Rounding breaks ties between paths of equal length differently: some faces at the cuts may
  // change sides.
  std::size_t different = 0;
  for (std::size_t f = 0; f < first.label.size(); ++f) {
    different += first.label[f] != second.label[f];
  }
  EXPECT_LT(static_cast<double>(different), 0.02 * static_cast<double>(first.label.size()));
}

TEST(CoreExtraction, ABallStaysWhole) {
  const Segmentation result =
      SegmentByCoreExtraction(samples::Ball(12, [](const Vector3d&) { return 1.0; }));
  EXPECT_EQ(result.parts, 1);
  EXPECT_FALSE(result.has_core);
  EXPECT_FALSE(result.note.empty());
}

TEST(CoreExtraction, PiecesThatAreNotJoinedAreParts) {
  const Shape two = samples::Twice(samples::Ball(3, [](const Vector3d&) { return 1.0; }));
  const std::size_t faces = two.faces.size() / 2;
  const Segmentation result = SegmentByCoreExtraction(two);
  EXPECT_EQ(result.parts, 2);
  for (std::size_t f = 0; f < 2 * faces; ++f) EXPECT_EQ(result.label[f], f < faces ? 0 : 1);
}

TEST(CoreExtraction, TakesATriangle) {
  Shape triangle;
  triangle.points = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
  triangle.faces = {{0, 1, 2}};
  EXPECT_EQ(SegmentByCoreExtraction(triangle).label, std::vector<std::int32_t>{0});
}

class SeededCut : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededCut, ::testing::Range<std::uint64_t>(0, 40));

// Includes several links between two nodes, and between a node and the source or the sink.
TEST_P(SeededCut, MinCutIsTheCheapestOfAll) {
  base::Rng rng(GetParam());
  constexpr std::uint32_t kNodes = 9;
  std::vector<CutLink> links;
  for (int i = 0; i < 30; ++i) {
    const auto a =
        i % 2 == 0 ? static_cast<std::uint32_t>(rng.Index(kNodes)) : (i % 4 == 1 ? kSource : kSink);
    const auto b = static_cast<std::uint32_t>(rng.Index(kNodes));
    if (a != b) links.push_back({a, b, rng.Uniform()});
  }
  const auto cost = [&](const std::vector<bool>& with_source) {
    double sum = 0.0;
    for (const CutLink& l : links) sum += with_source[l.a] != with_source[l.b] ? l.capacity : 0.0;
    return sum;
  };
  const std::vector<bool> cut = MinCut(kNodes, links);
  EXPECT_TRUE(cut[kSource]);
  EXPECT_FALSE(cut[kSink]);
  double cheapest = 1e9;
  for (std::uint32_t mask = 0; mask < (1u << kNodes); ++mask) {
    if (!(mask >> kSource & 1u) || (mask >> kSink & 1u)) continue;
    std::vector<bool> with_source(kNodes);
    for (std::uint32_t v = 0; v < kNodes; ++v) with_source[v] = mask >> v & 1u;
    cheapest = std::min(cheapest, cost(with_source));
  }
  EXPECT_NEAR(cost(cut), cheapest, 30 * 1e-6);  // 30 links, each rounded to a millionth
  std::ranges::reverse(links);
  EXPECT_EQ(MinCut(kNodes, links), cut);
}

TEST(CutRefinement, ABoundaryMovesIntoTheGrooveWithinReach) {
  constexpr std::uint32_t kTubeRings = 41;
  constexpr std::uint32_t kTubeAround = 12;
  // A rod of length 4 with a groove at 2.
  const Shape rod = samples::Tube(
      kTubeRings, kTubeAround, [](double t) { return Vector3d(4.0 * t, 0.0, 0.0); },
      [](double t) { return 0.5 - 0.2 * std::exp(-std::pow(40.0 * (t - 0.5), 2)); });
  const FaceGraph faces = BuildFaceGraph(rod);
  const auto x = [&](std::uint32_t f) { return samples::FaceCenter(rod, f).x(); };
  const auto refined = [&](double width) {
    std::vector<std::int32_t> label;
    for (std::uint32_t f = 0; f < rod.faces.size(); ++f) label.push_back(x(f) > 1.5 ? 1 : 0);
    RefineBoundary(rod, GeodesicGraph(rod), faces, CutCosts(rod, faces), 1, width, label);
    return label;
  };
  const std::vector<std::int32_t> far = refined(0.9);
  for (std::uint32_t f = 0; f < rod.faces.size(); ++f)
    EXPECT_EQ(far[f], x(f) > 2.0 ? 1 : 0) << x(f);
  const std::vector<std::int32_t> near = refined(0.2);
  for (std::uint32_t f = 0; f < rod.faces.size(); ++f) {
    if (std::abs(x(f) - 1.5) < 0.3) continue;
    EXPECT_EQ(near[f], x(f) > 1.5 ? 1 : 0);
  }
}

TEST(CutRefinement, AConcaveEdgeIsCheaperThanAConvexOneAndThanAFlatOne) {
  Shape mesh;  // four triangles at three edges: convex, flat, concave
  mesh.points = {Vector3d(0, 0, 0), Vector3d(0, 1, 0),   Vector3d(1, 0, 0),
                 Vector3d(1, 1, 0), Vector3d(-1, 0, -1), Vector3d(2, 1, 1)};
  mesh.faces = {{0, 2, 1}, {1, 2, 3}, {0, 1, 4}, {3, 2, 5}};
  const FaceGraph faces = BuildFaceGraph(mesh);
  const std::vector<double> costs = CutCosts(mesh, faces);
  std::map<std::set<std::uint32_t>, double> per_length;
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const auto& [a, b] = faces.edge[k];
    per_length[{a, b}] = costs[k] / (mesh.points[a] - mesh.points[b]).norm();
  }
  EXPECT_NEAR((per_length[{1, 2}]), 1.0, 1e-12);
  EXPECT_LT((per_length[{0, 1}]), 1.0);
  EXPECT_LT((per_length[{2, 3}]), (per_length[{0, 1}]));
}

TEST(CutRefinement, CrumbsJoinTheLabelTheyTouchMost) {
  const Shape rod = samples::Tube(
      20, 8, [](double t) { return Vector3d(t, 0.0, 0.0); }, [](double) { return 0.1; });
  const FaceGraph faces = BuildFaceGraph(rod);
  std::vector<std::int32_t> whole;
  for (const auto& [a, b, c] : rod.faces) {
    whole.push_back(rod.points[a].x() + rod.points[b].x() + rod.points[c].x() > 1.5 ? 1 : 0);
  }
  std::vector<std::int32_t> label = whole;
  for (std::size_t f = 0; f < label.size(); ++f) {
    const double x = rod.points[rod.faces[f][0]].x();
    if (x < 0.2) label[f] = 1;  // an end with the wrong label, not connected to its part
  }
  JoinCrumbs(faces, label);
  EXPECT_EQ(label, whole);
}

}  // namespace
}  // namespace rangegrasp::parts
