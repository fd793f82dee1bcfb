#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/image/image.h"
#include "geometry/observation.h"

namespace rangegrasp::geometry {

/// A view as pictures: what depth cameras give, and most detectors take. A point (x, y, z) of the
/// view's frame lies in column fx x / z + cx and row fy y / z + cy; the middle of the first pixel
/// is (0, 0).
struct ViewImages {
  static constexpr double kDepthUnit_m = 0.0001;

  image::Grey16 depth;  ///< z [kDepthUnit_m]; 0 where nothing was measured, or beyond 6.5 m
  image::Image color;   ///< 0 x 0 where the view has no colors
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< [px]
};

/// Pictures as files.
struct WrittenImages {
  ViewImages images;
  std::string depth, color;  ///< paths; no color: empty

  /// What reads them has to know, as an object of a JSON library.
  template <typename Json>
  Json Described() const {
    return {{"depth", depth},  {"depth_unit_m", ViewImages::kDepthUnit_m},
            {"color", color},  {"rows", images.depth.height},
            {"fx", images.fx}, {"columns", images.depth.width},
            {"fy", images.fy}, {"cx", images.cx},
            {"cy", images.cy}};
  }
};

/// nullopt if the view's samples do not lie on the rays of a camera's pixels, as a line scanner's.
std::optional<ViewImages> ImagesOf(const View& view);

/// Writes STEM_depth.png (16 bits) and, where it has colors, STEM_color.png into a folder.
/// @return nullopt as ImagesOf: nothing is written
std::optional<WrittenImages> WriteImages(const View& view, const std::filesystem::path& folder,
                                         const std::string& stem);

}  // namespace rangegrasp::geometry
