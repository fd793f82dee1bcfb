#include "grasp/unseen.h"

#include <algorithm>
#include <vector>

#include "geometry/seen_space.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// A convex body as its faces' planes.
class Convex {
 public:
  explicit Convex(const geometry::TriangleMesh& mesh) {
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& vertex : mesh.vertices) {
      bounds_.extend(vertex);
      middle += vertex / static_cast<double>(mesh.vertices.size());
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3d& on = mesh.vertices[a];
      const Vector3d normal = (mesh.vertices[b] - on).cross(mesh.vertices[c] - on).normalized();
      const double sign = normal.dot(middle - on) > 0.0 ? -1.0 : 1.0;
      planes_.emplace_back(sign * normal, on);
    }
  }

  const AlignedBox3d& bounds() const { return bounds_; }
  bool Contains(const Vector3d& p) const {
    return bounds_.contains(p) && std::ranges::all_of(planes_, [&](const auto& plane) {
             return plane.signedDistance(p) <= 0.0;
           });
  }

 private:
  AlignedBox3d bounds_;
  std::vector<Eigen::Hyperplane<double, 3>> planes_;
};

AlignedBox3d Measured(const geometry::Observation& observation) {
  AlignedBox3d bounds;
  for (const geometry::View& view : observation.views) {
    for (const Vector3d& p : view.image.points_C) {
      if (p.allFinite()) bounds.extend(p);
    }
  }
  return bounds;
}

void AddBox(const AlignedBox3d& box, geometry::TriangleMesh& mesh) {
  // Corners in Eigen's order: bit 0 is x, bit 1 is y, bit 2 is z.
  static constexpr std::uint32_t kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                                  {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                                  {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int k = 0; k < 8; ++k) {
    mesh.vertices.push_back(box.corner(static_cast<AlignedBox3d::CornerType>(k)));
  }
  for (const auto& face : kFaces) {
    mesh.triangles.push_back({first + face[0], first + face[1], first + face[2]});
  }
}

}  // namespace

geometry::TriangleMesh UnseenByAll(const geometry::Observation& observation,
                                   std::span<const geometry::TriangleMesh> shadows_C,
                                   double cell_m) {
  geometry::TriangleMesh unseen;
  std::vector<Convex> shadows;
  AlignedBox3d bounds;
  for (const auto& mesh : shadows_C) {
    shadows.emplace_back(mesh);
    bounds.extend(shadows.back().bounds());
  }
  bounds = bounds.intersection(Measured(observation));
  if (bounds.isEmpty() || bounds.sizes().minCoeff() < cell_m) return unseen;
  geometry::SeenSpace space(bounds, cell_m);
  for (const geometry::View& view : observation.views) space.Add(view);
  const auto counts = [&](const Eigen::Vector3i& cell) {
    if (space.At(cell) != geometry::SeenSpace::Cell::kUnseen) return false;
    const Vector3d middle = space.MiddleOf(cell);
    return std::ranges::any_of(shadows, [&](const Convex& one) { return one.Contains(middle); });
  };
  const Vector3d half = Vector3d::Constant(0.5 * cell_m);
  for (int y = 0; y < space.Size().y(); ++y) {
    for (int x = 0; x < space.Size().x(); ++x) {
      AlignedBox3d column;  // of the cells since the last that does not count
      for (int z = 0; z <= space.Size().z(); ++z) {
        const Eigen::Vector3i cell(x, y, z);
        if (z < space.Size().z() && counts(cell)) {
          column.extend(space.MiddleOf(cell) - half).extend(space.MiddleOf(cell) + half);
        } else if (!column.isEmpty()) {
          AddBox(column, unseen);
          column.setEmpty();
        }
      }
    }
  }
  return unseen;
}

}  // namespace rangegrasp::grasp
