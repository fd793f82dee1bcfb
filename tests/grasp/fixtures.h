#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "geometry/shape.h"
#include "perception/scene.h"
#include "robot/hand_model.h"

/// Scenes and a hand built by hand, so that what is claimed of grasps depends on no other module.
namespace rangegrasp::grasp::test {

using Eigen::Vector2d;
using Eigen::Vector3d;

// ---- The hand: the SensorHand's published chain, pads in front of capsules.

inline core::Pose TurnX(double rad) {
  return core::MakePose(Eigen::AngleAxisd(rad, Vector3d::UnitX()).toRotationMatrix(),
                        Vector3d::Zero());
}
inline core::Pose Move(double x, double y, double z) {
  return core::MakePose(Eigen::Matrix3d::Identity(), Vector3d(x, y, z));
}

inline geometry::Shape Capsule(const Vector3d& from, const Vector3d& to, double radius_m) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kCapsule;
  shape.size = Vector3d(radius_m, 0.5 * (to - from).norm(), 0.0);
  shape.X_BS = core::MakePose(
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), to - from).toRotationMatrix(),
      0.5 * (from + to));
  return shape;
}

/// Adds a finger's capsules: segments of the given lengths along y, each turned against the one
/// before, behind the pad's surface z = 0 by radius (side -1: fingers, +1: thumb). The last one
/// ends early, so that the fingertip is round at the chain's end. Returns the last capsule's end
/// sphere.
inline Vector3d AddFinger(const core::Pose& X_HBase, const std::vector<double>& lengths_m,
                          const std::vector<double>& turns_rad, double radius_m, double side,
                          double shorter_m, bool finger, bool thumb,
                          robot::HandModel::State& state) {
  core::Pose X = X_HBase;
  Vector3d end = Vector3d::Zero();
  for (std::size_t i = 0; i < lengths_m.size(); ++i) {
    X = X * TurnX(turns_rad[i]);
    const double length = lengths_m[i] - (i + 1 == lengths_m.size() ? shorter_m : 0.0);
    end = X * Vector3d(0.0, length, side * radius_m);
    state.shapes.push_back(Capsule(X * Vector3d(0.0, 0.0, side * radius_m), end, radius_m));
    state.is_finger.push_back(finger);
    state.is_thumb.push_back(thumb);
    X = X * Move(0.0, lengths_m[i], 0.0);
  }
  return end;
}

inline robot::HandModel::State HandState(double angle_rad) {
  using core::Deg;
  using core::Mm;
  robot::HandModel::State state;
  geometry::Shape palm;
  palm.kind = geometry::Shape::Kind::kBox;
  palm.size = Vector3d(0.028, 0.050, 0.011);
  palm.X_BS = Move(0.008, -0.018, 0.020);
  state.shapes.push_back(palm);
  state.shapes.push_back(Capsule({0.018, -0.045, 0.032}, {0.022, 0.014, 0.064}, 0.018));
  state.is_finger = {0, 0};
  state.is_thumb = {0, 0};
  const auto finger = [&](double x, double first_deg, double r, std::vector<double> mm,
                          std::vector<double> deg, double shorter_mm, bool driven) {
    std::vector<double> lengths, turns{Deg(first_deg) + angle_rad};
    for (const double length : mm) lengths.push_back(Mm(length));
    for (const double turn : deg) turns.push_back(Deg(turn));
    return AddFinger(Move(Mm(x), Mm(35.9), Mm(29.6)), lengths, turns, r, -1.0, Mm(shorter_mm),
                     driven, false, state);
  };
  const Vector3d index = finger(28.9, -19, 0.008, {42.1, 26.5, 17.2}, {37.4, 33.1}, 6, true);
  const Vector3d middle = finger(12.9, -19, 0.008, {42.1, 26.5, 17.2}, {37.4, 33.1}, 6, true);
  finger(0.0, -23, 0.007, {40, 24, 15}, {35, 30}, 5, false);
  finger(-13.0, -23, 0.006, {38, 22, 13}, {35, 30}, 4, false);
  const Vector3d thumb =
      AddFinger(Move(Mm(23.9), Mm(30.7), Mm(71.8)), {Mm(34.3), Mm(26.4)},
                {Deg(74.0) - angle_rad, Deg(-28.9)}, 0.010, 1.0, Mm(2.0), true, true, state);
  const Vector3d fingers = 0.5 * (index + middle);
  Vector3d line = thumb - fingers;
  line.x() = 0.0;
  line.normalize();
  state.thumb_pad_H = thumb - 0.010 * line;
  state.finger_pad_H = fingers + 0.008 * line;
  state.gap_m = std::max(0.0, (thumb - index).norm() - 0.018);
  return state;
}

inline robot::HandModel SensorHand(int states = 24) {
  robot::HandModel hand;
  const double touching = core::Deg(47.0);  // the last state's gap is about 0
  for (int i = 0; i < states; ++i) {
    const double closing = static_cast<double>(i) / (states - 1);
    hand.states.push_back(HandState(closing * touching));
    hand.states.back().closing = closing;
  }
  Eigen::Matrix3d R_HG;
  R_HG.col(0) = Vector3d(0.0, -0.0528, 0.0858).normalized();
  R_HG.col(1) = Vector3d::UnitX();
  R_HG.col(2) = R_HG.col(0).cross(R_HG.col(1));
  hand.X_HG_tip = core::MakePose(R_HG, Vector3d(0.0209, 0.0852, 0.0806));
  hand.X_HG_power = core::MakePose(R_HG, Vector3d(0.0133, 0.0908, 0.0631));
  hand.depth_m = 0.053;
  return hand;
}

// ---- Objects: closed meshes, from which a perceived object is made as if completion were perfect.

/// A polygon (counter-clockwise, convex) drawn up from z = 0 to height_m.
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
/// Part of a circle, from angle a to b.
inline std::vector<Vector2d> Arc(double radius_m, double a_rad, double b_rad, int points) {
  std::vector<Vector2d> arc;
  for (int i = 0; i < points; ++i) {
    const double angle = a_rad + (b_rad - a_rad) * i / points;
    arc.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle));
  }
  return arc;
}
inline std::vector<Vector2d> Disc(double radius_m) {
  return Arc(radius_m, 0.0, 2.0 * core::kPi, 72);
}
/// The upper half of a disc; its points end at both corners.
inline std::vector<Vector2d> HalfDisc(double radius_m, int points) {
  return Arc(radius_m, 0.0, core::kPi * points / (points - 1), points);
}
/// Lays an extrusion down: its height becomes the extent along x, its y axis points up.
inline geometry::TriangleMesh Lay(const geometry::TriangleMesh& mesh, double height_m,
                                  double lift_m) {
  Eigen::Matrix3d R;
  R.col(0) = Vector3d::UnitY();
  R.col(1) = Vector3d::UnitZ();
  R.col(2) = Vector3d::UnitX();
  return geometry::Transformed(mesh, core::MakePose(R, Vector3d(-height_m / 2, 0.0, lift_m)));
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
      const double angle = 2.0 * core::kPi * i / n;
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
  for (std::uint32_t i = 0; i < n; ++i)
    mesh.triangles.push_back({floor, 3 * n + i, 3 * n + (i + 1) % n});
  return mesh;
}

inline core::Pose Yaw(double rad) {
  return core::MakePose(Eigen::AngleAxisd(rad, Vector3d::UnitZ()).toRotationMatrix(),
                        Vector3d::Zero());
}
inline core::Pose At(double x, double y, double yaw_rad = 0.0) {
  return Move(x, y, 0.0) * Yaw(yaw_rad);
}

/// Points on the triangles, about one every spacing_m.
inline geometry::Points Dots(const geometry::TriangleMesh& mesh, double spacing_m) {
  geometry::Points points;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d& p = mesh.vertices[a];
    const Vector3d u = mesh.vertices[b] - p;
    const Vector3d v = mesh.vertices[c] - p;
    const int n = 1 + static_cast<int>(std::max(u.norm(), v.norm()) / spacing_m);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) points.push_back(p + u * i / n + v * j / n);
    }
  }
  return points;
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
  perception::PerceivedObject& AddBox(const Vector3d& size_m, const core::Pose& X_WO) {
    auto& object = Add(Transformed(Extrude(Rectangle(size_m.x(), size_m.y()), size_m.z()), X_WO));
    const bool along_x = size_m.x() >= size_m.y();
    SetTop(X_WO * Vector3d(0, 0, size_m.z()), X_WO.linear().col(along_x ? 0 : 1), Vector3d::UnitZ(),
           std::max(size_m.x(), size_m.y()), std::min(size_m.x(), size_m.y()), object);
    return object;
  }
  perception::PerceivedObject& AddUprightCylinder(double radius_m, double height_m,
                                                  const core::Pose& X_WO) {
    auto& object = Add(Transformed(Extrude(Disc(radius_m), height_m), X_WO));
    SetRotational(radius_m, height_m, X_WO, object);
    return object;
  }
  perception::PerceivedObject& AddCup(double radius_m, double wall_m, double height_m,
                                      const core::Pose& X_WO) {
    auto& object = Add(Transformed(Cup(radius_m, wall_m, height_m), X_WO));
    SetRotational(radius_m, height_m, X_WO, object);
    object.open = true;
    return object;
  }
  /// A lying extrusion along x of the object's frame.
  perception::PerceivedObject& AddLying(const std::vector<Vector2d>& polygon, double length_m,
                                        double lift_m, double top_m, double top_width_m,
                                        const core::Pose& X_WO) {
    auto& object = Add(Transformed(Lay(Extrude(polygon, length_m), length_m, lift_m), X_WO));
    SetTop(X_WO * Vector3d(0, 0, top_m), X_WO.linear().col(0), Vector3d::UnitZ(), length_m,
           top_width_m, object);
    return object;
  }

  perception::Scene scene;

 private:
  static void SetRotational(double radius_m, double height_m, const core::Pose& X_WO,
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

}  // namespace rangegrasp::grasp::test
