#include "trial/between.h"

#include "robot/timing.h"

namespace rangegrasp::trial {

double GoHome(const Cell& cell, sim::World& world) {
  const auto way = robot::TimeParameterise(cell.robot, {world.ArmPositions(), cell.robot.home},
                                           cell.options.planning.free_motion);
  world.SetArm(cell.robot.home);
  world.Settle();
  return way.Duration();
}

bool IsFinite(const sim::World& world) {
  for (int object = 0; object < world.objects(); ++object) {
    if (!world.ObjectPose(object).matrix().allFinite()) return false;
  }
  return world.ArmPositions().allFinite();
}

}  // namespace rangegrasp::trial
