#include "geometry/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/units.h"

namespace rangegrasp::geometry {
namespace {

using Eigen::Vector3d;
using Kind = Shape::Kind;

/// Smallest half size [m], so that flat meshes do not cause a division by zero.
constexpr double kMinHalfSize_m = 1e-6;

/// A ring of a surface of revolution about z.
struct Ring {
  double radius, z;
};

/// Revolves a profile that starts and ends on the axis (bottom and top pole); faces point outward.
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

/// A sphere, or the capsule that results from moving its halves apart by half_length each.
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

TriangleMesh Box(const Vector3d& half) {
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
  const Vector3d& size = shape.size;
  switch (shape.kind) {
    case Kind::kSphere:
      return RoundedTube(size.x(), 0.0, segments);
    case Kind::kCapsule:
      return RoundedTube(size.x(), size.y(), segments);
    case Kind::kCylinder:
      return Revolve(-size.y(), {{size.x(), -size.y()}, {size.x(), size.y()}}, size.y(), segments);
    case Kind::kBox:
      return Box(size);
    case Kind::kEllipsoid: {
      TriangleMesh mesh = RoundedTube(1.0, 0.0, segments);
      for (Vector3d& p : mesh.vertices) p = p.cwiseProduct(size);
      return mesh;
    }
    case Kind::kConvex:
      return ConvexHull(shape.mesh.vertices);
    case Kind::kMesh:
      return shape.mesh;
  }
  throw std::invalid_argument("Tessellate: unknown kind of shape");
}

}  // namespace

TriangleMesh Tessellate(const Shape& shape, int segments) {
  if (segments < 3) throw std::invalid_argument("Tessellate: segments must be >= 3");
  return Transformed(InShapeFrame(shape, segments), shape.X_BS);
}

double Support(const Shape& shape, const Vector3d& d) {
  const Vector3d& size = shape.size;
  switch (shape.kind) {
    case Kind::kSphere:
      return size.x();
    case Kind::kCapsule:
      return size.x() + size.y() * std::abs(d.z());
    case Kind::kCylinder:
      return size.x() * d.head<2>().norm() + size.y() * std::abs(d.z());
    case Kind::kBox:
      return size.dot(d.cwiseAbs());
    case Kind::kEllipsoid:
      return size.cwiseProduct(d).norm();
    case Kind::kConvex:
    case Kind::kMesh:
      break;
  }
  double reach = -std::numeric_limits<double>::infinity();
  for (const Vector3d& p : shape.mesh.vertices) reach = std::max(reach, d.dot(p));
  return reach;
}

double Support(const Shape& shape, const base::Pose& X_AB, const Vector3d& direction_A) {
  const base::Pose X_AS = X_AB * shape.X_BS;
  return Support(shape, X_AS.linear().transpose() * direction_A) +
         direction_A.dot(X_AS.translation());
}

Shape Grown(Shape shape, double margin_m) {
  switch (shape.kind) {
    case Kind::kSphere:
    case Kind::kCapsule:
      shape.size[0] += margin_m;
      break;
    case Kind::kCylinder:
      shape.size.head<2>().array() += margin_m;
      break;
    case Kind::kBox:
    case Kind::kEllipsoid:
      shape.size.array() += margin_m;
      break;
    case Kind::kConvex: {
      if (shape.mesh.vertices.empty()) break;
      const Vector3d center = Centroid(shape.mesh.vertices);
      for (Vector3d& p : shape.mesh.vertices) p += margin_m * (p - center).normalized();
      break;
    }
    case Kind::kMesh:
      break;
  }
  return shape;
}

bool Inside(const Shape& shape, const Vector3d& p_B) {
  const Vector3d q = shape.X_BS.inverse() * p_B;
  switch (shape.kind) {
    case Kind::kSphere:
      return q.norm() < shape.size[0];
    case Kind::kCapsule: {
      const double along = std::clamp(q.z(), -shape.size[1], shape.size[1]);
      return (q - Vector3d(0.0, 0.0, along)).norm() < shape.size[0];
    }
    case Kind::kCylinder:
      return q.head<2>().norm() < shape.size[0] && std::abs(q.z()) < shape.size[1];
    case Kind::kBox:
      return (q.cwiseAbs().array() < shape.size.array()).all();
    case Kind::kEllipsoid:
      return q.cwiseQuotient(shape.size).norm() < 1.0;
    case Kind::kConvex:
    case Kind::kMesh:
      break;
  }
  const Eigen::AlignedBox3d box = BoundsOf(shape.mesh.vertices);
  if (box.isEmpty()) return false;
  const Vector3d half = (0.5 * box.sizes()).cwiseMax(kMinHalfSize_m);
  return (q - box.center()).cwiseQuotient(half).norm() < 1.0;
}

}  // namespace rangegrasp::geometry
