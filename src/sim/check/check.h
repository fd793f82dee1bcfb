#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "sim/world.h"

namespace rangegrasp::check {

/// Bounds of the longest edge of an object's bounding box; a larger mesh is in millimetres.
inline constexpr double kMinSize_m = 0.005, kMaxSize_m = 1.0;

/// Kind of an MJCF file, by its content.
enum class Kind { kScene, kArm, kHand, kObject };
constexpr std::array<std::string_view, 4> WordsOf(Kind) {
  return {"scene", "arm", "hand", "object"};
}

/// Kind by the file's own text: a scene has a site "workspace", an arm a tuple "arm_joints", a hand
/// a tuple "hand_motors" or "hand_joints", an object a free joint. A file with none of these is an
/// arm if it has at least five hinges, else a hand if it has a hinge or slide, else a scene.
/// @throws base::InputError if the file is not XML.
Kind KindOf(const std::filesystem::path& mjcf);

/// All faults of a scene, an arm or a hand (with what it attaches), errors first. Simulations (the
/// home pose held for 2 s, a motion at the arm's limits) run only if everything else is right.
/// Takes a fraction of a second.
/// @param kind  not kObject
/// @throws base::InputError if the file cannot be read at all.
std::vector<base::Finding> CheckModel(const std::filesystem::path& mjcf, Kind kind);

/// Whether a file holds one free body and nothing else: an object, not a scene.
/// @throws base::InputError naming the file if it is not MJCF.
bool IsObjectFile(const std::filesystem::path& mjcf);

/// Faults of an object's file, worst first. A file that cannot be compiled, or is not an object,
/// gives one finding.
/// @param min_tipping_rad  at least one resting pose must withstand this tilt
std::vector<base::Finding> CheckObject(const sim::ObjectModel& object,
                                       double min_tipping_rad = 0.17);

}  // namespace rangegrasp::check
