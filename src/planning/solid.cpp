#include "planning/internal/solid.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>

namespace rangegrasp::planning::internal {
namespace {

using Kind = geometry::Shape::Kind;

bool IsMesh(Kind kind) { return kind == Kind::kConvex || kind == Kind::kMesh; }

/// Sizes of the shape grown by margin. For a capsule the radius alone grows.
Eigen::Vector3d Grown(Kind kind, const Eigen::Vector3d& size, double margin_m) {
  switch (kind) {
    case Kind::kSphere:
    case Kind::kCapsule:
      return size + Eigen::Vector3d(margin_m, 0.0, 0.0);
    case Kind::kCylinder:
      return size + Eigen::Vector3d(margin_m, margin_m, 0.0);
    default:
      return size.array() + margin_m;
  }
}

std::shared_ptr<fcl::CollisionGeometryd> MakePrimitive(Kind kind, const Eigen::Vector3d& size) {
  switch (kind) {
    case Kind::kSphere:
      return std::make_shared<fcl::Sphered>(size[0]);
    case Kind::kCapsule:
      return std::make_shared<fcl::Capsuled>(size[0], 2.0 * size[1]);
    case Kind::kCylinder:
      return std::make_shared<fcl::Cylinderd>(size[0], 2.0 * size[1]);
    case Kind::kEllipsoid:
      return std::make_shared<fcl::Ellipsoidd>(size);
    default:
      return std::make_shared<fcl::Boxd>(2.0 * size);
  }
}

}  // namespace

Solid::Solid(const geometry::Shape& shape, double margin_m) : kind_(shape.kind), X_BS_(shape.X_BS) {
  if (IsMesh(kind_)) {
    SetMesh(shape.mesh, kind_ == Kind::kConvex ? margin_m : 0.0);
    return;
  }
  size_ = Grown(kind_, shape.size, margin_m);
  geometry_ = MakePrimitive(kind_, size_);
  geometry_->computeLocalAABB();
}

Solid::Solid(const geometry::TriangleMesh& mesh) : kind_(Kind::kMesh) { SetMesh(mesh, 0.0); }

void Solid::SetMesh(const geometry::TriangleMesh& mesh, double margin_m) {
  vertices_ = mesh.vertices;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : vertices_) middle += v / static_cast<double>(vertices_.size());
  for (Eigen::Vector3d& v : vertices_) v += margin_m * (v - middle).normalized();
  box_ = {vertices_.front(), vertices_.front()};
  for (const Eigen::Vector3d& v : vertices_) {
    box_.low = box_.low.cwiseMin(v);
    box_.high = box_.high.cwiseMax(v);
  }
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto model = std::make_shared<fcl::BVHModel<fcl::OBBd>>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices_.size()));
  model->addSubModel(vertices_, triangles);
  model->endModel();
  geometry_ = model;
}

double Solid::HalfExtent(const Eigen::Vector3d& axis_S) const {
  switch (kind_) {
    case Kind::kSphere:
      return size_[0];
    case Kind::kCapsule:
      return size_[0] + std::abs(axis_S.z()) * size_[1];
    case Kind::kCylinder:
      return size_[0] * std::hypot(axis_S.x(), axis_S.y()) + std::abs(axis_S.z()) * size_[1];
    case Kind::kEllipsoid:
      return axis_S.cwiseProduct(size_).norm();
    default:
      return axis_S.cwiseAbs().dot(size_);
  }
}

Bounds Solid::BoundsAt(const core::Pose& X_WS) const {
  Eigen::Vector3d middle = X_WS.translation();
  Eigen::Vector3d half;
  if (IsMesh(kind_)) {
    middle = X_WS * (0.5 * (box_.low + box_.high));
    half = X_WS.linear().cwiseAbs() * (0.5 * (box_.high - box_.low));
  } else {
    for (int i = 0; i < 3; ++i) half[i] = HalfExtent(X_WS.linear().row(i).transpose());
  }
  return {middle - half, middle + half};
}

double Solid::LowestAt(const core::Pose& X_WS) const {
  if (!IsMesh(kind_)) return BoundsAt(X_WS).low.z();
  double lowest = (X_WS * vertices_.front()).z();
  const Eigen::RowVector3d down = X_WS.linear().row(2);
  for (const Eigen::Vector3d& v : vertices_) {
    lowest = std::min(lowest, down.dot(v) + X_WS.translation().z());
  }
  return lowest;
}

bool Solid::Hits(const core::Pose& X_WS, const Solid& other, const core::Pose& X_WOther) const {
  const fcl::CollisionRequestd request;
  fcl::CollisionResultd result;
  return fcl::collide(geometry_.get(), X_WS, other.geometry_.get(), X_WOther, request, result) > 0;
}

}  // namespace rangegrasp::planning::internal
