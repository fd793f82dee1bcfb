#include "seam/image/pgm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/image/random_pictures.h"

namespace rangegrasp::image {
namespace {

using ::testing::HasSubstr;
using std::string_literals::operator""s;

TEST(Pgm, GivesBackWhatWasWritten) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto picture = RandomPicture<Grey16>(seed);
    const Grey16 read = DecodePgm(EncodePgm(picture));
    ASSERT_EQ(read.width, picture.width);
    ASSERT_EQ(read.height, picture.height);
    ASSERT_EQ(read.grey, picture.grey);
  }
}

TEST(Pgm, BytesAreThoseOfTheFormat) {
  EXPECT_EQ(EncodePgm({2, 1, {0x0102, 0xfffe}}), "P5\n2 1\n65535\n\x01\x02\xff\xfe"s);
  const Grey16 read = DecodePgm("P5 # a note\n 2\t1 1023\n\x01\x02\x03\xff"s);
  EXPECT_EQ(read.width, 2);
  EXPECT_EQ(read.height, 1);
  EXPECT_EQ(read.grey, (std::vector<std::uint16_t>{0x0102, 0x03ff}));
}

TEST(Pgm, SaysWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"", "must begin with P5"},
      {"P7 2 2 65535 12345678", "must begin with P5"},
      {"P2 2 2 65535 1 2 3 4", "of the kind P2"},
      {"P5 2 2 255 1234", "8-bit grey"},
      {"P5 2 2 70000 12345678", "from 256 to 65535"},
      {"P5 2 0 65535 1", "height"},
      {"P5 x 2 65535 1", "width"},
      {"P5 2 2 65535 12345", "cut off in row 2 of 2"},
      {"P5 99999999 2 65535 1", "width"},
      {"P5 9999999 9999999 65535 1", "cut off in row 1"},
      {"P5 2 1 256 \x01\x01\x01\x00"s, "row 1, column 1: 257 is above"}};
  for (const auto& [bytes, says] : wrong) {
    try {
      DecodePgm(bytes);
      FAIL() << bytes;
    } catch (const base::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(says));
    }
  }
}

TEST(Pgm, DamagedBytesGiveAPictureOrAnError) {
  const std::string whole = EncodePgm(RandomPicture<Grey16>(3));
  int read = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    try {
      const Grey16 picture = DecodePgm(Damaged(whole, seed));
      ASSERT_EQ(picture.grey.size(),
                static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
      ++read;
    } catch (const base::InputError&) {
    }
  }
  EXPECT_GT(read, 100);  // there is no checksum
}

}  // namespace
}  // namespace rangegrasp::image
