#include "seam/image/tiff.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "base/error.h"

namespace rangegrasp::image {
namespace {

using base::InputError;

// libtiff's compressions pack some 1000 to 1 at best (deflate): a header that asks for more than
// the file can hold is damaged, and must not make us ask for the memory.
constexpr std::size_t kMaxPacking = 1100;

// A file in memory, and what libtiff said of it.
struct Memory {
  std::string_view bytes;  // reading
  std::string* written = nullptr;
  std::size_t at = 0;
  std::string error;
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
  if (memory->written != nullptr) return 0;
  const std::size_t left = memory->bytes.size() - std::min(memory->at, memory->bytes.size());
  const std::size_t take = std::min(left, static_cast<std::size_t>(count));
  if (take > 0) std::memcpy(out, memory->bytes.data() + memory->at, take);
  memory->at += take;
  return static_cast<tmsize_t>(take);
}

tmsize_t WriteBytes(thandle_t handle, void* bytes, tmsize_t count) {
  auto* memory = static_cast<Memory*>(handle);
  if (memory->written == nullptr) return 0;
  const auto size = static_cast<std::size_t>(count);
  std::string& out = *memory->written;
  if (out.size() < memory->at + size) out.resize(memory->at + size);
  std::memcpy(out.data() + memory->at, bytes, size);
  memory->at += size;
  return count;
}

toff_t SizeOf(thandle_t handle) {
  const auto* memory = static_cast<Memory*>(handle);
  return memory->written != nullptr ? memory->written->size() : memory->bytes.size();
}

toff_t Seek(thandle_t handle, toff_t offset, int from) {
  auto* memory = static_cast<Memory*>(handle);
  if (from == SEEK_CUR) offset += memory->at;
  if (from == SEEK_END) offset += SizeOf(handle);
  memory->at = static_cast<std::size_t>(offset);
  return offset;
}

int Close(thandle_t) { return 0; }

struct OptionsDeleter {
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};
struct FileDeleter {
  void operator()(TIFF* file) const { TIFFClose(file); }
};
using File = std::unique_ptr<TIFF, FileDeleter>;

// "m": no mapping of the file, for there is none.
File Open(Memory& memory, const char* mode) {
  const std::unique_ptr<TIFFOpenOptions, OptionsDeleter> options(TIFFOpenOptionsAlloc());
  if (!options) throw base::RunError("libtiff cannot start");
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), OnError, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), OnWarning, &memory);
  return File(TIFFClientOpenExt("", mode, &memory, ReadBytes, WriteBytes, Seek, Close, SizeOf,
                                nullptr, nullptr, options.get()));
}

[[noreturn]] void FailReading(const Memory& memory) {
  throw InputError("is not a whole TIFF image: " +
                   (memory.error.empty() ? "the file is cut off" : memory.error));
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

struct Size {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

Size SizeOfPage(TIFF* file, const Memory& memory) {
  Size size;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &size.width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &size.height);
  const auto pixels = static_cast<std::uint64_t>(size.width) * size.height;
  if (pixels == 0 || pixels > memory.bytes.size() * kMaxPacking) FailReading(memory);
  return size;
}

// Strips, row by row. Tiles have other rows; sensors that write rows write strips.
void ReadPage(TIFF* file, const Memory& memory, Tiff& tiff) {
  if (TIFFIsTiled(file) != 0) throw InputError("is tiled; a TIFF image of strips is needed");
  const Size size = SizeOfPage(file, memory);
  if (tiff.picture.grey.size() > memory.bytes.size() * kMaxPacking) FailReading(memory);
  const auto needed =
      static_cast<std::size_t>(size.width) * (tiff.pixel == TiffPixel::kFloat32 ? 4 : 2);
  const tmsize_t scanline = TIFFScanlineSize(file);
  if (scanline < 0 || static_cast<std::size_t>(scanline) < needed) FailReading(memory);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(scanline));
  for (std::uint32_t y = 0; y < size.height; ++y) {
    if (TIFFReadScanline(file, row.data(), y) != 1) FailReading(memory);
    AppendRow(row, tiff.pixel, size.width, tiff.picture.grey);
  }
  tiff.picture.width = static_cast<int>(size.width);
  tiff.picture.height += static_cast<int>(size.height);
}

void CheckLikeFirst(TIFF* file, const Memory& memory, const Tiff& tiff, int page) {
  const Size size = SizeOfPage(file, memory);
  if (size.width == static_cast<std::uint32_t>(tiff.picture.width) && PixelOf(file) == tiff.pixel) {
    return;
  }
  throw InputError(fmt::format(
      "page {} is {} columns wide and page 1 {}, or has other pixels; all must be like the first",
      page, size.width, tiff.picture.width));
}

}  // namespace

Tiff DecodeTiff(std::string_view bytes) {
  Memory memory{.bytes = bytes, .error = {}};
  const File file = Open(memory, "rm");
  if (!file) FailReading(memory);
  Tiff tiff;
  tiff.pixel = PixelOf(file.get());
  ReadPage(file.get(), memory, tiff);
  for (int page = 2; TIFFReadDirectory(file.get()) == 1; ++page) {
    CheckLikeFirst(file.get(), memory, tiff, page);
    ReadPage(file.get(), memory, tiff);
  }
  if (!memory.error.empty()) FailReading(memory);
  return tiff;
}

std::string EncodeTiff(const Grey16& picture) {
  const auto width = static_cast<std::size_t>(std::max(picture.width, 0));
  const auto height = static_cast<std::size_t>(std::max(picture.height, 0));
  if (width * height == 0 || picture.grey.size() != width * height) {
    throw std::invalid_argument("TIFF image: the size and the number of pixels do not fit");
  }
  std::string bytes;
  Memory memory{.bytes = {}, .written = &bytes, .error = {}};
  File file = Open(memory, "wm");
  if (!file) throw base::RunError("libtiff cannot start: " + memory.error);
  TIFFSetField(file.get(), TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(width));
  TIFFSetField(file.get(), TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(height));
  TIFFSetField(file.get(), TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(file.get(), TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(file.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(file.get(), TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(file.get(), TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(file.get(), 0));
  std::vector<std::uint16_t> row(width);
  for (std::size_t y = 0; y < height; ++y) {
    std::copy_n(picture.grey.begin() + static_cast<std::ptrdiff_t>(y * width), width, row.begin());
    if (TIFFWriteScanline(file.get(), row.data(), static_cast<std::uint32_t>(y)) != 1) {
      throw base::RunError("libtiff cannot write: " + memory.error);
    }
  }
  file.reset();
  if (!memory.error.empty()) throw base::RunError("libtiff cannot write: " + memory.error);
  return bytes;
}

}  // namespace rangegrasp::image
