#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/yaml_map.h"

namespace rangegrasp::trial {

/// How objects come to lie on and beside each other: scattered, touching, box, pile.
struct ClutterOptions {
  /// scattered: objects that lie there in every trial, and those that others are drawn from; empty:
  /// from all rows' objects.
  std::vector<std::string> always;
  std::vector<std::string> others;
  /// scattered: the target and what is always there stand, the axis z of their models vertical, so
  /// often; without it as often as a drop ends so, which for slender things is hardly ever.
  std::optional<double> standing_share;
  /// scattered: of what the scanner would see of the target if it lay there alone, at least this
  /// share is seen. 0: it may be hidden wholly.
  double min_seen_share = 0.0;
  /// scattered: others lie no further from the middle of the workspace. Larger: less crowded.
  double scatter_radius_m = 0.22;
  /// scattered, touching: how many objects lie there beside the target (tables 5.3: 2 to 5), and
  /// how many of them the target touches at least.
  int min_others = 2;
  int max_others = 5;
  /// box, pile: as many others as touching has, drawn anew with each heap (table 5.6); else all.
  bool draw_others = false;
  int min_touching = 2;
  /// Surfaces this close touch: less than the scanner's noise, about what two boards that were
  /// pushed together leave between them.
  double touch_m = 0.0005;
  /// An object is let go with its lowest point this high above what lies below it, as from a hand
  /// or out of a bag's mouth that follows the growing pile.
  double drop_height_m = 0.03;
  /// Radius of the disc that objects' middles fall through: of two hands' width, of a bag's mouth.
  double touching_radius_m = 0.06;
  double mouth_radius_m = 0.08;
  /// From one object to the next that leaves the bag: the first has left its place by then.
  double interval_s = 0.15;
  /// What rolls off its place is put back on top, so often at most in one heap.
  int max_put_back = 12;
  /// The target is dropped last, so often at most onto one heap; then all is drawn again.
  int target_drops = 8;
  int max_draws = 200;
  double settle_limit_s = 4.0;
  /// At rest all objects are slower than this, for as long (sim::World::Settle), and once more.
  double rest_speed_m_s = 0.002;
  double rest_time_s = 0.3;
  /// Deepest overlap of two things at rest.
  double max_penetration_m = 0.001;
};

/// Reads the keys of the mapping `clutter`, to its end. @throws base::InputError
void ReadClutterOptions(base::YamlMap map, ClutterOptions& options);

}  // namespace rangegrasp::trial
