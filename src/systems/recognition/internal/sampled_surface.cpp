#include "recognition/internal/sampled_surface.h"

#include "base/rng.h"
#include "geometry/triangle_point.h"
#include "recognition/internal/thin.h"

namespace rangegrasp::recognition::internal {
namespace {

/// Of a mesh's drawn points: so many a cell that is kept, for few cells to stay empty (e^-8).
constexpr double kDrawnPerCell = 8.0;

}  // namespace

geometry::PointCloud SampledSurface(const geometry::TriangleMesh& mesh, double spacing_m) {
  base::Rng rng(0);
  geometry::PointCloud drawn;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[triangle[0]];
    const Eigen::Vector3d& b = mesh.vertices[triangle[1]];
    const Eigen::Vector3d& c = mesh.vertices[triangle[2]];
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    const double wanted = kDrawnPerCell * cross.norm() / 2.0 / (spacing_m * spacing_m);
    double left = wanted + rng.Uniform();
    for (; left >= 1.0; left -= 1.0) {
      const double u = rng.Uniform();
      const double v = rng.Uniform();
      drawn.points.push_back(geometry::TrianglePoint(a, b, c, u, v));
      drawn.normals.push_back(cross.normalized());
    }
  }
  const auto kept = Thinned(drawn.points, spacing_m);
  return {geometry::Select(drawn.points, kept), geometry::Select(drawn.normals, kept)};
}

}  // namespace rangegrasp::recognition::internal
