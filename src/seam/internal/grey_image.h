#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace rangegrasp::seam::internal {

/// A grey image with 16 bits a pixel, row after row.
struct GreyImage {
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<std::uint16_t> grey;  ///< columns * rows
};

/// The image in the bytes of a file. @throws core::InputError saying what is wrong (the caller
/// names the file): not of this format, damaged, cut off, or not 16-bit grey.
GreyImage DecodePng(std::span<const unsigned char> bytes);
/// Binary PGM (P5) with a largest value above 255: two bytes a pixel, the higher one first.
GreyImage DecodePgm(std::span<const unsigned char> bytes);

/// The bytes of a file. @throws core::RunError if libpng fails.
std::string EncodePng(const GreyImage& image);
std::string EncodePgm(const GreyImage& image);

}  // namespace rangegrasp::seam::internal
