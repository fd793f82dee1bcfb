#include <cstdlib>

#include "core/units.h"
#include "core/yaml_map.h"
#include "stitching/stripe_sensor.h"

namespace rangegrasp::stitching {
namespace {

constexpr double kMm = 1e-3;
constexpr double kLongest_mm = 1000.0;

// lines_ahead_mm: the fixed line, then the places that the second line switches between.
void ReadLines(core::YamlMap& map, std::vector<double>& lines_m) {
  std::vector<std::string> words;
  map.Read("lines_ahead_mm", words);
  if (words.empty()) return;
  lines_m.clear();
  for (const std::string& word : words) {
    char* end = nullptr;
    const double mm = std::strtod(word.c_str(), &end);
    if (*end != '\0' || !(mm > 0.0 && mm <= kLongest_mm)) {
      map.Fail("lines_ahead_mm", "'" + word + "' must be a number above 0 and at most 1000");
    }
    lines_m.push_back(mm * kMm);
  }
}

}  // namespace

StripeSensorOptions ReadStripeSensor(const std::filesystem::path& file) {
  auto map = core::YamlMap::FromFile(file);
  StripeSensorOptions o;
  std::string type = "stripe_sensor";
  map.Read("type", type);
  if (type != "stripe_sensor") map.Fail("type", "'" + type + "' must be stripe_sensor");
  map.Read("name", o.name);
  map.Read("columns", o.line.columns, 32, 65536);
  map.ReadScaled("columns_per_mm", o.line.columns_per_m, 1.0 / kMm, 0.1, 1000.0);
  ReadLines(map, o.lines_ahead_m);
  map.ReadScaled("standoff_mm", o.standoff_m, kMm, 20.0, 5000.0);
  map.ReadScaled("angle_deg", o.angle_rad, core::kPi / 180.0, 1.0, 80.0);
  map.Read("rows", o.rows, 16, 65536);
  map.Read("rate_min_hz", o.rate_min_hz, 0.1, 1e5);
  map.Read("rate_max_hz", o.rate_max_hz, 0.1, 1e5);
  if (o.rate_min_hz > o.rate_max_hz) {
    map.Fail(map.Has("rate_max_hz") ? "rate_max_hz" : "rate_min_hz",
             "rate_max_hz must not be below rate_min_hz");
  }
  map.Read("row_sigma_px", o.row_sigma_px, 0.0, 100.0);
  map.Read("row_quantum_px", o.row_quantum_px, 0.0, 100.0);
  map.Read("speckle", o.speckle, 0.0, 1.0);
  map.Read("lost_return", o.lost_return, 0.0, 1.0);
  map.Read("outlier_share", o.outlier_share, 0.0, 1.0);
  map.Read("outlier_run_columns", o.outlier_run_columns, 1.0, 1000.0);
  map.Read("outlier_sigma_px", o.outlier_sigma_px, 0.0, 10'000.0);
  map.Read("phantom_share", o.phantom_share, 0.0, 1.0);
  map.Finish();
  return o;
}

}  // namespace rangegrasp::stitching
