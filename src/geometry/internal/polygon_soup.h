#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "geometry/mesh_file.h"

namespace rangegrasp::geometry::internal {

/// Polygons as stored in a file: polygon i has the corners [begin[i], begin[i + 1]).
struct PolygonSoup {
  Points points;
  std::vector<std::uint32_t> begin = {0};
  std::vector<std::uint32_t> corner;  ///< indices into points

  std::size_t Polygons() const { return begin.size() - 1; }
  /// Ends the polygon whose corners were appended last.
  void EndPolygon() { begin.push_back(static_cast<std::uint32_t>(corner.size())); }
};

/// Triangulates polygons in their order, joins equal vertices and removes unused ones. A polygon
/// with less than three corners gives no triangle.
/// @throws base::InputError naming the file: a vertex that is not finite, no triangle.
PolygonMesh ToPolygonMesh(const std::filesystem::path& file, const PolygonSoup& soup);

/// Reads vertices and faces of an OBJ file and ignores everything else.
/// @throws base::InputError naming file and line, also for a vertex that does not exist.
PolygonSoup ReadObj(const std::filesystem::path& file, std::string_view bytes);

/// Reads the text of an OFF file (OFF, COFF, NOFF, STOFF and their combinations).
/// @throws base::InputError naming file and line: counts too large for the file, fewer faces than
/// declared, a face with a vertex that does not exist, a word that is not a number.
PolygonSoup ReadOff(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
