#include "seam/command/seam_detect.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/draw/plot.h"
#include "base/error.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/output.h"
#include "seam/calibration.h"
#include "seam/monitor.h"
#include "seam/profile_io.h"
#include "seam/step_track.h"
#include "seam/stitching/closed_loop.h"
#include "seam/task/seam_task.h"
#include "seam/tracker.h"

namespace rangegrasp::cli {
namespace {

using base::InputError;
using base::YamlMap;
using nlohmann::ordered_json;

constexpr const char* kTextGroup = "Profiles as text (CSV)";
constexpr const char* kImageGroup = "Profiles as an image (PNG, TIFF)";
constexpr const char* kBothGroup = "Format";

// ---- the format of profiles ----

// Keys that apply only to text.
constexpr std::array<std::string_view, 16> kTextKeys = {
    "layout",      "separator",   "decimal_comma",  "header_lines", "header",         "sections",
    "time_column", "axis_column", "encoder_column", "z_column",     "profile_column", "x_in_header",
    "unit_mm",     "time_unit_s", "encoder_mm",     "first_column"};
constexpr std::array<std::string_view, 2> kImageKeys = {"image_scale_mm", "image_offset_mm"};
// Keys for heights and x; camera rows have neither.
constexpr std::array<std::string_view, 10> kHeightKeys = {
    "unit_mm",       "image_scale_mm", "image_offset_mm", "away",     "min_height_mm",
    "max_height_mm", "x_in_header",    "axis_column",     "z_column", "profile_column"};

// Source of the profiles, the user's options for their format, and what to do with them.
struct DetectArguments {
  std::string profiles;  // "-": stdin
  std::string options;   // YAML
  std::string preset;
  std::vector<std::string> words;  // KEY=VALUE each, from separate options; override the file
  std::vector<std::string> set;    // KEY=VALUE each, override both
  std::string calibration, method, picture;
  std::optional<double> columns_per_mm;
  int picture_row = 1;
  double rate_hz = 62.0;
  bool negative = false, json = false, xml = false;

  bool IsCalibrated() const { return !calibration.empty(); }  // numbers are camera rows
};

// Fails if the map has one of the keys `wrong`.
void Refuse(const YamlMap& map, std::span<const std::string_view> wrong, const std::string& why) {
  for (const std::string_view key : wrong) {
    const std::string name(key);
    if (map.Has(name)) map.Fail(name, why);
  }
}

void CheckKeys(const YamlMap& map, const DetectArguments& arguments) {
  if (seam::IsImageFile(arguments.profiles)) {
    Refuse(map, kTextKeys,
           "is for text; " + arguments.profiles +
               " is an image; use image_scale_mm and image_offset_mm for its grey levels");
  } else {
    Refuse(map, kImageKeys,
           "is for images; " + arguments.profiles + " is text; use unit_mm for its unit");
  }
  if (!arguments.IsCalibrated()) return;
  Refuse(map, kHeightKeys, "is for heights; with --calibration the numbers are camera rows");
}

void ReadPreset(const DetectArguments& arguments, const YamlMap& file,
                seam::ProfileFileOptions& options) {
  const auto& [preset, about, yaml, needed] = seam::PresetOf(arguments.preset);
  const std::string name = "--preset " + arguments.preset;
  const std::string needs(needed);
  if (!needs.empty() && !seam::IsImageFile(arguments.profiles)) {
    throw InputError(name + ": is for images; " + arguments.profiles + " is text");
  }
  auto map = YamlMap::FromText(std::string(yaml), name);
  CheckKeys(map, arguments);
  if (!needs.empty() && !file.Has(needs)) {
    throw InputError(fmt::format(
        "{}: {} differs between sensors and must also be given, e.g. --set file.{}=0.001", name,
        needs, needs));
  }
  seam::ReadProfileFileOptions(std::move(map), options);
}

void SetKey(DetectArguments& arguments, const std::string& key, const std::string& value) {
  arguments.words.push_back(fmt::format("file.{}={}", key, value));
}

// Adds an option for a key below `file`.
CLI::Option* AddKey(CLI::App& command, DetectArguments& arguments, const char* option,
                    const char* key, const char* group, const char* help) {
  const auto set = [&arguments, key](const std::string& value) { SetKey(arguments, key, value); };
  return command.add_option_function<std::string>(option, set, help)->group(group);
}

void AddKeyFlag(CLI::App& command, DetectArguments& arguments, const char* option, const char* key,
                const char* group, const char* help) {
  const auto set = [&arguments, key] { SetKey(arguments, key, "true"); };
  command.add_flag_callback(option, set, help)->group(group);
}

CLI::Option* AddUnit(CLI::App& command, DetectArguments& arguments) {
  const auto set = [&arguments](const std::string& unit) {
    SetKey(arguments, "unit_mm", unit == "um" ? "0.001" : unit == "m" ? "1000" : "1");
  };
  return command
      .add_option_function<std::string>("--unit", set, "unit of heights and x in a text file (mm)")
      ->check(CLI::IsMember({"um", "mm", "m"}))
      ->group(kTextGroup);
}

void AddTextOptions(CLI::App& command, DetectArguments& arguments) {
  AddKey(command, arguments, "--layout", "layout", kTextGroup,
         "rows of heights, rows of x,height pairs, one point x,height per line, or columns (rows)")
      ->check(CLI::IsMember(base::WordList<seam::TextLayout>()));
  AddKeyFlag(command, arguments, "--decimal-comma", "decimal_comma", kTextGroup,
             "numbers have a decimal comma: 1,5");
}

void AddFormatOptions(CLI::App& command, DetectArguments& arguments) {
  std::vector<std::string> presets;
  for (const auto& preset : seam::FormatPresets()) presets.emplace_back(preset.name);
  command.add_option("--preset", arguments.preset, "format of a sensor family")
      ->check(CLI::IsMember(presets))
      ->group(kBothGroup);
  AddTextOptions(command, arguments);
  AddKey(command, arguments, "--image-scale", "image_scale_mm", kImageGroup,
         "height of a grey level, mm (0.001; floating point: 1)");
  AddKey(command, arguments, "--image-offset", "image_offset_mm", kImageGroup,
         "height of level 0, mm (-32768 levels; signed, floating point: 0)");
  const auto set_no_values = [&arguments](const std::vector<std::string>& values) {
    SetKey(arguments, "no_values", "[" + base::Join(values) + "]");
  };
  command
      .add_option_function<std::vector<std::string>>(
          "--no-value", set_no_values, "numbers that stand for missing values (images: 0)")
      ->allow_extra_args(false)
      ->delimiter(',')
      ->group(kBothGroup);
  AddKeyFlag(command, arguments, "--away", "away", kBothGroup,
             "heights increase away from the sensor");
  command
      .add_option(
          "--set", arguments.set,
          "KEY=VALUE, overrides --options, e.g. monitor.window=40; keys: list formats, list keys")
      ->allow_extra_args(false)
      ->group(kBothGroup);
}

// ---- what looks wrong about the heights ----

// A sensor's noise alone spans more; heights in metres that are read as mm span less.
constexpr double kMinSpan_m = 0.01e-3;
// Share of exact zeros that measured heights far from 0 do not have.
constexpr double kMinZeroShare = 0.01;
// Of a step's log-likelihood ratio. Without an edge, the best place of a profile has less in 98 %
// of cases (white noise, best of both directions; see StepTrackOptions::evidence). Of seams 0 to 9
// of seam_base.yaml, at least 54 % of a recording's profiles have more, and at most 1.4 % of these
// in the wrong direction.
constexpr double kClearEvidence = 15.0;
constexpr double kMinClearShare = 0.25;
constexpr double kMinWrongShare = 0.8;

// Gathers figures of all profiles that indicate a wrong sign, a wrong unit, a number that stands
// for a missing value, or heights instead of camera rows. A tracker that searches in the wrong
// direction may still report an edge.
class HeightCheck {
 public:
  HeightCheck(const seam::TrackerOptions& tracker, const seam::ProfileFileOptions& file,
              const DetectArguments& arguments, const std::optional<seam::Calibration>& calibration)
      : steps_(seam::WithWindowsOfLine(tracker).step_track.steps),
        rising_(tracker.positive_edge),
        away_(file.away),
        image_(seam::IsImageFile(arguments.profiles)),
        calibration_(calibration) {}

  void Take(std::vector<float> height_m) {
    for (const float height : height_m) Count(away_ ? -height : height);  // sign of the file
    ++profiles_;
    const double up = BestStep(height_m);
    std::ranges::reverse(height_m);
    const double down = BestStep(height_m);
    if (std::max(up, down) < kClearEvidence) return;
    ++clear_;
    if (rising_ == (down > up)) ++wrong_;
  }

  std::vector<std::string> Warnings() const {
    std::vector<std::string> warnings;
    const auto share = [](double of, std::size_t all) { return of * static_cast<double>(all); };
    const auto wrong = static_cast<double>(wrong_);
    if (wrong > share(kMinClearShare, profiles_) && wrong > share(kMinWrongShare, clear_)) {
      warnings.push_back(WrongDirection());
    }
    if (calibration_ && heights_ == 0) warnings.push_back(NoRows());
    // Calibrated heights come from camera rows, whose unit is known.
    if (calibration_ || !(max_m_ >= min_m_)) return warnings;
    const double span_m = max_m_ - min_m_;
    if (span_m < kMinSpan_m) {
      warnings.push_back(fmt::format("heights span only {:.2g} mm: is their unit right ({})?",
                                     span_m * base::kMmPerM,
                                     image_ ? "--image-scale" : "--unit m"));
    }
    const bool far_from_zero = std::max(min_m_, -max_m_) > span_m;
    if (far_from_zero && static_cast<double>(zeros_) >= share(kMinZeroShare, heights_)) {
      warnings.push_back(ManyZeros());
    }
    return warnings;
  }

 private:
  void Count(float height_m) {
    if (!std::isfinite(height_m)) return;
    ++heights_;
    if (height_m == 0.0F) {
      ++zeros_;
      return;
    }
    min_m_ = std::min(min_m_, static_cast<double>(height_m));
    max_m_ = std::max(max_m_, static_cast<double>(height_m));
  }

  // Evidence of the best rising step.
  double BestStep(std::span<const float> height_m) const {
    double best = 0.0;
    for (const auto& step : seam::FitLocalSteps(height_m, steps_)) {
      best = std::max(best, step.evidence);
    }
    return best;
  }

  std::string WrongDirection() const {
    const char* sign = away_
                           ? "no --away (file.away: false) if heights grow towards the sensor, or "
                           : "--away if heights grow away from the sensor, or ";
    return fmt::format(
        "in {} of {} profiles the largest step {} with the column number, but a {} one is "
        "searched: {}{}",
        wrong_, profiles_, rising_ ? "falls" : "rises", rising_ ? "rising" : "falling",
        calibration_ ? "" : sign,
        rising_ ? "--negative if the high mat is at the small column numbers"
                : "no --negative (positive_edge: true) if the high mat is at the large column "
                  "numbers");
  }

  std::string NoRows() const {
    return fmt::format(
        "no value lies in the calibration's rows {:.0f} to {:.0f}: are these heights? Then leave "
        "--calibration out",
        calibration_->row_min_px, calibration_->row_max_px);
  }

  std::string ManyZeros() const {
    return fmt::format(
        "{:.0f} % of the heights are exactly 0, the others {:.4g} to {:.4g} mm: --no-value 0 if 0 "
        "stands for a missing value",
        100.0 * static_cast<double>(zeros_) / static_cast<double>(heights_), min_m_ * base::kMmPerM,
        max_m_ * base::kMmPerM);
  }

  seam::LocalStepOptions steps_;
  bool rising_;  // the step that is searched
  bool away_, image_;
  std::optional<seam::Calibration> calibration_;  // of camera rows
  std::size_t profiles_ = 0;
  std::size_t clear_ = 0;  // profiles with a clear step
  std::size_t wrong_ = 0;  // with one in the wrong direction
  std::size_t heights_ = 0, zeros_ = 0;
  double min_m_ = std::numeric_limits<double>::infinity();  // of all heights but zeros
  double max_m_ = -std::numeric_limits<double>::infinity();
};

// ---- what looks wrong about the times ----

// A head at 30 mm/s moves by 150 mm in this time.
constexpr double kLongInterval_s = 5.0;

// Counts long intervals between profiles, which indicate times in ms or us that are read as s.
class TimeCheck {
 public:
  void Take(double time_s) {
    const double interval_s = last_s_ ? time_s - *last_s_ : 0.0;
    if (last_s_) ++intervals_;
    last_s_ = time_s;
    if (interval_s <= kLongInterval_s) return;
    ++long_;
    shortest_long_s_ = std::min(shortest_long_s_, interval_s);
  }

  // Empty if the median interval is not long.
  std::string Warning() const {
    if (2 * long_ <= intervals_) return "";
    return fmt::format(
        "{:.3g} s between profiles: is the time in s (--set file.time_unit_s=0.001 if it is in "
        "ms)?",
        shortest_long_s_);
  }

 private:
  std::optional<double> last_s_;
  std::size_t intervals_ = 0, long_ = 0;
  double shortest_long_s_ = std::numeric_limits<double>::infinity();
};

// ---- recorded profiles or a stream ----

// Complete processing of profiles.
class Detection {
 public:
  explicit Detection(const DetectArguments& arguments) : arguments_(arguments) {
    ReadOptions();
    if (!arguments.method.empty()) {
      options_.method = base::FromWord<seam::DecisionMethod>(arguments.method, "--method");
    }
    if (arguments.negative) options_.positive_edge = false;
    if (arguments.IsCalibrated()) {
      calibration_ = seam::ReadCalibration(arguments.calibration);
      file_options_.columns = calibration_->columns;
    }
  }

  void Run() {
    const std::size_t rows = arguments_.profiles == "-" ? TakeStream(std::cin) : TakeFile();
    auto warnings = check_->Warnings();
    // Other times are computed from a rate or a path.
    if (!file_options_.text.time_column.empty()) warnings.push_back(time_check_.Warning());
    std::erase(warnings, "");
    for (const auto& warning : warnings) spdlog::warn("{}: {}", Source(), warning);
    if (!arguments_.picture.empty() && !drawn_) {
      throw InputError(fmt::format("--picture-row {}: there are only {} profiles",
                                   arguments_.picture_row, rows));
    }
  }

 private:
  // Reads the keys of the preset, the YAML file and --set; later ones override earlier ones.
  void ReadOptions() {
    if (arguments_.IsCalibrated()) file_options_ = RowFileOptions();
    std::vector<std::string> keys = arguments_.words;
    keys.insert(keys.end(), arguments_.set.begin(), arguments_.set.end());
    auto map = arguments_.options.empty() ? YamlMap::FromText("{}", "--set", keys)
                                          : YamlMap::FromFile(arguments_.options, keys);
    auto file = map.Child("file", "format of a profile file");
    CheckKeys(file, arguments_);
    if (!arguments_.preset.empty()) ReadPreset(arguments_, file, file_options_);
    seam::ReadProfileFileOptions(std::move(file), file_options_);
    const bool has_columns_per_mm = map.Has("columns_per_mm");
    seam::ReadTrackerOptions(map, options_);
    seam::ReadMonitorOptions(map.Child("monitor", "hazards that stop the head"), monitor_options_);
    map.Finish();
    file_options_.rate_hz = arguments_.rate_hz;
    const auto& columns_per_mm = arguments_.columns_per_mm;
    if (columns_per_mm && has_columns_per_mm) {
      throw InputError("--columns-per-mm excludes --set columns_per_mm");
    }
    if (columns_per_mm) options_.line.columns_per_m = *columns_per_mm * base::kMmPerM;
    if (columns_per_mm || has_columns_per_mm) {
      file_options_.columns_per_m = options_.line.columns_per_m;
    }
  }

  std::string Source() const { return arguments_.profiles == "-" ? "stdin" : arguments_.profiles; }

  std::size_t TakeFile() {
    const auto file = seam::ReadProfileFile(arguments_.profiles, file_options_);
    SetGrid(file.grid);
    for (const auto& row : file.rows) Take(row);
    return file.rows.size();
  }

  // Damaged rows of a stream are reported and skipped.
  std::size_t TakeStream(std::istream& in) {
    seam::ProfileStream stream(in, file_options_);
    std::size_t rows = 0;
    const auto next = [&stream] {
      try {
        return stream.Next();
      } catch (const InputError& error) {
        throw InputError(std::string("stdin: ") + error.what());
      }
    };
    while (const auto row = next()) {
      rows = row->row;
      if (!row->fault.empty()) {
        spdlog::warn("stdin: {}; skipped", row->fault);
        continue;
      }
      SetGrid(stream.grid());
      Take(*row);
    }
    if (!tracker_) throw InputError("stdin: contained no complete profile");
    return rows;
  }

  // Sets the grid of profiles that have x.
  void SetGrid(const std::optional<seam::ProfileGrid>& grid) {
    if (!grid || tracker_) return;
    options_.line.columns_per_m = 1.0 / grid->pitch_m;
    center_x_m_ = grid->Center();
  }

  void Take(const seam::ProfileRow& row) {
    seam::Profile profile = row.profile;
    if (calibration_) {
      profile =
          seam::Calibrate({.row_px = profile.height_m, .time_s = profile.time_s}, *calibration_);
    }
    if (!tracker_) Begin(static_cast<int>(profile.height_m.size()), row.position_m.has_value());
    check_->Take(profile.height_m);
    time_check_.Take(profile.time_s);
    seam::Reading reading = tracker_->Update(profile);
    reading.x_m += center_x_m_;
    auto stop = monitor_->Update(tracker_->prepared(), reading);
    if (row.gap_s && !stop) {  // the file's own times show that nothing was measured
      spdlog::warn("row {} (line {}): {:.3f} s after the previous row: an outage", row.row,
                   row.line, *row.gap_s);
      stop = seam::StopReason::kOutage;
    }
    if (arguments_.xml) {
      gap_ = gap_ || row.gap_s;
      if (const auto packet = tracker_->TakePacket()) {
        PrintXml(*packet, !stop && gap_ ? seam::StopReason::kOutage : stop);
        gap_ = false;
      }
    } else if (arguments_.json) {
      PrintJson(reading, stop, row);
    } else {
      PrintLine(reading, stop, row);
    }
    if (arguments_.picture.empty() || std::cmp_not_equal(row.row, arguments_.picture_row)) return;
    WriteResult(draw::PlotSvg(seam::ProfilePanels(*tracker_, reading, options_.line)),
                arguments_.picture);
    drawn_ = true;
  }

  void Begin(int columns, bool has_position) {
    if (columns < seam::kMinColumns) {
      throw InputError(fmt::format("{}: its profiles have {} columns; at least {} are needed",
                                   Source(), columns, seam::kMinColumns));
    }
    options_.line.columns = columns;
    if (calibration_) options_.line.columns_per_m = 1.0 / calibration_->meters_per_column[0];
    try {
      tracker_.emplace(options_, calibration_);
      monitor_.emplace(options_.line, seam::MonitorFor(monitor_options_, options_.method));
    } catch (const std::invalid_argument& error) {  // options that the line is too coarse for
      throw InputError(error.what());
    }
    check_.emplace(options_, file_options_, arguments_, calibration_);
    if (!arguments_.json && !arguments_.xml) {
      WriteResult(
          "profile,time_s,status,column,x_mm,step_mm,model_fitting,local_weighted_voting,gradient_"
          "accumulation,stop" +
          std::string(has_position ? ",position_mm\n" : "\n"));
    }
  }

  void PrintLine(const seam::Reading& reading, std::optional<seam::StopReason> stop,
                 const seam::ProfileRow& row) const {
    const auto mm = [](double length_m) { return length_m * base::kMmPerM; };
    std::string line = fmt::format(
        "{},{:.4f},{},{},{:.3f}", row.row, reading.time_s, base::Word(reading.status),
        reading.column ? fmt::format("{:.2f},{:.4f}", *reading.column, mm(reading.x_m)) : ",",
        mm(reading.step_m));
    for (const auto& column : reading.detected) line += column ? fmt::format(",{}", *column) : ",";
    line += fmt::format(",{}", stop ? base::Word(*stop) : "");
    if (row.position_m) line += fmt::format(",{:.4f}", mm(*row.position_m));
    WriteResult(line + "\n");
  }

  void PrintJson(const seam::Reading& reading, std::optional<seam::StopReason> stop,
                 const seam::ProfileRow& row) const {
    const auto or_null = [](const auto& value) {
      return value ? ordered_json(*value) : ordered_json(nullptr);
    };
    ordered_json json = {{"profile", row.row},
                         {"time_s", reading.time_s},
                         {"status", base::Word(reading.status)},
                         {"column", or_null(reading.column)},
                         {"x_m", or_null(reading.column ? &reading.x_m : nullptr)},
                         {"step_m", reading.step_m}};
    for (const auto detector : base::ValuesOf<seam::Detector>()) {
      json["detectors"][std::string(base::Word(detector))] =
          or_null(reading.detected[static_cast<std::size_t>(detector)]);
    }
    json["stop"] = stop ? ordered_json(base::Word(*stop)) : ordered_json(nullptr);
    if (row.position_m) json["position_m"] = *row.position_m;
    WriteResult(json.dump() + "\n");
  }

  void PrintXml(const seam::EdgePacket& packet, std::optional<seam::StopReason> stop) const {
    const double edge_x_m = packet.x_m + center_x_m_;
    WriteResult(seam::ToXml({.time_s = packet.time_s,
                             .valid = packet.column.has_value(),
                             .edge_x_m = edge_x_m,
                             .deviation_m = edge_x_m,
                             .sure = packet.sure,
                             .stop = stop}));
  }

  DetectArguments arguments_;
  seam::TrackerOptions options_;
  seam::MonitorOptions monitor_options_;
  seam::ProfileFileOptions file_options_;
  std::optional<seam::Calibration> calibration_;
  std::optional<seam::EdgeTracker> tracker_;
  std::optional<seam::SurfaceMonitor> monitor_;
  std::optional<HeightCheck> check_;
  TimeCheck time_check_;
  double center_x_m_ = 0.0;  // middle of the line, in the sensor's own x
  bool drawn_ = false;
  bool gap_ = false;  // in the file's times, since the last packet
};

}  // namespace

seam::ProfileFileOptions RowFileOptions() {
  seam::ProfileFileOptions options;
  options.text.scale.unit_m = kRowUnit;
  options.grey = {1.0 / 64.0, 0.0, {0.0}};
  options.signed_grey = {1.0 / 64.0, 0.0, {0.0}};
  options.real = {1.0, 0.0, {}};
  options.min_height_m = 0.0;
  options.max_height_m = 65535.0;
  return options;
}

void AddSeamDetect(CLI::App& seam) {
  auto* command =
      seam.add_subcommand("detect", "Detect edge positions in profiles, recorded or streamed.");
  auto arguments = std::make_shared<DetectArguments>();
  command
      ->add_option("profiles", arguments->profiles,
                   "CSV, 16-bit PNG/TIFF or floating-point TIFF, one profile per row; - reads "
                   "CSV rows from stdin")
      ->required();
  command->add_option("--method", arguments->method, "decision method (steps)")
      ->check(CLI::IsMember(base::WordList<seam::DecisionMethod>()));
  auto* options = command->add_option("--options", arguments->options,
                                      "YAML file: the keys of an experiment's `tracker` at the top "
                                      "level, and `monitor` and `file`");
  auto* columns =
      command
          ->add_option("--columns-per-mm", arguments->columns_per_mm,
                       "columns per mm of the sensor's line (12; computed if the file has x)")
          ->check(NumberBetween(0.1, 1000.0))
          ->excludes(options);
  command->add_option("--rate", arguments->rate_hz, "profiles per second (62)")
      ->check(NumberBetween(0.1, 1e5));
  auto* unit = AddUnit(*command, *arguments);
  command
      ->add_option("--calibration", arguments->calibration,
                   "calibration (YAML); the input numbers are then camera rows (images: 64 grey "
                   "levels per row)")
      ->excludes(columns)
      ->excludes(unit);
  command->add_flag("--negative", arguments->negative,
                    "the high mat is at the small column numbers");
  auto* json = command->add_flag("--json", arguments->json, "print one JSON object per profile");
  command->add_flag("--xml", arguments->xml, "print the packets for the robot, one every 100 ms")
      ->excludes(json);
  command->add_option("--picture", arguments->picture,
                      "SVG file of one profile with its detectors");
  command->add_option("--picture-row", arguments->picture_row, "number of this profile (1)")
      ->transform(WholeNumber(1, std::numeric_limits<int>::max()));
  AddFormatOptions(*command, *arguments);
  command->footer(
      "Example: rangegrasp seam detect profiles.csv --method weights --picture profile.svg\n"
      "         rangegrasp seam detect recording.csv --preset gocator\n"
      "         rangegrasp seam detect points.txt --layout points --decimal-comma --no-value -999");
  command->callback([arguments] {
    if (!arguments->picture.empty()) CheckEnding(arguments->picture, {".svg"});
    Detection(*arguments).Run();
  });
}

}  // namespace rangegrasp::cli
