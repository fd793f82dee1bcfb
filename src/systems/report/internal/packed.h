#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::report::internal {

/// Numbers as a page reads them: little-endian, in base64.

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

}  // namespace rangegrasp::report::internal
