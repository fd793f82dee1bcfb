#include "trial/internal/resting.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "trial/internal/arranging.h"
#include "trial/objects.h"

namespace rangegrasp::trial::internal {
namespace {

// A drop that shows how an object comes to rest starts with its lowest point this high, as from a
// hand.
constexpr double kDropHeight_m = 0.05;
// Objects are put down this far above the table, so that none begins inside it.
constexpr double kPutDown_m = 0.0005;
// An object that turns further than this falls into another pose.
constexpr double kMaxTurn_rad = 0.1;

// Whether a pose leaves the model's z axis upright.
bool AsDrawn(const sim::RestingPose& pose) {
  return (pose.faces.front().R_WO * Eigen::Vector3d::UnitZ()).z() > std::cos(kMaxTurn_rad);
}

}  // namespace

Resting::Resting(const Options& options, const robot::Robot& robot,
                 const std::vector<std::string>& objects)
    : robot_(robot) {
  for (const std::string& object : objects) {
    const auto model = ObjectModelOf(options, object);
    auto poses = sim::StableRestingPoses(model, options.min_tipping_rad);
    if (options.as_drawn) std::erase_if(poses, [](const auto& pose) { return !AsDrawn(pose); });
    if (poses.empty()) {
      throw base::InputError(fmt::format(
          "{}: no resting pose tips over later than at {:g} deg; lower min_tipping_deg or change "
          "the collision geometry",
          model.mjcf.string(), base::ToDeg(options.min_tipping_rad)));
    }
    poses_[object] = std::move(poses);
  }
}

std::optional<sim::AtRest> Resting::Drop(sim::World& world, int object, base::Rng& rng) const {
  const Eigen::Matrix3d R_WO = RandomRotation(rng).toRotationMatrix();
  base::Pose X_WO = base::MakePose(R_WO, robot_.X_WWorkspace.translation());
  world.PlaceObject(object, X_WO);
  X_WO.translation().z() += kDropHeight_m - world.ObjectBottom(object);
  world.PlaceObject(object, X_WO);
  world.Settle();
  return sim::FaceAtRest(poses_.at(world.object_name(object)), world.ObjectPose(object).linear());
}

std::optional<sim::AtRest> Resting::Standing(const std::string& object, base::Rng& rng) const {
  const auto& poses = poses_.at(object);
  const auto share = [](const sim::RestingPose& pose) {
    return Stands(pose.faces.front()) ? pose.probability : 0.0;
  };
  double rest = 0.0;
  for (const auto& pose : poses) rest += share(pose);
  rest *= rng.Uniform(0.0, 1.0);
  const sim::RestingPose* chosen = nullptr;
  for (const auto& pose : poses) {
    if (share(pose) == 0.0) continue;
    chosen = &pose;
    rest -= share(pose);
    if (rest < 0.0) break;
  }
  if (chosen == nullptr) return std::nullopt;
  return sim::AtRest{chosen, &chosen->faces.front()};
}

bool Resting::Stands(const sim::RestingFace& face) {
  return std::abs((face.R_WO * Eigen::Vector3d::UnitZ()).z()) > std::cos(kMaxTurn_rad);
}

base::Pose Resting::PutDown(const sim::RestingFace& face, double radius_m, sim::World& world,
                            int object, base::Rng& rng) const {
  const Eigen::Vector3d place = PlaceInDisc(robot_.X_WWorkspace, radius_m, rng);
  const double yaw = rng.Uniform(0.0, 2.0 * base::kPi);
  base::Pose X_WO = base::MakePose(
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * face.R_WO).toRotationMatrix(),
      Eigen::Vector3d(place.x(), place.y(), face.height_m + kPutDown_m));
  world.PlaceObject(object, X_WO);
  // The centre of mass, not the body's origin, comes to the drawn place.
  const Eigen::Vector3d shift = place - world.ObjectCenterOfMass(object);
  X_WO.translation() += Eigen::Vector3d(shift.x(), shift.y(), 0.0);
  world.PlaceObject(object, X_WO);
  return X_WO;
}

bool Resting::IsAsPutDown(const base::Pose& X_WO, const sim::World& world, int object) {
  const double turned = (world.ObjectPose(object).linear().transpose() * X_WO.linear()).trace();
  return turned > 1.0 + 2.0 * std::cos(kMaxTurn_rad);
}

}  // namespace rangegrasp::trial::internal
