#include "seam/image/pgm.h"

#include <fmt/format.h>

#include <charconv>

#include "base/error.h"

namespace rangegrasp::image {
namespace {

using base::InputError;

// A picture's side, as a header may claim it: above all that exist, and far below what overflows.
constexpr std::size_t kMaxSide_px = 10'000'000;
constexpr std::size_t kMaxGrey = 65535;

bool IsBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The header's next number; comments run from '#' to the line's end.
std::size_t NextNumber(std::string_view bytes, std::size_t& at, const char* what) {
  while (at < bytes.size() && (IsBlank(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), number);
  if (error != std::errc() || number == 0 || number > kMaxSide_px) {
    throw InputError(
        fmt::format("is not a whole PGM image: the header's {} must be a number from 1 to {}", what,
                    kMaxSide_px));
  }
  at = static_cast<std::size_t>(end - bytes.data());
  return number;
}

void CheckKind(std::string_view bytes) {
  if (bytes.size() < 3 || bytes[0] != 'P' || bytes[1] < '1' || bytes[1] > '6') {
    throw InputError("is not a PGM image: it must begin with P5");
  }
  if (bytes[1] != '5') {
    throw InputError(
        fmt::format("is of the kind P{}; a binary grey image, P5, is needed", bytes[1]));
  }
}

void CheckMaxGrey(std::size_t max_grey) {
  if (max_grey <= 255) {
    throw InputError(
        fmt::format("is 8-bit grey (maximum value {}); 16-bit grey is needed", max_grey));
  }
  if (max_grey > kMaxGrey) {
    throw InputError(
        fmt::format("has the maximum value {}; it must be from 256 to {}", max_grey, kMaxGrey));
  }
}

}  // namespace

Grey16 DecodePgm(std::string_view bytes) {
  CheckKind(bytes);
  std::size_t at = 2;
  const std::size_t width = NextNumber(bytes, at, "width");
  const std::size_t height = NextNumber(bytes, at, "height");
  const std::size_t max_grey = NextNumber(bytes, at, "maximum value");
  CheckMaxGrey(max_grey);
  ++at;  // one blank ends the header
  const std::size_t left = at < bytes.size() ? bytes.size() - at : 0;
  if (left / 2 / width < height) {
    throw InputError(fmt::format("is cut off in row {} of {}", left / 2 / width + 1, height));
  }
  Grey16 picture{static_cast<int>(width), static_cast<int>(height), {}};
  picture.grey.resize(width * height);
  const auto* from = reinterpret_cast<const unsigned char*>(bytes.data()) + at;
  for (std::size_t i = 0; i < picture.grey.size(); ++i, from += 2) {
    picture.grey[i] = static_cast<std::uint16_t>((from[0] << 8U) | from[1]);
    if (picture.grey[i] > max_grey) {
      throw InputError(fmt::format("row {}, column {}: {} is above the header's maximum value {}",
                                   i / width + 1, i % width + 1, picture.grey[i], max_grey));
    }
  }
  return picture;
}

std::string EncodePgm(const Grey16& picture) {
  std::string bytes = fmt::format("P5\n{} {}\n{}\n", picture.width, picture.height, kMaxGrey);
  bytes.reserve(bytes.size() + 2 * picture.grey.size());
  for (const std::uint16_t grey : picture.grey) {
    bytes += static_cast<char>(grey >> 8U);
    bytes += static_cast<char>(grey & 0xffU);
  }
  return bytes;
}

}  // namespace rangegrasp::image
