#include "geometry/shape.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/units.h"
#include "geometry/hull.h"

namespace rangegrasp::geometry {
namespace {

/// A ring of a surface of revolution about z.
struct Ring {
  double radius;
  double z;
};

/// Revolves a profile that starts below and ends above on the axis (poles), outward faces.
TriangleMesh Revolve(double bottom_z, const std::vector<Ring>& rings, double top_z, int segments) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(segments);
  mesh.vertices.emplace_back(0.0, 0.0, bottom_z);
  for (const Ring& ring : rings) {
    for (int i = 0; i < segments; ++i) {
      const double angle = 2.0 * base::kPi * i / segments;
      mesh.vertices.emplace_back(ring.radius * std::cos(angle), ring.radius * std::sin(angle),
                                 ring.z);
    }
  }
  mesh.vertices.emplace_back(0.0, 0.0, top_z);
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const auto at = [n](std::size_t ring, std::uint32_t i) {
    return static_cast<std::uint32_t>(1 + ring * n + i % n);
  };
  for (std::uint32_t i = 0; i < n; ++i) mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i + 1)});
      mesh.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r + 1, i)});
    }
  }
  const std::size_t last = rings.size() - 1;
  for (std::uint32_t i = 0; i < n; ++i)
    mesh.triangles.push_back({at(last, i), at(last, i + 1), top});
  return mesh;
}

/// A sphere of radius 1, or the capsule that it becomes when its halves are moved apart.
TriangleMesh RoundedTube(double radius, double half_length, int segments) {
  std::vector<Ring> rings;
  const int quarter = std::max(1, segments / 4);
  for (int i = 1; i <= quarter; ++i) {
    const double angle = base::kPi / 2.0 * (i - quarter) / quarter;
    rings.push_back({radius * std::cos(angle), radius * std::sin(angle) - half_length});
  }
  const int first_above = half_length > 0.0 ? 0 : 1;
  for (int i = first_above; i < quarter; ++i) {
    const double angle = base::kPi / 2.0 * i / quarter;
    rings.push_back({radius * std::cos(angle), radius * std::sin(angle) + half_length});
  }
  return Revolve(-radius - half_length, rings, radius + half_length, segments);
}

TriangleMesh Box(const Eigen::Vector3d& half) {
  TriangleMesh mesh;
  for (unsigned corner = 0; corner < 8; ++corner) {
    mesh.vertices.emplace_back((corner & 1u) != 0u ? half.x() : -half.x(),
                               (corner & 2u) != 0u ? half.y() : -half.y(),
                               (corner & 4u) != 0u ? half.z() : -half.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh InShapeFrame(const Shape& shape, int segments) {
  const Eigen::Vector3d& size = shape.size;
  switch (shape.kind) {
    case Shape::Kind::kSphere:
      return RoundedTube(size.x(), 0.0, segments);
    case Shape::Kind::kCapsule:
      return RoundedTube(size.x(), size.y(), segments);
    case Shape::Kind::kCylinder:
      return Revolve(-size.y(), {{size.x(), -size.y()}, {size.x(), size.y()}}, size.y(), segments);
    case Shape::Kind::kBox:
      return Box(size);
    case Shape::Kind::kEllipsoid: {
      TriangleMesh mesh = RoundedTube(1.0, 0.0, segments);
      for (Eigen::Vector3d& p : mesh.vertices) p = p.cwiseProduct(size);
      return mesh;
    }
    case Shape::Kind::kConvex:
      return ConvexHull(shape.mesh.vertices);
    case Shape::Kind::kMesh:
      return shape.mesh;
  }
  throw std::invalid_argument("Tessellate: unknown kind of shape");
}

}  // namespace

TriangleMesh Tessellate(const Shape& shape, int segments) {
  if (segments < 3) throw std::invalid_argument("Tessellate: segments must be >= 3");
  return Transformed(InShapeFrame(shape, segments), shape.X_BS);
}

}  // namespace rangegrasp::geometry
