#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/observation.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// A cloud as read from a file: organised if height > 1. Points that are not finite are kept (NaN)
/// so that rows stay whole.
struct CloudFile {
  int width = 0;
  int height = 1;
  Points points;  ///< row-major, scaled to metres
  /// One a point, from PCD's rgb or rgba, or PLY's red, green and blue of a byte each; empty where
  /// the file has none.
  std::vector<Rgb> colors;
  /// One a point, from PCD's whole-number field `label`; empty where the file has none.
  std::vector<std::uint32_t> labels;
  /// Where the sensor stood [m], from PCD's VIEWPOINT; absent where the file has none.
  std::optional<Eigen::Vector3d> sensor_origin;
};

/// Reads PCD, PLY (all their encodings) or NPY (N x 3 or H x W x 3, in C order), as the first bytes
/// say, or .xyz and .txt, lines "x y z ...". x, y, z: float or double. `unit_m`: 0.001 for mm.
/// @throws base::InputError naming the file, the line or key, the value and what would be right.
/// @throws std::invalid_argument if unit_m is not a finite number > 0.
CloudFile ReadCloud(const std::filesystem::path& file, double unit_m = 1.0);

/// Extra per-point columns of a cloud file, e.g. "label".
struct CloudField {
  std::string name;
  std::vector<std::uint32_t> values;  ///< one a point of the image
};
/// Colors as a column: "rgb", packed as PCL does; a PLY gets red, green and blue.
CloudField ColorField(const std::vector<Rgb>& colors);

/// Writes binary PCD (organised as the image is, with the sensor's mean place as its viewpoint) or,
/// by the ending .ply, binary PLY of the measured points alone. Coordinates are single precision.
/// @throws base::RunError naming the file if it cannot be written whole.
/// @throws std::invalid_argument if a column's length is not the image's.
void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields = {});

}  // namespace rangegrasp::geometry
