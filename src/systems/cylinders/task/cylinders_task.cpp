#include "cylinders/task/cylinders_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "base/file.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "cylinders/fit.h"
#include "cylinders/task/cylinder_scans.h"
#include "pcl_bridge/pcl_segmentation.h"
#include "sensing/line_scanner.h"

namespace rangegrasp::cylinders {
namespace {

/// A row of the table.
struct CylinderRow {
  CylinderShape shape;
  int points = 0;
};

struct ComparisonOptions {
  Shown shown = Shown::kResolution;
  std::vector<CylinderRow> rows;
  std::vector<Source> sources = {Source::kPerfect, Source::kNoisy, Source::kScanned};
  std::vector<Method> methods = {Method::kLsf, Method::kPrinted, Method::kRcf, Method::kPcl,
                                 Method::kRefined};
  std::vector<int> iterations = {100};
  int repetitions = 50;
  double neighborhood_m = 0.005;
  double noise_m = 0.0;  ///< of source noisy, along the rays: the scanner's at this distance
  std::filesystem::path sensor;
  sensing::LineScannerOptions scanner;
  std::filesystem::path reference;
};

constexpr int kMaxPoints = 1'000'000;
constexpr int kMaxIterations = 100'000;

std::vector<double> NumbersOf(const base::YamlMap& map, const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& part : base::Split(text, ',')) {
    const auto number =
        base::NumberFrom<double>(part.substr(std::min(part.find_first_not_of(' '), part.size())));
    if (!number) map.Fail("rows", fmt::format("'{}' in '{}' is not a number", part, text));
    numbers.push_back(*number);
  }
  return numbers;
}

CylinderRow RowOf(const base::YamlMap& map, const std::string& text) {
  const auto numbers = NumbersOf(map, text);
  if (numbers.size() != 3 || !(numbers[0] > 0.0) || !(numbers[1] > 0.0) || !(numbers[2] >= 100.0) ||
      numbers[2] > kMaxPoints) {
    map.Fail("rows", fmt::format("'{}' must be radius in mm, height in mm, points (100 to {}), as "
                                 "in \"10, 100, 20000\"",
                                 text, kMaxPoints));
  }
  return {{numbers[0] * base::kMm, numbers[1] * base::kMm}, static_cast<int>(numbers[2])};
}

ComparisonOptions ReadComparisonKeys(base::YamlMap& map) {
  ComparisonOptions o;
  map.Read("shown", o.shown, "resolution: table 4.3, fig. 4.13; iterations: 4.4, figs. 4.14-4.19");
  std::vector<std::string> rows;
  map.Read("rows", rows, "cylinders: \"radius in mm, height in mm, points\" each");
  for (const std::string& row : rows) o.rows.push_back(RowOf(map, row));
  map.Read("sources", o.sources, "sources of the points");
  map.Read("methods", o.methods, "fits to compare");
  std::vector<std::string> iterations;
  for (const int count : o.iterations) iterations.push_back(fmt::format("{}", count));
  map.Read(
      "iterations", iterations,
      "iterations of lsf, triples of rcf and refined, hypotheses of pcl: each is a row or a dot");
  o.iterations.clear();
  for (const std::string& text : iterations) {
    const auto count = base::NumberFrom<double>(text);
    if (!count || !(*count >= 1.0) || *count > kMaxIterations || *count != std::floor(*count)) {
      map.Fail("iterations",
               fmt::format("'{}' must be a whole number from 1 to {}", text, kMaxIterations));
    }
    o.iterations.push_back(static_cast<int>(*count));
  }
  map.Read("repetitions", o.repetitions, 1, 100000,
           "number of range images of each row and source");
  map.ReadScaled("neighborhood_mm", o.neighborhood_m, base::kMm, 0.1, 100.0,
                 "neighborhood for normals and curvature points");
  map.ReadPath("sensor", o.sensor, "sources noisy and scanned: file of the line scanner");
  map.ReadPath("reference", o.reference, "published table as CSV");
  return o;
}

/// Reads all keys, to the end of the map.
ComparisonOptions ReadComparison(base::YamlMap& map) {
  ComparisonOptions options = ReadComparisonKeys(map);
  map.Require("rows");
  map.Finish();
  if (!options.sensor.empty()) options.scanner = sensing::ReadLineScanner(options.sensor);
  options.noise_m = sensing::DepthSigma(options.scanner, kSensorDistance_m);
  return options;
}

/// One method's fit of one cloud.
struct ComparedFit {
  Method method = Method::kLsf;
  int iterations = 0;
  std::optional<Barrel> barrel;      ///< nullopt if the fit failed
  double seconds = 0.0;              ///< total
  double preparation_seconds = 0.0;  ///< part of `seconds` for normals and curvature points
};

/// Draws depend on seed, method and iterations only; `refined` starts from RCF with as many
/// triples.
std::vector<ComparedFit> CompareFits(const FitInput& input, const ComparisonOptions& options,
                                     std::uint64_t seed) {
  base::Stopwatch watch;
  const RcfPreparation prepared = PrepareRcf(input, options.neighborhood_m);
  const double rcf_s = watch.Restart();
  const bool needs_normals = std::ranges::count(options.methods, Method::kPcl) > 0;
  const auto normals =
      needs_normals ? pcl_bridge::EstimateNormals(input.points, input.eye, options.neighborhood_m)
                    : geometry::Points();
  const double pcl_s = watch.Restart();
  const auto fit = [&](Method method, int iterations) -> std::optional<Barrel> {
    if (method == Method::kLsf) return FitLeastSquares(input.points, iterations);
    if (method == Method::kPcl) {
      const auto found =
          pcl_bridge::FitCylinder(input.points, input.eye, normals, {.max_draws = iterations});
      if (!found) return std::nullopt;
      return Barrel{{found->point, found->axis}, found->radius_m};
    }
    base::Rng rng(
        base::DeriveSeed(base::DeriveSeed(seed, "rcf"), static_cast<std::uint64_t>(iterations)));
    const auto rcf = FitRcf(input, prepared, iterations, method == Method::kPrinted, rng);
    return rcf && method == Method::kRefined ? FitRefined(input, *rcf) : rcf;
  };
  std::vector<ComparedFit> fits;
  for (const Method method : options.methods) {
    const double preparation_s = method == Method::kLsf   ? 0.0
                                 : method == Method::kPcl ? pcl_s
                                                          : rcf_s;
    for (const int iterations : options.iterations) {
      watch.Restart();
      const auto barrel = fit(method, iterations);
      fits.push_back({method, iterations, barrel, preparation_s + watch.Seconds(), preparation_s});
    }
  }
  return fits;
}

using experiment::Case;
using experiment::Result;
using nlohmann::ordered_json;

ordered_json JsonOf(const ComparedFit& fit, const CylinderShape& truth) {
  ordered_json json = {{"method", base::Word(fit.method)}, {"iterations", fit.iterations}};
  if (!fit.barrel) {
    json["failed"] = true;
    return json;
  }
  json["radius_mm"] = fit.barrel->radius_m * base::kMmPerM;
  json["radius_error_mm"] = std::abs(fit.barrel->radius_m - truth.radius_m) * base::kMmPerM;
  json["axis_error_deg"] =
      base::ToDeg(AngleBetween(fit.barrel->axis.direction, Eigen::Vector3d::UnitX()));
  return json;
}

class CylindersExperiment : public experiment::Task {
 public:
  CylindersExperiment(ComparisonOptions options, const experiment::Common& common)
      : options_(std::move(options)), seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const Source source : options_.sources) {
      for (std::size_t row = 0; row < options_.rows.size(); ++row) {
        for (int i = 0; i < options_.repetitions; ++i) {
          const std::string word(base::Word(source));
          const std::uint64_t of_row = base::DeriveSeed(base::DeriveSeed(seed_, word), row);
          cases.push_back({fmt::format("{}-{}-{:03}", word, row + 1, i),
                           word,
                           base::DeriveSeed(of_row, static_cast<std::uint64_t>(i)),
                           {{"source", word}, {"row", static_cast<int>(row)}, {"repetition", i}}});
        }
      }
    }
    return cases;
  }

  Result Run(const Case& which) const override {
    const CylinderRow& row = RowOf(which);
    const geometry::Points points = PointsOf(which);
    const auto fits =
        CompareFits({points, SensorPosition(), Eigen::Vector3d::UnitX()}, options_, which.seed);
    ordered_json list = ordered_json::array();
    std::vector<std::pair<std::string, double>> seconds;
    int failed = 0;
    for (const ComparedFit& fit : fits) {
      list.push_back(JsonOf(fit, row.shape));
      const auto name = fmt::format("{} {}", base::Word(fit.method), fit.iterations);
      seconds.emplace_back(name, fit.seconds);
      seconds.emplace_back(name + kPreparation, fit.preparation_seconds);
      failed += fit.barrel ? 0 : 1;
    }
    const ordered_json data = {{"points", points.size()}, {"fits", list}};
    return {"fitted", "fit", fmt::format("{} of {} fits failed", failed, fits.size()), data.dump(),
            seconds};
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
    if (!options_.reference.empty()) {
      stamp.data[experiment::kReferenceKey] = experiment::PublishedText(options_.reference);
    }
  }

 private:
  const CylinderRow& RowOf(const Case& which) const {
    return options_.rows.at(static_cast<std::size_t>(which.params.Int("row")));
  }

  geometry::Points PointsOf(const Case& which) const {
    const CylinderRow& row = RowOf(which);
    const auto source = base::FromWord<Source>(which.params.Text("source"), "source");
    base::Rng rng(base::DeriveSeed(which.seed, "view"));
    if (source == Source::kScanned) {
      return ScanCylinder(row.shape, row.points, options_.scanner, rng);
    }
    const double noise_m = source == Source::kNoisy ? options_.noise_m : 0.0;
    return SyntheticScan(row.shape, row.points, noise_m, rng);
  }

  ComparisonOptions options_;
  std::uint64_t seed_;
};

}  // namespace

const experiment::TaskKind& CylindersTask() {
  static const experiment::TaskKind kind{
      .name = "cylinder_fits",
      .description =
          "Comparison of fits of single cylinders: radius, axis and time of least squares, random "
          "circles, PCL's model and the refined fit (tables 4.3 and 4.4).",
      .trials_key = "repetitions",
      .uses_seed = true,
      .success = {},
      .read = [](base::YamlMap& map,
                 const experiment::Common& common) -> std::unique_ptr<experiment::Task> {
        return std::make_unique<CylindersExperiment>(ReadComparison(map), common);
      },
      .read_keys = [](base::YamlMap& map) { ReadComparisonKeys(map); },
      .report = ComparisonReport};
  return kind;
}

}  // namespace rangegrasp::cylinders
