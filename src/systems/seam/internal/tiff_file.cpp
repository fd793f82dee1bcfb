#include "seam/internal/tiff_file.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::image {
namespace {

using base::InputError;

// libtiff compresses at most about 1000 to 1 (deflate). A header that asks for more than the file
// can hold is damaged; its memory must not be allocated.
constexpr std::size_t kMaxPacking = 1100;

int OnError(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto& error = *static_cast<std::string*>(user);
  char text[200];
  std::vsnprintf(text, sizeof(text), format, arguments);
  if (error.empty()) error = text;
  return 1;  // handled: not also to stderr
}
int OnWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

using File = std::unique_ptr<TIFF, void (*)(TIFF*)>;

// @param error  receives libtiff's first message, also while the file is read.
File Open(const std::filesystem::path& file, std::string& error) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  if (!options) throw base::RunError("libtiff cannot be initialised");
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), OnError, &error);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), OnWarning, &error);
  return {TIFFOpenExt(file.c_str(), "r", options.get()), TIFFClose};
}

[[noreturn]] void FailReading(const std::string& error) {
  throw InputError("is not a complete TIFF image: " +
                   (error.empty() ? "the file is truncated" : error));
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
  throw InputError(
      fmt::format("has {} of {}-bit {} pixels; one channel of 16-bit whole numbers or 32-bit "
                  "floating point is needed",
                  base::Counted(channels, "channel"), bits, kind));
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

// Reads strips row by row. Rows of tiles differ; sensors that write rows write strips.
void ReadPage(TIFF* file, std::size_t max_pixels, const std::string& error, int page, Tiff& tiff) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &height);
  const auto pixels = static_cast<std::uint64_t>(width) * height;
  if (pixels == 0 || pixels > max_pixels || tiff.picture.grey.size() > max_pixels) {
    FailReading(error);
  }
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
  if (scanline < 0 || static_cast<std::size_t>(scanline) < needed) FailReading(error);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(scanline));
  for (std::uint32_t y = 0; y < height; ++y) {
    if (TIFFReadScanline(file, row.data(), y) != 1) FailReading(error);
    AppendRow(row, pixel, width, tiff.picture.grey);
  }
  tiff.picture.height += static_cast<int>(height);
}

}  // namespace

Tiff ReadTiff(const std::filesystem::path& file) {
  std::string error;
  const File open = Open(file, error);
  if (!open) FailReading(error);
  const std::size_t max_pixels = std::filesystem::file_size(file) * kMaxPacking;
  Tiff tiff;
  int page = 1;
  do {
    ReadPage(open.get(), max_pixels, error, page++, tiff);
  } while (TIFFReadDirectory(open.get()) == 1);
  if (!error.empty()) FailReading(error);
  return tiff;
}

}  // namespace rangegrasp::image
