#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/file.h"

namespace rangegrasp::image {

/// Row-major index of a pixel in an image; for (0, height) it is the number of pixels.
constexpr std::size_t IndexAt(int x, int y, int width) {
  const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  return row + static_cast<std::size_t>(x);
}

/// An RGB image with 8 bits per channel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height, rows from the top

  const std::uint8_t* At(int x, int y) const { return rgb.data() + 3 * IndexAt(x, y, width); }
};

/// A single-channel image of brightness, depth, height, ...
template <typename Pixel>
struct Grey {
  int width = 0;
  int height = 0;
  std::vector<Pixel> grey;  ///< width * height, rows from the top
};
using Grey8 = Grey<std::uint8_t>;
using Grey16 = Grey<std::uint16_t>;

/// Decodes the bytes of a PNG file.
/// @tparam Picture  Image (8-bit RGB), Grey8 or Grey16: the file must have exactly this format.
/// @throws base::InputError describing the problem; the caller names the file.
template <typename Picture>
Picture DecodePng(std::string_view bytes);

/// Reads a PNG file. @throws base::InputError as DecodePng, naming the file.
template <typename Picture>
Picture ReadPng(const std::filesystem::path& file);

/// Reads the bytes of a PNG file with any kind of pixels, which another program is to decode.
/// @throws base::InputError naming the file if a pixel cannot be decoded.
std::string ReadPngOfAnyKind(const std::filesystem::path& file);

/// Encodes an Image, Grey8 or Grey16 as PNG; equal images give equal bytes.
/// @throws std::invalid_argument if the size is 0 or not that of the pixels; base::RunError.
template <typename Picture>
std::string EncodePng(const Picture& picture);

/// Writes a PNG file. @throws as base::WriteFile and EncodePng.
template <typename Picture>
void WritePng(const std::filesystem::path& file, const Picture& picture) {
  base::WriteFile(file, EncodePng(picture));
}

}  // namespace rangegrasp::image
