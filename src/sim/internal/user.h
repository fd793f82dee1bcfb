#pragma once

#include <Eigen/Dense>

#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::sim::internal {

/// A person's hand on an object, as a spring and a damper between the object's centre of mass and a
/// place that the person moves: it draws along a direction with a force that rises to the stated
/// one, and carries the object's weight and keeps its orientation as soon as it draws. Nothing acts
/// on the robot but through the object.
class User {
 public:
  /// Takes hold of the object where it is.
  /// @param direction_W  unit
  User(World& world, int object, const Eigen::Vector3d& direction_W, const UserOptions& options);
  ~User();  ///< lets go
  User(const User&) = delete;
  User& operator=(const User&) = delete;

  void Tick();                               ///< once before each step
  double pull_N() const { return pull_N_; }  ///< along the direction, as of the last tick
  bool Done() const;                         ///< the object has come nearly all the way

 private:
  double Drawn() const;  // how far the object has come [m]

  World& world_;
  int object_;
  Eigen::Vector3d direction_W_;
  UserOptions options_;
  Eigen::Vector3d start_W_;  ///< of the object's centre of mass
  Eigen::Matrix3d R_WO_;     ///< when it was taken hold of
  double drawn_to_m_ = 0.0;  ///< where the person's hand is along the direction
  double pull_N_ = 0.0;
};

}  // namespace rangegrasp::sim::internal
