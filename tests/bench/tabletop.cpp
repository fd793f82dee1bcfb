#include "tabletop.h"

#include <stdexcept>

#include "experiment/experiment.h"
#include "sim/resting_poses.h"
#include "trial/grasping_task.h"
#include "trial/options.h"

namespace rangegrasp::bench {
namespace {

sim::World PlaceFiveObjects() {
  const auto& cell = Cell();
  const std::vector<std::string> names = {"coffee_cup", "salt_cuboid", "spread", "sweets_cylinder",
                                          "dextrose"};
  const std::vector<Eigen::Vector2d> places = {
      {0.0, 0.0}, {0.09, 0.08}, {0.09, -0.08}, {-0.09, 0.09}, {-0.09, -0.09}};
  std::vector<sim::ObjectModel> models;
  for (const auto& name : names) {
    models.push_back(trial::ObjectModelOf(cell.options, name));
  }
  constexpr double kDrop_m = 0.0005;  // above the resting height: nothing starts inside the table
  sim::World world(cell.options.scene, models, cell.options.physics);
  world.SetArm(cell.robot.home);
  for (int i = 0; i < world.objects(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto pose =
        sim::StableRestingPoses(models[at], cell.options.min_tipping_rad).front().faces.front();
    const Eigen::Vector3d place =
        cell.robot.X_WWorkspace * Eigen::Vector3d(places[at].x(), places[at].y(), 0.0);
    world.PlaceObject(i, base::MakePose(pose.R_WO.toRotationMatrix(),
                                        {place.x(), place.y(), pose.height_m + kDrop_m}));
  }
  if (!world.Settle()) throw std::runtime_error("the five objects do not come to rest");
  return world;
}

}  // namespace

const trial::Cell& Cell() {
  static const auto experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  return trial::CellOf(*experiment.task);
}

const sim::World& FiveObjects() {
  static const sim::World world = PlaceFiveObjects();
  return world;
}

const geometry::Observation& FiveObjectsScan() {
  static const auto sensed = trial::Look(Cell(), FiveObjects(), 1);
  return sensed.observation;
}

const geometry::Points& FiveObjectsCloud() {
  constexpr double kArmMaxX_m = -0.3;  // of the arm at home and its pedestal; the table is beyond
  static const geometry::Points points = [] {
    geometry::Points all = geometry::ToCloud(FiveObjectsScan().views.front().image).points;
    std::erase_if(all, [](const Eigen::Vector3d& p_W) { return p_W.x() < kArmMaxX_m; });
    return all;
  }();
  return points;
}

Eigen::Vector3d SensorOrigin() { return FiveObjectsScan().views.front().image.origins_C.front(); }

const perception::Scene& FiveObjectsScene() {
  static const perception::Scene scene = [] {
    base::Rng rng(1);
    return perception::Perceive(FiveObjectsCloud(), SensorOrigin(), Cell().options.perception, rng);
  }();
  return scene;
}

}  // namespace rangegrasp::bench
