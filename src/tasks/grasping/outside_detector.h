#pragma once

#include <memory>

#include "core/yaml_map.h"
#include "experiment/stamp.h"
#include "tasks/grasping/detector.h"

namespace rangegrasp::tasks::grasping {

/// A detector that is another program (docs/bring-your-own-detector.md). Each question starts it in
/// a new folder of its own and ends it after its answer: nothing of one trial is left for the next,
/// so that results do not depend on the number of workers, and what breaks costs one trial.
/// options.outside.command must name it; the arguments must outlive it.
/// @param observer  sees the answer as a scene, with the table and what lies above it; may be empty
std::unique_ptr<Detector> MakeOutsideDetector(const Options& options, const robot::Robot& robot,
                                              SceneObserver observer = {});

/// @throws core::InputError if a sandbox is asked for and none can be made here, or a trial ends
/// before the detector's time is over.
void CheckOutside(const core::YamlMap& map, const OutsideOptions& options, double case_limit_s);

/// For tasks that have a method of their own. @throws core::InputError if there is such a program.
void RefuseOutside(const core::YamlMap& map, const OutsideOptions& options);

/// Puts a hash of the files that the command names into the stamp's identity.
void AddDetector(const OutsideOptions& options, experiment::Stamp& stamp);

}  // namespace rangegrasp::tasks::grasping
