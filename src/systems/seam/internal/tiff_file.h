#pragma once

#include <filesystem>

#include "base/image/image.h"

namespace rangegrasp::image {

/// What a pixel of a TIFF file is.
enum class TiffPixel { kUnsigned16, kSigned16, kFloat32 };

/// A TIFF file's picture. Its pages, all of one width, stand below each other.
struct Tiff {
  TiffPixel pixel = TiffPixel::kUnsigned16;
  Grey<float> picture;  ///< a float holds every whole number of 16 bits
};

/// @throws base::InputError saying what is wrong (the caller names the file): no TIFF, damaged, cut
/// off, more than one channel, other pixels than TiffPixel, pages that differ in width or pixels.
Tiff ReadTiff(const std::filesystem::path& file);

}  // namespace rangegrasp::image
