#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/image/image.h"
#include "geometry/observation.h"

namespace rangegrasp::geometry {

/// A view as images, as produced by depth cameras and used by most detectors. A point (x, y, z) of
/// the view's frame is in column fx x / z + cx and row fy y / z + cy; the center of the first pixel
/// is (0, 0).
struct ViewImages {
  static constexpr double kDepthUnit_m = 0.0001;

  image::Grey16 depth;  ///< z [kDepthUnit_m]; 0 where nothing was measured, or beyond 6.5 m
  image::Image color;   ///< 0 x 0 if the view has no colors
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< [px]
};

/// Images written to files.
struct WrittenImages {
  ViewImages images;
  std::string depth, color;  ///< file names; empty without color

  /// The data that a reader of the files needs, as an object of a JSON library.
  template <typename Json>
  Json Described() const {
    return {{"depth", depth},  {"depth_unit_m", ViewImages::kDepthUnit_m},
            {"color", color},  {"rows", images.depth.height},
            {"fx", images.fx}, {"columns", images.depth.width},
            {"fy", images.fy}, {"cx", images.cx},
            {"cy", images.cy}};
  }
};

/// nullopt if the view's samples are not on the rays of a camera's pixels, as for a line scanner.
std::optional<ViewImages> ImagesOf(const View& view);

/// Writes STEM_depth.png (16 bits) and, if the view has colors, STEM_color.png into a folder.
/// @return nullopt in the same cases as ImagesOf; then nothing is written
std::optional<WrittenImages> WriteImages(const View& view, const std::filesystem::path& folder,
                                         const std::string& stem);

}  // namespace rangegrasp::geometry
