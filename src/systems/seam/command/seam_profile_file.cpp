#include "seam/command/seam_profile_file.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "experiment/experiment.h"

namespace rangegrasp::cli {
namespace {

using base::InputError;
using base::YamlMap;

constexpr const char* kTextGroup = "Profiles as text (CSV)";
constexpr const char* kImageGroup = "Profiles as an image (PNG, PGM, TIFF)";
constexpr const char* kBothGroup = "Format";

// Keys that only a text has.
constexpr std::array<std::string_view, 17> kTextKeys = {
    "layout",      "separator",   "decimal_comma",  "header_lines", "header",      "sections",
    "time_column", "axis_column", "encoder_column", "x_column",     "z_column",    "profile_column",
    "x_in_header", "unit_mm",     "time_unit_s",    "encoder_mm",   "first_column"};
constexpr std::array<std::string_view, 2> kImageKeys = {"image_scale_mm", "image_offset_mm"};
// Keys of heights on an x; camera rows have neither.
constexpr std::array<std::string_view, 11> kHeightKeys = {
    "unit_mm",       "image_scale_mm", "image_offset_mm", "away",
    "min_height_mm", "max_height_mm",  "x_in_header",     "axis_column",
    "x_column",      "z_column",       "profile_column"};

constexpr const char* kPage = R"(# Formats of profiles

`rangegrasp seam detect` reads profiles of other sensors as these keys say. They stand below `file` in the YAML of `--options`, or are given
by `--set file.KEY=VALUE`; the most used have an option of their own (`rangegrasp seam detect --help`). `--preset NAME` sets those of a sensor
family first. Keys of texts do not go with images, nor the other way round: that is an error. The keys beside `file` are those of
`tracker` and `monitor` in [experiment files](experiment-file.md).

This page is made by `rangegrasp list formats` from the code that reads the files; a test compares them.

)";

bool IsImage(const std::string& file) {
  const std::string ending = base::EndingOf(file);
  return ending == ".png" || ending == ".pgm" || ending == ".tif" || ending == ".tiff";
}

// The keys of a map among `wrong` are errors.
template <typename Keys>
void Refuse(const YamlMap& map, const Keys& wrong, const std::string& why) {
  for (const std::string_view key : wrong) {
    const std::string name(key);
    if (map.Has(name)) map.Fail(name, why);
  }
}

void CheckKeys(const YamlMap& map, const ProfileFileArguments& arguments) {
  if (IsImage(arguments.profiles)) {
    Refuse(map, kTextKeys,
           "is for text; " + arguments.profiles +
               " is an image, where image_scale_mm and image_offset_mm tell what a grey level is");
  } else {
    Refuse(map, kImageKeys,
           "is for images; " + arguments.profiles + " is text, where unit_mm tells the unit");
  }
  if (!arguments.calibrated) return;
  Refuse(map, kHeightKeys, "tells of heights; with --calibration the numbers are camera rows");
}

void ReadPreset(const ProfileFileArguments& arguments, const YamlMap& file,
                seam::ProfileFileOptions& options) {
  const auto& [preset, about, yaml, needed] = seam::PresetOf(arguments.preset);
  const std::string name = "--preset " + arguments.preset;
  const std::string needs(needed);
  if (!needs.empty() && !IsImage(arguments.profiles)) {
    throw InputError(name + ": is for images; " + arguments.profiles + " is text");
  }
  auto map = YamlMap::FromText(std::string(yaml), name);
  CheckKeys(map, arguments);
  if (!needs.empty() && !file.Has(needs)) {
    throw InputError(
        fmt::format("{}: {} differs from sensor to sensor and must be given, too, e.g. "
                    "--set file.{}=0.001",
                    name, needs, needs));
  }
  seam::ReadProfileFileOptions(std::move(map), options);
}

/// A word of the command line for a key below `file`.
struct Word {
  const char* option;
  const char* key;
  const char* group;
  const char* help;
  std::vector<std::string> words = {};  ///< that it must be one of
  bool is_flag = false;
};

std::vector<Word> Words() {
  return {{"--layout", "layout", kTextGroup,
           "rows of heights, rows of x,height pairs, points "
           "x,height one a line, or columns (rows)",
           base::WordList<seam::TextLayout>()},
          {"--separator", "separator", kTextGroup, "between columns (auto)",
           base::WordList<seam::TextSeparator>()},
          {"--header-lines", "header_lines", kTextGroup,
           "lines left out first; the last names the columns (0)"},
          {"--time-column", "time_column", kTextGroup, "number, from 1, or name; times in s"},
          {"--encoder-column", "encoder_column", kTextGroup,
           "number or name; see file.encoder_mm, file.feed_mm_per_s"},
          {"--image-scale", "image_scale_mm", kImageGroup,
           "height of a grey level, mm (0.001; floating point: 1)"},
          {"--image-offset", "image_offset_mm", kImageGroup,
           "height of level 0, mm (-32768 levels; signed, floating point: 0)"},
          {"--min-height", "min_height_mm", kBothGroup, "lower is out of range, mm (-200)"},
          {"--max-height", "max_height_mm", kBothGroup, "higher is out of range, mm (200)"}};
}

void AddWord(CLI::App& command, ProfileFileArguments& arguments, const Word& word) {
  const auto take = [&arguments, key = word.key](const std::string& value) {
    arguments.words.push_back(fmt::format("file.{}={}", key, value));
  };
  auto* option = word.is_flag
                     ? command.add_flag_callback(
                           word.option, [take] { take("true"); }, word.help)
                     : command.add_option_function<std::string>(word.option, take, word.help);
  option->group(word.group);
  if (!word.words.empty()) option->check(CLI::IsMember(word.words));
}

}  // namespace

seam::ProfileFileOptions RowFileOptions() {
  seam::ProfileFileOptions options;
  options.text.scale.unit_m = 1.0;
  options.grey = {1.0 / 64.0, 0.0, {0.0}};
  options.signed_grey = {1.0 / 64.0, 0.0, {0.0}};
  options.real = {1.0, 0.0, {}};
  options.min_height_m = 0.0;
  options.max_height_m = 65535.0;
  return options;
}

CLI::Option* AddUnit(CLI::App& command, ProfileFileArguments& arguments) {
  return command
      .add_option_function<std::string>(
          "--unit",
          [&arguments](const std::string& unit) {
            const char* unit_mm = unit == "um" ? "0.001" : unit == "m" ? "1000" : "1";
            arguments.words.push_back(std::string("file.unit_mm=") + unit_mm);
          },
          "of heights and x in a text (mm)")
      ->check(CLI::IsMember({"um", "mm", "m"}))
      ->group(kTextGroup);
}

void AddFormatOptions(CLI::App& command, ProfileFileArguments& arguments) {
  std::vector<std::string> presets;
  for (const auto& preset : seam::FormatPresets()) presets.emplace_back(preset.name);
  command.add_option("--preset", arguments.preset, "format of a sensor family")
      ->check(CLI::IsMember(presets))
      ->group(kBothGroup);
  for (const Word& word : Words()) AddWord(command, arguments, word);
  command
      .add_option_function<std::vector<std::string>>(
          "--no-value",
          [&arguments](const std::vector<std::string>& values) {
            arguments.words.push_back("file.no_values=[" + base::Join(values) + "]");
          },
          "numbers that mean nothing was measured (images: 0)")
      ->allow_extra_args(false)
      ->delimiter(',')
      ->group(kBothGroup);
  AddWord(command, arguments,
          {"--decimal-comma", "decimal_comma", kTextGroup, "numbers are written 1,5", {}, true});
  AddWord(command, arguments,
          {"--away", "away", kBothGroup, "heights grow away from the sensor", {}, true});
  command
      .add_option("--set", arguments.set,
                  "KEY=VALUE over --options, e.g. monitor.window=20; keys: list formats, list keys")
      ->allow_extra_args(false)
      ->group(kBothGroup);
}

DetectOptions ReadDetectOptions(const ProfileFileArguments& arguments) {
  DetectOptions options;
  options.tracker.method = seam::DecisionMethod::kSteps;
  if (arguments.calibrated) options.file = RowFileOptions();
  std::vector<std::string> keys = arguments.words;
  keys.insert(keys.end(), arguments.set.begin(), arguments.set.end());
  auto map = arguments.options.empty() ? YamlMap::FromText("{}", "--set", keys)
                                       : YamlMap::FromFile(arguments.options, keys);
  auto file = map.Child("file", "how profiles stand in a file");
  CheckKeys(file, arguments);
  if (!arguments.preset.empty()) ReadPreset(arguments, file, options.file);
  seam::ReadProfileFileOptions(std::move(file), options.file);
  options.has_columns_per_mm = map.Has("columns_per_mm");
  seam::ReadTrackerOptions(map, options.tracker);
  seam::ReadMonitorOptions(map.Child("monitor", "what stops the head"), options.monitor);
  map.Finish();
  return options;
}

std::string ProfileKeysPage() {
  auto map = YamlMap::ForDocumentation();
  seam::ProfileFileOptions options;
  seam::ReadProfileFileOptions(map.Child("file", "how profiles stand in a file"), options);
  std::string page = kPage + experiment::KeyTable(map.Keys()) + "\n## Presets\n";
  for (const auto& preset : seam::FormatPresets()) {
    page += fmt::format(
        "\n`{}`: {}.{}\n\n```yaml{}```\n", preset.name, preset.about,
        preset.needs.empty() ? "" : fmt::format(" `{}` must be given, too.", preset.needs),
        preset.yaml);
  }
  return page;
}

}  // namespace rangegrasp::cli
