#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "base/finding.h"

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

}  // namespace rangegrasp::check
