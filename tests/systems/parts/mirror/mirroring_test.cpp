#include "parts/mirror/mirroring.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "base/error.h"
#include "base/rng.h"
#include "error_of.h"
#include "geometry/mesh.h"
#include "geometry/random_points.h"
#include "parts/mirror/internal/spherical_mirror.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

// A cell represents a direction: the cube face through which it leaves, and the place on that face.
TEST(CubeCell, HoldsDirectionsThatLeaveTheCubeCloseTogether) {
  constexpr int kSide = 5;
  base::Rng rng(1);
  std::set<std::size_t> cells;
  std::vector<Vector3d> first(6 * kSide * kSide, Vector3d::Zero());
  for (int i = 0; i < 20000; ++i) {
    const Vector3d d(rng.Normal(), rng.Normal(), rng.Normal());
    const std::size_t cell = CubeCell(d, kSide);
    ASSERT_LT(cell, first.size());
    EXPECT_EQ(CubeCell(rng.Uniform(0.1, 10.0) * d, kSide), cell);
    const Vector3d on_cube = d / d.cwiseAbs().maxCoeff();
    if (!cells.insert(cell).second) {
      // A cell is 2 / side wide and lies in one face.
      EXPECT_LE((on_cube - first[cell]).cwiseAbs().maxCoeff(), 2.0 / kSide + 1e-12);
    } else {
      first[cell] = on_cube;
    }
  }
  EXPECT_EQ(cells.size(), first.size());
  EXPECT_EQ(CubeCell(Vector3d::Zero(), kSide), 0U);
}

// Reference: the point comes first whose coordinates are smaller at the highest differing bit, in
// the order z, y, x, compared bit by bit.
TEST(SpatialOrder, IsThatOfInterleavedBits) {
  base::Rng rng(2);
  geometry::Points points = {Vector3d(0, 0, 0), Vector3d(1, 1, 1)};  // their bounding box
  for (int i = 0; i < 500; ++i) points.emplace_back(rng.Uniform(), rng.Uniform(), rng.Uniform());
  const auto order = SpatialOrder(points);
  std::vector<std::uint32_t> all(points.size());
  std::iota(all.begin(), all.end(), 0U);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    for (int bit = 20; bit >= 0; --bit) {
      for (const int axis : {2, 1, 0}) {
        const auto digit = [&](std::uint32_t i) {
          return static_cast<std::uint64_t>(points[i][axis] * 2097151.0) >> bit & 1U;
        };
        if (digit(a) != digit(b)) return digit(a) < digit(b);
      }
    }
    return a < b;
  };
  std::sort(all.begin(), all.end(), before);
  EXPECT_EQ(order, all);
  EXPECT_TRUE(SpatialOrder({}).empty());
  EXPECT_EQ(SpatialOrder(geometry::Points(3, Vector3d(1, 2, 3))),
            (std::vector<std::uint32_t>{0, 1, 2}));
}

using base::Rng;
using geometry::Points;
using geometry::samples::RandomDirection;

Points RandomPoints(std::size_t n, Rng& rng) {
  Points points;
  for (std::size_t i = 0; i < n; ++i)
    points.push_back(rng.Uniform(0.2, 3.0) * RandomDirection(rng));
  return points;
}

// ---- equations ----

TEST(SmallestEnclosingSphere, HoldsAllPointsAndNoSphereThroughFourIsSmaller) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    const Points points = RandomPoints(4 + rng.Index(12), rng);
    const Sphere sphere = SmallestEnclosingSphere(points);
    for (const auto& p : points) EXPECT_LE((p - sphere.center).norm(), sphere.radius * (1 + 1e-9));
    EXPECT_NEAR(SphereRound(sphere.center, points).radius, sphere.radius, 1e-9);
    // Any shift of the center increases the radius, because the problem is convex.
    for (int k = 0; k < 50; ++k) {
      const Eigen::Vector3d other = sphere.center + rng.Uniform(1e-4, 0.3) * RandomDirection(rng);
      EXPECT_GT(SphereRound(other, points).radius, sphere.radius);
    }
  }
}

TEST(SmallestEnclosingSphere, IsThatOfKnownSolids) {
  Points cube;
  for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const Sphere sphere = SmallestEnclosingSphere(cube);
  EXPECT_NEAR(sphere.radius, 0.5 * std::sqrt(3.0), 1e-12);
  EXPECT_LT((sphere.center - Eigen::Vector3d::Constant(0.5)).norm(), 1e-12);
  // Two points at the ends of a diameter, the others inside.
  const Points segment = {{-2, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, -1.5}};
  EXPECT_NEAR(SmallestEnclosingSphere(segment).radius, 2.0, 1e-12);
}

TEST(MirrorOut, IsEquation62) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    const Sphere sphere{rng.Uniform(0.0, 5.0) * RandomDirection(rng), rng.Uniform(1.0, 3.0)};
    const Eigen::Vector3d p =
        sphere.center + rng.Uniform(1e-6, 1.0) * sphere.radius * RandomDirection(rng);
    const Eigen::Vector3d d = p - sphere.center;
    const Eigen::Vector3d expected =
        p + 2.0 * (sphere.radius - d.norm()) * d / d.norm();  // as printed
    const Eigen::Vector3d image = MirrorOut(p, sphere);
    EXPECT_LT((image - expected).norm(), 1e-12);
    EXPECT_NEAR((image - sphere.center).norm(), 2.0 * sphere.radius - d.norm(), 1e-12);
  }
  EXPECT_EQ(MirrorOut({1, 2, 3}, {{1, 2, 3}, 2.0}), Eigen::Vector3d(5, 2, 3));
}

TEST(MirrorIn, BringsAnImageBackToItsOwnRadiusPlusTwiceTheOffset) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    const Sphere sphere{rng.Uniform(0.0, 5.0) * RandomDirection(rng), rng.Uniform(1.0, 3.0)};
    const Eigen::Vector3d p =
        sphere.center + rng.Uniform(0.1, 1.0) * sphere.radius * RandomDirection(rng);
    EXPECT_LT((MirrorIn(MirrorOut(p, sphere), sphere, 0.0) - p).norm(), 1e-12);
    const double offset = rng.Uniform(0.0, 0.2);
    const Eigen::Vector3d d = p - sphere.center;
    const Eigen::Vector3d expected = sphere.center + (d.norm() + 2.0 * offset) * d.normalized();
    EXPECT_LT((MirrorIn(MirrorOut(p, sphere), sphere, offset) - expected).norm(), 1e-12);
  }
}

TEST(Offset, IsTheMeanDifferenceOfRadii) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const Points neighbors = RandomPoints(rng.Index(9), rng);
    const Eigen::Vector3d center = RandomDirection(rng);
    const Eigen::Vector3d p = 2.0 * RandomDirection(rng);
    double sum = 0.0;
    for (const auto& n : neighbors) {
      sum += std::abs((n - center).norm() - (p - center).norm());
    }
    const double expected = neighbors.empty() ? 0.0 : sum / static_cast<double>(neighbors.size());
    EXPECT_NEAR(Offset(p, neighbors, center), expected, 1e-12);
  }
}

// ---- inside ----

TEST(IsInside, AgreesWithTheRadiusOfAStarShapedMesh) {
  const auto radius = [](const Eigen::Vector3d& d) {
    return 1.0 + 0.4 * std::sin(3.0 * d.x()) * std::cos(4.0 * d.z());
  };
  Shape ball = samples::Ball(24, radius);
  Rng rng(3);
  for (int variant = 0; variant < 3; ++variant) {
    // Faces in either orientation, and with a hole.
    if (variant == 1) {
      for (auto& f : ball.faces) std::swap(f[0], f[1]);
    }
    if (variant == 2) {
      for (auto& f : ball.faces) {
        if (rng.Uniform() < 0.5) std::swap(f[0], f[1]);
      }
      ball.faces.resize(ball.faces.size() - ball.faces.size() / 20);
    }
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d d = RandomDirection(rng);
      const double edge = variant == 2 ? 0.7 : 0.95;  // less is certain near a hole
      EXPECT_TRUE(IsInside(ball, edge * rng.Uniform() * radius(d) * d)) << variant;
      EXPECT_FALSE(IsInside(ball, (2.0 - edge) * radius(d) * d)) << variant;
    }
  }
}

TEST(IsInside, ACloudsMiddleIsAndWhatIsBesideItIsNot) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    Shape cloud;
    for (int i = 0; i < 2000; ++i) cloud.points.push_back(RandomDirection(rng));
    EXPECT_TRUE(IsInside(cloud, 0.5 * RandomDirection(rng)));
    EXPECT_FALSE(IsInside(cloud, 1.5 * RandomDirection(rng)));
  }
}

TEST(HullSide, AgreesWithAllHalfSpaces) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Rng rng(seed);
    Points points = RandomPoints(8 + rng.Index(200), rng);
    if (seed % 3 == 0) {  // facets of many coplanar triangles
      for (auto& p : points) p = (4.0 * p).array().round() / 4.0;
    }
    const auto hull = geometry::ConvexHull(points);
    if (hull.triangles.empty()) continue;
    const Eigen::Vector3d center =
        seed % 5 == 4 ? Eigen::Vector3d(9, 9, 9) : geometry::Centroid(points);
    const HullSide side(hull, center);
    HullSide::Hint hint;
    for (int k = 0; k < 400; ++k) {
      const Eigen::Vector3d p = rng.Uniform(0.0, 3.5) * RandomDirection(rng);
      double farthest = -1e9;
      for (const auto& t : hull.triangles) {
        const Eigen::Vector3d a = hull.vertices[t[0]];
        const Eigen::Vector3d n =
            (hull.vertices[t[1]] - a).cross(hull.vertices[t[2]] - a).normalized();
        farthest = std::max(farthest, n.dot(p - a));
      }
      if (std::abs(farthest) < 1e-6) continue;
      EXPECT_EQ(side.Contains(p, hint), farthest < 0.0) << seed;
    }
    for (const auto& v : hull.vertices) EXPECT_TRUE(side.Contains(v, hint)) << seed;
  }
  HullSide::Hint hint;
  EXPECT_FALSE(HullSide({}, {0, 0, 0}).Contains({0, 0, 0}, hint));
}

// ---- the method ----

// A ball with four arms along +-x and +-y. The arms are far outside.
double Armed(const Eigen::Vector3d& d) {
  const double along = std::max(std::abs(d.x()), std::abs(d.y()));
  return 1.0 + 1.5 * std::exp(-60.0 * (1.0 - along));
}

Shape ArmedCloud(std::size_t n, std::uint64_t seed) {
  Rng rng(seed);
  Shape cloud;
  while (cloud.points.size() < n) {
    if (rng.Uniform() < 0.6) {
      const Eigen::Vector3d d = RandomDirection(rng);
      if (std::max(std::abs(d.x()), std::abs(d.y())) < 0.96) cloud.points.push_back(d);
      continue;
    }
    const double angle = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    const double r = 0.25;
    const Eigen::Vector3d arm(rng.Uniform(0.97, 2.5), r * std::cos(angle), r * std::sin(angle));
    const double turn = 0.5 * std::numbers::pi * static_cast<double>(rng.Index(4));
    cloud.points.push_back(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * arm);
  }
  return cloud;
}

TEST(SegmentByMirroring, TakesTheArmsOffABall) {
  const Shape shape = samples::Ball(40, Armed);
  const Segmentation parts = SegmentByMirroring(shape);
  EXPECT_TRUE(parts.has_core);
  EXPECT_EQ(parts.parts, 5);
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    const Eigen::Vector3d p = samples::FaceCenter(shape, f);
    if (p.norm() > 1.5) {
      EXPECT_GT(parts.label[f], 0);
    }
    if (p.norm() < 1.005) {
      EXPECT_EQ(parts.label[f], 0);
    }
  }
}

TEST(SegmentByMirroring, TakesTheArmsOffACloud) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Shape cloud = ArmedCloud(6000, seed);
    const Segmentation parts = SegmentByMirroring(cloud);
    ASSERT_EQ(parts.label.size(), cloud.points.size());
    EXPECT_EQ(parts.parts, 5) << seed;
    // The outer half of each arm has one label, which differs from those of the other arms.
    std::map<int, std::int32_t> of_arm;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      const Eigen::Vector3d& p = cloud.points[i];
      if (p.norm() < 1.8) continue;
      const int arm = std::abs(p.x()) > std::abs(p.y()) ? (p.x() > 0 ? 0 : 1) : (p.y() > 0 ? 2 : 3);
      const auto [known, added] = of_arm.emplace(arm, parts.label[i]);
      EXPECT_EQ(known->second, parts.label[i]);
    }
    EXPECT_EQ(of_arm.size(), 4U);
  }
}

TEST(SegmentByMirroring, TakesTheArmsOffADenseAndNoisyCloud) {
  Shape cloud = ArmedCloud(100'000, 1);
  Rng rng(2);
  for (Eigen::Vector3d& p : cloud.points) {
    for (double& x : p) x += 0.015 * rng.Normal();  // 0.3 % of the size
  }
  const Segmentation parts = SegmentByMirroring(cloud);
  std::set<std::int32_t> arms;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (cloud.points[i].norm() > 1.8) arms.insert(parts.label[i]);
  }
  EXPECT_EQ(arms.size(), 4U);
  EXPECT_FALSE(arms.contains(0));
  // Other parts are crumbs of the ball that lie outside the inner hull.
  const auto crumbs = std::count_if(parts.label.begin(), parts.label.end(),
                                    [&](std::int32_t l) { return l > 0 && !arms.contains(l); });
  EXPECT_LT(crumbs, 1'000);
}

TEST(SegmentByMirroring, TheCoreHasNoHoles) {
  // All points of the sphere far from an arm are core, not only those on the outer hull.
  const Shape cloud = ArmedCloud(6000, 9);
  const auto core = ExtractCore(cloud);
  ASSERT_TRUE(core);
  std::size_t holes = 0;
  std::size_t ball = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d& p = cloud.points[i];
    if (p.norm() > 1.01 || std::max(std::abs(p.x()), std::abs(p.y())) > 0.8) continue;
    ++ball;
    holes += core->inside[i] ? 0 : 1;
  }
  EXPECT_GT(ball, 1000U);
  EXPECT_EQ(holes, 0U);
}

TEST(SegmentByMirroring, IsInvariantUnderRotationTranslationAndScale) {
  for (const bool mesh : {true, false}) {
    const Shape shape = mesh ? samples::Ball(20, Armed) : ArmedCloud(3000, 4);
    const auto labels = SegmentByMirroring(shape).label;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      Rng rng(seed);
      const Eigen::AngleAxisd turn(rng.Uniform(0.0, 3.0), RandomDirection(rng));
      const double scale = std::pow(10.0, rng.Uniform(-4.0, 4.0));
      const Eigen::Vector3d shift = scale * rng.Uniform(0.0, 5.0) * RandomDirection(rng);
      Shape moved = shape;
      for (auto& p : moved.points) p = scale * (turn * p) + shift;
      const auto other = SegmentByMirroring(moved).label;
      // A point exactly on the hull's surface may be on either side by rounding.
      std::size_t differ = 0;
      for (std::size_t i = 0; i < labels.size(); ++i) differ += labels[i] == other[i] ? 0 : 1;
      EXPECT_LE(differ, labels.size() / 500) << seed << (mesh ? " mesh" : " cloud");
    }
  }
}

TEST(SegmentByMirroring, ItsLabelsAreDenseAndFallBySize) {
  const Segmentation parts = SegmentByMirroring(ArmedCloud(5000, 2));
  std::vector<std::size_t> count(static_cast<std::size_t>(parts.parts), 0);
  for (const std::int32_t l : parts.label) ++count.at(static_cast<std::size_t>(l));
  EXPECT_TRUE(std::is_sorted(count.begin() + 1, count.end(), std::greater<>()));
  EXPECT_GT(count.back(), 8U);
}

// A horseshoe: the sphere's center and the center of gravity are both in its opening.
TEST(SegmentByMirroring, StopsWhereNoCenterIsInsideUnlessToldToGoOn) {
  const auto bow = [](double t) {
    const double angle = std::numbers::pi * (0.1 + 1.8 * t);
    return Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  };
  const Shape shape = samples::Tube(60, 12, bow, [](double) { return 0.15; });
  EXPECT_FALSE(ExtractCore(shape));
  const std::string error = testing_support::ErrorOf([&] { SegmentByMirroring(shape); });
  for (const char* cure : {"--go-on-outside", "--method hierarchy", "rangegrasp perceive CLOUD"}) {
    EXPECT_THAT(error, testing::HasSubstr(cure));
  }
  const Segmentation parts = SegmentByMirroring(shape, /*go_on_outside=*/true);
  EXPECT_EQ(parts.label.size(), shape.faces.size());
  EXPECT_NE(parts.note, "");
}

// A ball with a long bent tail: the smallest sphere's center is next to the tail, the center of
// gravity is in the ball.
TEST(SegmentByMirroring, FallsBackToTheCenterOfGravity) {
  const auto bent = [](double t) {
    return Eigen::Vector3d(std::min(0.0, 0.9 - 6.0 * t) + 2.0 * t, 3.0 * t * t, 0.0);
  };
  const Shape shape = samples::Tube(200, 16, bent, [](double t) {
    return t < 0.2 ? 0.1 + 1.5 * std::sqrt(t * (0.2 - t)) * 5.0 : 0.05;
  });
  const auto core = ExtractCore(shape);
  ASSERT_TRUE(core);
  EXPECT_TRUE(core->used_centroid);
  EXPECT_TRUE(core->center_inside);
  EXPECT_NE(SegmentByMirroring(shape).note, "");
}

TEST(SegmentByMirroring, SeveralPiecesAndOpenMeshesHaveResults) {
  Shape two = samples::Ball(10, [](const Eigen::Vector3d&) { return 1.0; });
  const Shape other = samples::Ball(6, [](const Eigen::Vector3d&) { return 0.3; });
  const auto offset = static_cast<std::uint32_t>(two.points.size());
  for (const auto& p : other.points) two.points.push_back(p + Eigen::Vector3d(1.6, 0, 0));
  for (const auto& f : other.faces)
    two.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  const Segmentation parts = SegmentByMirroring(two);
  EXPECT_EQ(parts.label.size(), two.faces.size());
  EXPECT_GE(parts.parts, 2);
  Shape open = samples::Ball(10, Armed);
  open.faces.resize(open.faces.size() * 9 / 10);
  EXPECT_NO_THROW(SegmentByMirroring(open, /*go_on_outside=*/true));
}

}  // namespace
}  // namespace rangegrasp::parts
