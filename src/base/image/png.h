#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/image/image.h"

namespace rangegrasp::image {

/// The picture in the bytes of a PNG file.
/// @tparam Picture  Image (8-bit RGB), Grey8 or Grey16: the file must hold exactly that.
/// @throws base::InputError saying what is wrong (the caller names the file): no PNG, damaged, cut
/// off, of another kind of pixels.
template <typename Picture>
Picture DecodePng(std::string_view bytes);

/// The picture in a PNG file. @throws base::InputError as above, naming the file.
template <typename Picture>
Picture ReadPng(const std::filesystem::path& file);

/// The bytes of a PNG file of an Image, Grey8 or Grey16; the same picture is the same bytes.
/// @throws std::invalid_argument if the size and the number of pixels do not fit, or are 0;
/// base::RunError if libpng fails.
template <typename Picture>
std::string EncodePng(const Picture& picture);

/// Writes a PNG file as base::WriteFile does: whole, making its folder where there is none.
/// @throws base::RunError naming the file if it cannot be written; base::InputError if the folder
/// cannot be made; std::invalid_argument as EncodePng.
template <typename Picture>
void WritePng(const std::filesystem::path& file, const Picture& picture);

}  // namespace rangegrasp::image
