#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/file.h"

namespace rangegrasp::image {

/// The position of a pixel among those of a picture, row after row; of (0, height): their number.
constexpr std::size_t IndexAt(int x, int y, int width) {
  const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  return row + static_cast<std::size_t>(x);
}

/// A colour picture with 8 bits a channel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height, rows from the top

  const std::uint8_t* At(int x, int y) const { return rgb.data() + 3 * IndexAt(x, y, width); }
};

/// A grey picture of brightness, depth, height, ...
template <typename Pixel>
struct Grey {
  int width = 0;
  int height = 0;
  std::vector<Pixel> grey;  ///< width * height, rows from the top
};
using Grey8 = Grey<std::uint8_t>;
using Grey16 = Grey<std::uint16_t>;

/// The picture in the bytes of a PNG file.
/// @tparam Picture  Image (8-bit RGB), Grey8 or Grey16: the file must hold exactly that.
/// @throws base::InputError saying what is wrong; the caller names the file.
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

/// Writes a PNG file. @throws as base::WriteFile and EncodePng.
template <typename Picture>
void WritePng(const std::filesystem::path& file, const Picture& picture) {
  base::WriteFile(file, EncodePng(picture));
}

}  // namespace rangegrasp::image
