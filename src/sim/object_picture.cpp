#include "sim/object_picture.h"

#include <fmt/format.h>

#include "base/data_folder.h"
#include "robot/robot.h"
#include "sim/render.h"
#include "sim/resting_poses.h"

namespace rangegrasp::sim {
namespace {

// From the scanner's side, so far away that an object fills half of the picture.
std::string NearBy(const sim::World& world) {
  const Eigen::AlignedBox3d box = world.ObjectBounds(0);
  const Eigen::Vector3d eye =
      box.center() + 1.8 * box.diagonal().norm() * Eigen::Vector3d(0.55, -0.65, 0.5).normalized();
  return fmt::format("{},{},{},{},{},{}", eye.x(), eye.y(), eye.z(), box.center().x(),
                     box.center().y(), box.center().z());
}

}  // namespace

image::Image DrawObject(const sim::ObjectModel& object, const std::string& camera, int width,
                        int height) {
  const auto scene = base::DataFolder() / "scenes/tabletop.xml";
  sim::World world(scene, {object}, {});
  world.SetArm(robot::Robot::Load(scene).home);
  const auto poses = sim::StableRestingPoses(object, 0.0);
  base::Pose X_WO = base::Pose::Identity();
  if (!poses.empty()) X_WO.linear() = poses.front().faces.front().R_WO.toRotationMatrix();
  world.PlaceObject(0, X_WO);
  X_WO.translation().z() -= world.ObjectBottom(0);
  world.PlaceObject(0, X_WO);
  world.Settle();
  return sim::Renderer(world, width, height).Render(world, camera.empty() ? NearBy(world) : camera);
}

}  // namespace rangegrasp::sim
