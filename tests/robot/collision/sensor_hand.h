#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/frames.h"
#include "base/units.h"
#include "geometry/shape.h"
#include "robot/robot.h"

/// A hand built in code from the SensorHand's published kinematic chain, with pads in front of
/// capsules, and poses and points for tests of it.
namespace rangegrasp::test {

constexpr double Mm(double millimetres) { return millimetres * base::kMm; }

using Eigen::Vector3d;

inline base::Pose TurnX(double rad) {
  return base::MakePose(Eigen::AngleAxisd(rad, Vector3d::UnitX()).toRotationMatrix(),
                        Vector3d::Zero());
}
inline base::Pose Move(double x, double y, double z) {
  return base::MakePose(Eigen::Matrix3d::Identity(), Vector3d(x, y, z));
}

inline geometry::Shape Capsule(const Vector3d& from, const Vector3d& to, double radius_m) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kCapsule;
  shape.size = Vector3d(radius_m, 0.5 * (to - from).norm(), 0.0);
  shape.X_BS = base::MakePose(base::TurnOnto(Vector3d::UnitZ(), to - from).toRotationMatrix(),
                              0.5 * (from + to));
  return shape;
}

/// Adds a finger's capsules: segments of the given lengths along y, each rotated relative to the
/// previous one, behind the pad's surface z = 0 by radius (side -1: fingers, +1: thumb). The last
/// one is shorter, so that the round fingertip ends at the chain's end.
/// @return the center of the last capsule's end sphere
inline Vector3d AddFinger(const base::Pose& X_HBase, const std::vector<double>& lengths_m,
                          const std::vector<double>& turns_rad, double radius_m, double side,
                          double shorter_m, bool finger, bool thumb,
                          robot::HandModel::State& state) {
  base::Pose X = X_HBase;
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
  using base::Deg;
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
  const Vector3d little = finger(-13.0, -23, 0.006, {38, 22, 13}, {35, 30}, 4, false);
  const Vector3d thumb =
      AddFinger(Move(Mm(23.9), Mm(30.7), Mm(71.8)), {Mm(34.3), Mm(26.4)},
                {Deg(74.0) - angle_rad, Deg(-28.9)}, 0.010, 1.0, Mm(2.0), true, true, state);
  const Vector3d fingers = 0.5 * (index + middle);
  Vector3d line = thumb - fingers;
  line.x() = 0.0;
  line.normalize();
  state.thumb_pad_H = thumb - 0.010 * line;
  state.finger_pad_H = fingers + 0.008 * line;
  state.tip_center_H = 0.5 * (thumb + index);
  state.power_center_H = 0.5 * thumb + 0.25 * (index + little);
  state.gap_m = std::max(0.0, (thumb - index).norm() - 0.018);
  return state;
}

inline robot::HandModel SensorHand(int states = 24) {
  robot::HandModel hand;
  const double touching = base::Deg(47.0);  // the last state's gap is about 0
  for (int i = 0; i < states; ++i) {
    hand.states.push_back(HandState(static_cast<double>(i) / (states - 1) * touching));
  }
  Eigen::Matrix3d R_HG;
  R_HG.col(0) = Vector3d(0.0, -0.0528, 0.0858).normalized();
  R_HG.col(1) = Vector3d::UnitX();
  R_HG.col(2) = R_HG.col(0).cross(R_HG.col(1));
  hand.X_HG_tip = base::MakePose(R_HG, Vector3d(0.0209, 0.0852, 0.0806));
  hand.depth_m = 0.053;
  return hand;
}

inline base::Pose Yaw(double rad) {
  return base::MakePose(Eigen::AngleAxisd(rad, Vector3d::UnitZ()).toRotationMatrix(),
                        Vector3d::Zero());
}
inline base::Pose At(double x, double y, double yaw_rad = 0.0) {
  return Move(x, y, 0.0) * Yaw(yaw_rad);
}

/// Points on the triangles, about spacing_m apart.
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

}  // namespace rangegrasp::test
