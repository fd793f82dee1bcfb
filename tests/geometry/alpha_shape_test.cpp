#include "geometry/alpha_shape.h"

#include <CGAL/Alpha_shape_2.h>
#include <CGAL/Alpha_shape_3.h>
#include <CGAL/Alpha_shape_cell_base_3.h>
#include <CGAL/Alpha_shape_face_base_2.h>
#include <CGAL/Alpha_shape_vertex_base_2.h>
#include <CGAL/Alpha_shape_vertex_base_3.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/units.h"
#include "geometry/random_points.h"

namespace rangegrasp::geometry {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Alpha3 = CGAL::Alpha_shape_3<CGAL::Delaunay_triangulation_3<
    Kernel, CGAL::Triangulation_data_structure_3<CGAL::Alpha_shape_vertex_base_3<Kernel>,
                                                 CGAL::Alpha_shape_cell_base_3<Kernel>>>>;
using Alpha2 = CGAL::Alpha_shape_2<CGAL::Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<CGAL::Alpha_shape_vertex_base_2<Kernel>,
                                                 CGAL::Alpha_shape_face_base_2<Kernel>>>>;
using TriangleSet = std::set<std::array<std::uint32_t, 3>>;

template <class Point>
struct Less {
  bool operator()(const Point& a, const Point& b) const {
    return std::lexicographical_compare(a.data(), a.data() + a.size(), b.data(),
                                        b.data() + b.size());
  }
};

/// Facets of CGAL's own alpha shape that are not exterior.
TriangleSet ReferenceTriangles(const Points& points, double alpha) {
  std::map<Eigen::Vector3d, std::uint32_t, Less<Eigen::Vector3d>> position;
  std::vector<Kernel::Point_3> input;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    position.emplace(points[i], i);
    input.emplace_back(points[i].x(), points[i].y(), points[i].z());
  }
  Alpha3 shape(input.begin(), input.end(), alpha * alpha, Alpha3::GENERAL);
  TriangleSet triangles;
  for (auto f = shape.finite_facets_begin(); f != shape.finite_facets_end(); ++f) {
    if (shape.classify(*f) == Alpha3::EXTERIOR) continue;
    std::array<std::uint32_t, 3> t{};
    for (int i = 0; i < 3; ++i) {
      const auto& p = f->first->vertex((f->second + 1 + i) & 3)->point();
      t[static_cast<std::size_t>(i)] = position.at(Eigen::Vector3d(p.x(), p.y(), p.z()));
    }
    std::sort(t.begin(), t.end());
    triangles.insert(t);
  }
  return triangles;
}

class SeededAlpha : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededAlpha, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededAlpha, TheComplexIsThatOfCgalsAlphaShape) {
  base::Rng rng(GetParam());
  const Points points = samples::RandomPoints(4 + rng.Index(200), 1.0, rng);
  const double alpha = rng.Uniform(0.1, 0.8);
  const auto found = AlphaTriangles(points, alpha);
  const TriangleSet triangles(found.begin(), found.end());
  EXPECT_EQ(triangles.size(), found.size());
  EXPECT_EQ(triangles, ReferenceTriangles(points, alpha));
}

/// The triangles of points i as those of points order[i].
std::vector<std::array<std::uint32_t, 3>> Renumbered(
    std::vector<std::array<std::uint32_t, 3>> triangles, const Indices& order) {
  for (auto& t : triangles) {
    for (std::uint32_t& i : t) i = order[i];
    std::sort(t.begin(), t.end());
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST_P(SeededAlpha, TheComplexDoesNotDependOnTheOrderOfThePointsEvenOnAGrid) {
  base::Rng rng(GetParam());
  Points points;  // cospherical points everywhere, so the triangulation is ambiguous
  for (int x = 0; x < 7; ++x) {
    for (int y = 0; y < 7; ++y) {
      for (int z = 0; z < 3; ++z) points.emplace_back(x, y, z);
    }
  }
  const Indices order = samples::Permutation(points.size(), rng);
  const Points shuffled = Select(points, order);
  EXPECT_EQ(AlphaTriangles(points, 0.8), Renumbered(AlphaTriangles(shuffled, 0.8), order));
}

TEST_P(SeededAlpha, TheComplexOfNearTwinsDoesNotDependOnTheOrderOfThePoints) {
  base::Rng rng(GetParam());
  Points
      points;  // pairs that differ in the last digit: their needles' radii are only rounding errors
  for (const Eigen::Vector3d& p : samples::RandomPoints(150, 0.1, rng)) {
    points.push_back(p);
    points.emplace_back(std::nextafter(p.x(), 1.0), p.y(), p.z());
  }
  const Indices order = samples::Permutation(points.size(), rng);
  const Points shuffled = Select(points, order);
  for (const double alpha : {0.01, 0.02, 0.03, 0.05}) {
    EXPECT_EQ(AlphaTriangles(points, alpha), Renumbered(AlphaTriangles(shuffled, alpha), order))
        << alpha;
  }
}

TEST(Alpha, FlatAndTinyCloudsHaveTheirComplexToo) {
  const Points square = {{0.0, 0.0, 1.0}, {1.0, 0.0, 1.0}, {1.0, 1.0, 1.0}, {0.0, 1.0, 1.0}};
  EXPECT_EQ(AlphaTriangles(square, 0.71).size(), 2u);
  EXPECT_TRUE(AlphaTriangles(square, 0.70).empty());
  EXPECT_TRUE(AlphaTriangles(Points{}, 1.0).empty());
  EXPECT_TRUE(AlphaTriangles(Points(4, {0.0, 0.0, 0.0}), 1.0).empty());
}

double SignedArea(const std::vector<Eigen::Vector2d>& p, const std::vector<std::uint32_t>& loop) {
  double area = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const auto& a = p[loop[i]];
    const auto& b = p[loop[(i + 1) % loop.size()]];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return area;
}

TEST_P(SeededAlpha, The2DTrianglesAreThoseOfCgalsAlphaShapeAndTheLoopsBoundThem) {
  base::Rng rng(GetParam());
  std::vector<Eigen::Vector2d> points;
  std::vector<Kernel::Point_2> input;
  for (std::size_t i = 0; i < 200; ++i) {
    const double x = rng.Uniform();
    const double y = rng.Uniform();
    points.emplace_back(x, y);
    input.emplace_back(x, y);
  }
  const double alpha = rng.Uniform(0.03, 0.15);
  const AlphaShape2 shape = BuildAlphaShape2(points, alpha);
  Alpha2 reference(input.begin(), input.end(), alpha * alpha, Alpha2::GENERAL);
  std::size_t interior = 0;
  for (auto f = reference.finite_faces_begin(); f != reference.finite_faces_end(); ++f) {
    interior += reference.classify(f) == Alpha2::INTERIOR ? 1 : 0;
  }
  EXPECT_EQ(shape.triangles.size(), interior);
  double loops = 0.0;
  for (const auto& loop : shape.loops) {
    EXPECT_GE(loop.size(), 3u);
    loops += SignedArea(points, loop);
  }
  EXPECT_NEAR(loops, shape.area_m2, 1e-12);  // Green's theorem: holes count as negative
}

TEST(Alpha2D, ARingHasAnOuterLoopCounterClockwiseAndAHoleClockwise) {
  std::vector<Eigen::Vector2d> points;
  base::Rng rng(4);
  for (double r : {0.05, 0.0485, 0.047, 0.0455, 0.044}) {
    for (int i = 0; i < 200; ++i) {
      const double angle = 2.0 * base::kPi * (i + rng.Uniform(-0.2, 0.2)) / 200;
      points.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
  }
  const AlphaShape2 shape = BuildAlphaShape2(points, 0.004);
  ASSERT_EQ(shape.loops.size(), 2u);
  EXPECT_GT(SignedArea(points, shape.loops[0]), 0.0);
  EXPECT_LT(SignedArea(points, shape.loops[1]), 0.0);
  // The chords of 200 sides are within 1 - cos(1.2 pi / 200) = 2e-4 of the radius.
  for (const std::uint32_t i : shape.loops[0]) EXPECT_NEAR(points[i].norm(), 0.05, 1e-9);
  for (const std::uint32_t i : shape.loops[1]) EXPECT_NEAR(points[i].norm(), 0.044, 1e-9);
  EXPECT_NEAR(shape.area_m2, base::kPi * (0.05 * 0.05 - 0.044 * 0.044), 1e-5);
}

// Two squares of grid points, 10 mm apart: two shapes with the smaller alpha, one with the larger.
TEST(Alpha2D, EachAlphaOfOneTriangulationHasItsOwnShape) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 11; ++i) {
    for (int j = 0; j < 11; ++j) {
      points.emplace_back(0.002 * i, 0.002 * j);
      points.emplace_back(0.030 + 0.002 * i, 0.002 * j);
    }
  }
  const auto shapes = BuildAlphaShapes2(points, std::vector{0.002, 0.020});
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0].loops.size(), 2u);
  EXPECT_NEAR(shapes[0].area_m2, 2 * 0.02 * 0.02, 1e-12);
  EXPECT_EQ(shapes[1].loops.size(), 1u);
  EXPECT_NEAR(shapes[1].area_m2, 0.05 * 0.02, 1e-12);
}

TEST(Alpha2D, TrianglesThatTouchInAPointGiveSimpleLoops) {
  std::vector<Eigen::Vector2d> points = {
      {0.0, 0.0}, {1.0, 0.5}, {1.0, -0.5}, {-1.0, 0.5}, {-1.0, -0.5}};
  for (std::size_t k = 0; k < points.size(); ++k) {  // at any place of the common point
    const AlphaShape2 shape = BuildAlphaShape2(points, 0.7);
    EXPECT_EQ(shape.triangles.size(), 2u);
    EXPECT_EQ(shape.loops.size(), 2u) << k;
    for (const auto& loop : shape.loops) EXPECT_EQ(loop.size(), 3u) << k;
    std::ranges::rotate(points, points.begin() + 1);
  }
  EXPECT_TRUE(BuildAlphaShape2({}, 1.0).loops.empty());
}

}  // namespace
}  // namespace rangegrasp::geometry
