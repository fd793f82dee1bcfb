#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "grasp/grasp.h"
#include "perception/perceive.h"
#include "planning/planning.h"
#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::experiment {

/// How the objects of a trial lie (docs/architecture.md, definitions).
enum class Arrangement { kSingle };

/// One experiment, as its YAML file states it. Defaults are those of the option structs.
struct Experiment {
  std::string name;
  std::filesystem::path file;
  std::filesystem::path scene;
  std::filesystem::path sensor;         ///< line scanner
  std::filesystem::path object_folder;  ///< holds <name>/<name>.xml
  std::filesystem::path reference;      ///< the published table; may be empty
  Arrangement arrangement = Arrangement::kSingle;
  std::vector<std::string> objects;
  int trials_per_object = 10;
  std::uint64_t seed = 1;
  double trial_limit_s = 60.0;       ///< wall time after which a trial is killed
  int most_plans = 24;               ///< grasps offered to the planner before the trial is given up
  double workspace_margin_m = 0.15;  ///< points further outside the workspace are not perceived
  double min_tipping_rad =
      0.1745;  ///< a pose that tips over more easily is no resting pose (10 deg)

  sim::PhysicsOptions physics;
  sim::HandControlOptions hand;
  sim::AuditBounds audit;
  perception::PerceptionOptions perception;
  grasp::GraspOptions grasp;
  planning::PlanOptions planning;
};

/// Reads and checks an experiment file. @throws core::InputError naming file, line, key, value and
/// the nearest valid key.
Experiment ReadExperiment(const std::filesystem::path& file);

/// The MJCF of one of the experiment's objects.
sim::ObjectModel ObjectModelOf(const Experiment& experiment, const std::string& object);

/// A hash over all that decides the results but the seed and the number of trials: the experiment
/// file's settings.
std::string ExperimentHash(const Experiment& experiment);
/// A hash over the scene, the models that it and the objects refer to, and the sensor.
std::string SceneHash(const Experiment& experiment);

}  // namespace rangegrasp::experiment
