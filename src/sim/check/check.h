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

/// By the file's own text: a scene has a site "workspace", an arm a tuple "arm_joints", a hand a
/// tuple "hand_motors" or "hand_joints", an object a free joint. What has none of them is an arm
/// from five hinges on, else a hand from one hinge or slide on, else a scene.
/// @throws base::InputError if the file is no XML.
Kind KindOf(const std::filesystem::path& mjcf);

/// Everything that is wrong with a scene, an arm or a hand (with what it attaches), errors first.
/// What is simulated (the home pose held for 2 s, a motion at the arm's limits) is only tried where
/// all else is right. Takes a fraction of a second.
/// @param kind  not kObject
/// @throws base::InputError if the file cannot be read at all.
std::vector<base::Finding> CheckModel(const std::filesystem::path& mjcf, Kind kind);

/// Whether a file holds one free body and nothing else: an object, no scene.
/// @throws base::InputError naming the file if it is no MJCF.
bool IsObjectFile(const std::filesystem::path& mjcf);

/// What is wrong with an object's file, worst first. A file that cannot be compiled, or is no
/// object, is one finding.
/// @param min_tipping_rad  at least one resting pose tips over later
std::vector<base::Finding> CheckObject(const sim::ObjectModel& object,
                                       double min_tipping_rad = 0.17);

}  // namespace rangegrasp::check
