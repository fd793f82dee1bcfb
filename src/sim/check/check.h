#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "sim/world.h"

namespace rangegrasp::check {

/// What an MJCF file is, by what it holds.
enum class Kind { kScene, kArm, kHand, kObject };
constexpr std::array<std::string_view, 4> WordsOf(Kind) {
  return {"scene", "arm", "hand", "object"};
}

/// By the file's own text and that of the files it attaches: a scene has a site "workspace", an arm
/// a tuple "arm_joints", a hand a tuple "hand_motors" or "hand_joints", an object a free joint.
/// What has none of them is an arm if it has five hinges or more, else a hand if it has a hinge or
/// a slide, else a scene.
/// @throws base::InputError if the file is no XML.
Kind KindOf(const std::filesystem::path& mjcf);

/// Everything that is wrong with a scene, an arm or a hand (with what it attaches): names, tuples
/// and ranges, drives, masses, geoms, pairs that touch, the home pose, what the arm reaches. What
/// is simulated (the home pose held for 2 s, a motion at the arm's own limits) is only tried where
/// all else is right. Errors come first. Takes a fraction of a second.
/// @param kind  not kObject
/// @throws base::InputError if the file cannot be read at all.
std::vector<base::Finding> CheckModel(const std::filesystem::path& mjcf, Kind kind);

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
std::vector<base::Finding> CheckObject(const sim::ObjectModel& object,
                                       const ObjectBounds& bounds = {});

}  // namespace rangegrasp::check
