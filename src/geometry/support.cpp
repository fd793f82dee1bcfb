#include "geometry/support.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rangegrasp::geometry {
namespace {

using Eigen::Vector3d;
using Kind = Shape::Kind;

/// Half sizes [m] below this count as this, so that flat meshes divide by no zero.
constexpr double kMinHalfSize_m = 1e-6;

}  // namespace

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
  Eigen::AlignedBox3d box;
  for (const Vector3d& v : shape.mesh.vertices) box.extend(v);
  if (box.isEmpty()) return false;
  const Vector3d half = (0.5 * box.sizes()).cwiseMax(kMinHalfSize_m);
  return (q - box.center()).cwiseQuotient(half).norm() < 1.0;
}

}  // namespace rangegrasp::geometry
