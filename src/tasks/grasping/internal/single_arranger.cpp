#include "tasks/grasping/internal/single_arranger.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "core/error.h"
#include "core/units.h"
#include "sim/resting_poses.h"
#include "tasks/grasping/internal/arranging.h"

namespace rangegrasp::tasks::grasping::internal {
namespace {

// An arrangement that does not rest in view is drawn again, so often at most. None of the 120
// trials of laser_single needs it (seed 1); a scene where all of these fail is out of the sensor's
// view.
constexpr int kMaxDraws = 50;
// A drop that shows how an object comes to rest starts with its lowest point this high, as from a
// hand.
constexpr double kDropHeight_m = 0.05;
// Objects are put down this far above the table, so that none begins inside it.
constexpr double kPutDown_m = 0.0005;
// An object may creep into place, but not turn further than this: it would fall into another pose.
constexpr double kMaxTurn_rad = 0.1;

// Whether a pose leaves the model's z axis upright.
bool AsDrawn(const sim::RestingPose& pose) {
  return (pose.faces.front().R_WO * Eigen::Vector3d::UnitZ()).z() > std::cos(kMaxTurn_rad);
}

class SingleArranger : public Arranger {
 public:
  SingleArranger(const Options& options, const robot::Robot& robot,
                 const sensing::LineScannerOptions& scanner)
      : options_(options), robot_(robot), scanner_(scanner) {
    for (const std::string& object : options.objects) {
      const auto model = ObjectModelOf(options, object);
      auto poses = sim::StableRestingPoses(model, options.min_tipping_rad);
      if (options.as_drawn) std::erase_if(poses, [](const auto& pose) { return !AsDrawn(pose); });
      if (poses.empty()) {
        throw core::InputError(fmt::format(
            "{}: no resting pose tips over later than at {:g} deg; lower min_tipping_deg or change "
            "the collision geometry",
            model.mjcf.string(), core::ToDeg(options.min_tipping_rad)));
      }
      resting_poses_[object] = std::move(poses);
    }
  }

  std::optional<Arrangement> Arrange(const std::string& target, core::Rng& rng,
                                     Redraws& redraws) const override {
    Arrangement trial{
        sim::World(options_.scene, {ObjectModelOf(options_, target)}, options_.physics)};
    trial.world.SetArm(robot_.home);
    for (int draw = 0; draw < kMaxDraws; ++draw) {
      const auto rest = Drop(resting_poses_.at(target), rng, trial);
      const auto wrong = rest ? PutDown(*rest->face, rng, trial) : Redraw::kOtherPose;
      if (wrong) {
        ++redraws[*wrong];
        continue;
      }
      trial.pose_class = rest->pose->label;
      return trial;
    }
    return std::nullopt;
  }

 private:
  // Drops the target onto the table, turned at random. @return how it came to rest; nullopt for a
  // pose that is left out.
  std::optional<sim::AtRest> Drop(const std::vector<sim::RestingPose>& poses, core::Rng& rng,
                                  Arrangement& trial) const {
    const Eigen::Matrix3d R_WO = RandomRotation(rng).toRotationMatrix();
    core::Pose X_WO = core::MakePose(R_WO, robot_.X_WWorkspace.translation());
    trial.world.PlaceObject(trial.target, X_WO);
    X_WO.translation().z() += kDropHeight_m - trial.world.ObjectBottom(trial.target);
    trial.world.PlaceObject(trial.target, X_WO);
    trial.world.Settle();
    return sim::FaceAtRest(poses, trial.world.ObjectPose(trial.target).linear());
  }

  // At a random place and yaw. @return nullopt if it rests there on that face and in view.
  std::optional<Redraw> PutDown(const sim::RestingFace& face, core::Rng& rng,
                                Arrangement& trial) const {
    const Eigen::Vector3d place = PlaceInDisc(robot_.X_WWorkspace, robot_.workspace_radius_m, rng);
    const double yaw = rng.Uniform(0.0, 2.0 * core::kPi);
    core::Pose X_WO = core::MakePose(
        (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * face.R_WO).toRotationMatrix(),
        Eigen::Vector3d(place.x(), place.y(), face.height_m + kPutDown_m));
    trial.world.PlaceObject(trial.target, X_WO);
    // The centre of mass, not the body's origin, comes to the drawn place.
    const Eigen::Vector3d shift = place - trial.world.ObjectCenterOfMass(trial.target);
    X_WO.translation() += Eigen::Vector3d(shift.x(), shift.y(), 0.0);
    trial.world.PlaceObject(trial.target, X_WO);
    const bool rests = trial.world.Settle();
    const double turned =
        (trial.world.ObjectPose(trial.target).linear().transpose() * X_WO.linear()).trace();
    const bool same_pose = turned > 1.0 + 2.0 * std::cos(kMaxTurn_rad);
    if (!rests) return Redraw::kNotAtRest;
    if (!same_pose) return Redraw::kOtherPose;
    if (!OutOfView(trial.world, robot_.X_WScanner, scanner_).empty()) return Redraw::kOutOfView;
    return std::nullopt;
  }

  const Options& options_;
  const robot::Robot& robot_;
  const sensing::LineScannerOptions& scanner_;
  std::map<std::string, std::vector<sim::RestingPose>> resting_poses_;
};

}  // namespace

std::unique_ptr<Arranger> MakeSingleArranger(const Options& options, const robot::Robot& robot,
                                             const sensing::LineScannerOptions& scanner) {
  return std::make_unique<SingleArranger>(options, robot, scanner);
}

}  // namespace rangegrasp::tasks::grasping::internal
