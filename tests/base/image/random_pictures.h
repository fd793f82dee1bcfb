#pragma once

#include "base/image/image.h"
#include "base/rng.h"

namespace rangegrasp::image {

inline void Fill(base::Rng& rng, auto& values, std::size_t count) {
  using Value = std::decay_t<decltype(values[0])>;
  values.resize(count);
  for (Value& value : values)
    value = static_cast<Value>(rng.Index(std::size_t{1} << (8 * sizeof(Value))));
}

inline std::size_t Size(base::Rng& rng, auto& picture) {
  picture.width = static_cast<int>(1 + rng.Index(60));
  picture.height = static_cast<int>(1 + rng.Index(40));
  return static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

inline void Randomise(base::Rng& rng, Image& picture) {
  Fill(rng, picture.rgb, 3 * Size(rng, picture));
}

template <typename Pixel>
void Randomise(base::Rng& rng, Grey<Pixel>& picture) {
  Fill(rng, picture.grey, Size(rng, picture));
}

/// A picture of random noise with up to 60 x 40 pixels.
template <typename Picture>
Picture RandomPicture(std::uint64_t seed) {
  base::Rng rng(seed);
  Picture picture;
  Randomise(rng, picture);
  return picture;
}

/// The bytes truncated or with some bytes changed. Half of the changes are in the first 60 bytes.
inline std::string Damaged(std::string bytes, std::uint64_t seed) {
  base::Rng rng(seed);
  if (rng.Uniform() < 0.3) bytes.resize(rng.Index(bytes.size()));
  const std::size_t changes = 1 + rng.Index(6);
  for (std::size_t k = 0; k < changes && !bytes.empty(); ++k) {
    const bool header = rng.Uniform() < 0.5;
    const std::size_t reach = header ? std::min<std::size_t>(60, bytes.size()) : bytes.size();
    const std::size_t at = rng.Index(reach);
    bytes[at] = static_cast<char>(rng.Index(256));
  }
  return bytes;
}

}  // namespace rangegrasp::image
