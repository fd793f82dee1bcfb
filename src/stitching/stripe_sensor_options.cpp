#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/yaml_map.h"
#include "stitching/internal/stripe_sensor_check.h"
#include "stitching/stripe_sensor.h"

namespace rangegrasp::stitching {
namespace {

using Options = StripeSensorOptions;

/// A key of a sensor file: where its value goes, the unit it is written in, its range there.
struct Key {
  std::string_view name;
  double Options::*member;
  double unit;  ///< SI value of 1
  double low;
  double high;
};

constexpr double kMm = 1e-3;

constexpr Key kKeys[] = {
    {"standoff_mm", &Options::standoff_m, kMm, 20.0, 2000.0},
    {"angle_rad", &Options::angle_rad, 1.0, 0.1, 1.4},
    {"range_below_mm", &Options::range_below_m, kMm, 1.0, 1000.0},
    {"range_above_mm", &Options::range_above_m, kMm, 1.0, 1000.0},
    {"rate_min_hz", &Options::rate_min_hz, 1.0, 1.0, 10'000.0},
    {"rate_max_hz", &Options::rate_max_hz, 1.0, 1.0, 10'000.0},
    {"row_sigma_px", &Options::row_sigma_px, 1.0, 0.0, 50.0},
    {"row_quantum_px", &Options::row_quantum_px, 1.0, 0.0, 50.0},
    {"speckle", &Options::speckle, 1.0, 0.0, 1.0},
    {"lost_return", &Options::lost_return, 1.0, 0.0, 1.0},
    {"outlier_share", &Options::outlier_share, 1.0, 0.0, 0.9},
    {"outlier_run_columns", &Options::outlier_run_columns, 1.0, 1.0, 1000.0},
    {"outlier_sigma_px", &Options::outlier_sigma_px, 1.0, 0.0, 10'000.0},
    {"phantom_share", &Options::phantom_share, 1.0, 0.0, 1.0},
    {"phantom_previous_share", &Options::phantom_previous_share, 1.0, 0.0, 1.0},
};
constexpr int kFewestColumns = 32;
constexpr int kMostPixels = 65'536;
constexpr double kLeastColumnsPerMm = 0.1;
constexpr double kMostColumnsPerMm = 1000.0;
constexpr double kFarthestLine_mm = 1000.0;

double RowFromMiddle(const Options& options, double height_m) {
  const double depth = options.standoff_m - height_m * std::cos(options.angle_rad);
  const double focal = options.line.columns_per_m * options.standoff_m;
  return focal * height_m * std::sin(options.angle_rad) / depth;
}

/// A key and what is wrong with its value.
struct Fault {
  std::string key;
  std::string what;
};

Fault OutOfRange(std::string_view key, double value, double low, double high) {
  std::ostringstream text;
  text << value << " is out of range, must be from " << low << " to " << high;
  return {std::string(key), text.str()};
}

std::optional<Fault> RelationFault(const Options& options) {
  if (options.rate_min_hz > options.rate_max_hz) {
    return Fault{"rate_min_hz", "must not be above rate_max_hz"};
  }
  if (options.range_above_m * std::cos(options.angle_rad) > 0.5 * options.standoff_m) {
    return Fault{"range_above_mm", "comes nearer to the camera than half of standoff_mm"};
  }
  const double half = 0.5 * (options.rows - 1);
  if (RowFromMiddle(options, options.range_above_m) > half) {
    return Fault{"range_above_mm", "is not seen: needs more rows or a smaller range"};
  }
  if (-RowFromMiddle(options, -options.range_below_m) > half) {
    return Fault{"range_below_mm", "is not seen: needs more rows or a smaller range"};
  }
  return std::nullopt;
}

std::optional<Fault> RangeFault(const Options& options) {
  const auto inside = [](double value, double low, double high) {
    // A relative slack, for a bound that went to SI units and back. NaN is not inside.
    const double slack = 1e-9 * std::max(std::abs(low), std::abs(high));
    return value >= low - slack && value <= high + slack;
  };
  for (const Key& key : kKeys) {
    const double value = options.*key.member / key.unit;
    if (!inside(value, key.low, key.high)) return OutOfRange(key.name, value, key.low, key.high);
  }
  const double density = options.line.columns_per_m * kMm;
  if (!inside(density, kLeastColumnsPerMm, kMostColumnsPerMm)) {
    return OutOfRange("columns_per_mm", density, kLeastColumnsPerMm, kMostColumnsPerMm);
  }
  if (!inside(options.line.columns, kFewestColumns, kMostPixels)) {
    return OutOfRange("columns", options.line.columns, kFewestColumns, kMostPixels);
  }
  if (!inside(options.rows, kFewestColumns, kMostPixels)) {
    return OutOfRange("rows", options.rows, kFewestColumns, kMostPixels);
  }
  if (options.lines_ahead_m.empty()) return Fault{"lines_ahead_mm", "must hold at least one line"};
  for (const double ahead : options.lines_ahead_m) {
    if (!inside(ahead / kMm, 0.0, kFarthestLine_mm)) {
      return OutOfRange("lines_ahead_mm", ahead / kMm, 0.0, kFarthestLine_mm);
    }
  }
  return std::nullopt;
}

// The mapping reads lists of words only.
void ReadLines(core::YamlMap& map, std::vector<double>& lines_m) {
  const std::string key = "lines_ahead_mm";
  std::vector<std::string> words;
  map.Read(key, words);
  if (words.empty()) return;
  lines_m.clear();
  for (const std::string& word : words) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0') map.Fail(key, "'" + word + "' is no number");
    lines_m.push_back(value * kMm);
  }
}

}  // namespace

namespace internal {

void CheckOptions(const StripeSensorOptions& options) {
  auto fault = RangeFault(options);
  if (!fault) fault = RelationFault(options);
  if (fault) throw std::invalid_argument("stripe sensor: " + fault->key + ": " + fault->what);
}

}  // namespace internal

StripeSensorOptions ReadStripeSensor(const std::filesystem::path& file) {
  auto map = core::YamlMap::FromFile(file);
  std::string type = "stripe_sensor";
  map.Read("type", type);
  if (type != "stripe_sensor") map.Fail("type", "'" + type + "' must be stripe_sensor");
  StripeSensorOptions options;
  map.Read("name", options.name);
  map.Read("columns", options.line.columns, kFewestColumns, kMostPixels);
  map.ReadScaled("columns_per_mm", options.line.columns_per_m, 1.0 / kMm, kLeastColumnsPerMm,
                 kMostColumnsPerMm);
  map.Read("rows", options.rows, kFewestColumns, kMostPixels);
  ReadLines(map, options.lines_ahead_m);
  for (const Key& key : kKeys) {
    map.ReadScaled(std::string(key.name), options.*key.member, key.unit, key.low, key.high);
  }
  map.Finish();
  auto fault = RangeFault(options);
  if (!fault) fault = RelationFault(options);
  if (fault) map.Fail(fault->key, fault->what);
  return options;
}

}  // namespace rangegrasp::stitching
