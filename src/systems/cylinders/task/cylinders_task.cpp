#include "cylinders/task/cylinders_task.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/csv.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "cylinders/task/compare_fits.h"
#include "cylinders/task/cylinders_report.h"

namespace rangegrasp::cylinder_task {
namespace {

using experiment::Case;
using experiment::Result;
using nlohmann::ordered_json;

std::string NameOf(const ComparedFit& fit) {
  return fmt::format("{} {}", base::Word(fit.method), fit.iterations);
}

ordered_json JsonOf(const ComparedFit& fit, const CylinderShape& truth) {
  ordered_json json = {{"method", base::Word(fit.method)}, {"iterations", fit.iterations}};
  if (!fit.barrel) {
    json["failed"] = true;
    return json;
  }
  const FitError error = ErrorOf(*fit.barrel, truth);
  json["radius_mm"] = fit.barrel->radius_m * base::kMmPerM;
  json["radius_error_mm"] = std::abs(error.radius_m) * base::kMmPerM;
  json["axis_error_deg"] = base::ToDeg(error.axis_rad);
  return json;
}

std::string CsvOf(const CylinderView& view) {
  std::string text = "x_m,y_m,z_m,line\n";
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const Eigen::Vector3d& p = view.points[i];
    text += fmt::format("{},{},{},{}\n", p.x(), p.y(), p.z(), view.lines[i]);
  }
  return text;
}

class CylindersExperiment : public experiment::Task {
 public:
  CylindersExperiment(Options options, const experiment::Common& common)
      : options_(std::move(options)), seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const Source source : options_.sources) {
      for (std::size_t row = 0; row < options_.rows.size(); ++row) {
        for (int i = 0; i < options_.repetitions; ++i) {
          const std::string word(base::Word(source));
          const ordered_json params = {{"source", word}, {"row", row}, {"repetition", i}};
          const std::uint64_t of_row = base::DeriveSeed(base::DeriveSeed(seed_, word), row);
          cases.push_back({fmt::format("{}-{}-{:03}", word, row + 1, i), word,
                           base::DeriveSeed(of_row, static_cast<std::uint64_t>(i)), params.dump()});
        }
      }
    }
    return cases;
  }

  Result Run(const Case& which) const override {
    const CylinderRow& row = RowOf(which);
    const CylinderView view = ViewOf(which);
    const auto fits = CompareFits(view.Input(), options_, which.seed);
    ordered_json list = ordered_json::array();
    std::vector<std::pair<std::string, double>> seconds;
    int failed = 0;
    for (const ComparedFit& fit : fits) {
      list.push_back(JsonOf(fit, row.shape));
      seconds.emplace_back(NameOf(fit), fit.seconds);
      seconds.emplace_back(NameOf(fit) + kPreparation, fit.preparation_seconds);
      failed += fit.barrel ? 0 : 1;
    }
    const ordered_json data = {{"points", view.points.size()}, {"fits", list}};
    return {"fitted", "fit", fmt::format("{} of {} fits failed", failed, fits.size()), data.dump(),
            seconds};
  }

  Result Replay(const Case& which, const experiment::ReplayOptions& options) const override {
    if (!options.video.empty() || !options.camera.empty()) {
      throw base::InputError("a cylinder's fit has no video and no camera; its points are a CSV");
    }
    base::WriteFile(options.folder / which.id / "points.csv", CsvOf(ViewOf(which)));
    return Run(which);
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.data[kShown] = base::Word(options_.shown);
    stamp.data[kNoise] = fmt::format("{:.3f}", options_.noise_m * base::kMmPerM);
    ordered_json rows = ordered_json::array();
    for (const CylinderRow& row : options_.rows) {
      rows.push_back({{"radius_mm", row.shape.radius_m * base::kMmPerM},
                      {"height_mm", row.shape.height_m * base::kMmPerM},
                      {"points", row.points}});
    }
    stamp.data[kRows] = rows.dump();
    if (!options_.sensor.empty()) {
      stamp.identity["sensor"] = base::Hex(base::Fnv1a(base::ReadFile(options_.sensor)));
    }
    if (!options_.reference.empty()) stamp.data[kReference] = base::ReadFile(options_.reference);
  }

 private:
  const CylinderRow& RowOf(const Case& which) const {
    return options_.rows.at(nlohmann::json::parse(which.params).at("row"));
  }

  CylinderView ViewOf(const Case& which) const {
    const CylinderRow& row = RowOf(which);
    const std::string word = nlohmann::json::parse(which.params).at("source");
    const auto source = base::FromWord<Source>(word, "source");
    base::Rng rng(base::DeriveSeed(which.seed, "view"));
    if (source == Source::kScanned) {
      return ScanCylinder(row.shape, options_.view, row.points, options_.scanned, rng);
    }
    const double noise_m = source == Source::kNoisy ? options_.noise_m : 0.0;
    return SyntheticScan(row.shape, options_.view, row.points, noise_m, rng);
  }

  Options options_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  return std::make_unique<CylindersExperiment>(ReadOptions(map), common);
}

}  // namespace

const experiment::TaskKind& CylindersTask() {
  static const experiment::TaskKind kind{
      .name = "cylinders",
      .description =
          "Fits of single cylinders compared: radius, axis and time of least squares, random "
          "circles, PCL's model and the refined fit (tables 4.3 and 4.4).",
      .trials_key = "repetitions",
      .uses_seed = true,
      .success = {},
      .read = Read,
      .read_keys =
          [](base::YamlMap& map) {
            Options options;
            ReadCylindersKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::cylinder_task
