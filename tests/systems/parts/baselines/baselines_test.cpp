#include "parts/baselines/baselines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/rng.h"
#include "parts/graphs.h"
#include "parts/metrics/human_score.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

// Two balls joined by a thin neck; the faces form rings along x.
constexpr std::uint32_t kRings = 61, kAround = 24;
Shape Dumbbell() {
  return samples::Tube(
      kRings, kAround, [](double t) { return Eigen::Vector3d(10.0 * t, 0.0, 0.0); },
      [](double t) {
        const double from_ball = std::min(std::abs(10.0 * t - 2.0), std::abs(10.0 * t - 8.0));
        return std::max(0.4, std::sqrt(std::max(0.0, 2.0 * 2.0 - from_ball * from_ball)));
      });
}

// The two halves, split at the middle of the neck.
Labels Halves(const Shape& dumbbell) {
  Labels labels;
  for (std::size_t f = 0; f < dumbbell.faces.size(); ++f) {
    labels.push_back(samples::FaceCenter(dumbbell, f).x() < 5.0 ? 0 : 1);
  }
  return labels;
}

void ExpectValid(const Shape& shape, const Segmentation& found) {
  ASSERT_EQ(found.label.size(), shape.faces.size());
  const std::set<std::int32_t> used(found.label.begin(), found.label.end());
  EXPECT_EQ(static_cast<int>(used.size()), found.parts);
  EXPECT_EQ(*used.begin(), 0);
  EXPECT_EQ(*used.rbegin(), found.parts - 1);
}

Shape Moved(const Shape& shape, const Eigen::Matrix3d& rotation, double scale) {
  Shape moved = shape;
  for (auto& p : moved.points) p = scale * (rotation * p) + Eigen::Vector3d(3.0, -7.0, 1.0);
  return moved;
}

const Eigen::Matrix3d kTurn =
    Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();

// A dumbbell with three faces at one edge, a hole, and a separate piece.
Shape Damaged() {
  Shape shape = Dumbbell();
  shape.faces.erase(shape.faces.begin() + 300, shape.faces.begin() + 340);
  const auto n = static_cast<std::uint32_t>(shape.points.size());
  shape.points.emplace_back(5.0, 5.0, 5.0);
  shape.points.emplace_back(6.0, 5.0, 5.0);
  shape.points.emplace_back(5.0, 6.0, 5.5);
  shape.faces.push_back({n, n + 1, n + 2});
  shape.faces.push_back({shape.faces[0][0], shape.faces[0][1], n});
  return shape;
}

// ---- k-means ----

TEST(KMeans, HalvesADumbbellAtItsNeck) {
  const Shape dumbbell = Dumbbell();
  const Segmentation found = SegmentByKMeans(dumbbell, {.clusters = 2});
  ExpectValid(dumbbell, found);
  // The cut may lie on any of the neck's six of 60 rings; these have a tenth of all faces.
  EXPECT_LT(RandError(found.label, Halves(dumbbell)), 0.1);
}

// All distances along the dual graph.
Eigen::MatrixXd DualDistances(const Shape& shape) {
  const auto n = static_cast<Eigen::Index>(shape.faces.size());
  Eigen::MatrixXd distance = Eigen::MatrixXd::Constant(n, n, 1e30);
  const auto at = [&](Eigen::Index f) {
    return samples::FaceCenter(shape, static_cast<std::size_t>(f));
  };
  for (Eigen::Index f = 0; f < n; ++f) {
    for (Eigen::Index g = 0; g < n; ++g) {
      int shared = 0;
      for (const auto v : shape.faces[static_cast<std::size_t>(f)]) {
        for (const auto w : shape.faces[static_cast<std::size_t>(g)]) shared += v == w ? 1 : 0;
      }
      if (shared >= 2) distance(f, g) = (at(f) - at(g)).norm();
    }
  }
  samples::Shorten(distance);
  return distance;
}

TEST(KMeans, FirstGivesEveryFaceToTheNearestOfTheFarthestSeeds) {
  // An asymmetric ball: no two distances are equal.
  const Shape ball = samples::Ball(4, [](const Eigen::Vector3d& p) {
    return 1.0 + 0.5 * std::sin(3.0 * p.x() + 0.3) + 0.3 * p.y() * p.z() + 0.2 * p.z();
  });
  const Eigen::MatrixXd distance = DualDistances(ball);
  const KMeansOptions options{.clusters = 5, .dihedral_weight = 0.0, .iterations = 1};
  const Labels label = SegmentByKMeans(ball, options).label;
  // Seeds found by brute force.
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (std::size_t f = 0; f < ball.faces.size(); ++f) {
    const auto& [a, b, c] = ball.faces[f];
    const double one =
        (ball.points[b] - ball.points[a]).cross(ball.points[c] - ball.points[a]).norm();
    centroid += one * samples::FaceCenter(ball, f);
    area += one;
  }
  std::vector<Eigen::Index> seeds{0};
  for (std::size_t f = 0; f < ball.faces.size(); ++f) {
    const auto far = [&](std::size_t g) {
      return (samples::FaceCenter(ball, g) - centroid / area).norm();
    };
    if (far(f) > far(static_cast<std::size_t>(seeds[0]))) seeds[0] = static_cast<Eigen::Index>(f);
  }
  const auto nearest = [&](Eigen::Index f) {
    return std::min_element(seeds.begin(), seeds.end(),
                            [&](auto s, auto t) { return distance(s, f) < distance(t, f); });
  };
  while (seeds.size() < 5) {
    Eigen::Index best = 0;
    for (Eigen::Index f = 0; f < distance.rows(); ++f) {
      if (distance(*nearest(f), f) > distance(*nearest(best), best)) best = f;
    }
    seeds.push_back(best);
  }
  for (Eigen::Index f = 0; f < distance.rows(); ++f) {
    EXPECT_EQ(label[static_cast<std::size_t>(f)], nearest(f) - seeds.begin()) << f;
  }
}

TEST(KMeans, GivesAsManyPartsAsAsked) {
  const Shape dumbbell = Dumbbell();
  for (const int k : {1, 2, 3, 5, 8, 20}) {
    const Segmentation found = SegmentByKMeans(dumbbell, {.clusters = k});
    ExpectValid(dumbbell, found);
    EXPECT_EQ(found.parts, k);
  }
}

TEST(KMeans, MoreClustersThanFacesAreOneFaceEach) {
  const Shape ball = samples::Ball(1, [](const auto&) { return 1.0; });
  const Segmentation found = SegmentByKMeans(ball, {.clusters = 1000});
  ExpectValid(ball, found);
  EXPECT_EQ(found.parts, static_cast<int>(ball.faces.size()));
}

TEST(KMeans, DoesNotDependOnPlaceAndScaleNorOnTheRun) {
  const Shape dumbbell = Dumbbell();
  const Labels labels = SegmentByKMeans(dumbbell, {.clusters = 4}).label;
  EXPECT_EQ(SegmentByKMeans(dumbbell, {.clusters = 4}).label, labels);
  // Scaled by a power of two without rotation, so that even rounding keeps the order of lengths.
  Shape larger = dumbbell;
  for (auto& p : larger.points) p *= 1024.0;
  EXPECT_EQ(SegmentByKMeans(larger, {.clusters = 4}).label, labels);
}

TEST(KMeans, ADamagedMeshIsCutToo) {
  const Shape damaged = Damaged();
  ExpectValid(damaged, SegmentByKMeans(damaged, {.clusters = 4}));
}

// ---- shape diameter function ----

TEST(Sdf, TellsTheBallsOfADumbbellFromItsNeck) {
  const Shape dumbbell = Dumbbell();
  const Segmentation found = SegmentBySdf(dumbbell, 2);
  ExpectValid(dumbbell, found);
  // Labels of faces in the middle of each ball and in the middle of the neck.
  std::set<std::int32_t> left, neck, right;
  for (std::size_t f = 0; f < dumbbell.faces.size(); ++f) {
    const double x = samples::FaceCenter(dumbbell, f).x();
    if (std::abs(x - 2.0) < 0.5) left.insert(found.label[f]);
    if (std::abs(x - 5.0) < 0.5) neck.insert(found.label[f]);
    if (std::abs(x - 8.0) < 0.5) right.insert(found.label[f]);
  }
  ASSERT_EQ(left.size(), 1U);
  ASSERT_EQ(neck.size(), 1U);
  ASSERT_EQ(right.size(), 1U);
  EXPECT_NE(*left.begin(), *neck.begin());
  EXPECT_NE(*right.begin(), *neck.begin());
  EXPECT_NE(*left.begin(), *right.begin()) << "equally thick, but apart: parts of their own";
}

TEST(Sdf, DoesNotDependOnTheRunNorOnThePose) {
  // Two clusters: with five, so simple a shape depends on rounding (local minima of the mixture).
  const Shape dumbbell = Dumbbell();
  const Labels labels = SegmentBySdf(dumbbell, 2).label;
  EXPECT_EQ(SegmentBySdf(dumbbell, 2).label, labels);
  EXPECT_LT(RandError(SegmentBySdf(Moved(dumbbell, kTurn, 0.01), 2).label, labels), 0.01);
}

TEST(Sdf, AMeshThatIsInsideOutHasTheSameParts) {
  const Shape dumbbell = Dumbbell();
  Shape turned = dumbbell;
  for (auto& face : turned.faces) std::swap(face[1], face[2]);
  EXPECT_EQ(SegmentBySdf(turned).label, SegmentBySdf(dumbbell).label);
}

TEST(Sdf, ADamagedMeshIsCutToo) {
  const Shape damaged = Damaged();
  ExpectValid(damaged, SegmentBySdf(damaged));
}

TEST(Sdf, ASurfaceWithoutInsideIsAResultToo) {
  // One folded sheet: no ray from a face hits anything behind it.
  Shape sheet;
  sheet.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.2}, {1, 1, 0}};
  sheet.faces = {{0, 1, 2}, {1, 3, 2}};
  ExpectValid(sheet, SegmentBySdf(sheet));
}

TEST(Sdf, TrianglesThatShareNoEdgeAreOnePartOrAPartEach) {
  int apart = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    Shape soup;
    for (std::uint32_t corner = 0; corner < 24; ++corner) {
      const double x = rng.Uniform(), y = rng.Uniform(), z = rng.Uniform();
      soup.points.emplace_back(x, y, z);
      if (corner % 3 == 2) soup.faces.push_back({corner - 2, corner - 1, corner});
    }
    const Segmentation found = SegmentBySdf(soup);
    ExpectValid(soup, found);
    EXPECT_TRUE(found.parts == 1 || found.parts == 8) << seed;
    apart += found.parts == 8 ? 1 : 0;
  }
  EXPECT_GT(apart, 0);
}

TEST(Sdf, SoupsOfRandomTrianglesNeverCrash) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    base::Rng rng(seed);
    Shape soup;
    const std::size_t points = 4 + rng.Index(12);
    for (std::size_t i = 0; i < points; ++i) {
      const double x = rng.Uniform(), y = rng.Uniform(), z = rng.Uniform();
      soup.points.emplace_back(x, y, z);
    }
    const std::size_t faces = 1 + rng.Index(30);
    while (soup.faces.size() < faces) {
      const auto a = static_cast<std::uint32_t>(rng.Index(points));
      const auto b = static_cast<std::uint32_t>(rng.Index(points));
      const auto c = static_cast<std::uint32_t>(rng.Index(points));
      if (a != b && b != c && c != a) soup.faces.push_back({a, b, c});
    }
    ExpectValid(soup, SegmentBySdf(soup));
    ExpectValid(soup, SegmentByKMeans(soup, {.clusters = 3}));
  }
}

}  // namespace
}  // namespace rangegrasp::parts
