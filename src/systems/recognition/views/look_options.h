#pragma once

#include <filesystem>

#include "base/units.h"
#include "base/yaml_map.h"
#include "recognition/views/merge.h"
#include "recognition/views/next_view.h"

namespace rangegrasp::views {

/// Looks from the wrist, after that of the fixed sensor.
struct LookOptions {
  int views = 1;  ///< of a trial: the sensor's own, then from the wrist, each where it tells most
  /// A line scanner's file, of the sensor at the scene's site "wrist_scanner".
  std::filesystem::path sensor;
  /// By how far the head sits elsewhere on the flange than the robot believes, root mean square:
  /// one draw a trial, the same in all its looks. Mounted by hand, after a drawing.
  double mount_sigma_m = 0.001;
  double mount_sigma_rad = base::Deg(0.3);
  /// A file of `rangegrasp calibrate-hand-eye`: the head is believed to sit where it says, in all
  /// trials, in place of a draw. Empty: none.
  std::filesystem::path hand_eye;
  /// Views are laid onto the earlier ones (views/merge.h); off: as the arm says they are.
  bool refine = true;
  /// What is wanted lies about the highest thing that was seen, no further from its middle than
  /// this: half of the longest object.
  double region_radius_m = 0.15;
  NextViewOptions next;
};

/// Under this name they stand in trial::Options.
inline constexpr const char* kLooks = "look";

/// Reads the keys `views` and `look`, that to its end. @throws base::InputError
void ReadLookOptions(base::YamlMap& map, LookOptions& options);

}  // namespace rangegrasp::views
