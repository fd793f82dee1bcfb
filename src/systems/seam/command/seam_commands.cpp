#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "seam/calibration.h"
#include "seam/command/seam_detect.h"
#include "seam/profile_io.h"
#include "seam/task/seam_experiment.h"
#include "seam/task/seam_task.h"

namespace rangegrasp::cli {
namespace {

using seam::SeamExperiment;

struct GenerateArguments {
  std::string experiment, out;
  int seam = 0;
  bool raw = false, body = false;

  std::filesystem::path Beside(const char* ending) const {
    return std::filesystem::path(out).replace_extension(ending);
  }
};

// Writes scans of the calibration body and the heights of its base, as `calibrate` reads them.
void GenerateBody(const SeamExperiment& experiment, const GenerateArguments& arguments) {
  std::vector<seam::Profile> rows;
  std::string bases = "scan,base_mm\n";
  for (const auto& scan :
       seam::CalibrationScansOf(experiment, seam::StripeSensor(experiment.sensor))) {
    rows.push_back({scan.profile.row_px, 0.0});
    bases += fmt::format("{},{:.6f}\n", rows.size(), scan.base_height_m * base::kMmPerM);
  }
  seam::WriteProfiles(rows, arguments.out, kRowUnit);
  WriteResult(bases, arguments.Beside(".bases.csv"));
  spdlog::info("{} of the calibration body in {}, its heights in a file next to it",
               base::Counted(rows.size(), "scan"), arguments.out);
}

void Generate(const GenerateArguments& arguments) {
  const SeamExperiment experiment = seam::ReadSeamExperiment(arguments.experiment);
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
                      arguments.raw ? kRowUnit : seam::HeightScale{}.unit_m);
  WriteResult(seam::LabelsCsv(recording), arguments.Beside(".labels.csv"));
  if (arguments.raw) seam::WriteCalibration(calibration, arguments.Beside(".calibration.yaml"));
  spdlog::info("{} in {}, their labels in a file next to it",
               base::Counted(profiles.size(), "profile"), arguments.out);
}

struct CalibrateArguments {
  std::string scans, bases, out;
  std::vector<double> step_heights_mm;
  std::optional<double> step_width_mm;
};

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
  throw base::InputError(fmt::format("{}: has the heights of {}, but {} has {}", arguments.bases,
                                     base::Counted(bases.rows(), "scan"), arguments.scans,
                                     base::Counted(rows.size(), "scan")));
}

// Maximum rms residual, relative to the body's highest step. That of the two simulated sensors is
// 0.001 and 0.004; step heights that are wrong by a factor of 2 give 0.16 and more.
constexpr double kMaxResidual = 0.05;

void CheckFit(const seam::Calibration& calibration, const seam::CalibrationBody& body) {
  if (calibration.residual_m <= kMaxResidual * std::ranges::max(body.step_heights_m)) return;
  std::vector<std::string> steps;
  for (const double height_m : body.step_heights_m) {
    steps.push_back(fmt::format("{:g}", height_m * base::kMmPerM));
  }
  throw base::InputError(fmt::format(
      "the scans do not fit steps of {} mm (residual {:.2g} mm): check --step-heights-mm and "
      "--bases",
      base::Join(steps, ","), calibration.residual_m * base::kMmPerM));
}

void Calibrate(const CalibrateArguments& arguments) {
  const auto scans = ReadScans(arguments);
  seam::CalibrationBody body;
  if (!arguments.step_heights_mm.empty()) body.step_heights_m.clear();
  for (const double height : arguments.step_heights_mm) {
    body.step_heights_m.push_back(height / base::kMmPerM);
  }
  if (arguments.step_width_mm) body.step_width_m = *arguments.step_width_mm / base::kMmPerM;
  seam::Calibration calibration;
  try {
    calibration = seam::CalibrateFromBody(body, scans);
    CheckFit(calibration, body);
  } catch (const base::InputError& error) {
    throw base::InputError(fmt::format("{}: {} (the heights of the body's base are from {})",
                                       arguments.scans, error.what(), arguments.bases));
  }
  seam::WriteCalibration(calibration, arguments.out);
  spdlog::info(
      "calibration in {}: rows {:.0f} to {:.0f}, heights {:.1f} to {:.1f} mm, {:.2f} columns per "
      "mm, residual {:.2g} mm rms",
      arguments.out, calibration.row_min_px, calibration.row_max_px,
      calibration.HeightAt(calibration.row_min_px) * base::kMmPerM,
      calibration.HeightAt(calibration.row_max_px) * base::kMmPerM,
      1.0 / calibration.meters_per_column[0] / base::kMmPerM,
      calibration.residual_m * base::kMmPerM);
}

void AddSeamGenerate(CLI::App& seam) {
  auto* command = seam.add_subcommand("generate", "Simulate profiles of one seam, with labels.");
  auto arguments = std::make_shared<GenerateArguments>();
  command->add_option("experiment", arguments->experiment, "seam experiment file")->required();
  command->add_option("-o,--out", arguments->out, "output profiles (CSV)")->required();
  command->add_option("--seam", arguments->seam, "number of the seam, from 0")
      ->transform(WholeNumber(0, std::numeric_limits<int>::max()));
  command->add_flag("--raw", arguments->raw,
                    "write camera rows, with the calibration in a file next to them");
  command->add_flag("--body", arguments->body, "scan the calibration body instead of a seam");
  command->footer(
      "Example: rangegrasp seam generate experiments/seam_base.yaml --seam 3 -o results/seam3.csv");
  command->callback([arguments] { Generate(*arguments); });
}

void AddSeamCalibrate(CLI::App& seam) {
  auto* command =
      seam.add_subcommand("calibrate", "Calibrate a stripe sensor from scans of a stepped body.");
  auto arguments = std::make_shared<CalibrateArguments>();
  command
      ->add_option("scans", arguments->scans,
                   "camera rows, one scan per row: CSV, or 16-bit PNG (64 grey levels per row)")
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
      ->check(NumberBetween(0.0, 1000.0));
  command->add_option("--step-width-mm", arguments->step_width_mm, "width of each step (8)")
      ->check(NumberBetween(0.01, 1000.0));
  command->add_option("-o,--out", arguments->out, "output calibration (YAML)")->required();
  command->footer(
      "Example: rangegrasp seam calibrate body.csv --bases body.bases.csv -o sensor.yaml");
  command->callback([arguments] { Calibrate(*arguments); });
}

// ---- list formats ----

constexpr const char* kPage = R"(# Formats of profiles

`rangegrasp seam detect` reads profiles of other sensors according to these keys. They are below `file` in the YAML of `--options`, or given
by `--set file.KEY=VALUE`; the most used ones have their own option (`rangegrasp seam detect --help`). `--preset NAME` sets those of a sensor
family first. Keys of text files cannot be used with images, and keys of images not with text files. The other keys are those of
`tracker` and `monitor` in [experiment files](experiment-file.md).

This page is generated by `rangegrasp list formats` from the code that reads the files; a test compares them.

)";

std::vector<base::KeyDoc> DocumentedKeys() {
  auto map = base::YamlMap::ForDocumentation();
  seam::ProfileFileOptions options;
  seam::ReadProfileFileOptions(map.Child("file", "format of a profile file"), options);
  return map.Keys();
}

std::vector<ListEntry> ProfileKeys() {
  std::vector<ListEntry> entries;
  for (const base::KeyDoc& key : DocumentedKeys()) entries.push_back(EntryOf(key));
  return entries;
}

std::string ProfileKeysPage() {
  std::string page = kPage + experiment::KeyTable(DocumentedKeys()) + "\n## Presets\n";
  for (const auto& preset : seam::FormatPresets()) {
    page += fmt::format(
        "\n`{}`: {}.{}\n\n```yaml{}```\n", preset.name, preset.about,
        preset.needs.empty() ? "" : fmt::format(" `{}` must also be given.", preset.needs),
        preset.yaml);
  }
  return page;
}

void AddSeamCommands(CLI::App& app) {
  auto* seam = app.add_subcommand(
      "seam", "Detect edges of overlapping fibre mats in laser-stripe profiles.");
  seam->require_subcommand(1);
  seam->footer("Example: rangegrasp seam detect profiles.csv");
  AddSeamGenerate(*seam);
  AddSeamCalibrate(*seam);
  AddSeamDetect(*seam);
}

}  // namespace
}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterSeam() {
  experiment::AddKind(seam::SeamTask());
  cli::AddCommand(cli::AddSeamCommands);
  cli::AddListing({"formats", "every key of profile formats: the page docs/profile-formats.md",
                   cli::ProfileKeys, false, cli::ProfileKeysPage});
}

}  // namespace rangegrasp
