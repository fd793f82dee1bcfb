#include "base/image/image.h"

#include <fmt/format.h>
#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

#include "base/error.h"

namespace rangegrasp::image {
namespace {

using base::InputError;

// Deflate compresses by at most 1032:1. A header that declares more than the file can contain is
// damaged, and no memory must be allocated for it.
constexpr std::size_t kMaxPacking = 1100;
// zlib's default level, with which all earlier files were written.
constexpr int kCompressionLevel = 6;

// The PNG pixel format of each image type.
template <typename Picture>
struct PixelFormat;
template <>
struct PixelFormat<Image> {
  static constexpr int kColorType = PNG_COLOR_TYPE_RGB;
  static constexpr int kBits = 8;
  static constexpr std::size_t kChannels = 3;
  static auto& Values(auto& picture) { return picture.rgb; }
};
template <typename Pixel>
struct PixelFormat<Grey<Pixel>> {
  static constexpr int kColorType = PNG_COLOR_TYPE_GRAY;
  static constexpr int kBits = 8 * sizeof(Pixel);
  static constexpr std::size_t kChannels = 1;
  static auto& Values(auto& picture) { return picture.grey; }
};

std::string KindOf(int color_type, int bits) {
  const char* kind = "grey";
  if (color_type == PNG_COLOR_TYPE_GRAY_ALPHA) kind = "grey with alpha";
  if (color_type == PNG_COLOR_TYPE_PALETTE) kind = "a palette";
  if (color_type == PNG_COLOR_TYPE_RGB) kind = "colour";
  if (color_type == PNG_COLOR_TYPE_RGB_ALPHA) kind = "colour with alpha";
  return fmt::format("{}-bit {}", bits, kind);
}

// libpng reports errors by longjmp: no object with a destructor may live between setjmp and there.
// Each function that calls setjmp therefore holds only plain values.

/// State of libpng while an image is read or written.
struct State {
  /// @param out  receives the written bytes; null: reads `file`
  explicit State(std::string_view file, std::string* out = nullptr)
      : bytes(file),
        written(out),
        png(out ? png_create_write_struct(PNG_LIBPNG_VER_STRING, this, OnError, OnWarning)
                : png_create_read_struct(PNG_LIBPNG_VER_STRING, this, OnError, OnWarning)),
        info(png ? png_create_info_struct(png) : nullptr) {
    if (!info) throw base::RunError("libpng cannot be initialised");
  }
  ~State() {
    if (written) {
      png_destroy_write_struct(&png, &info);
    } else {
      png_destroy_read_struct(&png, &info, nullptr);
    }
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  static void OnError(png_structp png, png_const_charp text) {
    auto* state = static_cast<State*>(png_get_error_ptr(png));
    std::snprintf(state->error.data(), state->error.size(), "%s", text);
    png_longjmp(png, 1);
  }
  static void OnWarning(png_structp, png_const_charp) {}

  std::string_view bytes;  // reading: the remaining bytes
  std::string* written;    // writing: the output
  std::array<char, 160> error{};
  png_structp png;
  png_infop info;
};

void ReadBytes(png_structp png, png_bytep out, std::size_t count) {
  auto* state = static_cast<State*>(png_get_io_ptr(png));
  if (count > state->bytes.size()) png_error(png, "the file is truncated");
  std::memcpy(out, state->bytes.data(), count);
  state->bytes.remove_prefix(count);
}

void WriteBytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto* state = static_cast<State*>(png_get_io_ptr(png));
  bool out_of_memory = false;
  try {
    state->written->append(reinterpret_cast<const char*>(bytes), count);
  } catch (const std::bad_alloc&) {
    out_of_memory = true;  // png_error must not jump out of a catch block
  }
  if (out_of_memory) png_error(png, "out of memory");
}
void FlushBytes(png_structp) {}

bool ReadHeader(State& state) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_set_read_fn(state.png, &state, ReadBytes);
  png_read_info(state.png, state.info);
  return true;
}

bool ReadRows(State& state, png_bytepp rows) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  // PNG stores 16-bit values in big-endian order; this machine is little-endian.
  png_set_swap(state.png);
  png_read_image(state.png, rows);
  png_read_end(state.png, nullptr);
  return true;
}

bool WriteRows(State& state, png_uint_32 width, png_uint_32 height, int bits, int color_type,
               png_bytepp rows) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_set_write_fn(state.png, &state, WriteBytes, FlushBytes);
  png_set_IHDR(state.png, state.info, width, height, bits, color_type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(state.png, kCompressionLevel);
  png_write_info(state.png, state.info);
  if (bits == 16) png_set_swap(state.png);
  png_write_image(state.png, rows);
  png_write_end(state.png, nullptr);
  return true;
}

[[noreturn]] void ThrowDamaged(const State& reader) {
  throw InputError(std::string("is not a complete PNG image: ") + reader.error.data());
}

// Pointers to the rows. libpng takes the rows to write as non-const, but does not modify them.
template <typename Value>
std::vector<png_bytep> RowsOf(const Value* values, std::size_t rows, std::size_t values_per_row) {
  std::vector<png_bytep> begins(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    begins[row] = reinterpret_cast<png_bytep>(const_cast<Value*>(values + row * values_per_row));
  }
  return begins;
}

void Begin(State& reader) {
  constexpr std::size_t kSignature = 8;  // bytes
  if (reader.bytes.size() < kSignature ||
      png_sig_cmp(reinterpret_cast<png_const_bytep>(reader.bytes.data()), 0, kSignature) != 0) {
    throw InputError("is not a PNG image");
  }
  if (!ReadHeader(reader)) ThrowDamaged(reader);
}

/// Width and height.
std::pair<std::size_t, std::size_t> SizeOf(const State& reader, std::size_t file_bytes) {
  const std::size_t width = png_get_image_width(reader.png, reader.info);
  const std::size_t height = png_get_image_height(reader.png, reader.info);
  if (width * height / kMaxPacking > file_bytes) {
    throw InputError(
        fmt::format("is not a whole PNG image: too short for {} x {} pixels", width, height));
  }
  return {width, height};
}

void CheckPng(std::string_view bytes) {
  State reader(bytes);
  Begin(reader);
  const std::size_t height = SizeOf(reader, bytes.size()).second;
  const std::size_t row_bytes = png_get_rowbytes(reader.png, reader.info);
  std::vector<std::uint8_t> values(row_bytes * height);
  std::vector<png_bytep> rows = RowsOf(values.data(), height, row_bytes);
  if (!ReadRows(reader, rows.data())) ThrowDamaged(reader);
}

/// The result of a function; an error names the file.
template <typename Function>
auto Naming(const std::filesystem::path& file, const Function& function) {
  try {
    return function();
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

}  // namespace

template <typename Picture>
Picture DecodePng(std::string_view bytes) {
  using Format = PixelFormat<Picture>;
  State reader(bytes);
  Begin(reader);
  const int type = png_get_color_type(reader.png, reader.info);
  const int bits = png_get_bit_depth(reader.png, reader.info);
  if (type != Format::kColorType || bits != Format::kBits) {
    throw InputError(fmt::format("is {}; {} is needed", KindOf(type, bits),
                                 KindOf(Format::kColorType, Format::kBits)));
  }
  const auto [width, height] = SizeOf(reader, bytes.size());
  Picture picture{static_cast<int>(width), static_cast<int>(height), {}};
  auto& values = Format::Values(picture);
  values.resize(width * height * Format::kChannels);
  std::vector<png_bytep> rows = RowsOf(values.data(), height, width * Format::kChannels);
  if (!ReadRows(reader, rows.data())) ThrowDamaged(reader);
  return picture;
}

template <typename Picture>
Picture ReadPng(const std::filesystem::path& file) {
  const std::string bytes = base::ReadFile(file);
  return Naming(file, [&] { return DecodePng<Picture>(bytes); });
}

std::string ReadPngOfAnyKind(const std::filesystem::path& file) {
  std::string bytes = base::ReadFile(file);
  Naming(file, [&] { CheckPng(bytes); });
  return bytes;
}

template <typename Picture>
std::string EncodePng(const Picture& picture) {
  using Format = PixelFormat<Picture>;
  const auto& values = Format::Values(picture);
  const auto width = static_cast<std::size_t>(picture.width);
  const auto height = static_cast<std::size_t>(picture.height);
  if (picture.width <= 0 || picture.height <= 0 ||
      values.size() != width * height * Format::kChannels) {
    throw std::invalid_argument(fmt::format("PNG: {} values do not fit a picture of {} x {} pixels",
                                            values.size(), picture.width, picture.height));
  }
  std::vector<png_bytep> rows = RowsOf(values.data(), height, width * Format::kChannels);
  std::string written;
  State writer("", &written);
  if (!WriteRows(writer, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
                 Format::kBits, Format::kColorType, rows.data())) {
    throw base::RunError(std::string("libpng: ") + writer.error.data());
  }
  return written;
}

template Image DecodePng(std::string_view);
template Grey8 DecodePng(std::string_view);
template Grey16 DecodePng(std::string_view);
template Image ReadPng(const std::filesystem::path&);
template Grey8 ReadPng(const std::filesystem::path&);
template Grey16 ReadPng(const std::filesystem::path&);
template std::string EncodePng(const Image&);
template std::string EncodePng(const Grey8&);
template std::string EncodePng(const Grey16&);
}  // namespace rangegrasp::image
