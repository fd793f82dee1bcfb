#include "seam/command/seam_calibration.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/csv.h"
#include "base/error.h"
#include "base/units.h"
#include "cli/output.h"
#include "seam/calibration_body.h"
#include "seam/task/seam_experiment.h"
#include "seam/task/seam_files.h"

namespace rangegrasp::cli {
namespace {

using seam::ProfileFileOptions;
using seam_task::SeamExperiment;

struct GenerateArguments {
  std::string experiment, out;
  int seam = 0;
  std::optional<std::uint64_t> seed;
  bool raw = false, body = false;
};

// Scans of the calibration body and the heights of its base, as `calibrate` reads them.
void GenerateBody(const SeamExperiment& experiment, const std::filesystem::path& out) {
  std::vector<seam::Profile> rows;
  std::string bases = "scan,base_mm\n";
  const stitching::StripeSensor sensor(experiment.sensor);
  for (const auto& scan : seam_task::CalibrationScansOf(experiment, sensor)) {
    rows.push_back({scan.profile.row_px, 0.0});
    bases += fmt::format("{},{:.6f}\n", rows.size(), scan.base_height_m * base::kMmPerM);
  }
  seam::WriteProfiles(rows, out, RowFileOptions());
  WriteResult(bases, std::filesystem::path(out).replace_extension(".bases.csv"));
  spdlog::info("{} scans of the calibration body in {}, its heights beside it", rows.size(),
               out.string());
}

void Generate(const GenerateArguments& arguments) {
  SeamExperiment experiment = seam_task::ReadSeamExperiment(arguments.experiment);
  if (arguments.seed) experiment.seed = *arguments.seed;
  if (arguments.body) {
    GenerateBody(experiment, arguments.out);
    return;
  }
  const stitching::StripeSensor sensor(experiment.sensor);
  const seam::Calibration calibration = seam_task::CalibrationOf(experiment, sensor);
  const stitching::Recording recording = seam_task::RecordSeam(experiment, sensor, arguments.seam);
  std::vector<seam::Profile> profiles;
  for (const seam::RawProfile& raw : recording.raw) {
    profiles.push_back(arguments.raw ? seam::Profile{raw.row_px, raw.time_s}
                                     : seam::Calibrate(raw, calibration));
  }
  const std::filesystem::path out(arguments.out);
  seam::WriteProfiles(profiles, out, arguments.raw ? RowFileOptions() : ProfileFileOptions{});
  WriteResult(seam_task::LabelsCsv(recording),
              std::filesystem::path(out).replace_extension(".labels.csv"));
  if (arguments.raw) {
    seam::WriteCalibration(calibration,
                           std::filesystem::path(out).replace_extension(".calibration.yaml"));
  }
  spdlog::info("{} profiles in {}, their labels beside it", profiles.size(), out.string());
}

struct CalibrateArguments {
  std::string scans, bases, out;
  std::vector<double> step_heights_mm;
  std::optional<double> step_width_mm;
};

seam::CalibrationBody BodyFrom(const CalibrateArguments& arguments) {
  seam::CalibrationBody body;
  if (!arguments.step_heights_mm.empty()) body.step_heights_m.clear();
  for (const double height : arguments.step_heights_mm)
    body.step_heights_m.push_back(height / base::kMmPerM);
  if (arguments.step_width_mm) body.step_width_m = *arguments.step_width_mm / base::kMmPerM;
  return body;
}

std::vector<seam::CalibrationScan> ReadScans(const CalibrateArguments& arguments) {
  const auto rows = seam::ReadProfiles(arguments.scans, RowFileOptions());
  const auto bases = base::CsvTable::Read(arguments.bases);
  const std::size_t base = bases.Column("base_mm");
  std::vector<double> bases_m;
  for (std::size_t i = 0; i < bases.rows(); ++i) {
    bases_m.push_back(bases.Number(i, base) / base::kMmPerM);
  }
  if (rows.size() != bases_m.size()) {
    throw base::InputError(fmt::format("{}: tells the heights of {} scans, {} holds {}",
                                       arguments.bases, bases_m.size(), arguments.scans,
                                       rows.size()));
  }
  std::vector<seam::CalibrationScan> scans;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    scans.push_back({{rows[i].height_m, 0.0}, bases_m[i]});
  }
  return scans;
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
      "calibration in {}: rows {:.0f} to {:.0f}, heights {:.1f} to {:.1f} mm, {:.2f} "
      "columns a mm",
      arguments.out, calibration.row_min_px, calibration.row_max_px,
      calibration.HeightAt(calibration.row_min_px) * base::kMmPerM,
      calibration.HeightAt(calibration.row_max_px) * base::kMmPerM,
      1.0 / calibration.meters_per_column[0] / base::kMmPerM);
}

}  // namespace

ProfileFileOptions RowFileOptions() {
  ProfileFileOptions options;
  options.text.scale.unit_m = 1.0;
  options.grey = {1.0 / 64.0, 0.0, {0.0}};
  options.signed_grey = {1.0 / 64.0, 0.0, {0.0}};
  options.real = {1.0, 0.0, {}};
  options.min_height_m = 0.0;
  options.max_height_m = 65535.0;
  return options;
}

void AddSeamGenerate(CLI::App& seam) {
  auto* command = seam.add_subcommand("generate", "Simulated profiles of one seam, with labels.");
  auto arguments = std::make_shared<GenerateArguments>();
  command->add_option("experiment", arguments->experiment, "seam experiment file")->required();
  command->add_option("-o,--out", arguments->out, "profiles: .csv, or .png/.pgm with 16 bits")
      ->required();
  command->add_option("--seam", arguments->seam, "its number, from 0")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--seed", arguments->seed, "instead of the experiment's");
  command->add_flag("--raw", arguments->raw, "camera rows, with the calibration beside them");
  command->add_flag("--body", arguments->body, "scans of the calibration body instead of a seam");
  command->footer(
      "Example: rangegrasp seam generate experiments/seam_base.yaml --seam 3 -o results/seam3.csv");
  command->callback([arguments] { Generate(*arguments); });
}

void AddSeamCalibrate(CLI::App& seam) {
  auto* command = seam.add_subcommand(
      "calibrate", "Calibration of a stripe sensor from scans of a stepped body.");
  auto arguments = std::make_shared<CalibrateArguments>();
  command
      ->add_option("scans", arguments->scans,
                   "camera rows, one scan a row: CSV, or 16-bit PNG/PGM (64 grey levels a row)")
      ->required();
  command
      ->add_option("--bases", arguments->bases,
                   "CSV with a header and a line 'scan,base_mm' a scan: the height of the body's "
                   "base in the sensor's frame")
      ->required();
  command
      ->add_option("--step-heights-mm", arguments->step_heights_mm,
                   "of the body's steps above its base (0,2,5,9,5,2,0)")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1000.0));
  command->add_option("--step-width-mm", arguments->step_width_mm, "of every step (8)")
      ->check(CLI::Range(0.01, 1000.0));
  command->add_option("-o,--out", arguments->out, "calibration, YAML")->required();
  command->footer(
      "Example: rangegrasp seam calibrate body.csv --bases body.bases.csv -o sensor.yaml");
  command->callback([arguments] { Calibrate(*arguments); });
}

}  // namespace rangegrasp::cli
