#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::sim::samples {

/// A grasp by hand: where the tool centre stands when the hand closes.
struct HandMadeGrasp {
  Eigen::Vector3d point_W;  ///< tool centre
  double yaw_rad = 0.0;     ///< of the closing direction x_G about W's z
  double pitch_rad = 0.0;   ///< about y_G; positive: the thumb's tip further down
  double opening_m = 0.1;
  std::string tool = "tcp_tip";
};

/// Kinematics of the arm in a world, on a copy of its state, by damped least squares.
class TestArm {
 public:
  explicit TestArm(const World& world);
  ~TestArm();
  TestArm(const TestArm&) = delete;
  TestArm& operator=(const TestArm&) = delete;

  base::Pose HandPose(const Eigen::VectorXd& q);
  base::Pose ToolInHand(const std::string& tool);
  /// Joint positions that bring the hand there, from a seed; nullopt if the search ends elsewhere.
  std::optional<Eigen::VectorXd> Solve(const base::Pose& X_WH, Eigen::VectorXd q);

 private:
  const mjModel* model_;
  mjData* data_;
  int hand_;
  std::vector<int> joints_;
};

/// Reach from above, straight down, close, lift 0.2 m, to above the delivery place, down, release,
/// up.
std::optional<GraspProgram> MakeProgram(const World& world, const HandMadeGrasp& grasp);

/// An object alone, upright and at rest.
World StandingAlone(const std::filesystem::path& scene, const ObjectModel& object,
                    const PhysicsOptions& physics = {});
/// Lifted, carried and put down, as a trial is judged.
bool Delivered(const ExecutionLog& log);

/// The same with a constant offset of the tool centre, for grasps that must fail.
inline HandMadeGrasp Beside(HandMadeGrasp grasp, const Eigen::Vector3d& offset_W) {
  grasp.point_W += offset_W;
  return grasp;
}

}  // namespace rangegrasp::sim::samples
