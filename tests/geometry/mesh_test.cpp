#include "geometry/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/plane.h"
#include "geometry/random_points.h"
#include "geometry/sample_meshes.h"

namespace rangegrasp::geometry {
namespace {

const TriangleMesh kUnitCube = samples::BoxMesh({0.5, 0.5, 0.5});

TEST(Mesh, VolumeIsThatOfTheSolidWhereverItStands) {
  base::Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(rng.Uniform(0.0, 6.0), samples::RandomDirection(rng)).toRotationMatrix();
    const base::Pose X = base::MakePose(R, samples::RandomPoint(100.0, rng));
    EXPECT_NEAR(Volume(Transformed(kUnitCube, X)), 1.0, 1e-10);
  }
}

TEST(Mesh, VolumeOfAMeshTurnedInsideOutIsNegative) {
  TriangleMesh mesh = kUnitCube;
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(Volume(mesh), -1.0, 1e-12);
  EXPECT_EQ(Volume(TriangleMesh{}), 0.0);
}

TEST(Mesh, AppendAddsUp) {
  TriangleMesh twice = kUnitCube;
  for (Eigen::Vector3d& p : twice.vertices) p.z() *= 2.0;
  TriangleMesh mesh = kUnitCube;
  Append(twice, mesh);
  EXPECT_NEAR(Volume(mesh), 3.0, 1e-12);
  EXPECT_EQ(mesh.vertices.size(), 16u);
}

class SeededHull : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededHull, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededHull, EveryPointIsInsideEveryFaceAndEveryVertexIsAPoint) {
  base::Rng rng(GetParam());
  const Points points = samples::RandomPoints(4 + rng.Index(300), 1.0, rng);
  const TriangleMesh hull = ConvexHull(points);
  ASSERT_FALSE(hull.triangles.empty());
  for (const auto& [a, b, c] : hull.triangles) {
    const auto plane = PlaneThrough(hull.vertices[a], hull.vertices[b], hull.vertices[c]);
    ASSERT_TRUE(plane);
    for (const Eigen::Vector3d& p : points) EXPECT_LE(plane->Distance(p), 1e-12);
  }
  for (const Eigen::Vector3d& v : hull.vertices) {
    EXPECT_NE(std::find(points.begin(), points.end(), v), points.end());
  }
  EXPECT_GT(Volume(hull), 0.0);
  // Euler's formula for a closed triangle mesh with the topology of a sphere.
  EXPECT_EQ(hull.triangles.size(), 2 * hull.vertices.size() - 4);
}

TEST_P(SeededHull, VerticesAreThePointsThatABruteForceFindsExtreme) {
  base::Rng rng(GetParam());
  const Points points = samples::RandomPoints(25, 1.0, rng);
  // A vertex lies on a plane through three points that has all other points on one side.
  std::vector<bool> extreme(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        const auto plane = PlaneThrough(points[i], points[j], points[k]);
        int above = 0;
        int below = 0;
        for (std::size_t m = 0; m < points.size(); ++m) {
          if (m == i || m == j || m == k) continue;
          (plane->Distance(points[m]) > 0.0 ? above : below) += 1;
        }
        if (above == 0 || below == 0) extreme[i] = extreme[j] = extreme[k] = true;
      }
    }
  }
  const auto expected = std::count(extreme.begin(), extreme.end(), true);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(ConvexHull(points).vertices.size()), expected);
}

// Points of a facet that are not corners of the solid are in no triangle. The order of the vertices
// does not depend on the order of the points.
TEST_P(SeededHull, OfACubeOfPointsHasEightVerticesInOrder) {
  base::Rng rng(GetParam());
  Points points;
  for (int x = 0; x <= 3; ++x) {
    for (int y = 0; y <= 3; ++y) {
      for (int z = 0; z <= 3; ++z) points.emplace_back(x, y, z);
    }
  }
  points = Select(points, samples::Permutation(points.size(), rng));
  const TriangleMesh hull = ConvexHull(points);
  EXPECT_NEAR(Volume(hull), 27.0, 1e-10);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_EQ(hull.triangles.size(), 12u);
  for (std::size_t i = 1; i < hull.vertices.size(); ++i) {
    const Eigen::Vector3d& a = hull.vertices[i - 1];
    const Eigen::Vector3d& b = hull.vertices[i];
    EXPECT_TRUE(std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3));
  }
  EXPECT_TRUE(std::is_sorted(hull.triangles.begin(), hull.triangles.end()));
  for (const auto& t : hull.triangles) EXPECT_EQ(*std::min_element(t.begin(), t.end()), t[0]);
}

TEST(Hull, OfFlatPointsIsEmpty) {
  base::Rng rng(1);
  Points flat = samples::RandomPoints(50, 1.0, rng);
  for (Eigen::Vector3d& p : flat) p.z() = 2.0 * p.x() - p.y();
  EXPECT_TRUE(ConvexHull(flat).triangles.empty());
  EXPECT_TRUE(ConvexHull(Points{}).triangles.empty());
  EXPECT_TRUE(ConvexHull(Points(10, Eigen::Vector3d(1.0, 1.0, 1.0))).triangles.empty());
}

}  // namespace
}  // namespace rangegrasp::geometry
