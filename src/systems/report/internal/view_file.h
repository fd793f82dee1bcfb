#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "experiment/view.h"

namespace rangegrasp::report {

/// Writes what the page loads when a case is looked at: `views/<number>.js`, a small picture
/// `views/<number>.png`, and each mesh that moves once for all cases, as `meshes/<hash>.js`.
/// Processes may write views of one report at the same time.
/// @throws base::RunError naming a file that cannot be written.
void WriteView(const experiment::View& view, const std::filesystem::path& folder,
               std::size_t number);

/// What a page loads from disk: a script that gives a variable its value.
std::string Script(const std::string& variable, const nlohmann::ordered_json& value);

/// The list of what items become.
template <typename Items, typename JsonOf>
nlohmann::ordered_json ListOf(Items&& items, const JsonOf& json_of) {
  auto list = nlohmann::ordered_json::array();
  for (auto&& item : items) list.push_back(json_of(item));
  return list;
}

// Numbers as a page reads them: little-endian, in base64.

/// {"low": [x, y, z], "step": s, "data": 16-bit steps above low, point after point}: within half a
/// step, 1 / 65535 of the longest edge of their box.
nlohmann::ordered_json PackedPoints(const geometry::Points& points);
/// {"vertices": as points, "triangles": positions, "wide": whether these have 32 bits and not 16}.
nlohmann::ordered_json PackedMesh(const geometry::TriangleMesh& mesh);
/// {"places": as points, "turns": quaternions (x, y, z, w) times 32767, signed 16-bit}.
nlohmann::ordered_json PackedPoses(const std::vector<base::Pose>& poses);
/// {"low": l, "step": s, "data": 16-bit steps above low}: within half a step, 1 / 65534 of their
/// range; 65535 for a number that is not finite.
nlohmann::ordered_json PackedNumbers(std::span<const double> numbers);
/// Bytes as RFC 4648 writes them, padded: what a browser's atob reads.
std::string Base64(std::span<const unsigned char> bytes);

}  // namespace rangegrasp::report
