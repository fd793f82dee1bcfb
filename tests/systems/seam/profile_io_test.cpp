#include "seam/profile_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "seam/grey_png.h"
#include "temp_folder.h"
#include "tiff_file.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;
using base::Rng;
using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;

constexpr float kProfileIoNone = std::numeric_limits<float>::quiet_NaN();

std::vector<ProfileRow> Stream(const std::string& text, const ProfileFileOptions& options = {}) {
  std::istringstream in(text);
  ProfileStream stream(in, options);
  std::vector<ProfileRow> rows;
  while (auto row = stream.Next()) rows.push_back(std::move(*row));
  return rows;
}

std::vector<Profile> RandomProfiles(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Profile> profiles(1 + rng.Index(5));
  const std::size_t columns = 1 + rng.Index(200);
  for (std::size_t row = 0; row < profiles.size(); ++row) {
    profiles[row].time_s = static_cast<double>(row) / ProfileFileOptions{}.rate_hz;
    for (std::size_t i = 0; i < columns; ++i) {
      // Whole micrometres, which both file formats can hold.
      const double height = std::round(rng.Uniform(-30'000.0, 30'000.0)) * 1e-6;
      profiles[row].height_m.push_back(rng.Uniform() < 0.1 ? kProfileIoNone
                                                           : static_cast<float>(height));
    }
  }
  return profiles;
}

void ExpectSame(const std::vector<Profile>& a, const std::vector<Profile>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t row = 0; row < a.size(); ++row) {
    EXPECT_DOUBLE_EQ(a[row].time_s, b[row].time_s);
    ASSERT_EQ(a[row].height_m.size(), b[row].height_m.size());
    for (std::size_t i = 0; i < a[row].height_m.size(); ++i) {
      const float x = a[row].height_m[i];
      const float y = b[row].height_m[i];
      EXPECT_TRUE((std::isnan(x) && std::isnan(y)) || std::abs(x - y) < 1e-8F) << x << " " << y;
    }
  }
}

std::vector<Profile> ReadProfiles(const std::filesystem::path& file,
                                  const ProfileFileOptions& options) {
  std::vector<Profile> profiles;
  for (const ProfileRow& row : ReadProfileFile(file, options).rows) profiles.push_back(row.profile);
  return profiles;
}

// A grey level is 1 um, 32768 is height 0, 0 is missing.
std::string PngOf(const std::vector<Profile>& profiles) {
  std::vector<std::vector<double>> rows;
  for (const Profile& profile : profiles) {
    rows.emplace_back(profile.height_m.begin(), profile.height_m.end());
  }
  return GreyPng(rows, 1e6, 32768.0);
}

TEST(ProfileFiles, EveryFormatGivesBackWhatWasWritten) {
  const TempFolder folder;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto profiles = RandomProfiles(seed);
    for (const char* name : {"p.csv", "p.txt", "P.CSV"}) {
      WriteProfiles(profiles, folder / name);
      ExpectSame(ReadProfiles(folder / name, {}), profiles);
    }
    for (const char* name : {"p.png", "p.PNG"}) {
      folder.Write(name, PngOf(profiles));
      ExpectSame(ReadProfiles(folder / name, {}), profiles);
    }
  }
}

TEST(ProfileFiles, TheSameProfilesAreTheSameBytes) {
  const TempFolder folder;
  WriteProfiles(RandomProfiles(7), folder / "a.csv");
  const std::string first = base::ReadFile(folder / "a.csv");
  WriteProfiles(RandomProfiles(7), folder / "a.csv");
  EXPECT_EQ(base::ReadFile(folder / "a.csv"), first);
}

TEST(ProfileStream, TakesEverySeparatorAndEveryWayToSayNoValue) {
  for (const char* text :
       {"1,2,nan\n3,,5\n", "1;2;NaN\r\n3;-;5\r\n", "1 2\tnan\n\n# note\n 3  - 5 \n",
        "\xEF\xBB\xBF"
        "1, 2, -,\n+3, , 5\n",
        "1,2,\n3,-,5"}) {
    ProfileFileOptions options;
    options.columns = 3;
    const auto rows = Stream(text, options);
    ASSERT_EQ(rows.size(), 2U) << text;
    for (const auto& row : rows) ASSERT_EQ(row.fault, "") << text;
    EXPECT_FLOAT_EQ(rows[0].profile.height_m[0], 1e-3F);
    EXPECT_FLOAT_EQ(rows[0].profile.height_m[1], 2e-3F);
    EXPECT_TRUE(std::isnan(rows[0].profile.height_m[2]));
    EXPECT_FLOAT_EQ(rows[1].profile.height_m[0], 3e-3F);
    EXPECT_TRUE(std::isnan(rows[1].profile.height_m[1]));
    EXPECT_FLOAT_EQ(rows[1].profile.height_m[2], 5e-3F);
  }
}

// A separator at the end of a line may also stand before a missing last height.
TEST(ProfileStream, ALastHeightMayBeMissingInAnyRow) {
  const auto lasts = [](const std::string& text) {
    std::string seen;
    for (const auto& row : Stream(text)) {
      const auto& heights = row.profile.height_m;
      seen += !row.fault.empty() ? 'f' : std::isnan(heights.back()) ? '-' : '0';
      seen += std::to_string(heights.size());
    }
    return seen;
  };
  EXPECT_EQ(lasts("1,2,3\n1,2,\n1,2,3\n"), "03-303");
  EXPECT_EQ(lasts("1,2,\n1,2,3\n1,2,3\n"), "-30303");
  EXPECT_EQ(lasts("1,2,\n1,2,\n1,2,3\n"), "-3-303");
  EXPECT_EQ(lasts("1,2,\n1,2,\n1,2,\n"), "020202");  // no row has a third height
  EXPECT_EQ(lasts("1,2\n1,2,\n1,2\n"), "020202");
  EXPECT_EQ(lasts("1,2,,\n1,2,3,\n1,2,3,\n"), "-30303");
}

TEST(ProfileStream, NamesADamagedRowAndGoesOn) {
  const auto rows = Stream(
      "# mm\n"
      "1,2,3\n"
      "1,2\n"
      "1,2,3,4\n"
      "1,two,3\n"
      "1,2,900\n"
      "1,inf,3\n"
      "1,1e999,3\n"
      "4,5,6\n");
  const std::vector<std::string> says = {"",
                                         "row 2 (line 3) has 2 columns instead of 3",
                                         "row 3 (line 4) has 4 columns instead of 3",
                                         "row 4 (line 5), column 2: 'two' is not a number",
                                         "row 5 (line 6), column 3: '900' is out of range; it must "
                                         "be from -200 to 200",
                                         "column 2: 'inf' is not a number",
                                         "column 2: '1e999' is not a number",
                                         ""};
  ASSERT_EQ(rows.size(), says.size());
  for (std::size_t i = 0; i < says.size(); ++i) {
    EXPECT_EQ(rows[i].row, i + 1);
    EXPECT_THAT(rows[i].fault, HasSubstr(says[i]));
    EXPECT_EQ(rows[i].fault.empty(), says[i].empty()) << rows[i].fault;
    EXPECT_EQ(rows[i].profile.height_m.empty(), !says[i].empty());
  }
  // Damaged rows count for the time as well.
  EXPECT_DOUBLE_EQ(rows.back().profile.time_s, 7.0 / ProfileFileOptions{}.rate_hz);
}

// A reader may join a stream in the middle of a row.
TEST(ProfileStream, AFirstRowThatWasCutOffDoesNotSayHowWideTheOthersAre) {
  const auto rows = Stream("8,9\n1,2,3\n1,2,3\n1,2,3\n");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].fault, "row 1 has 2 columns instead of 3");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].fault, "");
    EXPECT_EQ(rows[i].row, i + 1);
    EXPECT_DOUBLE_EQ(rows[i].profile.time_s, static_cast<double>(i) / 62.0);
  }
}

TEST(ProfileStream, ItsFirstTwoRowsSayHowWideTheOthersAre) {
  const auto rows = Stream("1,2\nx,2\n1,2\n1,2,3\n1,2,3\n");
  ASSERT_EQ(rows.size(), 5U);
  for (const std::size_t whole : {0U, 2U}) EXPECT_EQ(rows[whole].fault, "");
  for (const std::size_t other : {3U, 4U}) {
    EXPECT_THAT(rows[other].fault, HasSubstr("has 3 columns instead of 2"));
  }
}

TEST(ProfileStream, OneRowIsAStream) {
  const auto rows = Stream("1,2,3\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].fault, "");
}

// Rows that are no profiles are reported as they arrive, not held back until a profile arrives.
TEST(ProfileStream, DamagedRowsAreNotHeldBackForEver) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "what, is this\n";
  std::istringstream in(text);
  ProfileStream stream(in, {});
  const auto first = stream.Next();
  ASSERT_TRUE(first);
  EXPECT_THAT(first->fault, HasSubstr("'what' is not a number"));
  EXPECT_LT(in.tellg(), std::streampos(500));
}

TEST(ProfileStream, ALineWithoutEndFillsNoMemory) {
  const auto rows = Stream(std::string(std::size_t{9} << 20U, '1') + "\n1,2\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_THAT(rows[0].fault, HasSubstr("too long for a profile"));
  EXPECT_EQ(rows[1].fault, "");
}

void ExpectRefused(const std::filesystem::path& file, const std::string& says) {
  EXPECT_THAT(ErrorOf([&] { ReadProfiles(file, {}); }),
              testing::AllOf(HasSubstr(file.string()), HasSubstr(says)));
}

TEST(ProfileFiles, BadFilesAreNamedWithTheirRow) {
  const TempFolder folder;
  ExpectRefused(folder / "none.csv", "cannot be read");
  ExpectRefused(folder / "none.png", "cannot be read");
  ExpectRefused(folder / "none/a.csv", "cannot be read: No such file");
  ExpectRefused(folder.Write("e.csv", ""), "contains no profile");
  ExpectRefused(folder.Write("e.csv", "\n# only a note\n"), "contains no profile");
  ExpectRefused(folder.Write("r.csv", "1,2\n1,2,3\n"), "row 2 has 3 columns instead of 2");
  ExpectRefused(folder.Write("n.csv", "1,x\n"), "row 1, column 2: 'x'");
  ExpectRefused(folder.Write("p.png", "no picture"), "");
  ExpectRefused(folder.Write("p.pgm", "P5\n2 2\n65535\n1234"), "unknown ending '.pgm'");
  ExpectRefused(folder.Write("p.jpg", "x"), "unknown ending '.jpg'");
  ASSERT_EQ(mkfifo((folder / "pipe.csv").c_str(), 0600), 0);
  ExpectRefused(folder / "pipe.csv", "is a named pipe");
  std::filesystem::create_directory(folder / "folder.csv");
  ExpectRefused(folder / "folder.csv", "folder");
}

TEST(ProfileFiles, AnotherEndingIsNotWritten) {
  const TempFolder folder;
  const std::vector<Profile> profiles = {{.height_m = {0.0F, 0.19F}, .time_s = 0.0}};
  EXPECT_THROW(WriteProfiles(profiles, folder / "p.xyz"), InputError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  folder.Write("file", "x");
  EXPECT_THROW(WriteProfiles(profiles, folder / "file/p.csv"), InputError);
}

// Any bytes give either profiles of one width or an error that names the file.
TEST(ProfileFiles, DamagedFilesGiveProfilesOrAnError) {
  const TempFolder folder;
  int refused = 0;
  int read = 0;
  WriteProfiles(RandomProfiles(3), folder / "p.csv");
  folder.Write("p.png", PngOf(RandomProfiles(3)));
  testing_support::WriteTiff<std::uint16_t>(
      folder / "p.tif", {{.width = 40, .pixels = std::vector<std::uint16_t>(120, 32700)}});
  for (const char* name : {"p.csv", "p.png", "p.tif"}) {
    const std::string whole = base::ReadFile(folder / name);
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
      Rng rng(seed);
      std::string bytes = whole;
      if (rng.Uniform() < 0.3) bytes.resize(rng.Index(bytes.size()));
      const std::size_t changes = 1 + rng.Index(6);
      for (std::size_t k = 0; k < changes && !bytes.empty(); ++k) {
        // Half of the changes go into the header.
        const std::size_t reach =
            rng.Uniform() < 0.5 ? std::min<std::size_t>(60, bytes.size()) : bytes.size();
        bytes[rng.Index(reach)] = static_cast<char>(rng.Index(256));
      }
      folder.Write(name, bytes);
      try {
        const auto profiles = ReadProfiles(folder / name, {});
        ASSERT_FALSE(profiles.empty());
        for (const Profile& p : profiles) {
          ASSERT_EQ(p.height_m.size(), profiles[0].height_m.size());
        }
        ++read;
      } catch (const InputError& error) {
        ASSERT_THAT(error.what(), HasSubstr(name));
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace rangegrasp::seam
