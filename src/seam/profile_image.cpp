#include <png.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include "core/error.h"
#include "seam/internal/grey_image.h"

namespace rangegrasp::seam::internal {
namespace {

using core::InputError;

// Deflate packs at most 1032 to 1: a header that asks for more than the file can hold is damaged,
// and must not make us ask for the memory.
constexpr std::size_t kMostPacking = 1100;
constexpr std::size_t kLargestSide = 10'000'000;

[[noreturn]] void FailNot16Bit(const std::string& is) {
  throw InputError("is " + is + "; profiles need 16-bit grey");
}

std::uint16_t FromBigEndian(const unsigned char* bytes) {
  return static_cast<std::uint16_t>((bytes[0] << 8U) | bytes[1]);
}

void ToBigEndian(const std::vector<std::uint16_t>& grey, unsigned char* bytes) {
  for (const std::uint16_t value : grey) {
    *bytes++ = static_cast<unsigned char>(value >> 8U);
    *bytes++ = static_cast<unsigned char>(value & 0xffU);
  }
}

// ---- PNG. libpng leaves its functions by longjmp: between setjmp and there nothing with a
// destructor may live, so each function that calls it holds plain values only.

struct PngState {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const unsigned char> bytes;  // reading
  std::size_t at = 0;
  std::string* written = nullptr;  // writing
  bool out_of_memory = false;
  std::array<char, 160> error{};
};

void OnPngError(png_structp png, png_const_charp text) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::snprintf(state->error.data(), state->error.size(), "%s", text);
  png_longjmp(png, 1);
}
void OnPngWarning(png_structp, png_const_charp) {}

void ReadPngBytes(png_structp png, png_bytep out, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (count > state->bytes.size() - state->at) png_error(png, "the file is cut off");
  std::memcpy(out, state->bytes.data() + state->at, count);
  state->at += count;
}

void WritePngBytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  try {
    state->written->append(reinterpret_cast<const char*>(bytes), count);
  } catch (const std::bad_alloc&) {
    state->out_of_memory = true;
  }
  if (state->out_of_memory) png_error(png, "out of memory");
}
void FlushPngBytes(png_structp) {}

bool ReadPngHeader(PngState& state) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_set_read_fn(state.png, &state, ReadPngBytes);
  png_read_info(state.png, state.info);
  return true;
}

bool ReadPngRows(PngState& state, png_bytepp rows) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_read_image(state.png, rows);
  png_read_end(state.png, nullptr);
  return true;
}

bool WritePngRows(PngState& state, png_uint_32 columns, png_uint_32 count, png_bytepp rows) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_set_write_fn(state.png, &state, WritePngBytes, FlushPngBytes);
  png_set_IHDR(state.png, state.info, columns, count, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(state.png, state.info);
  png_write_image(state.png, rows);
  png_write_end(state.png, nullptr);
  return true;
}

class PngRead : public PngState {
 public:
  explicit PngRead(std::span<const unsigned char> file) {
    bytes = file;
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, static_cast<PngState*>(this), OnPngError,
                                 OnPngWarning);
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr) throw core::RunError("libpng cannot start");
  }
  ~PngRead() { png_destroy_read_struct(&png, &info, nullptr); }
  PngRead(const PngRead&) = delete;
  PngRead& operator=(const PngRead&) = delete;

  [[noreturn]] void Fail() const {
    throw InputError(std::string("is not a whole PNG image: ") + error.data());
  }
};

class PngWrite : public PngState {
 public:
  explicit PngWrite(std::string& out) {
    written = &out;
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, static_cast<PngState*>(this), OnPngError,
                                  OnPngWarning);
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr) throw core::RunError("libpng cannot start");
  }
  ~PngWrite() { png_destroy_write_struct(&png, &info); }
  PngWrite(const PngWrite&) = delete;
  PngWrite& operator=(const PngWrite&) = delete;
};

void CheckPngFormat(const PngRead& read) {
  const int type = png_get_color_type(read.png, read.info);
  const int depth = png_get_bit_depth(read.png, read.info);
  if (type == PNG_COLOR_TYPE_GRAY && depth == 16) return;
  const char* kind = "grey";
  if (type == PNG_COLOR_TYPE_GRAY_ALPHA) kind = "grey with alpha";
  if (type == PNG_COLOR_TYPE_PALETTE) kind = "a palette";
  if (type == PNG_COLOR_TYPE_RGB || type == PNG_COLOR_TYPE_RGB_ALPHA) kind = "colour";
  FailNot16Bit(std::to_string(depth) + "-bit " + kind);
}

std::vector<png_bytep> RowsOf(std::vector<unsigned char>& bytes, std::size_t rows) {
  std::vector<png_bytep> begins(rows);
  const std::size_t stride = bytes.size() / rows;
  for (std::size_t r = 0; r < rows; ++r) begins[r] = bytes.data() + r * stride;
  return begins;
}

// ---- PGM

bool IsBlank(unsigned char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The header's next number; comments run from '#' to the line's end.
std::size_t NextPgmNumber(std::span<const unsigned char> bytes, std::size_t& at, const char* what) {
  while (at < bytes.size() && (IsBlank(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text + at, text + bytes.size(), number);
  if (error != std::errc() || number == 0 || number > kLargestSide) {
    throw InputError(std::string("is not a whole PGM image: the header's ") + what +
                     " must be a number from 1 to " + std::to_string(kLargestSide));
  }
  at = static_cast<std::size_t>(end - text);
  return number;
}

}  // namespace

GreyImage DecodePng(std::span<const unsigned char> bytes) {
  if (bytes.size() < 8 || png_sig_cmp(bytes.data(), 0, 8) != 0) {
    throw InputError("is not a PNG image");
  }
  PngRead read(bytes);
  if (!ReadPngHeader(read)) read.Fail();
  CheckPngFormat(read);
  GreyImage image;
  image.columns = png_get_image_width(read.png, read.info);
  image.rows = png_get_image_height(read.png, read.info);
  if (image.columns * image.rows / kMostPacking > bytes.size()) {
    throw InputError("is not a whole PNG image: too short for " + std::to_string(image.columns) +
                     " x " + std::to_string(image.rows) + " pixels");
  }
  std::vector<unsigned char> pixels(image.columns * image.rows * 2);
  std::vector<png_bytep> rows = RowsOf(pixels, image.rows);
  if (!ReadPngRows(read, rows.data())) read.Fail();
  image.grey.resize(image.columns * image.rows);
  for (std::size_t i = 0; i < image.grey.size(); ++i) {
    image.grey[i] = FromBigEndian(pixels.data() + 2 * i);
  }
  return image;
}

std::string EncodePng(const GreyImage& image) {
  std::vector<unsigned char> pixels(image.grey.size() * 2);
  ToBigEndian(image.grey, pixels.data());
  std::vector<png_bytep> rows = RowsOf(pixels, image.rows);
  std::string written;
  PngWrite write(written);
  if (!WritePngRows(write, static_cast<png_uint_32>(image.columns),
                    static_cast<png_uint_32>(image.rows), rows.data())) {
    throw core::RunError(std::string("libpng: ") + write.error.data());
  }
  return written;
}

GreyImage DecodePgm(std::span<const unsigned char> bytes) {
  if (bytes.size() < 3 || bytes[0] != 'P' || bytes[1] < '1' || bytes[1] > '6') {
    throw InputError("is not a PGM image: it must begin with P5");
  }
  if (bytes[1] != '5') {
    throw InputError(std::string("is of the kind P") + static_cast<char>(bytes[1]) +
                     "; profiles need a binary grey image, P5");
  }
  std::size_t at = 2;
  GreyImage image;
  image.columns = NextPgmNumber(bytes, at, "width");
  image.rows = NextPgmNumber(bytes, at, "height");
  const std::size_t largest = NextPgmNumber(bytes, at, "largest value");
  if (largest < 256) FailNot16Bit("8-bit grey (largest value " + std::to_string(largest) + ")");
  if (largest > 65535) {
    throw InputError("has the largest value " + std::to_string(largest) +
                     "; it must be from 256 to 65535");
  }
  ++at;  // one blank ends the header
  const std::size_t left = at < bytes.size() ? bytes.size() - at : 0;
  if (left / 2 / image.columns < image.rows) {
    throw InputError("is cut off in row " + std::to_string(left / 2 / image.columns + 1) + " of " +
                     std::to_string(image.rows));
  }
  image.grey.resize(image.columns * image.rows);
  for (std::size_t i = 0; i < image.grey.size(); ++i) {
    image.grey[i] = FromBigEndian(bytes.data() + at + 2 * i);
    if (image.grey[i] > largest) {
      throw InputError("row " + std::to_string(i / image.columns + 1) + ", column " +
                       std::to_string(i % image.columns + 1) + ": " +
                       std::to_string(image.grey[i]) + " is above the header's largest value " +
                       std::to_string(largest));
    }
  }
  return image;
}

std::string EncodePgm(const GreyImage& image) {
  std::string file =
      "P5\n" + std::to_string(image.columns) + " " + std::to_string(image.rows) + "\n65535\n";
  const std::size_t begin = file.size();
  file.resize(begin + image.grey.size() * 2);
  ToBigEndian(image.grey, reinterpret_cast<unsigned char*>(file.data()) + begin);
  return file;
}

}  // namespace rangegrasp::seam::internal
