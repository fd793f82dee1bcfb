#include <png.h>

#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/error.h"
#include "sim/render.h"

namespace rangegrasp::sim {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// Alone in its function: libpng reports errors by longjmp. False on an error.
bool Encode(std::FILE* file, const Image& image, png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, 6);
  png_write_info(png, info);
  for (int row = 0; row < image.height; ++row) {
    png_write_row(png, image.rgb.data() + static_cast<std::ptrdiff_t>(3) * image.width * row);
  }
  png_write_end(png, nullptr);
  return true;
}

}  // namespace

void WritePng(const std::string& file, const Image& image) {
  if (image.width <= 0 || image.height <= 0 ||
      image.rgb.size() !=
          3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
    throw std::invalid_argument("WritePng: an image has width * height * 3 bytes");
  }
  std::unique_ptr<std::FILE, CloseFile> out(std::fopen(file.c_str(), "wb"));
  if (!out) throw core::RunError("cannot write " + file + ": " + std::strerror(errno));
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool encoded = info && Encode(out.get(), image, png, info);
  png_destroy_write_struct(&png, &info);
  // What is still in the buffer can fail to reach a full disk.
  const bool flushed = std::fflush(out.get()) == 0;
  if (!encoded || !flushed)
    throw core::RunError("cannot write " + file + ": " + std::strerror(errno));
}

}  // namespace rangegrasp::sim
