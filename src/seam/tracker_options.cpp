#include "core/yaml_map.h"
#include "seam/tracker.h"

namespace rangegrasp::seam {
namespace {

using core::YamlMap;

constexpr double kMm = 1e-3;

void ReadFilter(YamlMap map, FilterOptions& options) {
  map.Read("half_width_columns", options.half_width_columns, 1, 512);
  map.ReadScaled("half_height_mm", options.half_height_m, kMm, 0.001, 100.0);
  map.Read("min_neighbours", options.min_neighbours, 0, 1024);
  map.Finish();
}

void ReadDetectors(YamlMap map, DetectorOptions& options) {
  map.ReadEnum("model_levels", options.model_fitting.levels,
               {"extremes", "running_extremes", "means"});
  map.Read("half_window_columns", options.local_weighted_voting.half_window, 1, 4096);
  map.Read("candidates", options.local_weighted_voting.candidates, 1, 4096);
  map.Read("kernel", options.gradient_accumulation.kernel, 0.001, 0.5);
  map.Finish();
}

void ReadStep(YamlMap map, StepOptions& options) {
  map.Read("half_window_columns", options.half_window, 1, 512);
  map.Read("median_half_width_columns", options.median_half_width, 0, 512);
  map.Read("continued", options.continued, 0.0, 1.0);
  map.ReadScaled("min_step_mm", options.min_step_m, kMm, 0.001, 100.0);
  map.Finish();
}

}  // namespace

void ReadTrackerOptions(core::YamlMap& map, TrackerOptions& options) {
  map.ReadEnum("method", options.method, {"voting", "weights", "accumulated"});
  map.ReadScaled("columns_per_mm", options.line.columns_per_m, 1.0 / kMm, 0.1, 1000.0);
  ReadFilter(map.Child("filter"), options.preprocess.filter);
  map.Read("normalise", options.preprocess.normalise);
  map.Read("min_columns", options.preprocess.min_columns, 8, 65536);
  ReadDetectors(map.Child("detectors"), options.detectors);
  map.ReadScaled("vote_tolerance_mm", options.vote_tolerance_m, kMm, 0.01, 100.0);
  map.ReadScaled("packet_period_ms", options.packet_period_s, kMm, 1.0, 10'000.0);
  map.Read("line_inlier_columns", options.line_prediction.inlier_columns, 0.1, 1024.0);
  map.Read("line_max_slope_columns_per_s", options.line_prediction.max_slope_columns_per_s, 1.0,
           1e6);
  map.Read("history_length", options.history.length, 1, 1000);
  map.Read("history_sigma_columns", options.history.sigma_columns, 0.5, 4096.0);
  map.Read("memory", options.accumulation.memory, 0.0, 0.999);
  map.Read("spread_columns", options.accumulation.spread_columns, 0.1, 1024.0);
  ReadStep(map.Child("step"), options.step);
  map.Read("positive_edge", options.positive_edge);
}

TrackerOptions ReadTrackerOptions(const std::filesystem::path& file) {
  TrackerOptions options;
  auto map = YamlMap::FromFile(file);
  ReadTrackerOptions(map, options);
  map.Finish();
  return options;
}

}  // namespace rangegrasp::seam
