#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rangegrasp::image {

/// A colour picture with 8 bits a channel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height, rows from the top

  const std::uint8_t* At(int x, int y) const {
    return rgb.data() + 3 * (static_cast<std::ptrdiff_t>(width) * y + x);
  }
};

/// A grey picture. A pixel may be anything that a sensor tells in so many bits: brightness, depth,
/// height.
template <typename Pixel>
struct Grey {
  int width = 0;
  int height = 0;
  std::vector<Pixel> grey;  ///< width * height, rows from the top
};
using Grey8 = Grey<std::uint8_t>;
using Grey16 = Grey<std::uint16_t>;

}  // namespace rangegrasp::image
