// The seam commands, run as a user would run them with their own sensor.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/file.h"
#include "base/words.h"
#include "cli/command.h"
#include "seam/grey_png.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using testing_support::ExpectRefused;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

const std::filesystem::path kSeamSource = RANGEGRASP_SOURCE_DIR;
const std::string kBase = kSeamSource / "experiments/seam_base.yaml";

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// The cells of the rows below the header.
std::vector<std::vector<std::string>> Rows(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : Lines(csv)) rows.push_back(base::Split(line, ','));
  rows.erase(rows.begin());
  return rows;
}

// x of the edge in the last packet [m].
double EdgeX(const Ran& ran) {
  const std::string element = "<edge_x_m>";
  return std::stod(ran.out.substr(ran.out.rfind(element) + element.size()));
}

// A row of 256 columns with a ripple and a step at `column`; 256 gives a row without edge.
std::string Row(int column, int step_um = 1000) {
  std::string row;
  for (int i = 0; i < 256; ++i) {
    const int um = (i >= column ? step_um : 0) + (i * 37 % 11) * 3;
    row += (i > 0 ? "," : "") + std::to_string(um);
  }
  return row + "\n";
}

// A CSV of profiles as a 16-bit image.
std::string PngOf(const std::string& csv, double levels_per_unit, double zero) {
  std::vector<std::vector<double>> rows;
  for (const std::string& line : Lines(csv)) {
    auto& row = rows.emplace_back();
    for (const std::string& cell : base::Split(line, ',')) row.push_back(std::stod(cell));
  }
  return seam::GreyPng(rows, levels_per_unit, zero);
}

class SeamTest : public testing::Test {
 protected:
  std::string File(const std::string& name) const { return folder_ / name; }
  // Runs `seam detect` with the options that fit the rows of Row().
  Ran Detect(std::vector<std::string> more, const std::string& in = "/dev/null") {
    more.insert(more.begin(), {"seam", "detect"});
    more.insert(more.end(), {"--unit", "um"});
    return RunProgram(more, "", in);
  }
  TempFolder folder_;
};

TEST_F(SeamTest, DetectsTheEdgeOfRecordedProfiles) {
  std::string text;
  for (int i = 0; i < 10; ++i) text += Row(120);
  const std::string file = folder_.Write("p.csv", text);
  for (const char* method : {"voting", "weights"}) {
    const Ran ran = Succeeded(Detect({file, "--method", method}));
    const auto lines = Lines(ran.out);
    ASSERT_EQ(lines.size(), 11U);
    EXPECT_THAT(lines[0], StartsWith("profile,time_s,status,column,"));
    EXPECT_THAT(lines[10], StartsWith("10,0.1452,edge,120.00,")) << method;
  }
}

TEST_F(SeamTest, TracksStepsUnlessToldOtherwise) {
  const std::string file = folder_.Write("p.csv", Row(100) + Row(100) + Row(100));
  const std::string said = Detect({file}).out;
  EXPECT_EQ(said, Detect({file, "--method", "steps"}).out);
  EXPECT_NE(said, Detect({file, "--method", "voting"}).out);
  EXPECT_EQ(Detect({file, "--set", "method=voting"}).out, Detect({file, "--method", "voting"}).out);
}

TEST_F(SeamTest, OfALineWithTooFewColumnsForTrackedStepsTheCureIsNamed) {
  const std::string file = folder_.Write("p.csv", Row(100) + Row(100));
  ExpectRefused({"seam", "detect", file, "--unit", "um", "--columns-per-mm", "1"},
                "need 1.33 columns per mm, the line has 1.00; use method voting or weights");
  EXPECT_EQ(Detect({file, "--columns-per-mm", "1.34"}).code, 0);
  EXPECT_EQ(Detect({file, "--columns-per-mm", "1", "--method", "voting"}).code, 0);
}

TEST_F(SeamTest, JsonHasOneObjectAProfile) {
  const std::string file = folder_.Write("p.csv", Row(100) + Row(100) + Row(100));
  const Ran ran = Succeeded(Detect({file, "--json", "--method", "voting"}));
  const auto lines = Lines(ran.out);
  ASSERT_EQ(lines.size(), 3U);
  const auto json = nlohmann::json::parse(lines[2]);
  EXPECT_EQ(json["profile"], 3);
  EXPECT_EQ(json["status"], "edge");
  EXPECT_EQ(json["column"], 100.0);
  EXPECT_EQ(json["detectors"]["Gradient-Accumulation"], 100);
}

TEST_F(SeamTest, AStreamWithDamagedRowsGoesOn) {
  const std::string in =
      folder_.Write("in", Row(90) + "1,2,3\n" + Row(90) + Row(90) + "x" + Row(90) + Row(90))
          .string();
  const Ran ran = Succeeded(Detect({"-"}, in));
  EXPECT_THAT(ran.err, HasSubstr("row 2 has 3 columns instead of 256"));
  EXPECT_THAT(ran.err, HasSubstr("row 5, column 1: 'x0' is not a number"));
  const auto lines = Lines(ran.out);
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_THAT(lines[4], StartsWith("6,0.0806,edge,90.0"));
}

TEST_F(SeamTest, BadProfilesAreNamedWithTheirRow) {
  ExpectRefused({"seam", "detect", folder_.Write("r.csv", "1,2,3\n1,2\n")}, "row 2");
  ExpectRefused({"seam", "detect", folder_.Write("e.csv", "")}, "e.csv");
  ExpectRefused({"seam", "detect", File("none.png")}, "none.png");
  ExpectRefused({"seam", "detect", folder_.Write("s.csv", "1,2,3\n")}, "32");
  ExpectRefused({"seam", "detect", "-"}, "stdin");
  const std::string file = folder_.Write("p.csv", Row(90));
  ExpectRefused({"seam", "detect", file}, "row 1");  // 1,000 mm: out of range
  ExpectRefused({"seam", "detect", file, "--method", "accumulated"}, "voting,weights,steps");
  ExpectRefused({"seam", "detect", file, "--columns-per-mm", "0"}, "--columns-per-mm");
  ExpectRefused({"seam", "detect", file, "--options", File("none.yaml")}, "none.yaml");
  ExpectRefused({"seam", "detect", file, "--calibration", File("none.yaml")}, "none.yaml");
}

TEST_F(SeamTest, OptionsThatContradictEachOtherAreRefused) {
  const std::string file = folder_.Write("p.csv", Row(90));
  const std::string options = folder_.Write("o.yaml", "columns_per_mm: 12\n");
  ExpectRefused({"seam", "detect", file, "--options", options, "--columns-per-mm", "18"},
                "--options excludes --columns-per-mm");
  for (const std::vector<std::string>& other :
       {std::vector<std::string>{"--columns-per-mm", "18"}, {"--unit", "um"}}) {
    ExpectRefused({"seam", "detect", file, "--calibration", "c.yaml", other[0], other[1]},
                  other[0] + " excludes --calibration");
  }
  const std::string image = folder_.Write("s.png", PngOf("1,2\n", 1000.0, 32768.0));
  ExpectRefused({"seam", "detect", image, "--unit", "um"}, "its grey levels");
  ExpectRefused({"seam", "detect", file, "--xml", "--json"}, "excludes");
}

TEST_F(SeamTest, APictureIsSvgAndNoOtherFile) {
  const std::string file = folder_.Write("p.csv", Row(90));
  ExpectRefused({"seam", "detect", file, "--unit", "um", "--picture", File("p.png")},
                "p.png: unsupported file type; the name must end with .svg");
  EXPECT_FALSE(std::filesystem::exists(File("p.png")));
}

TEST_F(SeamTest, ASingleProfileIsAnswered) {
  for (const char* method : {"voting", "weights"}) {
    const Ran ran = Succeeded(Detect({folder_.Write("p.csv", Row(90)), "--method", method}));
    EXPECT_THAT(Lines(ran.out).back(), StartsWith("1,0.0000,edge,90.00,")) << method;
  }
  const Ran flat = Detect({folder_.Write("f.csv", Row(256)), "--method", "weights"});
  EXPECT_THAT(Lines(flat.out).back(), StartsWith("1,0.0000,no_edge,"));
}

TEST_F(SeamTest, AStreamThatIsJoinedInTheMiddleOfARowGoesOn) {
  const std::string in = folder_.Write("in", Row(90).substr(300) + Row(90) + Row(90) + Row(90));
  const Ran ran = Succeeded(Detect({"-"}, in));
  EXPECT_THAT(ran.err, HasSubstr("instead of 256"));
  EXPECT_THAT(Lines(ran.out).back(), StartsWith("4,0.0484,edge,90.0"));
}

TEST_F(SeamTest, HeightsWithACalibrationAreNamed) {
  const std::string calibration =
      folder_.Write("c.yaml",
                    "columns: 256\nrow_min_px: 2000\nrow_max_px: 3000\nheight_0_m: -0.01\n"
                    "height_1_m: 0.01\nheight_2_m: 0\nheight_3_m: 0\nheight_4_m: 0\n"
                    "meters_per_column: 0.0001\nmeters_per_column_per_m: -0.0005\n");
  const std::string file = folder_.Write("p.csv", Row(120) + Row(120));
  EXPECT_THAT(Succeeded(RunProgram({"seam", "detect", file, "--calibration", calibration})).err,
              HasSubstr(file + ": no value lies in the calibration's rows 2000 to 3000: are these "
                               "heights? Then leave --calibration out"));
}

// Rows 0 to 100 are heights from -20 to 0 mm. At -15 mm a column is 7.5 % wider.
TEST_F(SeamTest, XAndPacketsTakeTheHeightFromTheCalibration) {
  const std::string calibration =
      folder_
          .Write("c.yaml",
                 "columns: 256\nrow_min_px: 0\nrow_max_px: 100\nheight_0_m: -0.01\n"
                 "height_1_m: 0.01\nheight_2_m: 0\nheight_3_m: 0\nheight_4_m: 0\n"
                 "meters_per_column: 0.0001\nmeters_per_column_per_m: -0.0005\n")
          .string();
  std::string row;
  for (int i = 0; i < 256; ++i) row += fmt::format("{},", i >= 200 ? 26.0 : 24.0 + 0.1 * (i % 3));
  std::string text;
  for (int i = 0; i < 20; ++i) text += row + "\n";
  const std::string file = folder_.Write("r.csv", text);
  const double wanted_m = (200.0 - 127.5) * 1.075e-4;
  const std::vector<std::string> detect = {"seam",      "detect",   file,    "--calibration",
                                           calibration, "--method", "voting"};
  const auto with = [&](const char* output) {
    auto arguments = detect;
    arguments.emplace_back(output);
    return RunProgram(arguments);
  };
  const Ran json = Succeeded(with("--json"));
  EXPECT_THAT(json.err, testing::Not(HasSubstr("no value lies")));
  const auto reading = nlohmann::json::parse(Lines(json.out).back());
  EXPECT_EQ(reading["column"], 200.0);
  EXPECT_NEAR(reading["x_m"], wanted_m, 2e-3 * wanted_m);  // either side of the 0.4 mm step
  const Ran xml = with("--xml");
  EXPECT_NEAR(EdgeX(xml), wanted_m, 2e-3 * wanted_m);
}

TEST_F(SeamTest, TheMonitorIsSetByTheOptions) {
  std::string text;
  for (int i = 0; i < 16; ++i) text += Row(i < 3 ? 90 : 256);
  const std::string file = folder_.Write("p.csv", text);
  const std::string monitor = "monitor: {window: 6, mat_end_profiles: 3}\n";
  const Ran early = Succeeded(Detect({file, "--options", folder_.Write("o.yaml", monitor)}));
  EXPECT_THAT(Lines(early.out).back(), testing::EndsWith(",mat_end"));
  EXPECT_THAT(Lines(Detect({file}).out).back(), testing::EndsWith(","));
  ExpectRefused(
      {"seam", "detect", file, "--options", folder_.Write("b.yaml", "monitor: {window: 2}\n")},
      "b.yaml:1: key 'window'");
}

// The edge falls from 1.2 to 0.35 mm: less than 0.4 of its usual height, but more than 0.3 mm.
TEST_F(SeamTest, AsPublishedAnEdgeOfMoreThan03MmIsNoMatEnd) {
  std::string text;
  for (int i = 0; i < 90; ++i) text += Row(120, i < 60 ? 1200 : 350);
  const std::string file = folder_.Write("p.csv", text);
  for (const char* method : {"voting", "weights"}) {
    const Ran ran = Succeeded(Detect({file, "--method", method}));
    EXPECT_THAT(ran.out, testing::Not(HasSubstr("mat_end"))) << method;
  }
}

TEST_F(SeamTest, APictureOfAProfileThatIsNotThereIsRefused) {
  const std::string file = folder_.Write("p.csv", Row(90) + Row(90));
  EXPECT_EQ(Detect({file, "--picture", File("p.svg"), "--picture-row", "2"}).code, 0);
  EXPECT_THAT(base::ReadFile(File("p.svg")), HasSubstr("Gradient-Accumulation"));
  const Ran ran = Detect({file, "--picture", File("q.svg"), "--picture-row", "3"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("there are only 2 profiles"));
}

// ---- heights that look wrong ----

TEST_F(SeamTest, AStepInTheOtherDirectionIsNamedWithBothCures) {
  std::string edges, flat;
  for (int i = 0; i < 10; ++i) {
    edges += Row(120);
    flat += Row(256);
  }
  const std::string file = folder_.Write("p.csv", edges);
  EXPECT_EQ(Succeeded(Detect({file})).err, "");
  EXPECT_EQ(Succeeded(Detect({file, "--away", "--negative"})).err, "");
  EXPECT_THAT(
      Succeeded(Detect({file, "--away"})).err,
      HasSubstr(file + ": in 10 of 10 profiles the largest step falls with the column number, but "
                       "a rising one is searched: no --away (file.away: false) if heights grow "
                       "towards the sensor, or --negative if the high mat is at the small"));
  EXPECT_THAT(
      Succeeded(Detect({"-", "--negative"}, file)).err,
      HasSubstr("stdin: in 10 of 10 profiles the largest step rises with the column number, "
                "but a falling one is searched: --away if heights grow away from the "
                "sensor, or no --negative (positive_edge: true)"));
  EXPECT_EQ(Succeeded(Detect({folder_.Write("f.csv", flat), "--away"})).err, "");
}

TEST_F(SeamTest, AGeneratedSeamOfTheWrongSignIsNamed) {
  ASSERT_EQ(RunProgram({"seam", "generate", kBase, "--seam", "3", "-o", File("s.csv")}).code, 0);
  const std::string says = "is searched";
  EXPECT_THAT(RunProgram({"seam", "detect", File("s.csv")}).err, testing::Not(HasSubstr(says)));
  EXPECT_THAT(RunProgram({"seam", "detect", File("s.csv"), "--away"}).err, HasSubstr(says));
}

TEST_F(SeamTest, HeightsThatSpanLessThanNoiseAreNamedWithTheUnit) {
  const std::string file = folder_.Write("p.csv", Row(120) + Row(120));
  EXPECT_THAT(Succeeded(Detect({file, "--set", "file.unit_mm=1e-6"})).err,
              HasSubstr(file + ": heights span only 0.001 mm: is their unit right (--unit m)?"));
}

TEST_F(SeamTest, ZerosFarFromAllOtherHeightsAreNamed) {
  std::string row;  // um; a tenth is not measured
  for (int i = 0; i < 256; ++i) {
    row += fmt::format("{},", i % 10 == 3 ? 0 : (i >= 120 ? 81'000 : 80'000) + i % 7);
  }
  const std::string file = folder_.Write("p.csv", row + "\n" + row + "\n");
  EXPECT_THAT(Succeeded(Detect({file})).err,
              HasSubstr(file + ": 10 % of the heights are exactly 0, the others 80 to 81.01 mm: "
                               "--no-value 0 if 0 stands for a missing value"));
  EXPECT_EQ(Succeeded(Detect({file, "--no-value", "0"})).err, "");
}

TEST_F(SeamTest, TimesInMillisecondsAreNamed) {
  const auto times = [&](const char* name, const std::vector<double>& column) {
    std::string text;
    for (const double time : column) text += fmt::format("{},", time) + Row(120);
    return folder_.Write(name, text).string();
  };
  const std::string ms = times("ms.csv", {0, 20, 40, 60});
  const auto warnings = [&](const std::string& file, const std::string& set) {
    return Succeeded(Detect({file, "--set", "file.time_column=1", "--set", set})).err;
  };
  EXPECT_THAT(warnings(ms, "file.time_unit_s=1"),
              HasSubstr(ms + ": 20 s between profiles: is the time in s (--set "
                             "file.time_unit_s=0.001 if it is in ms)?"));
  EXPECT_EQ(warnings(ms, "file.time_unit_s=0.001"), "");
  // A pause is not the usual interval.
  EXPECT_THAT(warnings(times("s.csv", {0, 0.02, 0.04, 20}), "file.time_unit_s=1"),
              testing::Not(HasSubstr("is the time in s")));
}

// ---- formats of other sensors ----

TEST_F(SeamTest, ASensorThatExportsItsOwnFormatIsReadByItsPreset) {
  std::string text = "Profile\nFrame Count\n5\nFrame,Time,Encoder,Axis";
  for (int i = 0; i < 256; ++i) text += fmt::format(",{:.2f}", 50.0 + 0.1 * i);
  text += "\n";
  for (int k = 0; k < 5; ++k) {
    text += fmt::format("{},{},{},Z", k, 16000 * k, 7 * k);
    for (int i = 0; i < 256; ++i) text += i >= 120 ? ",31.0" : i % 9 == 4 ? "," : ",30.0";
    text += "\n";
  }
  const std::string file = folder_.Write("g.csv", text + "End\n");
  const std::vector<std::string> detect = {"seam",    "detect",   file,    "--preset",
                                           "gocator", "--method", "voting"};
  const Ran ran = Succeeded(RunProgram(detect));
  EXPECT_THAT(Lines(ran.out).back(), StartsWith("5,0.0640,edge,120.00,62.0000,"));
  // Columns are 0.1 mm apart and start at x = 50 mm.
  auto encoder = detect;
  encoder.insert(encoder.end(), {"--set", "file.encoder_column=Encoder", "--set",
                                 "file.encoder_mm=0.5", "--json"});
  const Ran with = Succeeded(RunProgram(encoder));
  const auto json = nlohmann::json::parse(Lines(with.out).back());
  EXPECT_NEAR(json["x_m"], 62e-3, 1e-9);
  EXPECT_NEAR(json["position_m"], 14e-3, 1e-9);
}

TEST_F(SeamTest, TheLastPointOfARowMayBeMissingWhereTheHeaderGivesX) {
  std::string text = "Profile\nFrame Count\n3\nFrame,Time,Encoder,Axis";
  for (int i = 0; i < 256; ++i) text += fmt::format(",{:.2f}", 0.1 * i);
  text += "\n";
  for (int k = 0; k < 3; ++k) {
    text += fmt::format("{},{},0,Z", k, 16000 * k);
    for (int i = 0; i < 255; ++i) text += i >= 120 ? ",31.0" : ",30.0";
    text += k < 2 ? ",\n" : ",31.0\n";
  }
  const std::string file = folder_.Write("g.csv", text + "End\n");
  const Ran ran =
      Succeeded(RunProgram({"seam", "detect", file, "--preset", "gocator", "--method", "voting"}));
  EXPECT_THAT(Lines(ran.out).back(), StartsWith("3,0.0320,edge,120.00,"));
}

TEST_F(SeamTest, PacketsTellTheSensorsOwnX) {
  std::string text;
  for (int k = 0; k < 20; ++k) {
    for (int i = 0; i < 256; ++i) text += fmt::format("{} {}\n", 50.0 + 0.1 * i, i >= 120 ? 1 : 0);
    text += "\n";
  }
  const std::string file = folder_.Write("p.txt", text);
  const Ran ran = Succeeded(RunProgram({"seam", "detect", file, "--layout", "points", "--xml"}));
  EXPECT_NEAR(EdgeX(ran), 62e-3, 1e-4);
}

TEST_F(SeamTest, AGapInTimeIsAnOutageThatIsNamed) {
  std::string text;
  for (const double time_s : {1.0, 1.02, 1.04, 2.04, 2.06})
    text += fmt::format("{},", time_s) + Row(90);
  const std::string file = folder_.Write("p.csv", text);
  const Ran ran = Succeeded(Detect({file, "--set", "file.time_column=1"}));
  EXPECT_THAT(ran.err, HasSubstr("row 4 (line 4): 1.000 s after the previous row: an outage"));
  const auto lines = Lines(ran.out);
  EXPECT_THAT(lines[4], testing::EndsWith(",outage"));
  EXPECT_THAT(lines[5], StartsWith("5,2.0600,edge,90.0"));
  EXPECT_THAT(lines[5], testing::EndsWith(","));
  const Ran patient = Detect({file, "--set", "file.time_column=1", "--set", "file.max_gap_s=1.5"});
  EXPECT_THAT(patient.err, testing::Not(HasSubstr("outage")));
}

TEST_F(SeamTest, APacketTellsOfAGapThatItsRowDoesNotShow) {
  std::string text;
  double time_s = 0.0;
  for (int i = 0; i < 120; ++i) {
    time_s += i == 45 || i == 85 ? 0.06 : 0.005;  // some rows before a packet is due
    text += fmt::format("{:.3f},", time_s) + Row(90);
  }
  const std::string file = folder_.Write("p.csv", text);
  const Ran ran = Succeeded(Detect({file, "--set", "file.time_column=1", "--xml"}));
  std::size_t outages = 0;
  for (std::size_t at = 0; (at = ran.out.find("outage", at)) != std::string::npos; ++at) ++outages;
  EXPECT_EQ(outages, 2U) << ran.out;
}

TEST_F(SeamTest, FormatsThatDoNotFitAreRefused) {
  const std::string text = folder_.Write("p.csv", Row(90));
  ExpectRefused({"seam", "generate", kBase, "-o", File("s.tif")},
                "profiles are written as .csv or .txt");
  const std::string image = folder_.Write("s.png", PngOf("1,2\n", 1000.0, 32768.0));
  const auto refused = [&](std::vector<std::string> arguments, const std::string& says) {
    arguments.insert(arguments.begin(), {"seam", "detect"});
    ExpectRefused(arguments, says);
  };
  refused({image, "--unit", "um"}, "file.unit_mm: key 'unit_mm': is for text; " + image);
  refused({image, "--layout", "pairs"}, "key 'layout': is for text");
  refused({image, "--preset", "gocator"}, "--preset gocator:");
  refused({image, "--preset", "sick"}, "--preset sick: image_scale_mm differs between sensors");
  refused({text, "--preset", "sick", "--image-scale", "1"}, "key 'image_scale_mm': is for images");
  refused({text, "--preset", "keyence"}, "--preset keyence: ");
  refused({text, "--preset", "other"}, "--preset");
  refused({text, "--image-offset", "1"}, "key 'image_offset_mm': is for images; " + text);
  refused({text, "--decimal-comma", "--set", "file.separator=comma"}, "key 'decimal_comma'");
  refused({text, "--set", "file.separator=dot"}, "key 'separator'");
  refused({text, "--set", "file.header_lines=two"},
          "key 'header_lines': 'two' must be a whole number");
  refused({text, "--no-value", "none"}, "key 'no_values': 'none' must be a number");
  refused({text, "--set", "file.max_height_mm=-300"},
          "key 'min_height_mm': must be below max_height_mm");
  refused({text, "--set", "file.time_column=Time"}, text + ": time_column: 'Time' is neither");
  refused({text, "--set", "file.layouts=pairs"}, "unknown key 'layouts'");
  refused({text, "--set", "monitor.windows=3"}, "unknown key 'windows'");
  refused({text, "--set", "monitor.window=20"},
          "20 must not be shorter than obstacle_profiles (3) or mat_end_profiles (24)");
  refused({text, "--set", "layout"}, "must be KEY=VALUE");
  refused({text, "--columns-per-mm", "10", "--set", "columns_per_mm=12"},
          "--columns-per-mm excludes");
  for (const char* key : {"image_scale_mm", "away", "min_height_mm"}) {
    refused({image, "--calibration", "c.yaml", "--set", std::string("file.") + key + "=true"},
            std::string("key '") + key + "': is for heights; with --calibration");
  }
}

TEST_F(SeamTest, EveryKeyIsReachedFromTheCommandLine) {
  std::string text;
  for (int i = 0; i < 16; ++i) text += Row(i < 3 ? 90 : 256);
  const std::string file = folder_.Write("p.csv", text);
  const Ran ran = Succeeded(Detect({file, "--set", "monitor.window=6", "--set",
                                    "monitor.mat_end_profiles=3", "--set", "packet_period_ms=50"}));
  EXPECT_THAT(Lines(ran.out).back(), testing::EndsWith(",mat_end"));
  const std::string options = folder_.Write("o.yaml", "file: {unit_mm: 0.001, away: true}\n");
  const Ran turned =
      Succeeded(RunProgram({"seam", "detect", file, "--options", options, "--negative"}));
  EXPECT_THAT(Lines(turned.out)[3], StartsWith("3,0.0323,edge,"));
  ExpectRefused(
      {"seam", "detect", file, "--options", folder_.Write("b.yaml", "file:\n  layout: lines\n")},
      "b.yaml:2: key 'layout': 'lines' must be one of rows, pairs, points, columns");
}

TEST_F(SeamTest, WhatIsGeneratedIsDetectedInEveryFormat) {
  ASSERT_EQ(RunProgram({"seam", "generate", kBase, "--seam", "3", "-o", File("s.csv")}).code, 0);
  folder_.Write("s.png", PngOf(base::ReadFile(File("s.csv")), 1000.0, 32768.0));
  for (const char* name : {"s.csv", "s.png"}) {
    const Ran ran = Succeeded(RunProgram({"seam", "detect", File(name)}));
    const auto readings = Rows(ran.out);
    const auto labels = Rows(base::ReadFile(File("s.labels.csv")));
    ASSERT_EQ(labels.size(), readings.size()) << name;
    // On an uneven mat at least nine tenths of the edges are found near their labels.
    int near = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const std::string& column = readings[i].at(3);
      const double label = std::stod(labels[i].at(1));
      near += !column.empty() && std::abs(std::stod(column) - label) <= 12.0 ? 1 : 0;
    }
    EXPECT_GT(near, static_cast<int>(0.9 * static_cast<double>(labels.size()))) << name;
  }
}

// Whether two rows have the same status and about the same edge. Heights in metres are at 12
// columns per mm; a calibration also widens the columns with their distance, which moves the edge
// by up to 0.12 mm.
bool IsSameReading(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  if (a.at(2) != b.at(2)) return false;
  const auto near = [&](std::size_t cell, double bound) {
    return std::abs(std::stod(a.at(cell)) - std::stod(b.at(cell))) <= bound;
  };
  return a.at(2) != "edge" || (near(3, 0.5) && near(4, 0.2) && near(5, 0.05));
}

// Compares the rows below the header. Nearly all of them must have the same readings.
void ExpectSameReadings(const Ran& ran, const Ran& other) {
  const auto a = Rows(ran.out);
  const auto b = Rows(other.out);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_GT(std::ranges::count(a, "edge", [](const auto& row) { return row.at(2); }), 100);
  int same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) same += IsSameReading(a[i], b[i]) ? 1 : 0;
  EXPECT_GT(same, static_cast<int>(0.98 * static_cast<double>(a.size())));
}

TEST_F(SeamTest, RawRowsAndTheirCalibrationGiveTheSameReadings) {
  ASSERT_EQ(RunProgram({"seam", "generate", kBase, "--seam", "4", "-o", File("m.csv")}).code, 0);
  ASSERT_EQ(
      RunProgram({"seam", "generate", kBase, "--seam", "4", "--raw", "-o", File("r.csv")}).code, 0);
  const Ran metres = RunProgram({"seam", "detect", File("m.csv")});
  ExpectSameReadings(metres, Succeeded(RunProgram({"seam", "detect", File("r.csv"), "--calibration",
                                                   File("r.calibration.yaml")})));
}

TEST_F(SeamTest, ACalibrationFromScansOfTheBodyIsTheSensors) {
  ASSERT_EQ(
      RunProgram({"seam", "generate", kBase, "--seam", "4", "--raw", "-o", File("r.csv")}).code, 0);
  ASSERT_EQ(RunProgram({"seam", "generate", kBase, "--body", "-o", File("body.csv")}).code, 0);
  folder_.Write("body.png", PngOf(base::ReadFile(File("body.csv")), 64.0, 0.0));
  for (const char* name : {"body.csv", "body.png"}) {
    const Ran ran = Succeeded(RunProgram({"seam", "calibrate", File(name), "--bases",
                                          File("body.bases.csv"), "-o", File("c.yaml")}));
    EXPECT_THAT(ran.err, HasSubstr("12.0"));  // columns per mm
    EXPECT_THAT(ran.err, testing::ContainsRegex("residual 0[.]0[0-9]+ mm rms"));
    const Ran with = RunProgram({"seam", "detect", File("r.csv"), "--calibration", File("c.yaml")});
    const Ran known =
        RunProgram({"seam", "detect", File("r.csv"), "--calibration", File("r.calibration.yaml")});
    ExpectSameReadings(with, known);
  }
  folder_.Write("few.csv", "scan,base_mm\n1,0\n");
  ExpectRefused(
      {"seam", "calibrate", File("body.csv"), "--bases", File("few.csv"), "-o", File("d")},
      "few.csv: has the heights of 1 scan,");
  folder_.Write("bad.csv", "scan,base_mm\n1,low\n");
  ExpectRefused(
      {"seam", "calibrate", File("body.csv"), "--bases", File("bad.csv"), "-o", File("d")},
      "bad.csv:2: column 'base_mm': 'low'");
  std::vector<std::string> swapped = Lines(base::ReadFile(File("body.bases.csv")));
  std::swap(swapped.at(1), swapped.at(3));
  folder_.Write("swapped.csv", base::Join(swapped, "\n") + "\n");
  ExpectRefused(
      {"seam", "calibrate", File("body.csv"), "--bases", File("swapped.csv"), "-o", File("d")},
      "(the heights of the body's base are from " + File("swapped.csv") + ")");
  ExpectRefused({"seam", "calibrate", File("body.csv"), "--bases", File("body.bases.csv"),
                 "--step-heights-mm", "0,4,9", "-o", File("d")},
                "body.csv: ");
  ExpectRefused({"seam", "calibrate", File("body.csv"), "--bases", File("body.bases.csv"),
                 "--step-heights-mm", "0,4,10,18,10,4,0", "-o", File("d")},
                "body.csv: the scans do not fit steps of 0,4,10,18,10,4,0 mm (residual 2.9 mm): "
                "check --step-heights-mm and --bases");
  EXPECT_FALSE(std::filesystem::exists(File("d")));
}

TEST_F(SeamTest, AnOutputThatCannotBeMadeIsNamedBeforeTheWork) {
  const std::string below = folder_.Write("file", "") / "below";
  ExpectRefused({"seam", "generate", kBase, "-o", below + "/p.csv"}, below);
  ExpectRefused({"seam", "generate", File("none.yaml"), "-o", File("p.csv")}, "none.yaml");
}

TEST(SeamHelp, EveryCommandHasAnExampleOfItself) {
  for (const std::string command : {"generate", "calibrate", "detect"}) {
    const Ran ran = Succeeded(RunProgram({"seam", command, "--help"}));
    EXPECT_THAT(ran.out, HasSubstr("Example: rangegrasp seam " + command));
    EXPECT_EQ(RunProgram({"seam", command}).code, 2);
  }
}

}  // namespace
}  // namespace rangegrasp
