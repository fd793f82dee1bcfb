#pragma once

#include <filesystem>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"
#include "geometry/range_image.h"

namespace rangegrasp::geometry {

/// A cloud as read from a file: organised if height > 1. Points that are not finite are kept (NaN)
/// so that rows stay whole.
struct CloudFile {
  int width = 0;
  int height = 1;
  Points points;  ///< scaled to metres
};

/// Reads PCD (ascii, binary, binary_compressed) or PLY. `unit_m` is the file's unit in metres
/// (0.001 for mm).
/// @throws core::InputError naming the file and what is wrong with it: missing, not readable,
/// truncated, no x/y/z,
///         no points, no finite point.
CloudFile ReadCloud(const std::filesystem::path& file, double unit_m = 1.0);

/// Extra per-point columns of a cloud file, e.g. "label".
struct CloudField {
  std::string name;
  std::vector<std::uint32_t> values;
};
/// Writes binary PCD (organised as the image is, with the sensor's viewpoint) or, by the ending,
/// PLY.
/// @throws core::RunError naming the file if it cannot be written whole.
void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields = {});

/// A mesh with one colour a vertex (r, g, b in 0..255), as PLY.
void WriteColoredPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint8_t, 3>>& colors);

/// Reads OFF, OBJ, STL or PLY (assimp). @throws core::InputError naming the file.
TriangleMesh ReadMesh(const std::filesystem::path& file);

}  // namespace rangegrasp::geometry
