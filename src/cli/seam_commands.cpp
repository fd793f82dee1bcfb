#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/seam_calibration.h"
#include "cli/seam_pictures.h"
#include "core/error.h"
#include "core/units.h"
#include "report/seam_table.h"
#include "seam/monitor.h"
#include "seam/profile_io.h"
#include "stitching/evaluation.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;
using stitching::Evaluation;

constexpr double kMm = 1e3;
constexpr int kFewestColumns = 32;

// ---- detect: recorded profiles or a stream ----

struct DetectArguments {
  std::string profiles, options, calibration, method, picture, unit = "mm";
  int picture_row = 1;
  double columns_per_mm = 12.0, rate_hz = 62.0;
  bool negative = false, json = false, xml = false;
};

seam::DecisionMethod MethodFrom(const std::string& name) {
  if (name == "weights") return seam::DecisionMethod::kWeights;
  return name == "accumulated" ? seam::DecisionMethod::kAccumulated : seam::DecisionMethod::kVoting;
}

double UnitOf(const std::string& name) {
  if (name == "um") return 1e-6;
  return name == "m" ? 1.0 : 1e-3;
}

// Everything that one profile goes through.
class Detection {
 public:
  explicit Detection(const DetectArguments& arguments) : arguments_(arguments) {
    if (!arguments.options.empty()) options_ = seam::ReadTrackerOptions(arguments.options);
    if (!arguments.method.empty()) {
      options_.method = MethodFrom(arguments.method);
    }
    if (arguments.options.empty()) options_.line.columns_per_m = arguments.columns_per_mm * kMm;
    if (arguments.negative) options_.positive_edge = false;
    if (!arguments.calibration.empty()) {
      calibration_ = seam::ReadCalibration(arguments.calibration);
    }
  }

  seam::ProfileFileOptions FileOptions() const {
    seam::ProfileFileOptions file;
    file.rate_hz = arguments_.rate_hz;
    file.unit_m = UnitOf(arguments_.unit);
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
      WriteResult(ProfileSvg(*tracker_, reading, options_.line), arguments_.picture);
      drawn_ = true;
    }
  }

  void Finish(std::size_t rows) const {
    if (!arguments_.picture.empty() && !drawn_) {
      throw core::InputError("--picture-row " + std::to_string(arguments_.picture_row) +
                             ": there are only " + std::to_string(rows) + " profiles");
    }
  }

 private:
  void Begin(int columns) {
    if (columns < kFewestColumns) {
      throw core::InputError(fmt::format("{}: its profiles have {} columns; a line has at least {}",
                                         arguments_.profiles == "-" ? "stdin" : arguments_.profiles,
                                         columns, kFewestColumns));
    }
    options_.line.columns = columns;
    if (calibration_) options_.line.columns_per_m = 1.0 / calibration_->meters_per_column[0];
    tracker_.emplace(options_);
    monitor_.emplace(options_.line, seam::MonitorOptions{});
    if (!arguments_.json && !arguments_.xml) {
      WriteResult(
          "profile,time_s,status,column,x_mm,step_mm,model_fitting,local_weighted_voting,gradient_"
          "accumulation,stop\n");
    }
  }

  void PrintLine(const seam::Reading& reading, std::optional<seam::StopReason> stop,
                 std::size_t row) const {
    std::string line =
        fmt::format("{},{:.4f},{},", row, reading.time_s, seam::Name(reading.status));
    line +=
        reading.column ? fmt::format("{:.2f},{:.4f},", *reading.column, reading.x_m * kMm) : ",,";
    line += fmt::format("{:.3f}", reading.step_m * kMm);
    for (const auto& column : reading.detected) line += column ? fmt::format(",{}", *column) : ",";
    WriteResult(line + "," + (stop ? seam::Name(*stop) : "") + "\n");
  }

  void PrintJson(const seam::Reading& reading, std::optional<seam::StopReason> stop,
                 std::size_t row) const {
    ordered_json json = {
        {"profile", row},    {"time_s", reading.time_s}, {"status", seam::Name(reading.status)},
        {"column", nullptr}, {"x_m", nullptr},           {"step_m", reading.step_m}};
    if (reading.column) {
      json["column"] = *reading.column;
      json["x_m"] = reading.x_m;
    }
    for (std::size_t d = 0; d < seam::kDetectors; ++d) {
      const char* name = seam::Name(static_cast<seam::Detector>(d));
      json["detectors"][name] =
          reading.detected[d] ? ordered_json(*reading.detected[d]) : ordered_json(nullptr);
    }
    json["stop"] = stop ? ordered_json(seam::Name(*stop)) : ordered_json(nullptr);
    WriteResult(json.dump() + "\n");
  }

  void PrintXml(const seam::EdgePacket& packet, std::optional<seam::StopReason> stop) const {
    stitching::Correction correction;
    correction.time_s = packet.time_s;
    correction.valid = packet.column.has_value();
    correction.edge_x_m = packet.x_m;
    correction.deviation_m = packet.x_m;
    correction.stop = stop;
    std::string xml = stitching::ToXml(correction);
    if (!xml.ends_with('\n')) xml += '\n';
    WriteResult(xml);
  }

  DetectArguments arguments_;
  seam::TrackerOptions options_;
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
    for (const auto& profile : seam::ReadProfiles(arguments.profiles, detection.FileOptions())) {
      detection.Take(profile, ++rows);
    }
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
      ->check(CLI::IsMember({"voting", "weights", "accumulated"}));
  command->add_option("--options", arguments->options, "YAML of the tracker's options");
  command->add_option("--columns-per-mm", arguments->columns_per_mm, "of the sensor's line (12)")
      ->check(CLI::Range(0.1, 1000.0));
  command->add_option("--rate", arguments->rate_hz, "profiles a second (62)")
      ->check(CLI::Range(0.1, 1e5));
  command->add_option("--unit", arguments->unit, "of the heights (mm)")
      ->check(CLI::IsMember({"um", "mm", "m"}));
  command->add_option("--calibration", arguments->calibration,
                      "YAML; the numbers are then camera rows (images: 64 grey levels a row)");
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

// ---- evaluate and track ----

struct EvaluateArguments {
  std::string experiment, out, format = "text", method = "voting";
  std::optional<std::uint64_t> seed;
  std::optional<int> seams;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  int run = 0;
  bool json = false;
};

Evaluation EvaluationFrom(const EvaluateArguments& arguments) {
  Evaluation evaluation = stitching::ReadEvaluation(arguments.experiment);
  if (arguments.seed) evaluation.seed = *arguments.seed;
  if (arguments.seams) evaluation.seams = *arguments.seams;
  return evaluation;
}

std::filesystem::path FolderOf(const EvaluateArguments& arguments, const Evaluation& evaluation) {
  return arguments.out.empty() ? std::filesystem::path("results") / evaluation.name
                               : std::filesystem::path(arguments.out);
}

void Evaluate(const EvaluateArguments& arguments) {
  const Evaluation evaluation = EvaluationFrom(arguments);
  const auto folder = FolderOf(arguments, evaluation);
  // A broken published table, or a folder that cannot be made, shows before the work.
  report::FormatSeam(evaluation, {}, report::TableFormat::kText);
  MakeFolderOf(folder / "rows.csv");
  const auto progress = [](int done, int total) {
    if (!isatty(STDERR_FILENO)) return;
    std::fprintf(stderr, "\r%d/%d\033[K%s", done, total, done == total ? "\n" : "");
  };
  const auto result = stitching::Evaluate(evaluation, arguments.jobs, progress);
  WriteResult(report::SeamRowsCsv(result), folder / "rows.csv");
  const std::string json = report::FormatSeam(evaluation, result, report::TableFormat::kJson);
  WriteResult(json, folder / "tables.json");
  WriteResult(arguments.json
                  ? json
                  : report::FormatSeam(evaluation, result, ParseTableFormat(arguments.format)));
}

void Track(const EvaluateArguments& arguments) {
  Evaluation evaluation = EvaluationFrom(arguments);
  if (evaluation.kind == stitching::EvaluationKind::kRates) {
    throw core::InputError(arguments.experiment +
                           ": key 'kind' is 'rates'; seam track needs 'tracks' or 'hazards'");
  }
  const auto method = MethodFrom(arguments.method);
  const auto run = stitching::TrackRun(evaluation, method, arguments.run);
  const auto& track = run.result;
  const auto folder = FolderOf(arguments, evaluation);
  std::string path = "time_s,x_mm,y_mm,heading_deg,distance_mm\n";
  for (const auto& p : track.path) {
    path += fmt::format("{:.3f},{:.4f},{:.4f},{:.4f},{:.4f}\n", p.time_s, p.x_m * kMm, p.y_m * kMm,
                        core::ToDeg(p.heading_rad), p.distance_m * kMm);
  }
  WriteResult(path, folder / "path.csv");
  std::string packets;
  for (const auto& packet : track.packets) packets += packet + (packet.ends_with('\n') ? "" : "\n");
  WriteResult(packets, folder / "packets.xml");
  WriteResult(TrackSvg(track, run.mats, evaluation.track.wanted_distance_m), folder / "path.svg");
  const ordered_json json = {
      {"end", stitching::Name(track.end)},  {"reached_hazard", track.reached_hazard},
      {"mean_error_m", track.mean_error_m}, {"p95_error_m", track.p95_error_m},
      {"max_error_m", track.max_error_m},   {"share_within_1mm", track.share_within_1mm},
      {"corrections", track.packets.size()}};
  if (arguments.json) {
    WriteResult(json.dump(2) + "\n");
  } else {
    WriteResult(fmt::format(
        "end: {}\nerror after 100 mm: mean {:.3f} mm, 95 % {:.3f} mm, max {:.3f} mm; within 1 mm: "
        "{:.2f} % of the length\n{} corrections; path.csv, packets.xml, path.svg in {}\n",
        stitching::Name(track.end), track.mean_error_m * kMm, track.p95_error_m * kMm,
        track.max_error_m * kMm, track.share_within_1mm * 100.0, track.packets.size(),
        folder.string()));
  }
}

void AddCommon(CLI::App& command, EvaluateArguments& arguments) {
  command.add_option("experiment", arguments.experiment, "seam experiment file")->required();
  command.add_option("-o,--out", arguments.out, "folder (results/<name>)");
  command.add_option("--seed", arguments.seed, "instead of the experiment's");
  command.add_flag("--json", arguments.json);
}

void AddEvaluate(CLI::App& seam) {
  auto* command = seam.add_subcommand("evaluate", "Runs a seam experiment and prints its tables.");
  auto arguments = std::make_shared<EvaluateArguments>();
  AddCommon(*command, *arguments);
  command->add_option("--seams", arguments->seams, "instead of the experiment's")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--jobs", arguments->jobs)->check(CLI::Range(1, 1024));
  command->add_option("--format", arguments->format)
      ->check(CLI::IsMember({"text", "markdown", "csv", "json"}));
  command->footer("Example: rangegrasp seam evaluate experiments/seam_base.yaml");
  command->callback([arguments] { Evaluate(*arguments); });
}

void AddTrack(CLI::App& seam) {
  auto* command = seam.add_subcommand("track", "One closed-loop run, with its path and packets.");
  auto arguments = std::make_shared<EvaluateArguments>();
  AddCommon(*command, *arguments);
  command->add_option("--run", arguments->run, "its number, from 0")->check(CLI::NonNegativeNumber);
  command->add_option("--method", arguments->method, "line prediction or historic weighting")
      ->check(CLI::IsMember({"voting", "weights", "accumulated"}));
  command->footer(
      "Example: rangegrasp seam track experiments/seam_track.yaml --run 4 -o results/track4");
  command->callback([arguments] { Track(*arguments); });
}

}  // namespace

void AddSeamCommands(CLI::App& app) {
  auto* seam =
      app.add_subcommand("seam", "Edges of overlapping fibre mats in laser-stripe profiles.");
  seam->require_subcommand(1);
  seam->footer("Example: rangegrasp seam evaluate experiments/seam_base.yaml");
  AddSeamGenerate(*seam);
  AddSeamCalibrate(*seam);
  AddDetect(*seam);
  AddEvaluate(*seam);
  AddTrack(*seam);
}

}  // namespace rangegrasp::cli
