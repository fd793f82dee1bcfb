#include "robot/collision/solid.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <utility>
#include <vector>

#include "geometry/support.h"

namespace rangegrasp::collision {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Kind = geometry::Shape::Kind;

/// Facets with 12 sides lie up to r (1 - cos 15 deg) = 0.27 to 0.34 mm inside a finger of 8 to 10
/// mm radius; grown by half of that they lie as much outside of it as inside. Larger: a free grasp
/// is called a hit; smaller: a hit is missed.
constexpr double kFacet_m = 0.00015;

bool IsMesh(Kind kind) { return kind == Kind::kConvex || kind == Kind::kMesh; }

geometry::Shape Faceted(const geometry::Shape& shape, const SolidOptions& options) {
  geometry::Shape out;
  out.kind = Kind::kMesh;
  out.X_BS = shape.X_BS;
  geometry::Shape bare = geometry::Grown(shape, options.margin_m + kFacet_m);
  bare.X_BS = base::Pose::Identity();
  out.mesh = geometry::Tessellate(bare, options.sides);
  return out;
}

std::shared_ptr<fcl::CollisionGeometryd> MakeTree(const geometry::TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
  auto tree = std::make_shared<fcl::BVHModel<fcl::OBBd>>();
  tree->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size()));
  tree->addSubModel(mesh.vertices, triangles);
  tree->endModel();
  return tree;
}

std::shared_ptr<fcl::CollisionGeometryd> MakePrimitive(Kind kind, const Vector3d& size) {
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

struct Solid::Geometry {
  std::shared_ptr<const fcl::CollisionGeometryd> fcl;
};

std::shared_ptr<const Solid::Geometry> Solid::MakeGeometry(const geometry::Shape& shape) {
  if (IsMesh(shape.kind)) {
    if (shape.mesh.triangles.empty()) return nullptr;
    return std::make_shared<Geometry>(Geometry{MakeTree(shape.mesh)});
  }
  auto primitive = MakePrimitive(shape.kind, shape.size);
  primitive->computeLocalAABB();
  return std::make_shared<Geometry>(Geometry{std::move(primitive)});
}

Solid::Solid(geometry::Shape shape, const SolidOptions& options)
    : shape_(options.sides > 0 ? Faceted(shape, options)
                               : geometry::Grown(std::move(shape), options.margin_m)),
      geometry_(MakeGeometry(shape_)) {
  for (const Vector3d& p : shape_.mesh.vertices) box_.extend(p);
}

Solid::Solid(geometry::TriangleMesh mesh)
    : Solid([&] {
        geometry::Shape surface;
        surface.kind = Kind::kMesh;
        surface.mesh = std::move(mesh);
        return surface;
      }()) {}

AlignedBox3d Solid::BoxAt(const base::Pose& X_WS) const {
  if (IsMesh(shape_.kind)) return box_.isEmpty() ? box_ : box_.transformed(X_WS);
  Vector3d half;
  for (int i = 0; i < 3; ++i) half[i] = geometry::Support(shape_, X_WS.linear().row(i).transpose());
  return {X_WS.translation() - half, X_WS.translation() + half};
}

double Solid::LowestAt(const base::Pose& X_WS) const {
  return X_WS.translation().z() - geometry::Support(shape_, -X_WS.linear().row(2).transpose());
}

bool Solid::Touches(const base::Pose& X_WS, const Solid& other, const base::Pose& X_WOther) const {
  if (IsEmpty() || other.IsEmpty()) return false;
  const fcl::CollisionRequestd first_contact;
  fcl::CollisionResultd result;
  return fcl::collide(geometry_->fcl.get(), X_WS, other.geometry_->fcl.get(), X_WOther,
                      first_contact, result) > 0;
}

PlacedSolid Place(const Solid& solid, const base::Pose& X_WB) {
  return PlaceAt(solid, X_WB * solid.X_BS());
}

PlacedSolid PlaceAt(const Solid& solid, const base::Pose& X_WS) {
  return {&solid, X_WS, solid.BoxAt(X_WS)};
}

bool Hit(const PlacedSolid& a, const PlacedSolid& b) {
  return a.box_W.intersects(b.box_W) && a.solid->Touches(a.X_WS, *b.solid, b.X_WS);
}

}  // namespace rangegrasp::collision
