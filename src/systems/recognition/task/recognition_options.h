#pragma once

#include "base/units.h"
#include "base/yaml_map.h"
#include "recognition/recognize.h"
#include "trial/options.h"

namespace rangegrasp::recognition_task {

struct Options {
  trial::Options grasping;
  recognition::LibraryOptions library;
  recognition::RecognitionOptions recognition;
  /// The library lacks the scene's target, which must stay unknown then.
  bool without_target = false;
  /// Of `views` only as many are taken as are wanted: as long as something that is perceived is
  /// open (recognition/looks.h), the next look is at it.
  bool until_sure = false;
  double max_distance_m = 0.005;          ///< of a pose that counts as found
  double max_angle_rad = base::Deg(5.0);  ///< likewise
};

/// Reads all keys but the common ones, to the end of the map. @throws base::InputError
Options ReadOptions(base::YamlMap& map);
/// The keys that `task: grasping` has not.
void ReadRecognitionKeys(base::YamlMap& map, Options& options);

}  // namespace rangegrasp::recognition_task
