#include "seam/internal/tiff_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "temp_folder.h"
#include "tiff_file.h"

namespace rangegrasp::image {
namespace {

using base::InputError;
using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;
using testing_support::TiffPage;
using testing_support::WriteTiff;

class TiffTest : public testing::Test {
 protected:
  template <typename Pixel>
  Tiff Read(const std::vector<TiffPage<Pixel>>& pages, int compression = COMPRESSION_NONE,
            const char* mode = "w") {
    WriteTiff(folder_ / "p.tif", pages, compression, mode);
    return ReadTiff(folder_ / "p.tif");
  }
  template <typename Pixel>
  void ExpectRefused(const std::vector<TiffPage<Pixel>>& pages, const std::string& says) {
    EXPECT_THAT(ErrorOf([&] { Read(pages); }), HasSubstr(says));
  }
  TempFolder folder_;
};

TEST_F(TiffTest, ReadsEveryKindOfPixel) {
  const Tiff grey = Read<std::uint16_t>({{2, {0, 1, 32768, 65535}}});
  EXPECT_EQ(grey.pixel, TiffPixel::kUnsigned16);
  EXPECT_EQ(grey.picture.width, 2);
  EXPECT_EQ(grey.picture.height, 2);
  EXPECT_THAT(grey.picture.grey, ElementsAre(0.0F, 1.0F, 32768.0F, 65535.0F));
  const Tiff with_sign = Read<std::int16_t>({{2, {-32768, -1, 0, 32767}}});
  EXPECT_EQ(with_sign.pixel, TiffPixel::kSigned16);
  EXPECT_THAT(with_sign.picture.grey, ElementsAre(-32768.0F, -1.0F, 0.0F, 32767.0F));
  const Tiff real = Read<float>({{3, {-0.25F, 0.0F, 1e-9F}}});
  EXPECT_EQ(real.pixel, TiffPixel::kFloat32);
  EXPECT_THAT(real.picture.grey, ElementsAre(-0.25F, 0.0F, 1e-9F));
}

TEST_F(TiffTest, ReadsCompressedFilesAndThoseOfTheOtherByteOrder) {
  const std::vector<TiffPage<std::uint16_t>> pages = {{4, {1, 2, 3, 4, 500, 600, 700, 800}}};
  const auto plain = Read(pages).picture.grey;
  for (const int compression : {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    EXPECT_EQ(Read(pages, compression).picture.grey, plain) << compression;
  }
  EXPECT_EQ(Read(pages, COMPRESSION_NONE, "wb").picture.grey, plain);
}

TEST_F(TiffTest, PagesStandBelowEachOther) {
  const Tiff tiff = Read<std::uint16_t>({{2, {1, 2}}, {2, {3, 4, 5, 6}}, {2, {7, 8}}});
  EXPECT_EQ(tiff.picture.height, 4);
  EXPECT_THAT(tiff.picture.grey, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
}

TEST_F(TiffTest, OtherPixelsAreRefused) {
  ExpectRefused<std::uint8_t>({{2, {1, 2}}}, "1 channel of 8-bit whole-number pixels");
  ExpectRefused<std::uint16_t>({{1, {1, 2, 3}, 3}}, "3 channels of 16-bit whole-number pixels");
  ExpectRefused<double>({{2, {1, 2}}}, "64-bit floating-point pixels");
  ExpectRefused<std::uint32_t>({{2, {1, 2}}}, "32-bit whole-number pixels");
  ExpectRefused<std::uint16_t>({{16, std::vector<std::uint16_t>(256), 1, true}}, "tiled");
  ExpectRefused<std::uint16_t>({{2, {1, 2}}, {3, {1, 2, 3}}},
                               "page 2 is 3 columns wide and page 1 2");
  for (const char* bytes : {"", "P5\n2 2\n65535\n12345678"}) {
    EXPECT_THROW(ReadTiff(folder_.Write("p.tif", bytes)), InputError);
  }
}

// Any bytes give either a picture of the size they state or an error.
TEST_F(TiffTest, DamagedFilesGiveAPictureOrAnError) {
  std::vector<std::string> whole;
  for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE}) {
    const std::vector<std::uint16_t> pixels(400, 1234);
    Read<std::uint16_t>({{20, pixels}, {20, pixels}}, compression);
    whole.push_back(base::ReadFile(folder_ / "p.tif"));
  }
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    base::Rng rng(seed);
    std::string bytes = whole[seed % whole.size()];
    if (rng.Uniform() < 0.3) bytes.resize(rng.Index(bytes.size()));
    const std::size_t changes = 1 + rng.Index(4);
    for (std::size_t k = 0; k < changes && !bytes.empty(); ++k) {
      bytes[rng.Index(bytes.size())] = static_cast<char>(rng.Index(256));
    }
    try {
      const Tiff tiff = ReadTiff(folder_.Write("d.tif", bytes));
      const auto size = static_cast<std::size_t>(tiff.picture.width) *
                        static_cast<std::size_t>(tiff.picture.height);
      ASSERT_EQ(tiff.picture.grey.size(), size);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace rangegrasp::image
