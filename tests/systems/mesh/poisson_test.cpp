#include "mesh/poisson.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "geometry/random_points.h"

namespace rangegrasp::geometry {
namespace {

using samples::RandomDirection;

constexpr double kRadius_m = 0.05;

/// Points of a ball's surface, about 2 mm apart, at any place.
PointCloud Ball(std::uint64_t seed) {
  base::Rng rng(seed);
  PointCloud cloud;
  for (int i = 0; i < 8000; ++i) {
    cloud.normals.push_back(RandomDirection(rng));
    cloud.points.push_back(Eigen::Vector3d(0.3, -0.2, 0.1) + kRadius_m * cloud.normals.back());
  }
  return cloud;
}

/// Whether each edge is shared by two triangles that run along it in opposite ways.
bool IsClosed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end()) return false;
  }
  return !edges.empty();
}

TEST(PoissonSurface, OfABallIsItAndClosed) {
  const auto mesh = PoissonSurface(Ball(1), 0.002);
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(IsClosed(*mesh));
  // Flat triangles of a ball of r with sagitta s lie within it by 2 s / 3 in the mean; a quarter of
  // the spacing is 1 % of r.
  const double ball_m3 = 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius_m, 3);
  EXPECT_NEAR(Volume(*mesh) / ball_m3, 1.0, 0.02);
  for (const Eigen::Vector3d& v : mesh->vertices) {
    EXPECT_NEAR((v - Eigen::Vector3d(0.3, -0.2, 0.1)).norm(), kRadius_m, 0.0005);
  }
}

TEST(PoissonSurface, ClosesWhatIsOpen) {
  PointCloud bowl;
  const PointCloud ball = Ball(2);
  for (std::size_t i = 0; i < ball.size(); ++i) {
    if (ball.normals[i].z() > 0.8) continue;
    bowl.points.push_back(ball.points[i]);
    bowl.normals.push_back(ball.normals[i]);
  }
  const auto mesh = PoissonSurface(bowl, 0.002);
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(IsClosed(*mesh));
}

// Triangles differ from call to call, what they stand for does not.
TEST(PoissonSurface, TheSamePointsGiveTheSameSurface) {
  const auto first = PoissonSurface(Ball(3), 0.002);
  const auto second = PoissonSurface(Ball(3), 0.002);
  ASSERT_TRUE(first && second);
  EXPECT_NEAR(Volume(*first) / Volume(*second), 1.0, 0.003);
}

TEST(PoissonSurface, RefusesWhatIsNoOrientedCloud) {
  PointCloud ball = Ball(4);
  ball.normals.pop_back();
  EXPECT_THROW(PoissonSurface(ball, 0.002), std::invalid_argument);
  EXPECT_THROW(PoissonSurface({}, 0.002), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::geometry
