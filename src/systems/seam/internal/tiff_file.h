#pragma once

#include <filesystem>

#include "base/image/image.h"

namespace rangegrasp::image {

enum class TiffPixel { kUnsigned16, kSigned16, kFloat32 };

/// The image of a TIFF file. Its pages have the same width and are stacked vertically.
struct Tiff {
  TiffPixel pixel = TiffPixel::kUnsigned16;
  Grey<float> picture;  ///< float represents every 16-bit integer exactly
};

/// @throws base::InputError (the caller names the file) if it is no TIFF, damaged or truncated, has
/// several channels or pixels not in TiffPixel, or its pages differ in width or pixels.
Tiff ReadTiff(const std::filesystem::path& file);

}  // namespace rangegrasp::image
