#include "recognition/library.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "geometry/hull.h"
#include "recognition/internal/hull_faces.h"
#include "recognition/internal/prepared.h"
#include "recognition/internal/sampled_surface.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Ways to lie that are nearer than this to each other, symmetry aside, are one.
constexpr double kSameWay = 0.6;  // of the step of the yaw

std::vector<Matrix3d> WaysToLie(const KnownObject& object, const LibraryOptions& options) {
  std::vector<Matrix3d> ways;
  const int yaws = static_cast<int>(std::ceil(2.0 * std::numbers::pi / options.yaw_step_rad));
  for (const Vector3d& down_B :
       internal::LyingDirections(object.mesh_B.vertices, options.lying_slack_m)) {
    const Matrix3d upright =
        Eigen::Quaterniond::FromTwoVectors(down_B, -Vector3d::UnitZ()).toRotationMatrix();
    for (int k = 0; k < yaws; ++k) {
      const double yaw = 2.0 * std::numbers::pi * k / yaws;
      const Matrix3d way = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * upright;
      const base::Pose pose = base::MakePose(way, Vector3d::Zero());
      const bool known = std::ranges::any_of(ways, [&](const Matrix3d& other) {
        const base::Pose of_other = base::MakePose(other, Vector3d::Zero());
        return Difference(pose, of_other, object.symmetry).angle_rad <
               kSameWay * options.yaw_step_rad;
      });
      if (!known) ways.push_back(way);
    }
  }
  return ways;
}

}  // namespace

KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            const LibraryOptions& options, geometry::MeshColors colors) {
  const std::size_t triangles = mesh_B.triangles.size();
  if ((colors.print && colors.uv.size() != triangles) ||
      (!colors.plain.empty() && colors.plain.size() != triangles)) {
    throw std::invalid_argument(fmt::format("{}: its colors are of another mesh", name));
  }
  KnownObject object;
  object.name = std::move(name);
  object.title = std::move(title);
  object.mesh_B = std::move(mesh_B);
  object.colors = std::move(colors);
  object.surface_B = internal::SampledSurface(object.mesh_B, options.spacing_m);
  if (object.surface_B.size() < 4) {
    throw std::invalid_argument(
        fmt::format("{}: its mesh is too small to be an object", object.name));
  }
  object.symmetry = SymmetryOf(object.mesh_B, object.surface_B, options.symmetry);
  for (const Vector3d& v : object.mesh_B.vertices) {
    object.radius_m = std::max(object.radius_m, (v - object.symmetry.center_B).norm());
  }
  return object;
}

namespace internal {

namespace {
Eigen::Matrix3d PrincipalAxes(const geometry::Points& points) {
  const Vector3d center = geometry::Centroid(points);
  Matrix3d scatter = Matrix3d::Zero();
  for (const Vector3d& p : points) scatter += (p - center) * (p - center).transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(scatter).eigenvectors();
}

std::vector<const geometry::TriangleMesh*> One(const geometry::TriangleMesh& mesh) {
  return {&mesh};
}
}  // namespace

PreparedObject::PreparedObject(const KnownObject& known, const LibraryOptions& options)
    : object(&known),
      rays(One(known.mesh_B)),
      tones(known.colors),
      target(known.surface_B),
      hull_B(geometry::ConvexHull(known.mesh_B.vertices).vertices),
      axes_B(PrincipalAxes(known.surface_B.points)),
      round(AxisOfRevolution(known.surface_B)),
      lying(WaysToLie(known, options)),
      pairs(known.surface_B, options.pair_spacing_m) {}

}  // namespace internal

Library::Library(std::vector<KnownObject> objects, const LibraryOptions& options) {
  auto prepared = std::make_shared<Prepared>();
  prepared->objects = std::move(objects);
  for (std::size_t i = 0; i < prepared->objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (prepared->objects[i].name != prepared->objects[j].name) continue;
      throw std::invalid_argument("two known objects are named " + prepared->objects[i].name);
    }
    prepared->ready.push_back(
        std::make_unique<internal::PreparedObject>(prepared->objects[i], options));
  }
  prepared_ = std::move(prepared);
}

const std::vector<KnownObject>& Library::objects() const { return prepared_->objects; }

const KnownObject& Library::Find(const std::string& name) const {
  std::string known;
  for (const KnownObject& object : objects()) {
    if (object.name == name) return object;
    known += (known.empty() ? "" : ", ") + object.name;
  }
  throw base::InputError(fmt::format("no known object is named '{}'; known: {}", name, known));
}

}  // namespace rangegrasp::recognition
