#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// A mesh of which polygon i of the file became the triangles t with polygon[t] == i.
struct PolygonMesh {
  TriangleMesh mesh;
  std::vector<std::uint32_t> polygon;
  std::size_t polygons = 0;
};

/// Reads OFF, OBJ, PLY (in double precision), STL or glTF (assimp, in single precision; their
/// triangles are the polygons). Polygons are cut into triangles where they stand, equal vertices
/// joined, unused ones left out.
/// @throws base::InputError naming the file and what is wrong with it.
PolygonMesh ReadPolygonMesh(const std::filesystem::path& file);
/// Its triangles alone.
TriangleMesh ReadMesh(const std::filesystem::path& file);

/// A mesh with the texture coordinates of its triangles' corners; none where the file has none.
struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<std::array<Eigen::Vector2d, 3>> uv;
};
/// The same with texture coordinates, in single precision; equal vertices are not joined, but in
/// OFF, which has no texture.
TexturedMesh ReadTexturedMesh(const std::filesystem::path& file);

/// Whether a PLY declares faces, so that it is a mesh and not a cloud; false for what is no PLY.
/// @throws base::InputError if its header is broken or the file cannot be read.
bool PlyHoldsMesh(const std::filesystem::path& file);

/// Binary STL, coordinates in single precision.
/// @throws base::RunError naming the file if it cannot be written whole.
void WriteStl(const std::filesystem::path& file, const TriangleMesh& mesh);

/// A mesh with one colour a vertex (r, g, b in 0..255), as binary PLY.
/// @throws base::RunError naming the file if it cannot be written whole.
/// @throws std::invalid_argument if there is not one colour a vertex.
void WriteColoredPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint8_t, 3>>& colors);

}  // namespace rangegrasp::geometry
