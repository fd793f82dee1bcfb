#include "seam/stitching/stripe_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "base/units.h"
#include "base/words.h"
#include "base/yaml_map.h"

namespace rangegrasp::seam {
namespace {

using base::kMm;

// ---- options ----

// Maximum number of columns or rows of a camera.
constexpr int kMaxPixels = 65'536;
constexpr double kMaxLineAhead_mm = 1000.0;
constexpr double kLineSlack_mm = 1e-6;  // rounding of a bound by conversion to SI units and back
// Minimum depth of a spot relative to the standoff. Closer to the camera, its column would depend
// on the height more than a calibration that is linear in the height can model.
constexpr double kMinDepthShare = 0.5;

// The ranges reject wrong units; CheckRelations may still reject accepted values.
void ReadNumbers(base::YamlMap& map, StripeSensorOptions& o) {
  map.Read("columns", o.line.columns, kMinColumns, kMaxPixels,
           "number of columns of the camera, along the line");
  map.ReadScaled("columns_per_mm", o.line.columns_per_m, 1.0 / kMm, 0.1, 1000.0,
                 "columns per millimetre of the line at height 0");
  map.Read("rows", o.rows, kMinColumns, kMaxPixels,
           "number of rows of the camera; the middle one sees height 0");
  map.ReadScaled("standoff_mm", o.standoff_m, kMm, 20.0, 2000.0,
                 "distance of the camera from the point where its axis meets height 0");
  map.Read("angle_rad", o.angle_rad, 0.1, 1.4,
           "angle between the laser plane and the camera's axis");
  map.ReadScaled("range_below_mm", o.range_below_m, kMm, 1.0, 1000.0,
                 "range of heights below 0 that the calibration covers");
  map.ReadScaled("range_above_mm", o.range_above_m, kMm, 1.0, 1000.0,
                 "range of heights above 0 that the calibration covers");
  map.Read("rate_min_hz", o.rate_min_hz, 1.0, 10'000.0, "profiles per second on black mats");
  map.Read("rate_max_hz", o.rate_max_hz, 1.0, 10'000.0, "profiles per second on bright mats");
  map.Read("row_sigma_px", o.row_sigma_px, 0.0, 50.0,
           "noise of the row of a spot that returns all light, standard deviation");
  map.Read("row_correlation_columns", o.row_correlation_columns, 0.0, 1000.0,
           "correlation length of this noise in columns; 0: independent columns");
  map.Read("row_quantum_px", o.row_quantum_px, 0.0, 50.0, "resolution of the rows; 0: no rounding");
  map.Read("speckle", o.speckle, 0.0, 1.0,
           "contrast of the speckle: standard deviation of a spot's strength over its mean");
  map.Read("lost_return", o.lost_return, 0.0, 1.0, "minimum strength of a spot that is found");
  map.Read("outlier_share", o.outlier_share, 0.0, 0.9,
           "share of the found spots that are reflections");
  map.Read("outlier_run_columns", o.outlier_run_columns, 1.0, 1000.0,
           "mean width of a reflection in columns");
  map.Read("outlier_sigma_px", o.outlier_sigma_px, 0.0, 10'000.0,
           "row error of a reflection, standard deviation");
  map.Read("phantom_share", o.phantom_share, 0.0, 1.0,
           "share of the lost spots that report the brightest pixel from another place");
  map.Read("phantom_previous_share", o.phantom_previous_share, 0.0, 1.0,
           "share of these that show the previous line; the others are in a random row");
}

// Fails for options that are inconsistent.
void CheckRelations(const base::YamlMap& map, const StripeSensorOptions& options) {
  if (options.lines_ahead_m.empty()) map.Fail("lines_ahead_mm", "must have at least one line");
  for (const double ahead : options.lines_ahead_m) {
    const double ahead_mm = ahead / kMm;
    if (ahead_mm >= -kLineSlack_mm && ahead_mm <= kMaxLineAhead_mm + kLineSlack_mm) continue;
    map.Fail("lines_ahead_mm", fmt::format("{:g} is out of range, must be from 0 to {:g}", ahead_mm,
                                           kMaxLineAhead_mm));
  }
  if (options.rate_min_hz > options.rate_max_hz)
    map.Fail("rate_min_hz", "must not be above rate_max_hz");
  if (options.range_above_m * std::cos(options.angle_rad) > kMinDepthShare * options.standoff_m) {
    map.Fail("range_above_mm", "comes nearer to the camera than half of standoff_mm");
  }
  const char* unseen = "is not visible: more rows or a smaller range are needed";
  const StripeSensor sensor(options);
  if (sensor.RowOf(options.range_above_m) > options.rows - 1) map.Fail("range_above_mm", unseen);
  if (sensor.RowOf(-options.range_below_m) < 0.0) map.Fail("range_below_mm", unseen);
}

// YamlMap can only read lists of words.
void ReadLines(base::YamlMap& map, std::vector<double>& lines_m) {
  const std::string key = "lines_ahead_mm";
  std::vector<std::string> words;
  for (const double line : lines_m) words.push_back(fmt::format("{:g}", line / kMm));
  map.Read(key, words,
           "distance of each laser line ahead of the needle; the second line switches between "
           "those after the first");
  if (!map.Has(key)) return;
  lines_m.clear();
  for (const std::string& word : words) {
    const auto value = base::NumberFrom<double>(word);
    if (!value) map.Fail(key, "'" + word + "' is not a number");
    lines_m.push_back(*value * kMm);
  }
}

// ---- a scan ----

constexpr float kNoRow = std::numeric_limits<float>::quiet_NaN();
// A spot's position along the line has converged if it moves by less than this, a tenth of a column
// of the finer sensor.
constexpr double kPlaceTolerance_m = 5e-6;
// Maximum number of iterations: more change a position only on faces nearly as steep as the rays.
constexpr int kPlaceSteps = 4;

/// Decides for one column after the other whether a reflection is mistaken for the spot: a
/// two-state Markov chain in which reflections have geometric lengths and, in the long run, the
/// wanted share of columns.
class Reflections {
 public:
  explicit Reflections(const StripeSensorOptions& options)
      : end_(1.0 / options.outlier_run_columns),
        begin_(std::min(1.0, options.outlier_share * end_ / (1.0 - options.outlier_share))),
        share_(options.outlier_share),
        sigma_px_(options.outlier_sigma_px) {}

  /// Row error of the next column, if a reflection is seen there.
  std::optional<double> Next(base::Rng& rng) {
    if (share_ <= 0.0) return std::nullopt;
    const double u = rng.Uniform();
    const bool was_on = on_;
    // At least one column lies between two runs.
    on_ = first_ ? u < share_ : was_on ? u >= end_ : u < begin_;
    first_ = false;
    if (!on_) return std::nullopt;
    if (!was_on) offset_px_ = sigma_px_ * rng.Normal();
    return offset_px_;
  }

 private:
  double end_, begin_, share_, sigma_px_;
  double offset_px_ = 0.0;
  bool on_ = false;
  bool first_ = true;
};

/// Noise of standard deviation 1 for successive columns; its correlation decays exponentially.
class CorrelatedNoise {
 public:
  explicit CorrelatedNoise(double columns)
      : kept_(columns > 0.0 ? std::exp(-1.0 / columns) : 0.0),
        fresh_(std::sqrt(1.0 - kept_ * kept_)) {}

  double Next(base::Rng& rng) {
    const double normal = rng.Normal();
    value_ = first_ ? normal : kept_ * value_ + fresh_ * normal;
    first_ = false;
    return value_;
  }

 private:
  double kept_, fresh_;
  double value_ = 0.0;
  bool first_ = true;
};

// Row reported for a lost spot: none, or the brightest pixel from elsewhere.
double LostRow(const StripeSensorOptions& options, const RawProfile* previous, std::size_t column,
               base::Rng& rng) {
  if (options.phantom_share <= 0.0) return kNoRow;
  const double u = rng.Uniform();
  if (u >= options.phantom_share) return kNoRow;
  const bool from_previous = u < options.phantom_share * options.phantom_previous_share;
  if (from_previous && previous && std::isfinite(previous->row_px[column])) {
    return previous->row_px[column];
  }
  return rng.Uniform(0.0, options.rows - 1.0);
}

// Intensity of a spot that averages bright and dark speckles: mean 1, standard deviation
// `contrast`.
double Speckle(double contrast, base::Rng& rng) {
  if (contrast <= 0.0) return 1.0;
  const double u = rng.Uniform();
  return 1.0 - contrast - contrast * std::log1p(-u);
}

double BodyHeight(const CalibrationBody& body, double base_m, double x_m) {
  const auto steps = static_cast<double>(body.step_heights_m.size());
  const double place = std::floor(x_m / body.step_width_m + 0.5 * steps);
  if (!(place >= 0.0 && place < steps)) return base_m;
  return base_m + body.step_heights_m[static_cast<std::size_t>(place)];
}

// Heights of the body's horizontal faces, highest first.
std::vector<double> BodyLevels(const CalibrationBody& body, double base_m) {
  std::vector<double> levels = {base_m};
  for (const double step : body.step_heights_m) levels.push_back(base_m + step);
  std::ranges::sort(levels, std::greater());
  return levels;
}

// ---- recordings ----

// Error of the sensor's height over the mats: a head on a flat mould.
constexpr double kHeightError_m = 2e-3;

// The line's pose at the first profile: the edge starts anywhere within the given share of the
// line.
LinePose FirstPose(const Mats& mats, const LineGeometry& line, double edge_within, base::Rng& rng) {
  const double line_m = line.columns / line.columns_per_m;
  const double across = rng.Uniform(-0.5, 0.5);
  LinePose pose;
  pose.height_m = rng.Uniform(-kHeightError_m, kHeightError_m);
  const double edge = mats.EdgeX(0.0);
  pose.x_m = (std::isfinite(edge) ? edge : 0.0) - across * edge_within * line_m;
  return pose;
}

double LabelColumn(const Mats& mats, const StripeSensor& sensor, const LinePose& pose) {
  const double edge = mats.EdgeX(pose.y_m);
  if (!std::isfinite(edge)) return std::numeric_limits<double>::quiet_NaN();
  const double height = mats.At(edge, pose.y_m).height_m - pose.height_m;
  return sensor.ColumnOf(edge - pose.x_m, height);
}

}  // namespace

StripeSensorOptions ReadStripeSensor(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  StripeSensorOptions options;
  std::string type = "stripe_sensor";
  map.Read("type", type, "type of the sensor: stripe_sensor");
  if (type != "stripe_sensor") map.Fail("type", "'" + type + "' must be stripe_sensor");
  map.Read("name", options.name, "name of the sensor");
  ReadLines(map, options.lines_ahead_m);
  ReadNumbers(map, options);
  map.Finish();
  CheckRelations(map, options);
  return options;
}

StripeSensor::StripeSensor(const StripeSensorOptions& options)
    : options_(options),
      focal_px_(options.line.columns_per_m * options.standoff_m),
      cos_(std::cos(options.angle_rad)),
      sin_(std::sin(options.angle_rad)) {}

double StripeSensor::Rate(const MatTexture& texture) const {
  return options_.rate_max_hz + texture.darkness * (options_.rate_min_hz - options_.rate_max_hz);
}

double StripeSensor::RowOf(double height_m) const {
  return 0.5 * (options_.rows - 1) +
         focal_px_ * height_m * sin_ / (options_.standoff_m - height_m * cos_);
}

double StripeSensor::ColumnOf(double x_m, double height_m) const {
  return options_.line.CenterColumn() + focal_px_ * x_m / (options_.standoff_m - height_m * cos_);
}

double StripeSensor::LateralAt(double column, double height_m) const {
  return (column - options_.line.CenterColumn()) * (options_.standoff_m - height_m * cos_) /
         focal_px_;
}

RawProfile StripeSensor::Scan(const Mats& mats, const LinePose& pose, double time_s,
                              const RawProfile* previous, base::Rng& rng) const {
  const auto columns = static_cast<std::size_t>(options_.line.columns);
  const double ahead_x = std::cos(pose.heading_rad);
  const double ahead_y = std::sin(pose.heading_rad);
  RawProfile profile{std::vector<float>(columns, kNoRow), time_s};
  Reflections reflections(options_);
  CorrelatedNoise noise(options_.row_correlation_columns);
  double height = 0.0;
  for (std::size_t c = 0; c < columns; ++c) {
    // A column is a plane through the camera: where it meets the surface depends on the height
    // there. The neighbor's height is a good estimate except at steep places.
    double x = LateralAt(static_cast<double>(c), height);
    MatPoint point{};
    for (int step = 0; step < kPlaceSteps; ++step) {
      point = mats.At(pose.x_m + ahead_x * x, pose.y_m + ahead_y * x);
      height = point.height_m - pose.height_m;
      const double better_x = LateralAt(static_cast<double>(c), height);
      if (std::abs(better_x - x) < kPlaceTolerance_m || point.return_strength <= 0.0) break;
      x = better_x;
    }
    const double strength = point.return_strength * Speckle(options_.speckle, rng);
    const std::optional<double> reflection = reflections.Next(rng);
    double row = 0.0;
    if (strength < options_.lost_return || strength <= 0.0) {
      row = LostRow(options_, previous, c, rng);
    } else {
      row = RowOf(height) + options_.row_sigma_px / std::sqrt(strength) * noise.Next(rng) +
            reflection.value_or(0.0);
      if (options_.row_quantum_px > 0.0) {
        row = std::round(row / options_.row_quantum_px) * options_.row_quantum_px;
      }
    }
    if (row >= 0.0 && row <= options_.rows - 1.0) profile.row_px[c] = static_cast<float>(row);
  }
  return profile;
}

std::vector<CalibrationScan> StripeSensor::ScanBody(const CalibrationBody& body, int distances,
                                                    base::Rng& rng) const {
  const double top = std::ranges::max(body.step_heights_m);
  const double low = -options_.range_below_m;
  const double high = std::max(low, options_.range_above_m - top);
  const auto columns = static_cast<std::size_t>(options_.line.columns);
  std::vector<CalibrationScan> scans;
  for (int i = 0; i < distances; ++i) {
    const double base = low + (high - low) * i / (distances - 1);
    const std::vector<double> levels = BodyLevels(body, base);
    scans.push_back({{std::vector<float>(columns, kNoRow), 0.0}, base});
    for (std::size_t c = 0; c < columns; ++c) {
      // The column's ray ends at the first horizontal face or riser that it meets.
      const auto met = std::ranges::find_if(levels, [&](double level) {
        return !(BodyHeight(body, base, LateralAt(static_cast<double>(c), level)) < level);
      });
      const double height = met == levels.end() ? base : *met;
      const double row = RowOf(height) + options_.row_sigma_px * rng.Normal();
      if (row < 0.0 || row > options_.rows - 1.0) continue;
      scans.back().profile.row_px[c] = static_cast<float>(row);
    }
  }
  return scans;
}

Recording RecordProfiles(const Mats& mats, const StripeSensor& sensor, const RecordOptions& options,
                         std::uint64_t seed) {
  base::Rng rng(seed);
  LinePose pose = FirstPose(mats, sensor.options().line, options.edge_within, rng);
  const double period_s = 1.0 / sensor.Rate(mats.options().texture);
  Recording recording;
  for (int i = 0; i < options.profiles; ++i) {
    pose.y_m = i * period_s * options.speed_m_s;
    const RawProfile* previous = recording.raw.empty() ? nullptr : &recording.raw.back();
    recording.raw.push_back(sensor.Scan(mats, pose, i * period_s, previous, rng));
    recording.label_column.push_back(LabelColumn(mats, sensor, pose));
  }
  return recording;
}

}  // namespace rangegrasp::seam
