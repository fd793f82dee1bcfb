#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/cloud_file.h"
#include "geometry/internal/polygon_soup.h"

namespace rangegrasp::geometry::internal {

/// Whether the bytes start as a PLY file does.
bool IsPly(std::string_view bytes);

/// The header of a binary little-endian PLY up to its vertices' x, y and z (float); further
/// properties and end_header are the caller's.
std::string PlyVertexHeader(std::size_t vertices);

/// Checks what stands before the data of a PLY, in full. @return how many faces it declares.
/// @throws base::InputError naming file and line: an unknown key or type, no x, y and z, no end,
/// more elements than the data can hold.
std::size_t CheckPlyHeader(const std::filesystem::path& file, std::string_view bytes);

/// Reads the faces too: lists vertex_indices or vertex_index of the element face.
/// @throws base::InputError naming file and line, also a list that the file cannot hold and a
/// vertex that is not there.
PolygonSoup ReadPlyPolygons(const std::filesystem::path& file, std::string_view bytes);

/// Reads the vertices of a PLY file (ascii, binary of either byte order).
/// @throws base::InputError naming file and line.
CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
