#include "cylinders/rims.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/rng.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;
using geometry::samples::RandomVector;

/// Two faces of a box that meet along y at the origin: points 2 mm apart, exact normals.
geometry::PointCloud Edge() {
  geometry::PointCloud cloud;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < 20; ++k) {
      cloud.points.emplace_back(-0.001 - 0.002 * i, 0.002 * k, 0.0);
      cloud.normals.push_back(Vector3d::UnitZ());
      cloud.points.emplace_back(0.0, 0.002 * k, -0.001 - 0.002 * i);
      cloud.normals.push_back(Vector3d::UnitX());
    }
  }
  return cloud;
}

/// The scalar product, component by component.
double Product(const Vector3d& a, const Vector3d& b) {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) sum += a[k] * b[k];
  return sum;
}

TEST(Curvature, EdgeCosineIsThatOfTheEquation) {
  base::Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3d before = RandomVector(rng);
    const Vector3d p = RandomVector(rng);
    const Vector3d after = RandomVector(rng);
    const double one = std::sqrt(Product(p - before, p - before));
    const double other = std::sqrt(Product(p - after, p - after));
    EXPECT_NEAR(EdgeCosine(before, p, after), Product(p - before, p - after) / (one * other),
                1e-12);
  }
  EXPECT_NEAR(EdgeCosine({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), -1.0, 1e-12);
  EXPECT_NEAR(EdgeCosine({0, 0, 0}, {1, 0, 0}, {1, 1, 0}), 0.0, 1e-12);
  EXPECT_EQ(EdgeCosine({1, 0, 0}, {1, 0, 0}, {2, 0, 0}), -1.0);
}

TEST(Curvature, CurvedPointsAreThoseOfANaiveLoop) {
  base::Rng rng(3);
  geometry::PointCloud cloud = Edge();
  for (auto& n : cloud.normals) n = (n + 0.1 * RandomVector(rng)).normalized();
  const CurvatureOptions options;
  const auto curved = CurvedPoints(cloud, geometry::KdTree(cloud.points), options);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    double sum = 0.0;
    int others = 0;
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      if (k == i || (cloud.points[k] - cloud.points[i]).norm() >= options.radius_m) continue;
      sum += cloud.normals[i].dot(cloud.normals[k]);
      ++others;
    }
    const double angle = others == 0 ? 0.0 : std::acos(sum / others);
    EXPECT_EQ(curved[i], angle > base::Deg(20.0)) << i;
  }
}

TEST(Curvature, NeighborsThatAreKnownChangeNothing) {
  base::Rng rng(5);
  geometry::PointCloud cloud = Edge();
  for (auto& p : cloud.points) p += 0.0003 * RandomVector(rng);
  const geometry::KdTree tree(cloud.points);
  const CurvatureOptions options;
  const Vector3d eye(1.0, 0.0, 1.0);
  for (const double radius_m : {double{options.radius_m}, 0.5 * options.radius_m}) {
    geometry::NeighborLists known;
    cloud.normals = geometry::EstimateNormals(cloud.points, tree, radius_m, {&eye, 1}, {},
                                              2.0 * radius_m, &known);
    ASSERT_TRUE(known.Has(cloud.size() - 1));
    EXPECT_EQ(CurvedPoints(cloud, tree, options, known), CurvedPoints(cloud, tree, options));
    // For some points no list may have been kept.
    known.ends.resize(cloud.size() / 2);
    EXPECT_EQ(CurvedPoints(cloud, tree, options, known), CurvedPoints(cloud, tree, options));
  }
}

TEST(Curvature, OnlyWhatIsNearAnEdgeIsCurved) {
  const geometry::PointCloud cloud = Edge();
  const auto curved = CurvedPoints(cloud, geometry::KdTree(cloud.points), {});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double from_edge = Vector3d(cloud.points[i].x(), 0.0, cloud.points[i].z()).norm();
    if (from_edge < 0.002) {
      EXPECT_TRUE(curved[i]) << i;
    }
    if (from_edge > 0.005) {
      EXPECT_FALSE(curved[i]) << i;
    }
  }
}

TEST(Curvature, LineEdgesAreThoseOfTheEquationOverStoredNeighbors) {
  base::Rng rng(4);
  geometry::Points points;
  geometry::Indices lines;
  for (std::uint32_t line = 0; line < 5; ++line) {
    for (std::uint32_t sample = 0; sample < 40; ++sample) {
      points.push_back(Vector3d(0.01 * sample, 0.02 * line, 0.0) + 0.01 * RandomVector(rng));
      lines.push_back(line);
    }
  }
  CurvatureOptions options;
  options.line_step_m = 0.0;
  const auto edges = LineEdges(points, lines, options);
  int found = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool edge = false;
    if (i != 0 && i + 1 != points.size()) {
      edge = std::acos(EdgeCosine(points[i - 1], points[i], points[i + 1])) < base::Deg(110.0);
    }
    EXPECT_EQ(edges[i], edge) << i;
    found += edge;
  }
  EXPECT_GT(found, 10);
}

TEST(Curvature, NoiseOfDenseSamplesIsNoEdge) {
  // A straight line of samples 0.2 mm apart with 0.1 mm noise, and one with a right-angle bend.
  base::Rng rng(5);
  geometry::Points points;
  geometry::Indices lines;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const double along = 0.0002 * i - 0.04;
    points.push_back(Vector3d(std::min(along, 0.0), std::max(along, 0.0), 0.0) +
                     0.0001 * RandomVector(rng));
    lines.push_back(0);
  }
  CurvatureOptions options;
  options.line_step_m = 0.002;
  const auto edges = LineEdges(points, lines, options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double from_edge = std::abs(0.0002 * static_cast<double>(i) - 0.04);
    if (from_edge < 0.0003) {
      EXPECT_TRUE(edges[i]) << i;
    }
    if (from_edge > 0.0025) {
      EXPECT_FALSE(edges[i]) << i;
    }
  }
  options.line_step_m = 0.0;
  const auto adjacent = LineEdges(points, lines, options);
  EXPECT_GT(std::ranges::count(adjacent, true), 20);
}

TEST(Curvature, SensorGateIsThePublishedOne) {
  EXPECT_TRUE(PassesSensorGate({0.8, 0.5, 0.3}));
  EXPECT_FALSE(PassesSensorGate({0.5, 0.8, 0.3}));
  EXPECT_FALSE(PassesSensorGate({0.5, 0.3, 0.8}));
  EXPECT_TRUE(PassesSensorGate({0.1, -0.99, 0.0}));
}

TEST(Curvature, SensorGatePassesTopsAndNearlyNothingOfAStandingBarrel) {
  // In any frame of the cloud, the axes follow the up direction and the direction to the sensor.
  base::Rng rng(6);
  for (int turn = 0; turn < 20; ++turn) {
    const Vector3d up = RandomVector(rng).normalized();
    const Vector3d level = up.unitOrthogonal();
    const Vector3d side = up.cross(level);
    const Eigen::Matrix3d R_CS = SensorAxes(up, level + 0.75 * up);
    EXPECT_NEAR((R_CS.transpose() * R_CS - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(R_CS.determinant(), 1.0, 1e-12);
    const auto passes = [&](const Vector3d& n_C) {
      return PassesSensorGate(R_CS.transpose() * n_C);
    };
    EXPECT_TRUE(passes(up));
    int barrel = 0;
    for (int degree = -89; degree <= 89; ++degree) {
      const double angle = base::Deg(degree);  // from the direction to the sensor: the visible half
      const Vector3d out = std::cos(angle) * level + std::sin(angle) * side;
      barrel += passes(out);
      EXPECT_TRUE(passes((up + 0.9 * out).normalized())) << degree;
    }
    EXPECT_EQ(barrel, 0);
  }
}

geometry::Points RandomPoints(int count, base::Rng& rng) {
  geometry::Points points;
  for (int i = 0; i < count; ++i) {
    const double x = rng.Uniform();
    const double y = rng.Uniform();
    points.emplace_back(x, y, 0.1 * rng.Uniform());
  }
  return points;
}

double NaiveMeanNearest(const geometry::Points& points) {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (k != i) nearest = std::min(nearest, (points[i] - points[k]).norm());
    }
    sum += nearest;
  }
  return sum / static_cast<double>(points.size());
}

TEST(Fragments, MeanNeighborDistanceIsThatOfANaiveLoop) {
  base::Rng rng(1);
  const auto points = RandomPoints(200, rng);
  double sum = 0.0;
  int with_neighbors = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double of_one = 0.0;
    int m = 0;
    for (std::size_t t = 0; t < points.size(); ++t) {
      const double d = (points[i] - points[t]).norm();
      if (t == i || d >= 0.1) continue;
      of_one += d;
      ++m;
    }
    if (m == 0) continue;
    sum += of_one / m;
    ++with_neighbors;
  }
  EXPECT_NEAR(MeanNeighborDistance(points, geometry::KdTree(points), 0.1), sum / with_neighbors,
              1e-12);
  const geometry::Points apart = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(MeanNeighborDistance(apart, geometry::KdTree(apart), 0.1), 0.0);
}

// The recursive flood fill of the text, with a direct implementation of eq. 4.16.
std::vector<geometry::Indices> NaiveFloodFill(const geometry::Points& points, double d_ca) {
  std::vector<bool> visited(points.size(), false);
  std::vector<geometry::Indices> fragments;
  std::function<void(std::uint32_t)> fill = [&](std::uint32_t i) {
    visited[i] = true;
    fragments.back().push_back(i);
    for (std::uint32_t w = 0; w < points.size(); ++w) {
      const double dx = points[i].x() - points[w].x();
      const double dy = points[i].y() - points[w].y();
      const double dz = points[i].z() - points[w].z();
      if (!visited[w] && std::sqrt(dx * dx + dy * dy + dz * dz) < d_ca) fill(w);
    }
  };
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (visited[i]) continue;
    fragments.emplace_back();
    fill(i);
    std::ranges::sort(fragments.back());
  }
  return fragments;
}

class SeededFragments : public testing::TestWithParam<double> {};

TEST_P(SeededFragments, AreThoseOfTheRecursiveFloodFill) {
  base::Rng rng(2);
  const auto points = RandomPoints(300, rng);
  auto naive = NaiveFloodFill(points, GetParam() * NaiveMeanNearest(points));
  std::erase_if(naive, [](const auto& fragment) { return fragment.size() < 3; });
  std::stable_sort(naive.begin(), naive.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  EXPECT_EQ(Fragments(points, {.link = GetParam(), .min_points = 3}), naive);
}
INSTANTIATE_TEST_SUITE_P(Links, SeededFragments, testing::Values(1.0, 1.5, 2.0));

TEST(Fragments, ThereAreNoneOfNoPoints) { EXPECT_TRUE(Fragments({}, {}).empty()); }

TEST(Fragments, TwoRimsApartAreTwo) {
  geometry::Points points;
  for (int i = 0; i < 40; ++i) points.emplace_back(0.002 * i, 0.0, 0.0);
  for (int i = 0; i < 30; ++i) points.emplace_back(0.002 * i, 0.05, 0.0);
  const auto fragments = Fragments(points, {});
  ASSERT_EQ(fragments.size(), 2u);
  EXPECT_EQ(fragments[0].size(), 40u);
  EXPECT_EQ(fragments[1].size(), 30u);
  // As printed, points at exactly the mean distance are not neighbors.
  EXPECT_TRUE(Fragments(points, {.link = 0.999, .min_points = 2}).empty());
}

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Noisy points of a circle of the given radius about the axis along `normal` through `center`.
geometry::Points Arc(const Vector3d& center, const Vector3d& normal, double radius_m,
                     double arc_rad, int count, double noise_m, base::Rng& rng) {
  const Vector3d u = normal.unitOrthogonal();
  const Vector3d v = normal.cross(u);
  geometry::Points points;
  for (int i = 0; i < count; ++i) {
    const double angle = arc_rad * i / count;
    const Vector3d noise = noise_m * RandomVector(rng);
    points.push_back(center + radius_m * (std::cos(angle) * u + std::sin(angle) * v) + noise);
  }
  return points;
}

TEST(CylinderCircle, ProductsAreThoseOfTheEquations) {
  base::Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = RandomVector(rng);
    const Vector3d b = RandomVector(rng);
    const Vector3d c = RandomVector(rng);
    const double ca = Product(c - a, b - a);
    const double ba = Product(c - b, a - b);
    const double cb = Product(a - c, b - c);
    const auto p = ProductsOf(a, b, c);
    EXPECT_DOUBLE_EQ(p.d_ca, ca);
    EXPECT_DOUBLE_EQ(p.d_ba, ba);
    EXPECT_DOUBLE_EQ(p.d_cb, cb);
    EXPECT_DOUBLE_EQ(p.n_1, ba * cb);
    EXPECT_DOUBLE_EQ(p.n_2, cb * ca);
    EXPECT_DOUBLE_EQ(p.n_3, ca * ba);
    // The quotient's unit is m^2, so its root is a length.
    const double r =
        std::sqrt((ca + ba) * (ba + cb) * (cb + ca) / (ba * cb + cb * ca + ca * ba)) / 2;
    EXPECT_NEAR(CircumradiusOf(p), r, 1e-9 * r);
  }
}

TEST(CylinderCircle, RadiusIsTheProductOfTheSidesByFourAreas) {
  base::Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = RandomVector(rng);
    const Vector3d b = RandomVector(rng);
    const Vector3d c = RandomVector(rng);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    const double r = (a - b).norm() * (b - c).norm() * (c - a).norm() / (4.0 * area);
    EXPECT_NEAR(CircumradiusOf(ProductsOf(a, b, c)), r, 1e-6 * r);
  }
}

TEST(CylinderCircle, CircleThroughThreePointsIsAsFarFromEach) {
  base::Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const geometry::Points corners = {RandomVector(rng), RandomVector(rng), RandomVector(rng)};
    const auto circle = CircleThrough(corners[0], corners[1], corners[2]);
    ASSERT_TRUE(circle);
    for (const Vector3d& p : corners) {
      EXPECT_NEAR((p - circle->center).norm(), circle->radius_m, 1e-6 * circle->radius_m);
      EXPECT_NEAR((p - circle->center).dot(circle->normal), 0.0, 1e-6 * circle->radius_m);
    }
  }
}

TEST(CylinderCircle, ThereIsNoneThroughCollinearPoints) {
  EXPECT_FALSE(CircleThrough({0, 0, 1}, {0.1, 0, 1}, {0.3, 0, 1}));
  EXPECT_FALSE(CircleThrough({0, 0, 1}, {0, 0, 1}, {0.3, 0, 1}));
  EXPECT_FALSE(CircleThrough({0, 0, 1}, {0, 0, 1}, {0, 0, 1}));
}

TEST(CylinderCircle, DistanceFromTheSphereAndFromTheCurve) {
  const Circle circle{Vector3d::Zero(), Vector3d::UnitZ(), 0.03};
  const Vector3d pole(0, 0, 0.03);
  EXPECT_DOUBLE_EQ(DistanceTo(circle, pole, CircleDistance::kSphere), 0.0);
  EXPECT_DOUBLE_EQ(DistanceTo(circle, pole, CircleDistance::kCurve), std::hypot(0.03, 0.03));
  EXPECT_NEAR(DistanceTo(circle, {0.034, 0, 0.003}, CircleDistance::kCurve), 0.005, 1e-12);
}

TEST(CylinderCircle, SumAndShareAreThoseOfTheEquations) {
  base::Rng rng(4);
  const Circle circle{Vector3d(0.1, 0.2, 0.3), Vector3d::UnitZ(), 0.03};
  const auto rim = Arc(circle.center, circle.normal, 0.03, 3.0, 200, 0.002, rng);
  double sum = 0.0;
  int on_sphere = 0;
  for (const Vector3d& p : rim) {
    // The circle lies in z = 0.3.
    const double level = std::hypot(p.x() - 0.1, p.y() - 0.2);
    sum += std::hypot(level - 0.03, p.z() - 0.3);
    on_sphere += std::abs(0.03 - std::hypot(level, p.z() - 0.3)) <= 0.002;
  }
  EXPECT_NEAR(SumOfDistances(circle, rim, kNoLimit), sum, 1e-12);
  EXPECT_GT(SumOfDistances(circle, rim, 0.5 * sum), 0.5 * sum);
  EXPECT_DOUBLE_EQ(ShareOn(circle, rim, CircleDistance::kSphere, 0.002), on_sphere / 200.0);
  EXPECT_EQ(ShareOn(circle, {}, CircleDistance::kSphere, 0.002), 0.0);
}

TEST(CylinderCircle, TheLeastSumOfAllDrawsWins) {
  base::Rng rng(5);
  const auto rim = Arc(Vector3d::Zero(), Vector3d::UnitZ(), 0.03, 3.0, 60, 0.0005, rng);
  base::Rng naive(7);
  double least = kNoLimit;
  for (int draw = 0; draw < 100; ++draw) {
    const auto a = naive.Index(rim.size());
    const auto b = naive.Index(rim.size());
    const auto c = naive.Index(rim.size());
    const auto circle = CircleThrough(rim[a], rim[b], rim[c]);
    if (!circle) continue;
    double sum = 0.0;
    for (const Vector3d& p : rim) sum += DistanceTo(*circle, p, CircleDistance::kCurve);
    least = std::min(least, sum);
  }
  base::Rng same(7);
  const auto fit = FitRandomCircle(rim, 100, same);
  ASSERT_TRUE(fit);
  EXPECT_DOUBLE_EQ(SumOfDistances(*fit, rim, kNoLimit), least);
}

TEST(CylinderCircle, FindsAnArcAmongOutliers) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    base::Rng rng(seed);
    const Vector3d normal = RandomVector(rng).normalized();
    auto rim = Arc({0.5, -0.2, 0.9}, normal, 0.026, 3.5, 160, 0.0002, rng);
    for (int i = 0; i < 30; ++i) rim.push_back(Vector3d(0.5, -0.2, 0.9) + 0.03 * RandomVector(rng));
    const auto fit = FitRandomCircle(rim, 100, rng);
    ASSERT_TRUE(fit);
    // The best of about 60 clean triples; a typical one is off by about ten times the noise.
    EXPECT_NEAR(fit->radius_m, 0.026, 0.002);
    EXPECT_GT(ShareOn(*fit, rim, CircleDistance::kSphere, 0.002), 0.8);
  }
}

TEST(CylinderCircle, NoCircleOfTooFewPointsOrOfALine) {
  base::Rng rng(1);
  EXPECT_FALSE(FitRandomCircle({}, 100, rng));
  const geometry::Points two = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_FALSE(FitRandomCircle(two, 100, rng));
  const geometry::Points line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {4, 0, 0}};
  EXPECT_FALSE(FitRandomCircle(line, 100, rng));
}

}  // namespace
}  // namespace rangegrasp::cylinders
