#include "cylinders/task/cylinders_options.h"

#include <fmt/format.h>

#include "base/number.h"
#include "sensing/line_scanner.h"

namespace rangegrasp::cylinder_task {
namespace {

constexpr int kMaxPoints = 1'000'000;
constexpr int kMaxIterations = 100'000;

std::vector<double> NumbersOf(const base::YamlMap& map, const std::string& key,
                              const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& part : base::Split(text, ',')) {
    const auto first = part.find_first_not_of(' ');
    const std::string trimmed = first == std::string::npos ? "" : part.substr(first);
    const auto number = base::NumberFrom<double>(trimmed);
    if (!number) map.Fail(key, fmt::format("'{}' in '{}' is no number", part, text));
    numbers.push_back(*number);
  }
  return numbers;
}

CylinderRow RowOf(const base::YamlMap& map, const std::string& text) {
  const auto numbers = NumbersOf(map, "rows", text);
  if (numbers.size() != 3 || !(numbers[0] > 0.0) || !(numbers[1] > 0.0) || !(numbers[2] >= 100.0) ||
      numbers[2] > kMaxPoints) {
    map.Fail("rows", fmt::format("'{}' must be radius in mm, height in mm, points (100 to {}), as "
                                 "in \"10, 100, 20000\"",
                                 text, kMaxPoints));
  }
  return {{numbers[0] * base::kMm, numbers[1] * base::kMm}, static_cast<int>(numbers[2])};
}

}  // namespace

void ReadCylindersKeys(base::YamlMap& map, Options& o) {
  map.Read("shown", o.shown, "resolution: table 4.3, fig. 4.13; iterations: 4.4, figs. 4.14-4.19");
  std::vector<std::string> rows;
  map.Read("rows", rows, "cylinders: \"radius in mm, height in mm, points\" each");
  for (const std::string& row : rows) o.rows.push_back(RowOf(map, row));
  map.Read("sources", o.sources, "where the points come from");
  map.Read("methods", o.methods, "fits that are compared");
  std::vector<std::string> iterations;
  for (const int count : o.iterations) iterations.push_back(fmt::format("{}", count));
  map.Read("iterations", iterations,
           "of lsf, triples of rcf and refined, hypotheses of pcl: each is a row or a dot");
  o.iterations.clear();
  for (const std::string& text : iterations) {
    const double count = NumbersOf(map, "iterations", text).front();
    if (!(count >= 1.0) || count > kMaxIterations) {
      map.Fail("iterations", fmt::format("'{}' must be 1 to {}", text, kMaxIterations));
    }
    o.iterations.push_back(static_cast<int>(count));
  }
  map.Read("repetitions", o.repetitions, 1, 100000, "range images of each row and source");
  map.ReadScaled("neighborhood_mm", o.neighborhood_m, base::kMm, 0.1, 100.0,
                 "of normals and curvature points");
  map.ReadScaled("noise_mm", o.noise_m, base::kMm, 0.0, 100.0,
                 "along the rays, of source noisy; 0: the scanner's own at that distance");
  map.ReadScaled("distance_mm", o.view.distance_m, base::kMm, 300.0, 5000.0,
                 "from the sensor to the cylinder's middle");
  map.ReadScaled("pitch_deg", o.view.pitch_rad, base::kDeg, 0.0, 85.0,
                 "by which the sensor looks down");
  map.ReadPath("sensor", o.sensor, "the line scanner, of sources noisy and scanned");
  map.ReadPath("reference", o.reference, "the published table as CSV");
}

Options ReadOptions(base::YamlMap& map) {
  Options options;
  ReadCylindersKeys(map, options);
  map.Require("rows");
  map.Finish();
  if (!options.sensor.empty()) options.scanned.scanner = sensing::ReadLineScanner(options.sensor);
  if (options.noise_m == 0.0) {
    options.noise_m = sensing::DepthSigma(options.scanned.scanner, options.view.distance_m);
  }
  return options;
}

}  // namespace rangegrasp::cylinder_task
