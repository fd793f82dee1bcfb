#pragma once

#include "perception/perceive.h"
#include "robot/robot.h"

namespace rangegrasp::grasp {

/// What lies within margin_m of the robot's workspace, in W.
inline perception::Workspace WorkspaceOf(const robot::Robot& robot, double margin_m) {
  return {robot.X_WWorkspace, robot.workspace_radius_m + margin_m};
}

}  // namespace rangegrasp::grasp
