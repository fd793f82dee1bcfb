#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/image/image.h"

namespace rangegrasp::image {

/// The picture in the bytes of a binary PGM file (P5) whose header's maximum value is above 255:
/// two bytes a pixel, the higher one first.
/// @throws base::InputError saying what is wrong (the caller names the file): no PGM, cut off, not
/// 16-bit grey, a pixel above the header's maximum value.
Grey16 DecodePgm(std::string_view bytes);

/// The bytes of such a file.
std::string EncodePgm(const Grey16& picture);

/// What a pixel of a TIFF file is.
enum class TiffPixel { kUnsigned16, kSigned16, kFloat32 };

/// A TIFF file's picture. Its pages, all of one width, stand below each other.
struct Tiff {
  TiffPixel pixel = TiffPixel::kUnsigned16;
  Grey<float> picture;  ///< a float holds every whole number of 16 bits
};

/// The picture in the bytes of a TIFF file.
/// @throws base::InputError saying what is wrong (the caller names the file): no TIFF, damaged, cut
/// off, more than one channel, other pixels than TiffPixel, pages that differ in width or pixels.
Tiff DecodeTiff(std::string_view bytes);

}  // namespace rangegrasp::image
