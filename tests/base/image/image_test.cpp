#include "base/image/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "base/image/random_pictures.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::image {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;

const auto& Values(const Image& picture) { return picture.rgb; }
template <typename Pixel>
const auto& Values(const Grey<Pixel>& picture) {
  return picture.grey;
}

template <typename Picture>
class Png : public ::testing::Test {};
using Pictures = ::testing::Types<Image, Grey8, Grey16>;
TYPED_TEST_SUITE(Png, Pictures);

TYPED_TEST(Png, GivesBackWhatWasWritten) {
  const TempFolder folder;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto picture = RandomPicture<TypeParam>(seed);
    WritePng(folder / "new/a.png", picture);
    const auto read = ReadPng<TypeParam>(folder / "new/a.png");
    ASSERT_EQ(read.width, picture.width);
    ASSERT_EQ(read.height, picture.height);
    ASSERT_EQ(Values(read), Values(picture));
    ASSERT_EQ(base::ReadFile(folder / "new/a.png"), EncodePng(picture));
  }
}

// For any bytes, the result is a complete picture or an error that names the file.
TYPED_TEST(Png, DamagedFilesGiveAPictureOrAnErrorThatNamesThem) {
  const TempFolder folder;
  const std::string whole = EncodePng(RandomPicture<TypeParam>(3));
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const auto file = folder.Write("a.png", Damaged(whole, seed));
    try {
      const auto read = ReadPng<TypeParam>(file);
      ASSERT_EQ(Values(read).size() % static_cast<std::size_t>(read.width * read.height), 0U);
    } catch (const base::InputError& error) {
      ASSERT_THAT(error.what(), HasSubstr(file.string()));
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);  // each chunk has a checksum
}

TYPED_TEST(Png, RefusesSizesThatDoNotFit) {
  auto picture = RandomPicture<TypeParam>(1);
  ++picture.width;
  EXPECT_THROW(EncodePng(picture), std::invalid_argument);
  EXPECT_THROW(EncodePng(TypeParam{}), std::invalid_argument);
}

TYPED_TEST(Png, NamesAFileThatCannotBeWritten) {
  const TempFolder folder;
  const auto picture = RandomPicture<TypeParam>(1);
  for (const std::filesystem::path& file : {folder.path(), std::filesystem::path("/dev/full")}) {
    EXPECT_THAT(ErrorOf<base::RunError>([&] { WritePng(file, picture); }),
                HasSubstr(file.string()));
  }
  EXPECT_THROW(WritePng(folder.Write("file", "") / "a.png", picture), base::InputError);
}

template <typename Picture>
void ExpectRefused(const std::filesystem::path& file, const std::string& says) {
  EXPECT_THAT(ErrorOf([&] { ReadPng<Picture>(file); }),
              AllOf(HasSubstr(file.string()), HasSubstr(says)));
}

TEST(ReadPng, SaysWhichKindOfPixelsItWants) {
  const TempFolder folder;
  const auto colour = folder.Write("c.png", EncodePng(RandomPicture<Image>(1)));
  const auto grey = folder.Write("g.png", EncodePng(RandomPicture<Grey8>(1)));
  const auto deep = folder.Write("d.png", EncodePng(RandomPicture<Grey16>(1)));
  ExpectRefused<Grey16>(colour, "is 8-bit colour; 16-bit grey is needed");
  ExpectRefused<Grey16>(grey, "is 8-bit grey; 16-bit grey is needed");
  ExpectRefused<Grey8>(deep, "is 16-bit grey; 8-bit grey is needed");
  ExpectRefused<Image>(grey, "is 8-bit grey; 8-bit colour is needed");
}

TEST(ReadPng, NamesWhatIsNoPng) {
  const TempFolder folder;
  ExpectRefused<Image>(folder / "none.png", "no such file");
  ExpectRefused<Image>(folder.Write("e.png", ""), "is not a PNG image");
  ExpectRefused<Image>(folder.Write("t.png", "no picture at all"), "is not a PNG image");
  const std::string whole = EncodePng(RandomPicture<Image>(1));
  ExpectRefused<Image>(folder.Write("h.png", whole.substr(0, whole.size() / 2)), "truncated");
}

TEST(ReadPngOfAnyKind, GivesTheBytesUnlessAPixelCannotBeDecoded) {
  const TempFolder folder;
  const auto check = [&](const std::string& bytes) {
    EXPECT_EQ(ReadPngOfAnyKind(folder.Write("a.png", bytes)), bytes);
    std::string wrong = bytes;
    char& pixel = wrong[wrong.size() / 2];
    pixel = static_cast<char>(pixel ^ 1);  // the pixels have a checksum
    for (const std::string& damaged : {wrong, bytes.substr(0, wrong.size() / 2), bytes.substr(8)}) {
      EXPECT_THAT(ErrorOf([&] { ReadPngOfAnyKind(folder.Write("b.png", damaged)); }),
                  AllOf(HasSubstr("b.png: is not a"), HasSubstr("PNG image")));
    }
  };
  check(EncodePng(RandomPicture<Image>(1)));
  check(EncodePng(RandomPicture<Grey8>(1)));
  check(EncodePng(RandomPicture<Grey16>(1)));
}

TEST(DecodePng, NoBeginningOfAFileIsAPicture) {
  const std::string whole = EncodePng(RandomPicture<Grey8>(1));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THROW(DecodePng<Grey8>(whole.substr(0, size)), base::InputError) << size;
  }
}

// The CRC at the end of a PNG chunk (ISO 3309), computed bit by bit.
std::uint32_t Crc(const std::string& bytes) {
  std::uint32_t crc = ~0U;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

TEST(DecodePng, AHeaderThatAsksForMoreThanTheFileCanHoldAsksForNoMemory) {
  std::string bytes = EncodePng(Grey8{3, 2, std::vector<std::uint8_t>(6, 7)});
  constexpr std::size_t kKind = 12, kSides = 16, kEnd = 29;  // in the header chunk
  using std::string_literals::operator""s;
  bytes.replace(kSides, 8, "\x00\x00\x75\x30\x00\x00\x75\x30"s);  // 30000 twice
  const std::uint32_t crc = Crc(bytes.substr(kKind, kEnd - kKind));
  for (std::size_t i = 0; i < 4; ++i) bytes[kEnd + i] = static_cast<char>(crc >> (24 - 8 * i));
  EXPECT_THAT(ErrorOf([&] { DecodePng<Grey8>(bytes); }),
              HasSubstr("too short for 30000 x 30000 pixels"));
}

// Two rows of three pixels, as in the PNG specification: the width comes first, rows start at the
// top, and each row is preceded by its filter type.
TEST(EncodePng, TheHeaderSaysSizeDepthAndColour) {
  const std::string bytes = EncodePng(Grey16{3, 2, std::vector<std::uint16_t>(6, 0x1234)});
  using std::string_literals::operator""s;
  EXPECT_EQ(bytes.substr(0, 26), "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\x03\0\0\0\x02\x10\0"s);
}

// A file made by hand with uncompressed pixels: 2 x 2 pixels of 16-bit grey, 0x0102 0xfffe above
// 0x0304 0x0000.
TEST(DecodePng, TheHigherByteComesFirst) {
  const std::string hex =
      "89504e470d0a1a0a0000000d4948445200000002000000021000000000074d8ebb00000015494441"
      "547801010a00f5ff000102fffe00030400000d280208dabdf24b0000000049454e44ae426082";
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  const auto picture = DecodePng<Grey16>(bytes);
  EXPECT_EQ(picture.width, 2);
  EXPECT_EQ(picture.height, 2);
  EXPECT_EQ(picture.grey, (std::vector<std::uint16_t>{0x0102, 0xfffe, 0x0304, 0x0000}));
}

}  // namespace
}  // namespace rangegrasp::image
