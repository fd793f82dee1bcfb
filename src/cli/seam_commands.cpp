#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/seam_calibration.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "core/words.h"
#include "seam/monitor.h"
#include "seam/profile_io.h"
#include "seam/tracker.h"
#include "stitching/correction.h"
#include "tasks/seam/seam_pictures.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;

// ---- detect: recorded profiles or a stream ----

struct DetectArguments {
  std::string profiles, options, calibration, method, picture;
  std::optional<std::string> unit;
  std::optional<double> columns_per_mm;
  int picture_row = 1;
  double rate_hz = 62.0;
  bool negative = false, json = false, xml = false;
};

double UnitOf(const std::string& name) {
  if (name == "um") return 1e-6;
  return name == "m" ? 1.0 : 1e-3;
}

bool IsImage(const std::string& file) {
  const std::string ending = core::EndingOf(file);
  return ending == ".png" || ending == ".pgm";
}

void CheckArguments(const DetectArguments& arguments) {
  if (arguments.unit && IsImage(arguments.profiles)) {
    throw core::InputError("--unit " + *arguments.unit + ": is for CSV; a grey level of " +
                           arguments.profiles + " is 1 um");
  }
}

// Everything that one profile goes through.
class Detection {
 public:
  explicit Detection(const DetectArguments& arguments) : arguments_(arguments) {
    CheckArguments(arguments);
    if (!arguments.options.empty()) ReadOptions(arguments.options);
    if (!arguments.method.empty()) {
      options_.method = core::FromWord<seam::DecisionMethod>(arguments.method, "--method");
    }
    if (arguments.columns_per_mm) {
      options_.line.columns_per_m = *arguments.columns_per_mm * core::kMmPerM;
    }
    if (arguments.negative) options_.positive_edge = false;
    if (!arguments.calibration.empty()) {
      calibration_ = seam::ReadCalibration(arguments.calibration);
    }
  }

  seam::ProfileFileOptions FileOptions() const {
    seam::ProfileFileOptions file;
    file.rate_hz = arguments_.rate_hz;
    if (arguments_.unit) file.text.scale.unit_m = UnitOf(*arguments_.unit);
    if (calibration_) {
      file = RowFileOptions();
      file.rate_hz = arguments_.rate_hz;
      file.columns = calibration_->columns;
    }
    return file;
  }

  void Take(const seam::Profile& read, std::size_t row) {
    seam::Profile profile = read;
    if (calibration_) {
      profile = seam::Calibrate({.row_px = read.height_m, .time_s = read.time_s}, *calibration_);
    }
    if (!tracker_) Begin(static_cast<int>(profile.height_m.size()));
    const seam::Reading reading = tracker_->Update(profile);
    const auto stop = monitor_->Update(tracker_->prepared(), reading);
    if (arguments_.xml) {
      if (const auto packet = tracker_->TakePacket()) PrintXml(*packet, stop);
    } else if (arguments_.json) {
      PrintJson(reading, stop, row);
    } else {
      PrintLine(reading, stop, row);
    }
    if (!arguments_.picture.empty() && row == static_cast<std::size_t>(arguments_.picture_row)) {
      WriteResult(tasks::seam_task::ProfileSvg(*tracker_, reading, options_.line),
                  arguments_.picture);
      drawn_ = true;
    }
  }

  /// What no other profile can bear out counts at once.
  void BelieveSingleProfiles() { options_.confirm = false; }

  void Finish(std::size_t rows) const {
    if (!arguments_.picture.empty() && !drawn_) {
      throw core::InputError(fmt::format("--picture-row {}: there are only {} profiles",
                                         arguments_.picture_row, rows));
    }
  }

 private:
  void ReadOptions(const std::string& file) {
    auto map = core::YamlMap::FromFile(file);
    seam::ReadTrackerOptions(map, options_);
    seam::ReadMonitorOptions(map.Child("monitor", "what stops the head"), monitor_options_);
    map.Finish();
  }

  void Begin(int columns) {
    if (columns < seam::kMinColumns) {
      throw core::InputError(fmt::format("{}: its profiles have {} columns; a line has at least {}",
                                         arguments_.profiles == "-" ? "stdin" : arguments_.profiles,
                                         columns, seam::kMinColumns));
    }
    options_.line.columns = columns;
    if (calibration_) options_.line.columns_per_m = 1.0 / calibration_->meters_per_column[0];
    tracker_.emplace(options_, calibration_);
    monitor_.emplace(options_.line, monitor_options_);
    if (!arguments_.json && !arguments_.xml) {
      WriteResult(
          "profile,time_s,status,column,x_mm,step_mm,model_fitting,local_weighted_voting,gradient_"
          "accumulation,stop\n");
    }
  }

  void PrintLine(const seam::Reading& reading, std::optional<seam::StopReason> stop,
                 std::size_t row) const {
    std::string line =
        fmt::format("{},{:.4f},{},", row, reading.time_s, core::Word(reading.status));
    line += reading.column
                ? fmt::format("{:.2f},{:.4f},", *reading.column, reading.x_m * core::kMmPerM)
                : ",,";
    line += fmt::format("{:.3f}", reading.step_m * core::kMmPerM);
    for (const auto& column : reading.detected) line += column ? fmt::format(",{}", *column) : ",";
    WriteResult(fmt::format("{},{}\n", line, stop ? core::Word(*stop) : ""));
  }

  void PrintJson(const seam::Reading& reading, std::optional<seam::StopReason> stop,
                 std::size_t row) const {
    ordered_json json = {
        {"profile", row},    {"time_s", reading.time_s}, {"status", core::Word(reading.status)},
        {"column", nullptr}, {"x_m", nullptr},           {"step_m", reading.step_m}};
    if (reading.column) {
      json["column"] = *reading.column;
      json["x_m"] = reading.x_m;
    }
    for (std::size_t d = 0; d < seam::kDetectors; ++d) {
      const std::string name(core::Word(static_cast<seam::Detector>(d)));
      json["detectors"][name] =
          reading.detected[d] ? ordered_json(*reading.detected[d]) : ordered_json(nullptr);
    }
    json["stop"] = stop ? ordered_json(core::Word(*stop)) : ordered_json(nullptr);
    WriteResult(json.dump() + "\n");
  }

  void PrintXml(const seam::EdgePacket& packet, std::optional<seam::StopReason> stop) const {
    stitching::Correction correction;
    correction.time_s = packet.time_s;
    correction.valid = packet.column.has_value();
    correction.edge_x_m = packet.x_m;
    correction.deviation_m = packet.x_m;
    correction.stop = stop;
    WriteResult(stitching::ToXml(correction));
  }

  DetectArguments arguments_;
  seam::TrackerOptions options_;
  seam::MonitorOptions monitor_options_;
  std::optional<seam::Calibration> calibration_;
  std::optional<seam::EdgeTracker> tracker_;
  std::optional<seam::SurfaceMonitor> monitor_;
  bool drawn_ = false;
};

// A damaged row of a stream is told and left out; the stream goes on.
std::size_t DetectStream(std::istream& in, Detection& detection) {
  seam::ProfileStream stream(in, detection.FileOptions());
  std::size_t rows = 0;
  std::size_t whole = 0;
  while (const auto row = stream.Next()) {
    rows = row->row;
    if (!row->fault.empty()) {
      spdlog::warn("stdin: {}; left out", row->fault);
      continue;
    }
    detection.Take(row->profile, row->row);
    ++whole;
  }
  if (whole == 0) throw core::InputError("stdin: held no whole profile");
  return rows;
}

void Detect(const DetectArguments& arguments) {
  Detection detection(arguments);
  std::size_t rows = 0;
  if (arguments.profiles == "-") {
    rows = DetectStream(std::cin, detection);
  } else {
    const auto profiles = seam::ReadProfiles(arguments.profiles, detection.FileOptions());
    if (profiles.size() == 1) detection.BelieveSingleProfiles();
    for (const auto& profile : profiles) detection.Take(profile, ++rows);
  }
  detection.Finish(rows);
}

void AddDetect(CLI::App& seam) {
  auto* command =
      seam.add_subcommand("detect", "Edge positions in profiles, recorded or streamed.");
  auto arguments = std::make_shared<DetectArguments>();
  command
      ->add_option("profiles", arguments->profiles,
                   "CSV or 16-bit PNG/PGM, one profile a row; - reads CSV rows from stdin")
      ->required();
  command->add_option("--method", arguments->method, "how a position is decided (voting)")
      ->check(CLI::IsMember(core::WordList<seam::DecisionMethod>()));
  auto* options =
      command->add_option("--options", arguments->options,
                          "YAML of what an experiment has below `tracker`, and of its `monitor`");
  auto* columns =
      command
          ->add_option("--columns-per-mm", arguments->columns_per_mm, "of the sensor's line (12)")
          ->check(CLI::Range(0.1, 1000.0))
          ->excludes(options);
  command->add_option("--rate", arguments->rate_hz, "profiles a second (62)")
      ->check(CLI::Range(0.1, 1e5));
  auto* unit = command->add_option("--unit", arguments->unit, "of the heights of a CSV (mm)")
                   ->check(CLI::IsMember({"um", "mm", "m"}));
  command
      ->add_option("--calibration", arguments->calibration,
                   "YAML; the numbers are then camera rows (images: 64 grey levels a row)")
      ->excludes(columns)
      ->excludes(unit);
  command->add_flag("--negative", arguments->negative, "the high mat is at small columns");
  command->add_flag("--json", arguments->json, "one JSON object a profile");
  command->add_flag("--xml", arguments->xml, "the packets for the robot, one every 100 ms");
  command->add_option("--picture", arguments->picture, "SVG of one profile with its detectors");
  command->add_option("--picture-row", arguments->picture_row, "which profile (1)")
      ->check(CLI::PositiveNumber);
  command->footer(
      "Example: rangegrasp seam detect profiles.csv --method weights --picture profile.svg");
  command->callback([arguments] { Detect(*arguments); });
}

// Commands of earlier versions: they say what took their place.
void AddMoved(CLI::App& seam, const std::string& name, const std::string& now) {
  auto* command = seam.add_subcommand(name)->group("")->prefix_command();
  command->set_help_flag();
  command->callback([name, now] {
    throw core::InputError(
        fmt::format("seam {}: there is no such command any more; {}", name, now));
  });
}

}  // namespace

void AddSeamCommands(CLI::App& app) {
  auto* seam =
      app.add_subcommand("seam", "Edges of overlapping fibre mats in laser-stripe profiles.");
  seam->require_subcommand(1);
  seam->footer("Example: rangegrasp seam detect profiles.csv --method weights");
  AddSeamGenerate(*seam);
  AddSeamCalibrate(*seam);
  AddDetect(*seam);
  AddMoved(*seam, "evaluate",
           "'rangegrasp run EXPERIMENT.yaml' runs a seam experiment and prints its tables");
  AddMoved(
      *seam, "track",
      "'rangegrasp run EXPERIMENT.yaml' runs closed loops, 'rangegrasp trial DIR ID' shows one "
      "of them again, with its path, packets and picture");
}

}  // namespace rangegrasp::cli
