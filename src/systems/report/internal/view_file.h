#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "experiment/view.h"

namespace rangegrasp::report {

/// Writes what the page loads when a case is viewed: `views/<number>.js`, a small picture
/// `views/<number>.png`, and each moving mesh once for all cases, as `meshes/<hash>.js`. Several
/// processes may write views of one report at the same time.
/// @throws base::RunError naming a file that cannot be written.
void WriteView(const experiment::View& view, const std::filesystem::path& folder,
               std::size_t number);

/// A script that the page loads from disk; it assigns a value to a variable.
std::string Script(const std::string& variable, const nlohmann::ordered_json& value);

/// The JSON list of json_of(item) for all items.
template <typename Items, typename JsonOf>
nlohmann::ordered_json ListOf(Items&& items, const JsonOf& json_of) {
  auto list = nlohmann::ordered_json::array();
  for (auto&& item : items) list.push_back(json_of(item));
  return list;
}

// Numbers in the format that the page reads: little-endian, in base64.

/// {"low": [x, y, z], "step": s, "data": 16-bit steps above low, point after point}. Accurate to
/// half a step; a step is 1 / 65535 of the longest edge of their box.
nlohmann::ordered_json PackedPoints(const geometry::Points& points);
/// {"vertices": as points, "triangles": indices, "wide": true if these have 32 bits instead of 16}.
nlohmann::ordered_json PackedMesh(const geometry::TriangleMesh& mesh);
/// {"places": as points, "turns": quaternions (x, y, z, w) times 32767, signed 16-bit}.
nlohmann::ordered_json PackedPoses(const std::vector<base::Pose>& poses);
/// {"low": l, "step": s, "data": 16-bit steps above low}. Accurate to half a step; a step is 1 /
/// 65534 of their range. 65535 stands for a number that is not finite.
nlohmann::ordered_json PackedNumbers(std::span<const double> numbers);
/// Padded base64 by RFC 4648, which a browser's atob reads.
std::string Base64(std::span<const unsigned char> bytes);

}  // namespace rangegrasp::report
