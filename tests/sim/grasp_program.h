#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <filesystem>
#include <optional>
#include <vector>

#include "robot/mjcf/hand.h"
#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::sim::samples {

/// A manually defined grasp: the tool centre's pose when the hand closes.
struct HandMadeGrasp {
  Eigen::Vector3d point_W;  ///< tool centre
  double yaw_rad = 0.0;     ///< yaw of the closing direction x_G about W's z
  double pitch_rad = 0.0;   ///< about y_G; positive: the thumb's tip further down
  double opening_m = 0.1;
};

/// Kinematics of the arm in a world, on a copy of its state; inverse kinematics by damped least
/// squares.
class TestArm {
 public:
  explicit TestArm(const World& world);

  base::Pose HandPose(const Eigen::VectorXd& q);
  base::Pose ToolInHand();
  /// Joint positions for a hand pose, from the seed q; nullopt if the search does not converge.
  std::optional<Eigen::VectorXd> Solve(const base::Pose& X_WH, Eigen::VectorXd q);

 private:
  const mjModel* model_;
  mjcf::DataPtr data_;
  int hand_;
  std::vector<int> joints_;
};

/// Reach from above, move straight down, close, lift by 0.2 m, move above the delivery place, move
/// down, release, move up.
/// @throws std::runtime_error if the arm does not reach the grasp
GraspProgram MakeProgram(const World& world, const HandMadeGrasp& grasp);

/// A world with only this object, upright and at rest.
World StandingAlone(const std::filesystem::path& scene, const ObjectModel& object,
                    const PhysicsOptions& physics = {});
/// True if the object was lifted, carried and put down, by the criteria of a trial.
bool Delivered(const ExecutionLog& log);

/// The grasp with a constant offset of the tool centre, for grasps that must fail.
inline HandMadeGrasp Beside(HandMadeGrasp grasp, const Eigen::Vector3d& offset_W) {
  grasp.point_W += offset_W;
  return grasp;
}

}  // namespace rangegrasp::sim::samples
