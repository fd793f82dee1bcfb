#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/observation.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// A cloud as read, organised if height > 1. Points that are not finite are kept as NaN.
struct CloudFile {
  int width = 0;
  int height = 1;
  Points points;  ///< row-major, scaled to metres
  /// One per point, from PCD's rgb or rgba, or PLY's one-byte red, green and blue; else empty.
  std::vector<Rgb> colors;
  /// One per point, from PCD's integer field `label`; empty if the file has none.
  std::vector<std::uint32_t> labels;
  /// [m], from PCD's VIEWPOINT or PLY's comment "viewpoint x y z"; absent if the file has none.
  std::optional<Eigen::Vector3d> sensor_origin;
};

/// Reads PCD, PLY (all encodings) or NPY (N x 3 or H x W x 3, C order), detected by the first
/// bytes, or .xyz and .txt, lines "x y z ...". x, y, z: float or double. `unit_m`: 0.001 for mm.
/// @throws base::InputError naming the file, the line or key, the value and what is expected.
/// @throws std::invalid_argument if unit_m is not a finite number > 0.
CloudFile ReadCloud(const std::filesystem::path& file, double unit_m = 1.0);

/// Extra per-point columns of a cloud file, e.g. "label".
struct CloudField {
  std::string name;
  std::vector<std::uint32_t> values;  ///< one per point of the image
};
/// Colors as a column "rgb", packed as in PCL; a PLY file gets red, green and blue.
CloudField ColorField(const std::vector<Rgb>& colors);

/// Writes binary PCD (organised like the image, with the mean sensor position as viewpoint) or, for
/// the extension .ply, binary PLY of only the measured points, with that position as a comment.
/// Coordinates are single precision.
/// @throws base::RunError naming the file if it cannot be written completely.
/// @throws std::invalid_argument if the length of a column differs from the image's.
void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields = {});

}  // namespace rangegrasp::geometry
