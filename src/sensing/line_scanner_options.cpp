#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/units.h"
#include "core/yaml_map.h"
#include "sensing/internal/options_check.h"
#include "sensing/line_scanner.h"

namespace rangegrasp::sensing {
namespace {

using Options = LineScannerOptions;

/// A key of a sensor file: where its value goes, the unit it is written in, its range there.
struct Key {
  std::string_view name;
  std::variant<int Options::*, double Options::*> member;
  double unit;  ///< SI value of 1
  double low;
  double high;
};

constexpr double kDegree = core::kPi / 180.0;
constexpr double kMillimetre = 1e-3;
constexpr double kMicrometre = 1e-6;

const std::vector<Key>& Keys() {
  static const std::vector<Key> keys = {
      {"samples", &Options::samples, 1.0, 2, 8192},
      {"profiles", &Options::profiles, 1.0, 1, 8192},
      {"fan_deg", &Options::fan_rad, kDegree, 0.1, 120.0},
      {"pan_range_deg", &Options::pan_range_rad, kDegree, 0.0, 180.0},
      {"baseline_mm", &Options::baseline_m, kMillimetre, 1.0, 5000.0},
      {"focal_length_mm", &Options::focal_length_m, kMillimetre, 0.5, 500.0},
      {"pixel_pitch_um", &Options::pixel_pitch_m, kMicrometre, 0.1, 100.0},
      {"sensor_pixels", &Options::sensor_pixels, 1.0, 8, 65536},
      {"focus_distance_mm", &Options::focus_distance_m, kMillimetre, 10.0, 100000.0},
      {"near_mm", &Options::near_m, kMillimetre, 0.0, 10000.0},
      {"line_width_mm", &Options::line_width_m, kMillimetre, 0.0, 50.0},
      {"blur_px", &Options::blur_px, 1.0, 0.0, 100.0},
      {"centroid_sigma_px", &Options::centroid_sigma_px, 1.0, 0.0, 100.0},
      {"speckle_sigma_mm", &Options::speckle_sigma_m, kMillimetre, 0.0, 100.0},
      {"correlation_samples", &Options::correlation_samples, 1.0, 0.01, 10000.0},
      {"quantisation_px", &Options::quantisation_px, 1.0, 0.0, 100.0},
      {"pan_jitter_deg", &Options::pan_jitter_rad, kDegree, 0.0, 10.0},
      {"dropout_begin_deg", &Options::dropout_begin_rad, kDegree, 0.0, 90.0},
      {"dropout_end_deg", &Options::dropout_end_rad, kDegree, 0.0, 90.0},
      {"saturation_angle_deg", &Options::saturation_angle_rad, kDegree, 0.0, 180.0},
  };
  return keys;
}

std::string Range(const Key& key) {
  std::ostringstream text;
  text << "from " << key.low << " to " << key.high;
  return text.str();
}

double ValueOf(const Key& key, const Options& options) {
  if (const auto* member = std::get_if<int Options::*>(&key.member)) return options.**member;
  return options.*std::get<double Options::*>(key.member) / key.unit;
}

/// What is wrong with a key's value, if anything.
std::optional<std::string> RangeFault(const Key& key, const Options& options) {
  const double value = ValueOf(key, options);
  // A relative slack, for a bound that went to SI units and back.
  const double slack = 1e-9 * std::max(std::abs(key.low), std::abs(key.high));
  if (value >= key.low - slack && value <= key.high + slack) return std::nullopt;
  std::ostringstream text;
  text << key.name << ": " << value << " is out of range, must be " << Range(key);
  return text.str();
}

/// What is wrong between keys, if anything.
std::optional<std::string> RelationFault(const Options& options) {
  if (options.dropout_begin_rad < options.dropout_end_rad) return std::nullopt;
  return "dropout_begin_deg must be less than dropout_end_deg";
}

}  // namespace

namespace internal {

void CheckOptions(const LineScannerOptions& options) {
  for (const Key& key : Keys()) {
    if (const auto fault = RangeFault(key, options)) {
      throw std::invalid_argument("line scanner: " + *fault);
    }
  }
  if (const auto fault = RelationFault(options)) {
    throw std::invalid_argument("line scanner: " + *fault);
  }
}

}  // namespace internal

LineScannerOptions ReadLineScanner(const std::filesystem::path& file) {
  auto map = core::YamlMap::FromFile(file);
  std::string type = "line_scanner";
  map.Read("type", type);
  if (type != "line_scanner") map.Fail("type", "'" + type + "' must be line_scanner");
  LineScannerOptions options;
  for (const Key& key : Keys()) {
    const std::string name(key.name);
    if (const auto* member = std::get_if<int Options::*>(&key.member)) {
      map.Read(name, options.**member, static_cast<int>(key.low), static_cast<int>(key.high));
    } else {
      map.ReadScaled(name, options.*std::get<double Options::*>(key.member), key.unit, key.low,
                     key.high);
    }
  }
  map.Finish();
  if (const auto fault = RelationFault(options)) {
    const std::string name = map.Has("dropout_begin_deg") ? "dropout_begin_deg" : "dropout_end_deg";
    map.Fail(name, *fault);
  }
  return options;
}

}  // namespace rangegrasp::sensing
