#pragma once

#include <filesystem>
#include <vector>

#include "base/finding.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What an object that a hand is to grasp may be.
struct ObjectBounds {
  double min_size_m = 0.005;  ///< longest edge of the box round it
  double max_size_m = 1.0;    ///< larger: its mesh is in millimetres
  /// Mass in the convex hull of what collides: foam, and what is heavier than all but gold.
  double min_density_kg_m3 = 20.0;
  double max_density_kg_m3 = 12000.0;
  /// Principal moments against those of its hull filled evenly with its mass: a hammer has 0.3 to
  /// 2.5, a shell up to 1.7.
  double min_inertia = 0.1;
  double max_inertia = 4.0;
  /// What is seen and what collides have the same size but for this share of it.
  double max_mismatch = 0.25;
  /// A colliding mesh with less than this share of its hull's volume has a hollow that is closed.
  double min_convexity = 0.85;
  double min_tipping_rad = 0.17;  ///< at least one resting pose tips over later: 10 deg
};

/// Whether a file holds one free body and nothing else: an object, no scene.
/// @throws base::InputError naming the file if it is no MJCF.
bool IsObjectFile(const std::filesystem::path& mjcf);

/// What is wrong with an object's file, worst first; empty if nothing is. A file that cannot be
/// compiled, or is no object, is one finding.
std::vector<base::Finding> CheckObject(const ObjectModel& object, const ObjectBounds& bounds = {});

}  // namespace rangegrasp::sim
