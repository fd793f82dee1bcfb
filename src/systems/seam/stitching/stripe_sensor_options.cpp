#include "seam/stitching/stripe_sensor_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <stdexcept>

#include "base/units.h"

namespace rangegrasp::stitching {
namespace {

using base::kMm;
using Options = StripeSensorOptions;

/// A key of a sensor file: where its value goes, the unit it is written in, its range there.
struct Key {
  const char* name;
  double Options::*member;
  double unit;  ///< SI value of 1
  double low;
  double high;
  const char* doc;
};

// The ranges keep out slips of unit; what they let in may still be refused by RelationFault.
constexpr Key kKeys[] = {
    {"standoff_mm", &Options::standoff_m, kMm, 20.0, 2000.0,
     "distance of the camera from the point where its axis meets height 0"},
    {"angle_rad", &Options::angle_rad, 1.0, 0.1, 1.4, "between the laser plane and that axis"},
    {"range_below_mm", &Options::range_below_m, kMm, 1.0, 1000.0,
     "heights below 0 that the calibration covers"},
    {"range_above_mm", &Options::range_above_m, kMm, 1.0, 1000.0, "and those above 0"},
    {"rate_min_hz", &Options::rate_min_hz, 1.0, 1.0, 10'000.0, "profiles a second on black mats"},
    {"rate_max_hz", &Options::rate_max_hz, 1.0, 1.0, 10'000.0, "and on bright ones"},
    {"row_sigma_px", &Options::row_sigma_px, 1.0, 0.0, 50.0,
     "noise of the row of a spot that returns all light, standard deviation"},
    {"row_correlation_columns", &Options::row_correlation_columns, 1.0, 0.0, 1000.0,
     "columns over which that noise fades; 0: each column's is its own"},
    {"row_quantum_px", &Options::row_quantum_px, 1.0, 0.0, 50.0,
     "rows are rounded to multiples of this; 0 does not round"},
    {"speckle", &Options::speckle, 1.0, 0.0, 1.0,
     "contrast of the speckle: standard deviation of a spot's strength over its mean"},
    {"lost_return", &Options::lost_return, 1.0, 0.0, 1.0, "a weaker spot is not found"},
    {"outlier_share", &Options::outlier_share, 1.0, 0.0, 0.9,
     "share of the found spots that are really reflections"},
    {"outlier_run_columns", &Options::outlier_run_columns, 1.0, 1.0, 1000.0,
     "columns that a reflection covers, on average"},
    {"outlier_sigma_px", &Options::outlier_sigma_px, 1.0, 0.0, 10'000.0,
     "rows by which a reflection is off, standard deviation"},
    {"phantom_share", &Options::phantom_share, 1.0, 0.0, 1.0,
     "share of the lost spots that report the brightest pixel of elsewhere"},
    {"phantom_previous_share", &Options::phantom_previous_share, 1.0, 0.0, 1.0,
     "share of those that show the previous line; the others are in any row"},
};
// Columns or rows: what a camera's side can have.
constexpr int kMaxPixels = 65'536;
constexpr double kMinColumnsPerMm = 0.1;
constexpr double kMaxColumnsPerMm = 1000.0;
constexpr double kMaxLineAhead_mm = 1000.0;
// Nearer to the camera than this share of its standoff a spot's column would depend on the height
// more than a calibration that is linear in it can tell.
constexpr double kMinDepthShare = 0.5;
// Relative, for a bound that went to SI units and back.
constexpr double kBoundSlack = 1e-9;

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

std::optional<Fault> RelationFault(const Options& options) {
  if (options.rate_min_hz > options.rate_max_hz) {
    return Fault{"rate_min_hz", "must not be above rate_max_hz"};
  }
  if (options.range_above_m * std::cos(options.angle_rad) > kMinDepthShare * options.standoff_m) {
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

// NaN is out of every range.
std::optional<Fault> OutOfRange(const char* key, double value, double low, double high) {
  const double slack = kBoundSlack * std::max(std::abs(low), std::abs(high));
  if (value >= low - slack && value <= high + slack) return std::nullopt;
  return Fault{key,
               fmt::format("{:g} is out of range, must be from {:g} to {:g}", value, low, high)};
}

std::optional<Fault> RangeFault(const Options& options) {
  for (const Key& key : kKeys) {
    if (auto fault = OutOfRange(key.name, options.*key.member / key.unit, key.low, key.high)) {
      return fault;
    }
  }
  const double density = options.line.columns_per_m * kMm;
  if (auto fault = OutOfRange("columns_per_mm", density, kMinColumnsPerMm, kMaxColumnsPerMm)) {
    return fault;
  }
  if (auto fault = OutOfRange("columns", options.line.columns, seam::kMinColumns, kMaxPixels)) {
    return fault;
  }
  if (auto fault = OutOfRange("rows", options.rows, seam::kMinColumns, kMaxPixels)) return fault;
  if (options.lines_ahead_m.empty()) return Fault{"lines_ahead_mm", "must hold at least one line"};
  for (const double ahead : options.lines_ahead_m) {
    if (auto fault = OutOfRange("lines_ahead_mm", ahead / kMm, 0.0, kMaxLineAhead_mm)) return fault;
  }
  return std::nullopt;
}

std::optional<Fault> FaultOf(const Options& options) {
  const auto fault = RangeFault(options);
  return fault ? fault : RelationFault(options);
}

// The mapping reads lists of words only.
void ReadLines(base::YamlMap& map, std::vector<double>& lines_m) {
  const std::string key = "lines_ahead_mm";
  std::vector<std::string> words;
  for (const double line : lines_m) words.push_back(fmt::format("{:g}", line / kMm));
  const auto defaults = words;
  map.Read(key, words,
           "distance of each laser line ahead of the needle; the second line switches between "
           "those after the first");
  if (words == defaults) return;
  lines_m.clear();
  for (const std::string& word : words) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0') map.Fail(key, "'" + word + "' is no number");
    lines_m.push_back(value * kMm);
  }
}

}  // namespace

void CheckOptions(const StripeSensorOptions& options) {
  if (const auto fault = FaultOf(options)) {
    throw std::invalid_argument("stripe sensor: " + fault->key + ": " + fault->what);
  }
}

void ReadStripeSensor(base::YamlMap& map, StripeSensorOptions& options) {
  std::string type = "stripe_sensor";
  map.Read("type", type, "the kind of sensor: stripe_sensor");
  if (type != "stripe_sensor") map.Fail("type", "'" + type + "' must be stripe_sensor");
  map.Read("name", options.name, "what the sensor is called");
  map.Read("columns", options.line.columns, seam::kMinColumns, kMaxPixels,
           "columns of the camera, along the line");
  map.ReadScaled("columns_per_mm", options.line.columns_per_m, 1.0 / kMm, kMinColumnsPerMm,
                 kMaxColumnsPerMm, "columns a millimetre of the line at height 0");
  map.Read("rows", options.rows, seam::kMinColumns, kMaxPixels,
           "rows of the camera; the middle one sees height 0");
  ReadLines(map, options.lines_ahead_m);
  for (const Key& key : kKeys) {
    map.ReadScaled(key.name, options.*key.member, key.unit, key.low, key.high, key.doc);
  }
}

StripeSensorOptions ReadStripeSensor(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  StripeSensorOptions options;
  ReadStripeSensor(map, options);
  map.Finish();
  if (const auto fault = FaultOf(options)) map.Fail(fault->key, fault->what);
  return options;
}

}  // namespace rangegrasp::stitching
