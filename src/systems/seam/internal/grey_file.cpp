#include "seam/internal/grey_file.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <charconv>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include "base/error.h"

namespace rangegrasp::image {
namespace {

using base::InputError;

// ---- PGM ----

// A picture's side, as a header may claim it: above all that exist, and far below what overflows.
constexpr std::size_t kMaxSide_px = 10'000'000;
constexpr std::size_t kMaxGrey = 65535;

bool IsBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The header's next number; comments run from '#' to the line's end.
std::size_t NextNumber(std::string_view bytes, std::size_t& at, const char* what) {
  for (; at < bytes.size() && (IsBlank(bytes[at]) || bytes[at] == '#'); ++at) {
    if (bytes[at] == '#') at = std::min(bytes.find('\n', at), bytes.size() - 1);
  }
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), number);
  if (error != std::errc() || number == 0 || number > kMaxSide_px) {
    throw InputError(
        fmt::format("is not a valid PGM image: the header's {} must be a number from 1 to {}", what,
                    kMaxSide_px));
  }
  at = static_cast<std::size_t>(end - bytes.data());
  return number;
}

// ---- TIFF ----

// libtiff's compressions pack some 1000 to 1 at best (deflate): a header that asks for more than
// the file can hold is damaged, and must not make us ask for the memory.
constexpr std::size_t kMaxPacking = 1100;

// A file in memory, and what libtiff said of it.
struct Memory {
  std::string_view bytes;
  std::size_t at = 0;
  std::string error = {};
};

int OnError(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto* memory = static_cast<Memory*>(user);
  char text[200];
  std::vsnprintf(text, sizeof(text), format, arguments);
  if (memory->error.empty()) memory->error = text;
  return 1;  // said: not to stderr, too
}
int OnWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

tmsize_t ReadBytes(thandle_t handle, void* out, tmsize_t count) {
  auto* memory = static_cast<Memory*>(handle);
  const std::size_t left = memory->bytes.size() - std::min(memory->at, memory->bytes.size());
  const std::size_t take = std::min(left, static_cast<std::size_t>(count));
  if (take > 0) std::memcpy(out, memory->bytes.data() + memory->at, take);
  memory->at += take;
  return static_cast<tmsize_t>(take);
}

tmsize_t WriteBytes(thandle_t, void*, tmsize_t) { return 0; }

toff_t SizeOf(thandle_t handle) { return static_cast<Memory*>(handle)->bytes.size(); }

toff_t Seek(thandle_t handle, toff_t offset, int from) {
  auto* memory = static_cast<Memory*>(handle);
  if (from == SEEK_CUR) offset += memory->at;
  if (from == SEEK_END) offset += SizeOf(handle);
  memory->at = static_cast<std::size_t>(offset);
  return offset;
}

int Close(thandle_t) { return 0; }

using File = std::unique_ptr<TIFF, void (*)(TIFF*)>;

// "rm": to read, without a mapping of the file, for there is none.
File Open(Memory& memory) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  if (!options) throw base::RunError("libtiff cannot be initialised");
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), OnError, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), OnWarning, &memory);
  return {TIFFClientOpenExt("", "rm", &memory, ReadBytes, WriteBytes, Seek, Close, SizeOf, nullptr,
                            nullptr, options.get()),
          TIFFClose};
}

[[noreturn]] void FailReading(const Memory& memory) {
  throw InputError("is not a complete TIFF image: " +
                   (memory.error.empty() ? "the file is truncated" : memory.error));
}

std::uint16_t Field(TIFF* file, std::uint32_t tag) {
  std::uint16_t value = 0;
  TIFFGetFieldDefaulted(file, tag, &value);
  return value;
}

TiffPixel PixelOf(TIFF* file) {
  const int channels = Field(file, TIFFTAG_SAMPLESPERPIXEL);
  const int bits = Field(file, TIFFTAG_BITSPERSAMPLE);
  const int format = Field(file, TIFFTAG_SAMPLEFORMAT);
  if (channels == 1 && bits == 16 && format == SAMPLEFORMAT_UINT) return TiffPixel::kUnsigned16;
  if (channels == 1 && bits == 16 && format == SAMPLEFORMAT_INT) return TiffPixel::kSigned16;
  if (channels == 1 && bits == 32 && format == SAMPLEFORMAT_IEEEFP) return TiffPixel::kFloat32;
  const char* kind = format == SAMPLEFORMAT_IEEEFP ? "floating-point" : "whole-number";
  throw InputError(fmt::format(
      "has {} channel{} of {}-bit {} pixels; one channel of 16-bit whole numbers or 32-bit "
      "floating point is needed",
      channels, channels == 1 ? "" : "s", bits, kind));
}

template <typename Pixel>
void Append(const std::vector<std::uint8_t>& row, std::size_t width, std::vector<float>& out) {
  for (std::size_t i = 0; i < width; ++i) {
    Pixel pixel;
    std::memcpy(&pixel, row.data() + i * sizeof(Pixel), sizeof(Pixel));
    out.push_back(static_cast<float>(pixel));
  }
}

void AppendRow(const std::vector<std::uint8_t>& row, TiffPixel pixel, std::size_t width,
               std::vector<float>& out) {
  if (pixel == TiffPixel::kUnsigned16) Append<std::uint16_t>(row, width, out);
  if (pixel == TiffPixel::kSigned16) Append<std::int16_t>(row, width, out);
  if (pixel == TiffPixel::kFloat32) Append<float>(row, width, out);
}

// Strips, row by row. Tiles have other rows; sensors that write rows write strips.
void ReadPage(TIFF* file, const Memory& memory, int page, Tiff& tiff) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &height);
  const std::size_t most = memory.bytes.size() * kMaxPacking;
  const auto pixels = static_cast<std::uint64_t>(width) * height;
  if (pixels == 0 || pixels > most || tiff.picture.grey.size() > most) FailReading(memory);
  const TiffPixel pixel = PixelOf(file);
  if (page == 1) {
    tiff = {pixel, {static_cast<int>(width), 0, {}}};
  } else if (static_cast<int>(width) != tiff.picture.width || pixel != tiff.pixel) {
    throw InputError(
        fmt::format("page {} is {} columns wide and page 1 {}, or has another pixel format; all "
                    "pages must be like the first",
                    page, width, tiff.picture.width));
  }
  if (TIFFIsTiled(file) != 0) throw InputError("is tiled; a TIFF image of strips is needed");
  const std::size_t needed = std::size_t{width} * (pixel == TiffPixel::kFloat32 ? 4 : 2);
  const tmsize_t scanline = TIFFScanlineSize(file);
  if (scanline < 0 || static_cast<std::size_t>(scanline) < needed) FailReading(memory);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(scanline));
  for (std::uint32_t y = 0; y < height; ++y) {
    if (TIFFReadScanline(file, row.data(), y) != 1) FailReading(memory);
    AppendRow(row, pixel, width, tiff.picture.grey);
  }
  tiff.picture.height += static_cast<int>(height);
}

}  // namespace

Grey16 DecodePgm(std::string_view bytes) {
  if (bytes.size() < 3 || bytes[0] != 'P' || bytes[1] < '1' || bytes[1] > '6') {
    throw InputError("is not a PGM image: it must begin with P5");
  }
  if (bytes[1] != '5') {
    throw InputError(
        fmt::format("has the format P{}; a binary grey image, P5, is needed", bytes[1]));
  }
  std::size_t at = 2;
  const std::size_t width = NextNumber(bytes, at, "width");
  const std::size_t height = NextNumber(bytes, at, "height");
  const std::size_t max_grey = NextNumber(bytes, at, "maximum value");
  if (max_grey <= 255) {
    throw InputError(
        fmt::format("is 8-bit grey (maximum value {}); 16-bit grey is needed", max_grey));
  }
  if (max_grey > kMaxGrey) {
    throw InputError(
        fmt::format("has the maximum value {}; it must be from 256 to {}", max_grey, kMaxGrey));
  }
  ++at;  // one blank ends the header
  const std::size_t left = at < bytes.size() ? bytes.size() - at : 0;
  if (left / 2 / width < height) {
    throw InputError(fmt::format("is truncated in row {} of {}", left / 2 / width + 1, height));
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

Tiff DecodeTiff(std::string_view bytes) {
  Memory memory{bytes};
  const File file = Open(memory);
  if (!file) FailReading(memory);
  Tiff tiff;
  int page = 1;
  do {
    ReadPage(file.get(), memory, page++, tiff);
  } while (TIFFReadDirectory(file.get()) == 1);
  if (!memory.error.empty()) FailReading(memory);
  return tiff;
}

}  // namespace rangegrasp::image
