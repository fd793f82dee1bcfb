#pragma once

#include "core/units.h"
#include "core/yaml_map.h"
#include "recognition/recognize.h"
#include "tasks/grasping/options.h"

namespace rangegrasp::tasks::recognition_task {

struct Options {
  grasping::Options grasping;
  recognition::LibraryOptions library;
  recognition::RecognitionOptions recognition;
  /// The library lacks the scene's target, which must stay unknown then.
  bool without_target = false;
  /// Of `views` only as many are taken as are wanted: as long as something that is perceived is
  /// open (recognition/looks.h), the next look is at it.
  bool until_sure = false;
  double max_distance_m = 0.005;          ///< of a pose that counts as found
  double max_angle_rad = core::Deg(5.0);  ///< likewise
};

/// Reads all keys but the common ones, to the end of the map. @throws core::InputError
Options ReadOptions(core::YamlMap& map);
/// The keys that `task: grasping` has not.
void ReadRecognitionKeys(core::YamlMap& map, Options& options);

}  // namespace rangegrasp::tasks::recognition_task
