#include "grasp/hand_collider.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBB.h>
#include <fcl/narrowphase/collision.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/shape.h"
#include "grasp/hand_profiles.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Tree = fcl::BVHModel<fcl::OBBd>;

constexpr int kSides = 12;
// Grown by this, the facets of a tessellated finger lie as much outside of it as inside.
constexpr double kFacet_m = 0.00015;

/// A surface with its tree and its box, in its own frame.
struct Body {
  std::unique_ptr<Tree> tree;
  AlignedBox3d box;
  geometry::TriangleMesh mesh;
};

Body MakeBody(geometry::TriangleMesh mesh) {
  Body body;
  for (const Vector3d& p : mesh.vertices) body.box.extend(p);
  if (!mesh.triangles.empty()) {
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
    body.tree = std::make_unique<Tree>();
    body.tree->beginModel(static_cast<int>(triangles.size()),
                          static_cast<int>(mesh.vertices.size()));
    body.tree->addSubModel(mesh.vertices, triangles);
    body.tree->endModel();
  }
  body.mesh = std::move(mesh);
  return body;
}

std::vector<Body> MakeHand(const robot::HandModel& hand, double margin_m) {
  std::vector<Body> bodies;
  for (geometry::Shape shape : hand.states.front().shapes) {
    shape.X_BS = core::Pose::Identity();
    bodies.push_back(MakeBody(geometry::Tessellate(Grown(shape, margin_m + kFacet_m), kSides)));
  }
  return bodies;
}

bool Collide(const Body& a, const core::Pose& X_CA, const Body& b) {
  if (!a.tree || !b.tree) return false;
  if (!AlignedBox3d(a.box).transformed(X_CA).intersects(b.box)) return false;
  const fcl::CollisionRequestd request(1, false);
  fcl::CollisionResultd result;
  return fcl::collide(a.tree.get(), X_CA, b.tree.get(), core::Pose::Identity(), request, result) >
         0;
}

}  // namespace

struct HandCollider::Impl {
  const robot::HandModel& hand;
  double object_clearance_m;
  double table_clearance_m;
  geometry::Plane table_C;
  std::vector<Body> grown;
  std::vector<Body> bare;
  std::vector<Body> obstacles;
  Body own;

  core::Pose X_CS(const core::Pose& X_CH, std::size_t state, std::size_t shape) const {
    return X_CH * hand.states[state].shapes[shape].X_BS;
  }

  /// An obstacle with a vertex inside a shape: surfaces need not cross where it is small.
  bool Swallows(const core::Pose& X_CH, std::size_t state, const Body& obstacle) const {
    for (std::size_t i = 0; i < grown.size(); ++i) {
      const core::Pose X = X_CS(X_CH, state, i);
      const AlignedBox3d box = AlignedBox3d(grown[i].box).transformed(X);
      if (!box.intersects(obstacle.box)) continue;
      geometry::Shape shape = Grown(hand.states[state].shapes[i], object_clearance_m);
      shape.X_BS = X;
      for (const Vector3d& p : obstacle.mesh.vertices) {
        if (box.contains(p) && Inside(shape, p)) return true;
      }
    }
    return false;
  }
};

HandCollider::HandCollider(const robot::HandModel& hand,
                           std::span<const geometry::TriangleMesh> obstacles_C,
                           const geometry::TriangleMesh& own_C, const geometry::Plane& table_C,
                           double object_clearance_m, double table_clearance_m)
    : impl_(std::make_unique<Impl>(Impl{hand,
                                        object_clearance_m,
                                        table_clearance_m,
                                        table_C,
                                        MakeHand(hand, object_clearance_m),
                                        MakeHand(hand, 0.0),
                                        {},
                                        MakeBody(own_C)})) {
  for (const geometry::TriangleMesh& mesh : obstacles_C) {
    if (!mesh.triangles.empty()) impl_->obstacles.push_back(MakeBody(mesh));
  }
  if (!impl_->obstacles.empty()) impl_->grown = MakeHand(hand, object_clearance_m);
}
HandCollider::~HandCollider() = default;
HandCollider::HandCollider(HandCollider&&) noexcept = default;
HandCollider& HandCollider::operator=(HandCollider&&) noexcept = default;

bool HandCollider::HitsObstacle(const core::Pose& X_CH, std::size_t state) const {
  for (const Body& obstacle : impl_->obstacles) {
    for (std::size_t i = 0; i < impl_->grown.size(); ++i) {
      if (Collide(impl_->grown[i], impl_->X_CS(X_CH, state, i), obstacle)) return true;
    }
    if (impl_->Swallows(X_CH, state, obstacle)) return true;
  }
  return false;
}

void HandCollider::SetOwn(const geometry::TriangleMesh& own_C) { impl_->own = MakeBody(own_C); }

bool HandCollider::HitsOwn(const core::Pose& X_CH, std::size_t state) const {
  for (std::size_t i = 0; i < impl_->bare.size(); ++i) {
    if (Collide(impl_->bare[i], impl_->X_CS(X_CH, state, i), impl_->own)) return true;
  }
  return false;
}

double HandCollider::TableDistance(const core::Pose& X_CH, std::size_t state) const {
  const geometry::Plane& table = impl_->table_C;
  double lowest = 1e9;
  for (const geometry::Shape& shape : impl_->hand.states[state].shapes) {
    lowest = std::min(lowest, table.offset_m - Support(shape, X_CH, -table.normal));
  }
  return lowest;
}

bool HandCollider::HitsTable(const core::Pose& X_CH, std::size_t state) const {
  // A micrometre of slack, so that a grasp placed exactly at the clearance passes.
  return TableDistance(X_CH, state) < impl_->table_clearance_m - 1e-6;
}

geometry::Shape Grown(geometry::Shape shape, double margin_m) {
  using Kind = geometry::Shape::Kind;
  switch (shape.kind) {
    case Kind::kSphere:
    case Kind::kCapsule:
      shape.size[0] += margin_m;
      break;
    case Kind::kCylinder:
      shape.size[0] += margin_m;
      shape.size[1] += margin_m;
      break;
    case Kind::kBox:
    case Kind::kEllipsoid:
      shape.size.array() += margin_m;
      break;
    case Kind::kConvex:
    case Kind::kMesh: {
      if (shape.mesh.vertices.empty()) break;
      const Vector3d center = geometry::Centroid(shape.mesh.vertices);
      for (Vector3d& p : shape.mesh.vertices) {
        const Vector3d out = p - center;
        if (out.norm() > 0.0) p += margin_m * out.normalized();
      }
      break;
    }
  }
  return shape;
}

bool Inside(const geometry::Shape& shape, const Vector3d& p) {
  using Kind = geometry::Shape::Kind;
  const Vector3d q = shape.X_BS.inverse() * p;
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
    case Kind::kMesh: {
      AlignedBox3d box;
      for (const Vector3d& v : shape.mesh.vertices) box.extend(v);
      if (box.isEmpty()) return false;
      const Vector3d half = (0.5 * box.sizes()).cwiseMax(1e-6);
      return (q - box.center()).cwiseQuotient(half).norm() < 1.0;
    }
  }
  return false;
}

}  // namespace rangegrasp::grasp
