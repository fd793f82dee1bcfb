#pragma once

#include <string>
#include <string_view>

#include "base/image/image.h"

namespace rangegrasp::image {

/// The picture in the bytes of a binary PGM file (P5) whose header's maximum value is above 255:
/// two bytes a pixel, the higher one first.
/// @throws base::InputError saying what is wrong (the caller names the file): no PGM, cut off, not
/// 16-bit grey, a pixel above the header's maximum value.
Grey16 DecodePgm(std::string_view bytes);

/// The bytes of such a file.
std::string EncodePgm(const Grey16& picture);

}  // namespace rangegrasp::image
