#pragma once

// Writes TIFF files with any pixel type, as other programs do. It uses libtiff's own file
// functions, not the functions that the program reads with.

#include <gtest/gtest.h>
#include <tiffio.h>

#include <cstdint>
#include <filesystem>
#include <type_traits>
#include <vector>

namespace rangegrasp::testing_support {

template <typename Pixel>
struct TiffPage {
  std::size_t width = 0;
  std::vector<Pixel> pixels;  ///< rows of `width`
  int channels = 1;
  bool tiled = false;
};

template <typename Pixel>
int SampleFormat() {
  if (std::is_floating_point_v<Pixel>) return SAMPLEFORMAT_IEEEFP;
  return std::is_signed_v<Pixel> ? SAMPLEFORMAT_INT : SAMPLEFORMAT_UINT;
}

/// @param mode  "w", or "wb" for big-endian
template <typename Pixel>
void WriteTiff(const std::filesystem::path& file, std::vector<TiffPage<Pixel>> pages,
               int compression = COMPRESSION_NONE, const char* mode = "w") {
  TIFF* tiff = TIFFOpen(file.c_str(), mode);
  ASSERT_NE(tiff, nullptr);
  for (auto& page : pages) {
    const std::size_t row = page.width * static_cast<std::size_t>(page.channels);
    const auto height = static_cast<std::uint32_t>(page.pixels.size() / row);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(page.width));
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page.channels);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * sizeof(Pixel));
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SampleFormat<Pixel>());
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                 page.channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
    if (page.tiled) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
      std::vector<Pixel> tile(16 * 16);
      TIFFWriteTile(tiff, tile.data(), 0, 0, 0, 0);
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3);
      for (std::uint32_t y = 0; y < height; ++y) {
        std::vector<Pixel> copy(page.pixels.begin() + static_cast<std::ptrdiff_t>(y * row),
                                page.pixels.begin() + static_cast<std::ptrdiff_t>((y + 1) * row));
        ASSERT_EQ(TIFFWriteScanline(tiff, copy.data(), y), 1);
      }
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

}  // namespace rangegrasp::testing_support
