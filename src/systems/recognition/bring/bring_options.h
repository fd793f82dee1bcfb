#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/units.h"
#include "base/yaml_map.h"
#include "recognition/library.h"
#include "recognition/recognize.h"
#include "trial/hand_over.h"
#include "trial/options.h"

namespace rangegrasp::bring {

/// How a known object is looked for, taken and handed over (section 7.2).
struct BringOptions {
  int runs_per_object = 20;
  /// Objects that the program knows; empty: all of the experiment.
  std::vector<std::string> known;
  /// The wanted object is taken off the table before the program looks: it has to say so.
  bool absent = false;
  /// What the object is wanted for: of its named grasps those for this use; empty: all.
  std::string use;
  int max_tries = 4;  ///< grasps at the wanted object
  int max_clear = 0;  ///< attempts at others that are in the way; 0: two for each object
  /// Looks at one table before others are cleared away: the first from the fixed sensor, more from
  /// the wrist where a sensor is there, else again from the same place.
  int max_looks = 3;
  /// Others whose surface is this near to the wanted one may be in its way.
  double near_m = 0.08;
  /// Two perceived objects whose centers are no further apart are one, when tries are counted.
  double same_place_m = 0.03;
  recognition::LibraryOptions library;
  recognition::RecognitionOptions recognition;
  trial::HandOverOptions hand_over;
};

/// A bring experiment, as its file states it.
struct Options {
  trial::Options grasping;
  BringOptions bring;
};

/// The keys of a bring experiment but those that it shares with grasping. @throws base::InputError
void ReadBringKeys(base::YamlMap& map, BringOptions& options);
/// All keys, to the end of the map. @throws base::InputError
Options ReadOptions(base::YamlMap& map);

}  // namespace rangegrasp::bring
