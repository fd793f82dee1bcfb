#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/draw/plot.h"
#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "seam/calibration.h"
#include "seam/command/seam_profile_file.h"
#include "seam/monitor.h"
#include "seam/profile_io.h"
#include "seam/stitching/closed_loop.h"
#include "seam/task/seam_experiment.h"
#include "seam/task/seam_task.h"
#include "seam/tracker.h"

namespace rangegrasp::cli {
namespace {

using seam::ProfileFileOptions;
using seam::SeamExperiment;

struct GenerateArguments {
  std::string experiment, out;
  int seam = 0;
  std::optional<std::uint64_t> seed;
  bool raw = false, body = false;

  std::filesystem::path Beside(const char* ending) const {
    return std::filesystem::path(out).replace_extension(ending);
  }
};

// Scans of the calibration body and the heights of its base, as `calibrate` reads them.
void GenerateBody(const SeamExperiment& experiment, const GenerateArguments& arguments) {
  std::vector<seam::Profile> rows;
  std::string bases = "scan,base_mm\n";
  for (const auto& scan :
       seam::CalibrationScansOf(experiment, seam::StripeSensor(experiment.sensor))) {
    rows.push_back({scan.profile.row_px, 0.0});
    bases += fmt::format("{},{:.6f}\n", rows.size(), scan.base_height_m * base::kMmPerM);
  }
  seam::WriteProfiles(rows, arguments.out, RowFileOptions());
  WriteResult(bases, arguments.Beside(".bases.csv"));
  spdlog::info("{} scans of the calibration body in {}, its heights in a file next to it",
               rows.size(), arguments.out);
}

void Generate(const GenerateArguments& arguments) {
  SeamExperiment experiment = seam::ReadSeamExperiment(arguments.experiment);
  if (arguments.seed) experiment.seed = *arguments.seed;
  if (arguments.body) return GenerateBody(experiment, arguments);
  const seam::StripeSensor sensor(experiment.sensor);
  const seam::Calibration calibration = seam::CalibrationOf(experiment, sensor);
  const seam::Recording recording = seam::RecordSeam(experiment, sensor, arguments.seam);
  std::vector<seam::Profile> profiles;
  for (const seam::RawProfile& raw : recording.raw) {
    profiles.push_back(arguments.raw ? seam::Profile{raw.row_px, raw.time_s}
                                     : seam::Calibrate(raw, calibration));
  }
  seam::WriteProfiles(profiles, arguments.out,
                      arguments.raw ? RowFileOptions() : ProfileFileOptions{});
  WriteResult(seam::LabelsCsv(recording), arguments.Beside(".labels.csv"));
  if (arguments.raw) seam::WriteCalibration(calibration, arguments.Beside(".calibration.yaml"));
  spdlog::info("{} profiles in {}, their labels in a file next to it", profiles.size(),
               arguments.out);
}

struct CalibrateArguments {
  std::string scans, bases, out;
  std::vector<double> step_heights_mm;
  std::optional<double> step_width_mm;
};

seam::CalibrationBody BodyFrom(const CalibrateArguments& arguments) {
  seam::CalibrationBody body;
  if (!arguments.step_heights_mm.empty()) body.step_heights_m.clear();
  for (const double height : arguments.step_heights_mm) {
    body.step_heights_m.push_back(height / base::kMmPerM);
  }
  if (arguments.step_width_mm) body.step_width_m = *arguments.step_width_mm / base::kMmPerM;
  return body;
}

std::vector<seam::CalibrationScan> ReadScans(const CalibrateArguments& arguments) {
  const auto rows = seam::ReadProfileFile(arguments.scans, RowFileOptions()).rows;
  const auto bases = base::CsvTable::Read(arguments.bases);
  const std::size_t base = bases.Column("base_mm");
  std::vector<seam::CalibrationScan> scans;
  for (std::size_t i = 0; i < bases.rows(); ++i) {
    const double base_m = bases.Number(i, base) / base::kMmPerM;
    if (i < rows.size()) scans.push_back({{rows[i].profile.height_m, 0.0}, base_m});
  }
  if (rows.size() == bases.rows()) return scans;
  throw base::InputError(fmt::format("{}: has the heights of {} scans, but {} has {} scans",
                                     arguments.bases, bases.rows(), arguments.scans, rows.size()));
}

void Calibrate(const CalibrateArguments& arguments) {
  const auto scans = ReadScans(arguments);
  seam::Calibration calibration;
  try {
    calibration = seam::CalibrateFromBody(BodyFrom(arguments), scans);
  } catch (const base::InputError& error) {
    throw base::InputError(arguments.scans + ": " + error.what());
  }
  seam::WriteCalibration(calibration, arguments.out);
  spdlog::info(
      "calibration in {}: rows {:.0f} to {:.0f}, heights {:.1f} to {:.1f} mm, {:.2f} columns per "
      "mm",
      arguments.out, calibration.row_min_px, calibration.row_max_px,
      calibration.HeightAt(calibration.row_min_px) * base::kMmPerM,
      calibration.HeightAt(calibration.row_max_px) * base::kMmPerM,
      1.0 / calibration.meters_per_column[0] / base::kMmPerM);
}

/// `seam generate`: simulated profiles, or scans of the calibration body.
void AddSeamGenerate(CLI::App& seam) {
  auto* command = seam.add_subcommand("generate", "Simulate profiles of one seam, with labels.");
  auto arguments = std::make_shared<GenerateArguments>();
  command->add_option("experiment", arguments->experiment, "seam experiment file")->required();
  command
      ->add_option("-o,--out", arguments->out, "output profiles: .csv, or .png/.pgm with 16 bits")
      ->required();
  command->add_option("--seam", arguments->seam, "number of the seam, from 0")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--seed", arguments->seed, "overrides the seed of the experiment");
  command->add_flag("--raw", arguments->raw,
                    "write camera rows, with the calibration in a file next to them");
  command->add_flag("--body", arguments->body,
                    "number of scans of the calibration body, instead of a seam");
  command->footer(
      "Example: rangegrasp seam generate experiments/seam_base.yaml --seam 3 -o results/seam3.csv");
  command->callback([arguments] { Generate(*arguments); });
}

/// `seam calibrate`: scans of a calibration body to a calibration.
void AddSeamCalibrate(CLI::App& seam) {
  auto* command =
      seam.add_subcommand("calibrate", "Calibrate a stripe sensor from scans of a stepped body.");
  auto arguments = std::make_shared<CalibrateArguments>();
  command
      ->add_option("scans", arguments->scans,
                   "camera rows, one scan per row: CSV, or 16-bit PNG/PGM (64 grey levels per row)")
      ->required();
  command
      ->add_option("--bases", arguments->bases,
                   "CSV with a header and one line 'scan,base_mm' per scan: the height of the "
                   "body's base in the sensor's frame")
      ->required();
  command
      ->add_option("--step-heights-mm", arguments->step_heights_mm,
                   "heights of the body's steps above its base (0,2,5,9,5,2,0)")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1000.0));
  command->add_option("--step-width-mm", arguments->step_width_mm, "width of each step (8)")
      ->check(CLI::Range(0.01, 1000.0));
  command->add_option("-o,--out", arguments->out, "output calibration (YAML)")->required();
  command->footer(
      "Example: rangegrasp seam calibrate body.csv --bases body.bases.csv -o sensor.yaml");
  command->callback([arguments] { Calibrate(*arguments); });
}

using nlohmann::ordered_json;

// ---- detect: recorded profiles or a stream ----

struct DetectArguments {
  ProfileFileArguments file;
  std::string calibration, method, picture;
  std::optional<double> columns_per_mm;
  int picture_row = 1;
  double rate_hz = 62.0;
  bool negative = false, json = false, xml = false;
};

// Everything that one profile goes through.
class Detection {
 public:
  explicit Detection(const DetectArguments& arguments) : arguments_(arguments) {
    ReadOptions();
    if (!arguments.method.empty()) {
      options_.method = base::FromWord<seam::DecisionMethod>(arguments.method, "--method");
    }
    if (arguments.negative) options_.positive_edge = false;
    if (!arguments.calibration.empty()) {
      calibration_ = seam::ReadCalibration(arguments.calibration);
      file_options_.columns = calibration_->columns;
    }
  }

  const seam::ProfileFileOptions& FileOptions() const { return file_options_; }

  /// Of profiles that have x.
  void SetGrid(const std::optional<seam::ProfileGrid>& grid) {
    if (!grid || tracker_) return;
    options_.line.columns_per_m = grid->columns_per_m;
    center_x_m_ = grid->center_x_m;
  }

  void Take(const seam::ProfileRow& row) {
    seam::Profile profile = row.profile;
    if (calibration_) {
      profile =
          seam::Calibrate({.row_px = profile.height_m, .time_s = profile.time_s}, *calibration_);
    }
    if (!tracker_) Begin(static_cast<int>(profile.height_m.size()), row.position_m.has_value());
    seam::Reading reading = tracker_->Update(profile);
    reading.x_m += center_x_m_;
    auto stop = monitor_->Update(tracker_->prepared(), reading);
    if (row.gap_s && !stop) stop = OutageBefore(row);
    if (arguments_.xml) {
      if (const auto packet = tracker_->TakePacket()) PrintXml(*packet, stop);
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

  /// What no other profile can bear out counts at once.
  void BelieveSingleProfiles() { options_.confirm = false; }

  void Finish(std::size_t rows) const {
    if (!arguments_.picture.empty() && !drawn_) {
      throw base::InputError(fmt::format("--picture-row {}: there are only {} profiles",
                                         arguments_.picture_row, rows));
    }
  }

 private:
  void ReadOptions() {
    DetectOptions read = ReadDetectOptions(arguments_.file);
    options_ = read.tracker;
    monitor_options_ = read.monitor;
    file_options_ = std::move(read.file);
    file_options_.rate_hz = arguments_.rate_hz;
    const auto& columns_per_mm = arguments_.columns_per_mm;
    if (columns_per_mm && read.has_columns_per_mm) {
      throw base::InputError("--columns-per-mm excludes --set columns_per_mm");
    }
    if (columns_per_mm) options_.line.columns_per_m = *columns_per_mm * base::kMmPerM;
    if (columns_per_mm || read.has_columns_per_mm) {
      file_options_.columns_per_m = options_.line.columns_per_m;
    }
  }

  // The file's own times tell that nothing was measured.
  static seam::StopReason OutageBefore(const seam::ProfileRow& row) {
    spdlog::warn("row {} (line {}): {:.3f} s after the previous row: an outage", row.row, row.line,
                 *row.gap_s);
    return seam::StopReason::kOutage;
  }

  void Begin(int columns, bool has_position) {
    if (columns < seam::kMinColumns) {
      const std::string& file = arguments_.file.profiles;
      throw base::InputError(fmt::format("{}: its profiles have {} columns; at least {} are needed",
                                         file == "-" ? "stdin" : file, columns, seam::kMinColumns));
    }
    options_.line.columns = columns;
    if (calibration_) options_.line.columns_per_m = 1.0 / calibration_->meters_per_column[0];
    try {
      tracker_.emplace(options_, calibration_);
      monitor_.emplace(options_.line, monitor_options_);
    } catch (const std::invalid_argument& error) {  // options that the line is too coarse for
      throw base::InputError(error.what());
    }
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
  double center_x_m_ = 0.0;  // of the line, on the sensor's own x
  bool drawn_ = false;
};

// A damaged row of a stream is reported and left out; the stream goes on.
std::size_t DetectStream(std::istream& in, Detection& detection) {
  seam::ProfileStream stream(in, detection.FileOptions());
  std::size_t rows = 0;
  std::size_t whole = 0;
  const auto next = [&stream] {
    try {
      return stream.Next();
    } catch (const base::InputError& error) {
      throw base::InputError(std::string("stdin: ") + error.what());
    }
  };
  while (const auto row = next()) {
    rows = row->row;
    if (!row->fault.empty()) {
      spdlog::warn("stdin: {}; skipped", row->fault);
      continue;
    }
    detection.SetGrid(stream.grid());
    detection.Take(*row);
    ++whole;
  }
  if (whole == 0) throw base::InputError("stdin: contained no complete profile");
  return rows;
}

void Detect(DetectArguments arguments) {
  arguments.file.calibrated = !arguments.calibration.empty();
  Detection detection(arguments);
  std::size_t rows = 0;
  if (arguments.file.profiles == "-") {
    rows = DetectStream(std::cin, detection);
  } else {
    const auto file = seam::ReadProfileFile(arguments.file.profiles, detection.FileOptions());
    rows = file.rows.size();
    detection.SetGrid(file.grid);
    if (rows == 1) detection.BelieveSingleProfiles();
    for (const auto& row : file.rows) detection.Take(row);
  }
  detection.Finish(rows);
}

void AddDetect(CLI::App& seam) {
  auto* command =
      seam.add_subcommand("detect", "Detect edge positions in profiles, recorded or streamed.");
  auto arguments = std::make_shared<DetectArguments>();
  command
      ->add_option("profiles", arguments->file.profiles,
                   "CSV, 16-bit PNG/PGM/TIFF or floating-point TIFF, one profile per row; - reads "
                   "CSV rows from stdin")
      ->required();
  command->add_option("--method", arguments->method, "decision method (steps)")
      ->check(CLI::IsMember(base::WordList<seam::DecisionMethod>()));
  auto* options = command->add_option(
      "--options", arguments->file.options,
      "YAML file with the keys `tracker` and `monitor` of an experiment, and `file`");
  auto* columns =
      command
          ->add_option("--columns-per-mm", arguments->columns_per_mm,
                       "columns per mm of the sensor's line (12; computed if the file has x)")
          ->check(CLI::Range(0.1, 1000.0))
          ->excludes(options);
  command->add_option("--rate", arguments->rate_hz, "profiles per second (62)")
      ->check(CLI::Range(0.1, 1e5));
  auto* unit = AddUnit(*command, arguments->file);
  command
      ->add_option("--calibration", arguments->calibration,
                   "calibration (YAML); the input numbers are then camera rows (images: 64 grey "
                   "levels per row)")
      ->excludes(columns)
      ->excludes(unit);
  command->add_flag("--negative", arguments->negative,
                    "the high mat is at the small column numbers");
  command->add_flag("--json", arguments->json, "print one JSON object per profile");
  command->add_flag("--xml", arguments->xml, "print the packets for the robot, one every 100 ms");
  command->add_option("--picture", arguments->picture,
                      "SVG file of one profile with its detectors");
  command->add_option("--picture-row", arguments->picture_row, "number of this profile (1)")
      ->check(CLI::PositiveNumber);
  AddFormatOptions(*command, arguments->file);
  command->footer(
      "Example: rangegrasp seam detect profiles.csv --method weights --picture profile.svg\n"
      "         rangegrasp seam detect recording.csv --preset gocator\n"
      "         rangegrasp seam detect points.txt --layout points --decimal-comma --no-value -999");
  command->callback([arguments] { Detect(*arguments); });
}

void AddSeamCommands(CLI::App& app) {
  auto* seam = app.add_subcommand(
      "seam", "Detect edges of overlapping fibre mats in laser-stripe profiles.");
  seam->require_subcommand(1);
  seam->footer("Example: rangegrasp seam detect profiles.csv --method weights");
  AddSeamGenerate(*seam);
  AddSeamCalibrate(*seam);
  AddDetect(*seam);
}

}  // namespace
}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterSeam() {
  experiment::AddKind(seam::SeamTask());
  cli::AddCommand(cli::AddSeamCommands);
  cli::AddListing({"formats", "every key of profile formats: the page docs/profile-formats.md",
                   cli::ProfileKeysPage, false});
}

}  // namespace rangegrasp
