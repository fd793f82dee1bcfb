#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// Reads OFF, OBJ, STL, PLY or glTF (assimp); polygons are cut into triangles, equal vertices
/// joined.
/// @throws core::InputError naming the file and what is wrong with it.
TriangleMesh ReadMesh(const std::filesystem::path& file);

/// A mesh with the texture coordinates of its triangles' corners; none where the file has none.
struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<std::array<Eigen::Vector2d, 3>> uv;
};
/// The same with texture coordinates; equal vertices are not joined.
TexturedMesh ReadTexturedMesh(const std::filesystem::path& file);

/// Whether a PLY declares faces, so that it is a mesh and not a cloud; false for what is no PLY.
/// @throws core::InputError if its header is broken or the file cannot be read.
bool PlyHoldsMesh(const std::filesystem::path& file);

/// Binary STL, coordinates in single precision.
/// @throws core::RunError naming the file if it cannot be written whole.
void WriteStl(const std::filesystem::path& file, const TriangleMesh& mesh);

/// A mesh with one colour a vertex (r, g, b in 0..255), as binary PLY.
/// @throws core::RunError naming the file if it cannot be written whole.
/// @throws std::invalid_argument if there is not one colour a vertex.
void WriteColoredPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint8_t, 3>>& colors);

}  // namespace rangegrasp::geometry
