#include "seam/profile_format.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

#include "base/error.h"
#include "base/image/image.h"
#include "base/rng.h"
#include "base/yaml_map.h"
#include "error_of.h"
#include "seam/profile_io.h"
#include "seam/tracker.h"
#include "temp_folder.h"
#include "tiff_file.h"

// Formats of other sensors. The same profiles give the same edges in every format, and errors in a
// file are named.

namespace rangegrasp::seam {
namespace {

using base::InputError;
using base::Rng;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing_support::ErrorOf;
using testing_support::TempFolder;
using testing_support::TiffPage;
using testing_support::WriteTiff;

constexpr int kProfileFormatsColumns = 512;
constexpr int kProfiles = 20;
constexpr double kColumnsPerMm = 12.0;

ProfileFileOptions OptionsOf(const std::string& yaml, const std::string& preset = "") {
  ProfileFileOptions options;
  if (!preset.empty()) {
    const std::string keys(PresetOf(preset).yaml);
    ReadProfileFileOptions(base::YamlMap::FromText(keys, preset), options);
  }
  ReadProfileFileOptions(base::YamlMap::FromText(yaml, "o.yaml"), options);
  return options;
}

struct ProfilePoint {
  double x_mm;
  double height_mm;  ///< NaN if nothing was measured
};
using ProfilePoints = std::vector<ProfilePoint>;

// A mat 0.8 mm thick with a wavy surface, noise of 20 um and 3 % of the points missing. Its edge
// moves from profile to profile. Points are one column apart in x, with an error of up to `jitter`.
std::vector<ProfilePoints> FormatRecording(double jitter = 0.0) {
  std::vector<ProfilePoints> profiles;
  for (int k = 0; k < kProfiles; ++k) {
    Rng noise(static_cast<std::uint64_t>(k));
    Rng place(1000 + static_cast<std::uint64_t>(k));
    ProfilePoints points;
    const double edge_mm = 3.0 + 0.1 * k;
    for (int i = 0; i < kProfileFormatsColumns; ++i) {
      const double off = jitter * place.Uniform(-1.0, 1.0);
      const double x_mm = (i - 0.5 * (kProfileFormatsColumns - 1) + off) / kColumnsPerMm;
      const double step_mm = x_mm >= edge_mm ? 0.8 : 0.0;
      const double noise_mm = noise.Uniform(-0.035, 0.035);
      const bool missing = noise.Uniform() < 0.03;
      const double height_mm = step_mm + 0.2 * std::sin(0.15 * x_mm) + noise_mm;
      points.push_back({x_mm, missing ? std::numeric_limits<double>::quiet_NaN() : height_mm});
    }
    profiles.push_back(points);
  }
  return profiles;
}

// x of each profile's edge, in columns from the middle of the sensor's x range.
std::vector<double> Edges(const ProfileFile& file) {
  TrackerOptions options;
  options.method = DecisionMethod::kVoting;
  options.line.columns = static_cast<int>(file.rows.at(0).profile.height_m.size());
  options.line.columns_per_m = 1e3 * kColumnsPerMm;
  double center_m = 0.0;
  if (file.grid) {
    options.line.columns_per_m = 1.0 / file.grid->pitch_m;
    center_m = file.grid->Center();
  }
  EdgeTracker tracker(options);
  std::vector<double> edges;
  for (const ProfileRow& row : file.rows) {
    const Reading reading = tracker.Update(row.profile);
    if (reading.column) edges.push_back((reading.x_m + center_m) * 1e3 * kColumnsPerMm);
  }
  return edges;
}

std::string Number(double number, const std::string& none, bool comma = false) {
  if (std::isnan(number)) return none;
  std::string text = fmt::format("{:.4f}", number);
  if (comma) std::ranges::replace(text, '.', ',');
  return text;
}

// Text with one profile per line.
std::string Rows(
    const std::vector<ProfilePoints>& profiles, const std::string& separator,
    const std::function<std::string(const ProfilePoint&)>& field,
    const std::function<std::string(int)>& before = [](int) { return ""; }) {
  std::string text;
  for (std::size_t k = 0; k < profiles.size(); ++k) {
    text += before(static_cast<int>(k));
    for (std::size_t i = 0; i < profiles[k].size(); ++i) {
      text += (i > 0 ? separator : "") + field(profiles[k][i]);
    }
    text += "\n";
  }
  return text;
}

class ProfileFormats : public testing::Test {
 protected:
  // Expects the same edges as from plain CSV, profile by profile.
  void ExpectSameEdges(const std::string& name, const ProfileFileOptions& options,
                       double offset_mm = 0.0) {
    const auto plain = Edges(ReadProfileFile(
        folder_.Write("plain.csv",
                      Rows(FormatRecording(), ",",
                           [](const ProfilePoint& p) { return Number(p.height_mm, "nan"); })),
        {}));
    ASSERT_EQ(std::ssize(plain), kProfiles);
    EXPECT_NEAR(plain.back(), 4.9 * kColumnsPerMm, 3.0);
    const auto edges = Edges(ReadProfileFile(folder_ / name, options));
    ASSERT_EQ(edges.size(), plain.size()) << name;
    for (std::size_t k = 0; k < plain.size(); ++k) {
      EXPECT_NEAR(edges[k] - offset_mm * kColumnsPerMm, plain[k], 1.0) << name << " " << k;
    }
  }
  // The recording as rows of an image with any pixel type.
  template <typename Pixel>
  std::vector<TiffPage<Pixel>> Pages(const std::function<double(double)>& level, int pages) {
    std::vector<TiffPage<Pixel>> made(static_cast<std::size_t>(pages),
                                      {kProfileFormatsColumns, {}});
    const auto recording = FormatRecording();
    for (std::size_t k = 0; k < recording.size(); ++k) {
      auto& page = made[k * static_cast<std::size_t>(pages) / recording.size()];
      for (const ProfilePoint& p : recording[k]) {
        page.pixels.push_back(static_cast<Pixel>(level(p.height_mm)));
      }
    }
    return made;
  }
  TempFolder folder_;
};

TEST_F(ProfileFormats, DecimalCommasHeaderAndTimesOfAText) {
  folder_.Write("p.csv",
                "Sensor 7;;\n\"Zeit\";Weg;Werte\n" +
                    Rows(
                        FormatRecording(), ";",
                        [](const ProfilePoint& p) { return Number(p.height_mm, "", true); },
                        [](int k) { return fmt::format("{},5;{};", 1000 + 16 * k, k); }));
  const auto options = OptionsOf(
      "{decimal_comma: true, header_lines: 2, time_column: Zeit, time_unit_s: 0.001, "
      "encoder_column: 2, encoder_mm: 0.5}");
  ExpectSameEdges("p.csv", options);
  const auto file = ReadProfileFile(folder_ / "p.csv", options);
  EXPECT_NEAR(file.rows[3].profile.time_s, 1.0485, 1e-9);
  EXPECT_NEAR(file.rows[3].position_m.value(), 1.5e-3, 1e-12);
  EXPECT_FALSE(file.rows[3].gap_s);
}

TEST_F(ProfileFormats, PairsOnUnevenXWithSentinels) {
  folder_.Write("p.txt", Rows(FormatRecording(0.2), "\t", [](const ProfilePoint& p) {
                  return Number(p.x_mm, "") + "\t" + Number(p.height_mm, "-999.9999");
                }));
  ExpectSameEdges("p.txt", OptionsOf("{layout: pairs, no_values: [-999.9999]}"));
}

TEST_F(ProfileFormats, PointsOneALine) {
  std::string blank;
  std::string numbered = "profile;x;z\n";
  int k = 0;
  for (const ProfilePoints& points : FormatRecording(0.2)) {
    ++k;
    for (const ProfilePoint& p : points) {
      // Some sensors report no x either where nothing was measured.
      const bool none = std::isnan(p.height_mm);
      blank +=
          none ? "0 0\n" : Number(p.x_mm + 40.0, "") + " " + Number(p.height_mm + 60.0, "") + "\n";
      numbered +=
          fmt::format("{};{};{}\n", k, Number(p.x_mm, "", true), Number(p.height_mm, "-", true));
    }
    blank += "\n";
  }
  folder_.Write("b.txt", blank);
  ExpectSameEdges("b.txt", OptionsOf("{layout: points, no_values: [0]}"), 40.0);
  folder_.Write("n.csv", numbered);
  ExpectSameEdges("n.csv", OptionsOf("{layout: points, decimal_comma: true, header_lines: 1, "
                                     "profile_column: profile, first_column: x, z_column: z}"));
}

TEST_F(ProfileFormats, HeightsFarBeyondTwoHundredAndAwayFromTheSensor) {
  folder_.Write("p.csv", Rows(FormatRecording(), ",", [](const ProfilePoint& p) {
                  return Number(350.0 - p.height_mm, "nan");
                }));
  ExpectSameEdges("p.csv", OptionsOf("{away: true, min_height_mm: 300, max_height_mm: 400}"));
}

// The export as the manual describes it; see the preset.
std::string Gocator(const std::vector<ProfilePoints>& profiles, bool raw) {
  std::string text =
      "Info\nCSV Version,Sensor Count,Trigger Mode\n2,1,0\nEnd\nRanges\nFrame Count\n0\nEnd\n";
  text += raw ? "RawProfile\n" : "Profile\n";
  text += fmt::format("Frame Count,Column Count,X Offset\n{},{},0\n", profiles.size(),
                      kProfileFormatsColumns);
  text += "Frame,Source,Time,Encoder,Z Encoder,Inputs,Exposure,Y,Axis";
  for (int i = 0; i < kProfileFormatsColumns; ++i) {
    text += raw ? fmt::format(",{}", i)
                : "," + Number(profiles[0][static_cast<std::size_t>(i)].x_mm, "");
  }
  text += "\n";
  for (std::size_t k = 0; k < profiles.size(); ++k) {
    for (const char axis : std::string(raw ? "XZI" : "ZI")) {
      text += fmt::format("{},0,{},{},0,0,80,{},{}", k, 16000 * k, k, k, axis);
      for (const ProfilePoint& p : profiles[k]) {
        const double value = axis == 'X' ? p.x_mm : axis == 'Z' ? p.height_mm : 128.0;
        text += "," + Number(std::isnan(p.height_mm) && axis != 'I' ? p.height_mm : value, "");
      }
      text += "\n";
    }
  }
  return text + "End\nPart\nFrame,Source\nEnd\n";
}

TEST_F(ProfileFormats, GocatorsExport) {
  folder_.Write("u.csv", Gocator(FormatRecording(), false));
  ExpectSameEdges("u.csv", OptionsOf("{}", "gocator"));
  EXPECT_NEAR(ReadProfileFile(folder_ / "u.csv", OptionsOf("{}", "gocator")).rows[2].profile.time_s,
              0.032, 1e-9);
  folder_.Write("r.csv", Gocator(FormatRecording(0.2), true));
  ExpectSameEdges("r.csv", OptionsOf("{}", "gocator"));
}

TEST_F(ProfileFormats, KeyencesText) {
  const auto profiles = FormatRecording();
  std::string text;
  const auto whole = [](double mm) { return fmt::format("{:.0f}", 1e5 * mm); };
  for (std::size_t i = 0; i < kProfileFormatsColumns; ++i) {
    text += whole(profiles[0][i].x_mm);
    for (const ProfilePoints& points : profiles) {
      const double height = points[i].height_mm;
      text += "\t" + (std::isnan(height) ? "-2147483647" : whole(height));
    }
    text += "\r\n";
  }
  folder_.Write("p.txt", text);
  ExpectSameEdges("p.txt", OptionsOf("{}", "keyence_text"));
}

TEST_F(ProfileFormats, ImagesWithScaleOffsetAndNoValue) {
  const auto level = [](double scale_mm, double offset_mm, double none) {
    return
        [=](double mm) { return std::isnan(mm) ? none : std::round((mm - offset_mm) / scale_mm); };
  };
  WriteTiff(folder_ / "g.tif", Pages<std::uint16_t>(level(0.001, -32.768, 0), 1));
  ExpectSameEdges("g.tif", {});
  WriteTiff(folder_ / "pages.tiff", Pages<std::uint16_t>(level(0.001, -32.768, 0), kProfiles),
            COMPRESSION_LZW);
  ExpectSameEdges("pages.tiff", {});
  WriteTiff(folder_ / "k.tif", Pages<std::uint16_t>(level(0.0008, -32768 * 0.0008, 0), 1));
  ExpectSameEdges("k.tif", OptionsOf("{image_scale_mm: 0.0008}", "keyence"));
  WriteTiff(folder_ / "s.tif", Pages<std::uint16_t>(level(0.002, -10.0, 0), 1));
  ExpectSameEdges("s.tif", OptionsOf("{image_scale_mm: 0.002, image_offset_mm: -10}", "sick"));
  WriteTiff(folder_ / "n.tif", Pages<std::uint16_t>(level(0.002, -10.0, 65535), 1));
  ExpectSameEdges("n.tif", OptionsOf("{image_scale_mm: 0.002, image_offset_mm: -10, "
                                     "no_values: [65535]}"));
  WriteTiff(folder_ / "i.tif", Pages<std::int16_t>(level(0.001, 0.0, -32768), 1));
  ExpectSameEdges("i.tif", {});
}

TEST_F(ProfileFormats, FloatingPointImages) {
  const auto same = [](double mm) { return mm; };
  WriteTiff(folder_ / "f.tif", Pages<float>(same, 1));
  ExpectSameEdges("f.tif", {});
  const auto sentinel = [](double mm) { return std::isnan(mm) ? -999.9999 : 1e-3 * mm; };
  WriteTiff(folder_ / "m.tif", Pages<float>(sentinel, 4));
  ExpectSameEdges("m.tif", OptionsOf("{image_scale_mm: 1000, no_values: [-999.9999]}"));
}

// ---- the grid ----

ProfileFile ReadText(const TempFolder& folder, const std::string& text, const std::string& yaml,
                     double columns_per_m = 0.0) {
  auto options = OptionsOf(yaml);
  options.columns_per_m = columns_per_m;
  return ReadProfileFile(folder.Write("t.csv", text), options);
}

TEST(ProfileGrids, AGapStaysAGapAndWhatIsBetweenNeighboursIsLinear) {
  const TempFolder folder;
  const auto file =
      ReadText(folder, "0,0,1,2,2,nan,3,6,4,8,7,14,8,16\n", "{layout: pairs}", 2000.0);
  ASSERT_TRUE(file.grid);
  EXPECT_DOUBLE_EQ(1.0 / file.grid->pitch_m, 2000.0);
  EXPECT_DOUBLE_EQ(file.grid->Center(), 4e-3);
  const auto& heights = file.rows[0].profile.height_m;
  ASSERT_EQ(heights.size(), 17U);
  // A column is 0.5 mm wide. Between x = 1 and 3 and between 4 and 7 only columns near a point have
  // a height.
  const std::vector<double> wanted_mm = {0, 1, 2, 2, -1, 6, 6, 7, 8, 8, -1, -1, -1, 14, 14, 15, 16};
  for (std::size_t i = 0; i < wanted_mm.size(); ++i) {
    if (wanted_mm[i] < 0) {
      EXPECT_TRUE(std::isnan(heights[i])) << i;
    } else {
      EXPECT_NEAR(heights[i], 1e-3 * wanted_mm[i], 1e-8) << i;
    }
  }
}

// 1024 columns of 1/12 mm, written with three digits. An error of half a column at the end would be
// too large.
TEST(ProfileGrids, RoundedXDoesNotShiftAlongTheLine) {
  const TempFolder folder;
  std::string text;
  for (int i = 0; i < 1024; ++i) text += fmt::format("{:.3f} 1\n", i / 12.0);
  const auto file = ReadText(folder, text, "{layout: points}");
  EXPECT_NEAR(1.0 / file.grid->pitch_m, 12e3, 0.2);  // an error of 1 um over the whole line
  EXPECT_EQ(file.rows[0].profile.height_m.size(), 1024U);
}

TEST(ProfileGrids, XMayFallAndTheGridHoldsAllRows) {
  const TempFolder folder;
  const auto file =
      ReadText(folder, "3,30,2,20,1,10,0,0\n5,50,4,40,3,30,2,20\n", "{layout: pairs}");
  ASSERT_EQ(file.rows[0].profile.height_m.size(), 6U);
  EXPECT_DOUBLE_EQ(1.0 / file.grid->pitch_m, 1000.0);
  EXPECT_FLOAT_EQ(file.rows[0].profile.height_m[1], 10e-3F);
  EXPECT_TRUE(std::isnan(file.rows[0].profile.height_m[5]));
  EXPECT_TRUE(std::isnan(file.rows[1].profile.height_m[0]));
  EXPECT_FLOAT_EQ(file.rows[1].profile.height_m[5], 50e-3F);
}

// ---- time and path ----

TEST(ProfileTimes, TheEncoderTellsThemWhereNoColumnDoes) {
  const TempFolder folder;
  const auto file = ReadText(folder, "0,1,2\n100,1,2\n300,1,2\n",
                             "{encoder_column: 1, encoder_mm: 0.1, feed_mm_per_s: 20}");
  ASSERT_EQ(file.rows.size(), 3U);
  EXPECT_NEAR(file.rows[2].position_m.value(), 30e-3, 1e-12);
  EXPECT_NEAR(file.rows[2].profile.time_s, 1.5, 1e-12);
  EXPECT_EQ(file.rows[2].profile.height_m.size(), 2U);
}

TEST(ProfileTimes, AGapIsToldWithItsLength) {
  const TempFolder folder;
  std::string text;
  for (const double time : {5.0, 5.1, 5.2, 6.19, 7.3, 7.4}) text += fmt::format("{},1,2\n", time);
  const auto file = ReadText(folder, text, "{time_column: 1}");
  for (const std::size_t row : {0U, 1U, 2U, 3U, 5U}) EXPECT_FALSE(file.rows[row].gap_s) << row;
  ASSERT_TRUE(file.rows[4].gap_s);
  EXPECT_NEAR(*file.rows[4].gap_s, 1.11, 1e-9);
  EXPECT_NEAR(ReadText(folder, text, "{time_column: 1, max_gap_s: 0.5}").rows[3].gap_s.value(),
              0.99, 1e-9);
}

// ---- bad input ----

struct Bad {
  std::string text;
  std::string yaml;
  std::string says;
};

TEST(BadFormats, NameTheRowTheColumnTheValueAndWhatWouldBeRight) {
  const TempFolder folder;
  const std::vector<Bad> all = {
      {"x;z\n1;2\n", "{}",
       "row 1, column 1: 'x' is not a number; a missing value is nan, - or empty; for a header use "
       "header_lines"},
      {"1;2\n3;4,5\n", "{}", "row 2, column 2: '4,5' is not a number"},
      {"1;2\n3;4,5\n", "{}", "for a decimal comma use decimal_comma"},
      {"1;2\n3;4.500,5\n", "{decimal_comma: true}", "row 2, column 2: '4.500,5' is not a number"},
      {"1,2\n3,-999.9999\n", "{}",
       "row 2, column 2: '-999.9999' is out of range; it must be from -200 to 200"},
      {"x;z\n1;2\n", "{}", "for a header use header_lines (--set file.header_lines=1)"},
      {"1;2\n3;4,5\n", "{}", "for a decimal comma use decimal_comma (--decimal-comma)"},
      {"1,2\n3,-999.9999\n", "{}",
       "it must be from -200 to 200 (min_height_mm, max_height_mm); if it stands for a missing "
       "value use no_values (--no-value -999.9999); for another unit use unit_mm (--unit um or "
       "--unit m)"},
      {"1,2\n3,-999.9999\n", "{no_values: [-999.999]}", "column 2: '-999.9999' is out of range"},
      {"1,2\n3,240\n", "{max_height_mm: 230}", "it must be from -200 to 230"},
      {"1,2,3\n", "{layout: pairs}",
       "row 1 has 3 columns; pairs of x and height need an even number"},
      {"1,2,3,4\n1,2,a,4\n", "{layout: pairs}", "row 2, column 3: 'a' is not a number"},
      {"nan,2,3,4\n", "{layout: pairs}", "row 1 has fewer than two points with a height"},
      {"0,1,1,1,2,1,1e9,1\n", "{layout: pairs}", "columns; at most 65536 are allowed"},
      {"0,1,1,1,2,1,1e9,1\n", "{layout: pairs}",
       "for another unit use unit_mm (--unit um or --unit m), for a missing value among x "
       "no_values"},
      {"1 2\n2\n", "{layout: points}", "row 1 (line 2) has 1 column, but no column 2"},
      {"1 2\n2 2\n\n1 2\n2 b\n", "{layout: points}",
       "row 2 (line 5), column 2: 'b' is not a number"},
      {"1\t2\t3\n1\t2\n", "{layout: columns}", "line 2 has 2 columns instead of 3"},
      {"1\t2\t3\n2\t2\tc\n", "{layout: columns}", "line 2, column 3: 'c' is not a number"},
      {"1\n2\n", "{layout: columns}", "line 1 has 1 column; x and a height are needed"},
      {"t,z\n1,2\n", "{header_lines: 1, time_column: time}",
       "time_column: 'time' is neither a column number, from 1, nor in the header, which has t, "
       "z"},
      {"1,2\n", "{time_column: time}", "the header, which is missing"},
      {"1,2\n", "{encoder_column: 3, first_column: 1}", "row 1 has 2 columns, but no column 3"},
      {"1,2\n-,2\n", "{time_column: 1}",
       "row 2, column 1: the number is missing; time and encoder columns need one in every row"},
      {"1.5,2,3\n1.25,2,3\n", "{time_column: 1}",
       "row 2 has time 1.25 s, the previous row 1.5 s; time must not go back"},
      {"10,2,3\n8,2,3\n", "{encoder_column: 1}",
       "row 2 is at 8 mm of the path, the previous row at 10 mm; the encoder must not go back"},
      {"a,b\n1,2\n", "{header_lines: 1, x_in_header: true}",
       "header, column 1: 'a' is not a number"},
      {"0,1,2\n1,2\n", "{header_lines: 1, x_in_header: true}",
       "row 1 (line 2) has 2 heights, but 3 x values"},
      {"1,2\n", "{axis_column: 3}", "row 1 has 2 columns; axis_column is 3"},
      {"Info\n1,2\nEnd\n", "{sections: [Profile]}", "contains no profile"},
      {"1,2\n", "{header: Frame}", "contains no profile"}};
  for (const Bad& bad : all) {
    const auto file = folder.Write("bad.csv", bad.text);
    EXPECT_THAT(ErrorOf([&] { ReadProfileFile(file, OptionsOf(bad.yaml)); }),
                AllOf(StartsWith(file.string() + ": "), HasSubstr(bad.says)))
        << bad.text << bad.yaml;
  }
}

TEST(BadFormats, PointsThatNoProfileEndsInFillNoMemory) {
  std::string text;
  for (int i = 0; i < 70'000; ++i) text += "1 2\n";
  std::istringstream in(text);
  ProfileStream stream(in, OptionsOf("{layout: points}"));
  const auto row = stream.Next();
  ASSERT_TRUE(row);
  EXPECT_THAT(row->fault, HasSubstr("row 1 has more than 65536 points; an empty line"));
}

TEST(BadFormats, ImagesNameTheirPixel) {
  const TempFolder folder;
  WriteTiff<std::int16_t>(folder / "i.tif", {{2, {0, 1, 2, 30000}}});
  WriteTiff<float>(folder / "f.tif", {{2, {0.0F, 1.0F, -999.5F, 2.0F}}});
  WriteTiff<float>(folder / "p.tif", {{2, {0.0F, 1.0F}}, {3, {1.0F, 1.0F, 1.0F}}});
  WriteTiff<std::uint8_t>(folder / "b.tif", {{2, {0, 1}}});
  folder.Write("d.tif", "II*");
  folder.Write("g.png", image::EncodePng(image::Grey16{2, 1, {32768, 62768}}));
  const auto expect = [&](const char* name, const std::string& yaml, const std::string& says) {
    EXPECT_THAT(ErrorOf([&] { ReadProfileFile(folder / name, OptionsOf(yaml)); }),
                AllOf(StartsWith((folder / name).string() + ": "), HasSubstr(says)));
  };
  expect("i.tif", "{image_scale_mm: 0.01}",
         "row 2, column 2: level 30000 is out of range; it must be from -20000 to 20000");
  expect("f.tif", "{}",
         "row 2, column 1: level -999.5 is out of range; it must be from -200 to 200");
  expect("f.tif", "{}", "if it stands for a missing value use no_values (--no-value -999.5)");
  expect("f.tif", "{}",
         "(--no-value -999.5); otherwise give image_scale_mm and image_offset_mm (--image-scale, "
         "--image-offset; now 1 mm, 0 mm)");
  expect("g.png", "{image_scale_mm: 0.01}", "--image-offset; now 0.01 mm, -327.68 mm)");
  expect("p.tif", "{}", "page 2 is 3 columns wide");
  expect("b.tif", "{}", "8-bit whole-number pixels");
  expect("d.tif", "{}", "is not a complete TIFF image");
  expect("none.tif", "{}", "cannot be read");
}

TEST(BadFormats, OptionsNameTheirKey) {
  const std::vector<std::pair<std::string, std::string>> all = {
      {"{decimal_comma: true, separator: comma}",
       "key 'decimal_comma': with commas between columns"},
      {"{header_lines: 1, header: Frame}", "key 'header': cannot be used with header_lines"},
      {"{x_in_header: true}", "key 'x_in_header': needs a header"},
      {"{encoder_mm: 0}", "key 'encoder_mm': must not be 0"},
      {"{min_height_mm: 200}", "key 'min_height_mm': must be below max_height_mm"},
      {"{no_values: [none]}", "key 'no_values': 'none' must be a number"},
      {"{layout: lines}", "key 'layout': 'lines' must be one of rows, pairs, points, columns"},
      {"{image_scale_mm: 0}", "key 'image_scale_mm': '0' must be a number from"},
      {"{unit: um}", "unknown key 'unit'"}};
  for (const auto& [yaml, says] : all) {
    EXPECT_THAT(ErrorOf([&] { OptionsOf(yaml); }), AllOf(StartsWith("o.yaml:1: "), HasSubstr(says)))
        << yaml;
  }
  EXPECT_THROW(PresetOf("gokator"), InputError);
}

// A stream skips damaged rows, including rows that go back in time, and continues.
TEST(BadFormats, AStreamGoesOnBehindThem) {
  std::istringstream in("1.0,0,5,1,6\n1.1,0,5,1,6\n0.9,0,5,1,6\n1.2,0,x,1,6\n1.3,0,5,1,6\n");
  ProfileStream stream(in, OptionsOf("{layout: pairs, time_column: 1}"));
  std::vector<ProfileRow> rows;
  while (auto row = stream.Next()) rows.push_back(*row);
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_THAT(rows[2].fault, HasSubstr("row 3 has time 0.9 s"));
  EXPECT_THAT(rows[3].fault, HasSubstr("row 4, column 3: 'x'"));
  for (const std::size_t row : {0U, 1U, 4U}) {
    EXPECT_EQ(rows[row].fault, "");
    EXPECT_EQ(rows[row].profile.height_m.size(), 2U);
  }
  EXPECT_DOUBLE_EQ(rows[4].profile.time_s, 1.3);
  EXPECT_TRUE(stream.grid());
}

}  // namespace
}  // namespace rangegrasp::seam
