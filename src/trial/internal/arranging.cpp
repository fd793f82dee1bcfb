#include "trial/internal/arranging.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "trial/options.h"

namespace rangegrasp::trial::internal {
Eigen::Quaterniond RandomRotation(base::Rng& rng) {
  const double u = rng.Uniform();
  const double v = rng.Uniform(0.0, 2.0 * base::kPi);
  const double w = rng.Uniform(0.0, 2.0 * base::kPi);
  return {std::sqrt(1.0 - u) * std::sin(v), std::sqrt(1.0 - u) * std::cos(v),
          std::sqrt(u) * std::sin(w), std::sqrt(u) * std::cos(w)};
}

Eigen::Vector3d PlaceInDisc(const base::Pose& X_WWorkspace, double radius_m, base::Rng& rng) {
  const double radius = radius_m * std::sqrt(rng.Uniform());
  const double angle = rng.Uniform(0.0, 2.0 * base::kPi);
  return X_WWorkspace * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
}

namespace {

bool Sees(const sensing::LineScannerOptions& scanner, const Eigen::Vector3d& p_S) {
  const double pan = std::atan2(p_S.x(), p_S.z());
  const double fan = std::atan2(p_S.y(), std::hypot(p_S.x(), p_S.z()));
  return std::abs(pan) <= 0.5 * scanner.pan_range_rad && std::abs(fan) <= 0.5 * scanner.fan_rad;
}

// Height of an object's lowest point at the start of a drop: as if dropped from a hand.
constexpr double kDropHeight_m = 0.05;
// Objects are put down this far above the table, so that none starts inside it.
constexpr double kPutDown_m = 0.0005;
// An object that rotates by more than this changes its resting pose.
constexpr double kMaxTurn_rad = 0.1;

// Whether a pose leaves the model's z axis upright.
bool AsDrawn(const sim::RestingPose& pose) {
  return (pose.faces.front().R_WO * Eigen::Vector3d::UnitZ()).z() > std::cos(kMaxTurn_rad);
}

// Why the options exclude all resting poses of an object.
std::string WhyNoPose(const Options& options, const sim::ObjectModel& model) {
  const double min_deg = base::ToDeg(options.min_tipping_rad);
  if (!options.as_drawn) {
    return fmt::format(
        "every resting pose tips over at less than {:g} deg; lower min_tipping_deg or change the "
        "collision geometry",
        min_deg);
  }
  double tipping_rad = 0.0;  // of a model that rests on no face below it
  for (const auto& pose : sim::StableRestingPoses(model, 0.0)) {
    if (AsDrawn(pose)) tipping_rad = std::max(tipping_rad, pose.tipping_rad);
  }
  return fmt::format(
      "with as_drawn: true it must stand as in its model, z up, but then tips over at {:.1f} deg "
      "(min_tipping_deg: {:g}); set as_drawn: false, leave the object out, or turn its model "
      "(add-object --up)",
      base::ToDeg(tipping_rad), min_deg);
}

}  // namespace

std::vector<int> OutOfView(const sim::World& world, const base::Pose& X_WS,
                           const sensing::LineScannerOptions& scanner) {
  const base::Pose X_SW = X_WS.inverse();
  std::vector<int> unseen;
  for (const auto& visual : world.VisualMeshes()) {
    if (visual.label == 0 || visual.label == sim::kContainerLabel) continue;
    const auto is_seen = [&](const Eigen::Vector3d& p_W) { return Sees(scanner, X_SW * p_W); };
    if (std::ranges::all_of(visual.mesh_W.vertices, is_seen)) continue;
    unseen.push_back(static_cast<int>(visual.label) - 1);
  }
  return unseen;
}

Resting::Resting(const Options& options, const robot::Robot& robot,
                 const std::vector<std::string>& objects)
    : robot_(robot), as_drawn_(options.as_drawn) {
  for (const std::string& object : objects) {
    const auto model = ObjectModelOf(options, object);
    auto poses = sim::StableRestingPoses(model, options.min_tipping_rad);
    if (options.as_drawn) std::erase_if(poses, [](const auto& pose) { return !AsDrawn(pose); });
    if (poses.empty()) {
      throw base::InputError(model.mjcf.string() + ": " + WhyNoPose(options, model));
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

std::optional<sim::AtRest> Resting::ComeToRest(sim::World& world, int object,
                                               base::Rng& rng) const {
  if (!as_drawn_) return Drop(world, object, rng);
  const std::string& name = world.object_name(object);
  const auto upright = Standing(name, rng);
  if (!upright) return std::nullopt;
  PutDown(*upright->face, 0.0, world, object, rng);
  world.Settle();
  return sim::FaceAtRest(poses_.at(name), world.ObjectPose(object).linear());
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
  // The center of mass, not the body's origin, is moved to the drawn place.
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
