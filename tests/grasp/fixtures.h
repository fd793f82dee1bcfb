#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "perception/scene.h"
#include "robot/collision/sensor_hand.h"

/// Scenes built in code, so that the tests of grasps depend on no other module.
namespace rangegrasp::grasp::test {

using namespace rangegrasp::test;
using Eigen::Vector2d;

// ---- Objects: closed meshes that become perceived objects as if completion were perfect.

/// A convex, counter-clockwise polygon extruded from z = 0 to height_m.
inline geometry::TriangleMesh Extrude(const std::vector<Vector2d>& polygon, double height_m) {
  geometry::TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {0.0, height_m}) {
    for (const Vector2d& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
  }
  for (std::uint32_t i = 1; i + 1 < n; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({n, n + i, n + i + 1});
  }
  return mesh;
}
inline std::vector<Vector2d> Rectangle(double x_m, double y_m) {
  return {{-x_m / 2, -y_m / 2}, {x_m / 2, -y_m / 2}, {x_m / 2, y_m / 2}, {-x_m / 2, y_m / 2}};
}
/// An arc of a circle from angle a to b.
inline std::vector<Vector2d> Arc(double radius_m, double a_rad, double b_rad, int points) {
  std::vector<Vector2d> arc;
  for (int i = 0; i < points; ++i) {
    const double angle = a_rad + (b_rad - a_rad) * i / points;
    arc.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle));
  }
  return arc;
}
inline std::vector<Vector2d> Disc(double radius_m) {
  return Arc(radius_m, 0.0, 2.0 * base::kPi, 72);
}
/// The upper half of a disc; its first and last points are the corners.
inline std::vector<Vector2d> HalfDisc(double radius_m, int points) {
  return Arc(radius_m, 0.0, base::kPi * points / (points - 1), points);
}
/// Lays an extrusion down: its height becomes the extent along x and its y axis points up.
inline geometry::TriangleMesh Lay(const geometry::TriangleMesh& mesh, double height_m,
                                  double lift_m) {
  Eigen::Matrix3d R;
  R.col(0) = Vector3d::UnitY();
  R.col(1) = Vector3d::UnitZ();
  R.col(2) = Vector3d::UnitX();
  return geometry::Transformed(mesh, base::MakePose(R, Vector3d(-height_m / 2, 0.0, lift_m)));
}
/// A cup without its bottom's underside: outer wall, inner wall, rim and floor.
inline geometry::TriangleMesh Cup(double radius_m, double wall_m, double height_m) {
  geometry::TriangleMesh mesh;
  const std::vector<std::pair<double, double>> profile{{radius_m, 0.0},
                                                       {radius_m, height_m},
                                                       {radius_m - wall_m, height_m},
                                                       {radius_m - wall_m, 0.008}};
  const std::uint32_t n = 72;
  for (const auto& [r, z] : profile) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const double angle = 2.0 * base::kPi * i / n;
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  }
  for (std::uint32_t k = 0; k + 1 < profile.size(); ++k) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t j = (i + 1) % n;
      mesh.triangles.push_back({k * n + i, k * n + j, (k + 1) * n + j});
      mesh.triangles.push_back({k * n + i, (k + 1) * n + j, (k + 1) * n + i});
    }
  }
  const auto floor = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.0, 0.0, 0.008);
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh.triangles.push_back({floor, 3 * n + i, 3 * n + (i + 1) % n});
  }
  return mesh;
}

/// A scene on the table z = 0 of frame W.
class SceneBuilder {
 public:
  /// Adds an object; returns it for further description.
  perception::PerceivedObject& Add(const geometry::TriangleMesh& mesh_W) {
    perception::PerceivedObject object;
    object.surface_C = mesh_W;
    object.completed_C = Dots(mesh_W, 0.004);
    for (const Vector3d& p : object.completed_C) {
      object.points.push_back(static_cast<std::uint32_t>(scene.cloud.points.size()));
      scene.cloud.points.push_back(p);
      object.height_m = std::max(object.height_m, p.z());
    }
    object.center_C = geometry::Centroid(object.completed_C);
    object.size_m = Vector3d::Zero();
    scene.objects.push_back(std::move(object));
    return scene.objects.back();
  }
  /// A flat top with its principal axis.
  static void SetTop(const Vector3d& center, const Vector3d& major, const Vector3d& normal,
                     double major_m, double minor_m, perception::PerceivedObject& object) {
    perception::TopSurface top;
    top.plane.normal = normal;
    top.plane.offset_m = -normal.dot(center);
    top.center_C = center;
    top.major_C = major;
    top.minor_C = normal.cross(major);
    top.major_m = major_m;
    top.minor_m = minor_m;
    object.top = top;
  }
  perception::PerceivedObject& AddBox(const Vector3d& size_m, const base::Pose& X_WO) {
    auto& object = Add(Transformed(Extrude(Rectangle(size_m.x(), size_m.y()), size_m.z()), X_WO));
    const bool along_x = size_m.x() >= size_m.y();
    SetTop(X_WO * Vector3d(0, 0, size_m.z()), X_WO.linear().col(along_x ? 0 : 1), Vector3d::UnitZ(),
           std::max(size_m.x(), size_m.y()), std::min(size_m.x(), size_m.y()), object);
    return object;
  }
  perception::PerceivedObject& AddUprightCylinder(double radius_m, double height_m,
                                                  const base::Pose& X_WO) {
    auto& object = Add(Transformed(Extrude(Disc(radius_m), height_m), X_WO));
    SetRotational(radius_m, height_m, X_WO, object);
    return object;
  }
  perception::PerceivedObject& AddCup(double radius_m, double wall_m, double height_m,
                                      const base::Pose& X_WO) {
    auto& object = Add(Transformed(Cup(radius_m, wall_m, height_m), X_WO));
    SetRotational(radius_m, height_m, X_WO, object);
    object.open = true;
    return object;
  }
  /// A lying extrusion along x of the object's frame.
  perception::PerceivedObject& AddLying(const std::vector<Vector2d>& polygon, double length_m,
                                        double lift_m, double top_m, double top_width_m,
                                        const base::Pose& X_WO) {
    auto& object = Add(Transformed(Lay(Extrude(polygon, length_m), length_m, lift_m), X_WO));
    SetTop(X_WO * Vector3d(0, 0, top_m), X_WO.linear().col(0), Vector3d::UnitZ(), length_m,
           top_width_m, object);
    return object;
  }

  perception::Scene scene;

 private:
  static void SetRotational(double radius_m, double height_m, const base::Pose& X_WO,
                            perception::PerceivedObject& object) {
    object.kind = perception::ObjectKind::kRotational;
    perception::RotationAxis axis;
    axis.center_C = X_WO * Vector3d(0, 0, height_m);
    axis.direction_C = Vector3d::UnitZ();
    axis.radius_m = radius_m;
    object.axis = axis;
    SetTop(axis.center_C, Vector3d::UnitX(), Vector3d::UnitZ(), 2 * radius_m, 2 * radius_m, object);
  }
};

inline Vector3d ArmBase() { return {-0.50, 0.0, 0.20}; }

/// The hand, built once.
inline const robot::HandModel& Hand() {
  static const robot::HandModel hand = SensorHand();
  return hand;
}

}  // namespace rangegrasp::grasp::test
