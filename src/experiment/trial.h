#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/experiment_file.h"
#include "experiment/result.h"
#include "robot/robot.h"
#include "sensing/line_scanner.h"

namespace rangegrasp::experiment {

/// What all trials of an experiment share; made once, before processes are forked.
struct TrialContext {
  Experiment experiment;
  robot::Robot robot;
  sensing::LineScannerOptions scanner;
  std::map<std::string, std::vector<sim::RestingPose>> resting_poses;  ///< by object
};
/// @throws core::InputError for a scene, sensor or object that is not what it should be.
TrialContext Prepare(const Experiment& experiment);

struct TrialSpec {
  std::string object;
  int index = 0;
};
/// "<object>-<index, 4 digits>".
std::string TrialId(const TrialSpec& spec);
/// Derived from (experiment seed, object, index) alone.
std::uint64_t TrialSeed(std::uint64_t experiment_seed, const TrialSpec& spec);
/// The trials of an experiment, object by object.
std::vector<TrialSpec> AllTrials(const Experiment& experiment);
/// The spec of a trial's id. @throws core::InputError if the experiment has no such trial.
TrialSpec TrialFrom(const Experiment& experiment, const std::string& id);

/// Stage 1: a settled world with the target in it.
struct ArrangedTrial {
  sim::World world;
  int target = 0;
  std::string pose_class;
  int redraws = 0;
};
/// Draws pose, place and yaw until the arrangement rests in the scanner's view (section "Target" of
/// the definitions).
/// @return nullopt if none of 50 draws did.
std::optional<ArrangedTrial> Arrange(const TrialContext& context, const TrialSpec& spec,
                                     std::uint64_t trial_seed);

/// Stage 2.
sensing::Scan ScanWorld(const TrialContext& context, const sim::World& world,
                        std::uint64_t trial_seed);

/// Stage 3, from the range image and the calibration alone: of the image's points those further
/// from the workspace's middle than its radius and Experiment::workspace_margin_m are left out (the
/// arm, its pedestal and the table's rim stand there). `source` receives the places in the image of
/// the points that are perceived.
perception::Scene PerceiveImage(const TrialContext& context, const geometry::RangeImage& image,
                                std::uint64_t trial_seed, geometry::Indices& source);

/// What the scorer makes of perception, from the labels that it alone knows.
struct DetectionVerdict {
  bool segmented =
      false;  ///< the topmost object holds more than half of the target's visible points
  bool right_target = false;  ///< more than half of the topmost object's points are the target's
  double share_of_object = 0.0;
  double share_of_target = 0.0;
};
/// @param label_of_cloud  label of each point of scene.cloud
DetectionVerdict JudgeDetection(const perception::Scene& scene,
                                const std::vector<std::uint32_t>& label_of_cloud,
                                std::uint32_t target_label);

/// What an execution is worth (docs/architecture.md, definitions): delivered, not_lifted, dropped,
/// misplaced or invalid_physics.
Outcome JudgeExecution(const sim::ExecutionLog& log);

/// Everything a viewer may want to see of a trial, in the order it happens.
struct TrialObserver {
  std::function<void(const perception::Scene& scene, const std::vector<grasp::Grasp>& grasps,
                     const sensing::Scan& scan)>
      on_perceived;
  sim::ExecutionObserver execution;
};

/// One trial from arrangement to score (design, section 1). Never throws for what a trial may run
/// into: that is an outcome.
TrialResult RunTrial(const TrialContext& context, const TrialSpec& spec,
                     const TrialObserver& observer = {});

}  // namespace rangegrasp::experiment
