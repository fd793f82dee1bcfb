// Draws points in a ball with rangegrasp's generator, computes their convex hull, and asks the
// engine for its version.

#include <cstdio>

#include "base/rng.h"
#include "geometry/mesh.h"
#include "sim/world.h"

int main() {
  rangegrasp::base::Rng rng(1);
  std::vector<Eigen::Vector3d> points;
  while (points.size() < 1000) {
    const double x = rng.Uniform(-1.0, 1.0);
    const double y = rng.Uniform(-1.0, 1.0);
    const double z = rng.Uniform(-1.0, 1.0);
    if (x * x + y * y + z * z <= 1.0) points.emplace_back(x, y, z);
  }
  const auto hull = rangegrasp::geometry::ConvexHull(points);
  // Euler's formula: a closed surface of triangles has V - T / 2 = 2.
  const bool closed = 2 * hull.vertices.size() == hull.triangles.size() + 4;
  std::printf("hull %s, engine %s\n", closed ? "closed" : "open",
              rangegrasp::sim::EngineVersion().c_str());
  return closed ? 0 : 1;
}
