#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "geometry/mesh_file.h"

namespace rangegrasp::geometry::internal {

/// Polygons as a file holds them: polygon i has the corners [begin[i], begin[i + 1]).
struct PolygonSoup {
  Points points;
  std::vector<std::uint32_t> begin = {0};
  std::vector<std::uint32_t> corner;  ///< positions in points

  std::size_t Polygons() const { return begin.size() - 1; }
  /// Ends the polygon whose corners were appended last.
  void EndPolygon() { begin.push_back(static_cast<std::uint32_t>(corner.size())); }
};

/// Cuts polygons into triangles where they stand, equal vertices joined, unused ones left out.
/// A polygon of less than three corners has none.
/// @throws base::InputError naming the file: a vertex that is not finite, no triangle.
PolygonMesh ToPolygonMesh(const std::filesystem::path& file, const PolygonSoup& soup);

/// Reads places and faces of an OBJ file; all else in it is passed over.
/// @throws base::InputError naming file and line: a vertex without three numbers, a face with a
/// vertex that is not there.
PolygonSoup ReadObj(const std::filesystem::path& file, std::string_view bytes);

/// Reads the text of an OFF file (OFF, COFF, NOFF, STOFF and what they make together).
/// @throws base::InputError naming file and line: counts that the file cannot hold, fewer faces
/// than declared, a face with a vertex that is not there, what is no number.
PolygonSoup ReadOff(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
