#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// A mesh in which polygon i of the file became the triangles t with polygon[t] == i.
struct PolygonMesh {
  TriangleMesh mesh;
  std::vector<std::uint32_t> polygon;
  std::size_t polygons = 0;
};

/// Reads OFF, OBJ, PLY (in double precision), STL or glTF (assimp, in single precision; their
/// triangles are the polygons). Polygons are triangulated in their order, equal vertices are
/// joined, and unused ones are removed.
/// @throws base::InputError naming the file and what is wrong with it.
PolygonMesh ReadPolygonMesh(const std::filesystem::path& file);
/// Like ReadPolygonMesh, but only the triangles.
TriangleMesh ReadMesh(const std::filesystem::path& file);

/// A mesh with the texture coordinates of its triangles' corners; empty if the file has none.
struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<std::array<Eigen::Vector2d, 3>> uv;
};
/// The same with texture coordinates, in single precision. Equal vertices are joined only in OFF.
TexturedMesh ReadTexturedMesh(const std::filesystem::path& file);

/// Whether a PLY declares faces, so that it is a mesh and not a cloud; false for other formats.
/// @throws base::InputError if its header is invalid or the file cannot be read.
bool PlyHoldsMesh(const std::filesystem::path& file);

/// Writes binary STL, with coordinates in single precision.
/// @throws base::RunError naming the file if it cannot be written completely.
void WriteStl(const std::filesystem::path& file, const TriangleMesh& mesh);

/// Writes a mesh with one color per vertex (r, g, b in 0..255) as binary PLY.
/// @throws base::RunError naming the file if it cannot be written completely.
/// @throws std::invalid_argument if there is not one color per vertex.
void WriteColoredPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint8_t, 3>>& colors);

}  // namespace rangegrasp::geometry
