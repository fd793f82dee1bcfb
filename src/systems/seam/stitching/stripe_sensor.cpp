#include "seam/stitching/stripe_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace rangegrasp::stitching {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
// A spot's place along the line is known well enough when it moves by less than this, a tenth of
// a column of the finer sensor.
constexpr double kPlaceTolerance_m = 5e-6;
// Steps towards it, at most: more would change a place only on faces nearly as steep as the rays.
constexpr int kPlaceSteps = 4;

/// Decides column after column whether a reflection is taken for the spot: a chain of two states
/// whose reflections have geometric lengths and, in the long run, the wanted share of columns.
class Reflections {
 public:
  explicit Reflections(const StripeSensorOptions& options)
      : end_(1.0 / options.outlier_run_columns),
        begin_(std::min(1.0, options.outlier_share * end_ / (1.0 - options.outlier_share))),
        share_(options.outlier_share),
        sigma_px_(options.outlier_sigma_px) {}

  /// By how many rows the next column is off, if a reflection is seen there.
  std::optional<double> Next(base::Rng& rng) {
    if (share_ <= 0.0) return std::nullopt;
    const double u = rng.Uniform();
    const bool was_on = on_;
    // A run that ends may be followed by another at once.
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

/// Noise of standard deviation 1 of column after column, whose correlation fades exponentially.
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

// What a lost spot reports: nothing, or the brightest pixel of elsewhere.
double LostRow(const StripeSensorOptions& options, const seam::RawProfile* previous,
               std::size_t column, base::Rng& rng) {
  if (options.phantom_share <= 0.0) return kMissing;
  const double u = rng.Uniform();
  if (u >= options.phantom_share) return kMissing;
  const bool from_previous = u < options.phantom_share * options.phantom_previous_share;
  if (from_previous && previous && std::isfinite(previous->row_px[column])) {
    return previous->row_px[column];
  }
  return rng.Uniform(0.0, options.rows - 1.0);
}

// Intensity of a spot that is a mean of bright and dark speckles: mean 1, standard deviation
// `contrast`.
double Speckle(double contrast, base::Rng& rng) {
  if (contrast <= 0.0) return 1.0;
  const double u = rng.Uniform();
  return 1.0 - contrast - contrast * std::log1p(-u);
}

double BodyHeight(const seam::CalibrationBody& body, double base_m, double x_m) {
  const auto steps = static_cast<double>(body.step_heights_m.size());
  const double place = std::floor(x_m / body.step_width_m + 0.5 * steps);
  if (!(place >= 0.0 && place < steps)) return base_m;
  return base_m + body.step_heights_m[static_cast<std::size_t>(place)];
}

// Heights at which the body has level faces, highest first.
std::vector<double> BodyLevels(const seam::CalibrationBody& body, double base_m) {
  std::vector<double> levels = {base_m};
  for (const double step : body.step_heights_m) levels.push_back(base_m + step);
  std::sort(levels.rbegin(), levels.rend());
  return levels;
}

}  // namespace

StripeSensor::StripeSensor(const StripeSensorOptions& options) : options_(options) {
  CheckOptions(options);
  focal_px_ = options.line.columns_per_m * options.standoff_m;
  cos_ = std::cos(options.angle_rad);
  sin_ = std::sin(options.angle_rad);
}

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

seam::RawProfile StripeSensor::Scan(const Mats& mats, const LinePose& pose, double time_s,
                                    const seam::RawProfile* previous, base::Rng& rng) const {
  const auto columns = static_cast<std::size_t>(options_.line.columns);
  if (previous && previous->row_px.size() != columns) {
    throw std::invalid_argument(
        "stripe sensor: the previous profile has another number of columns");
  }
  const double ahead_x = std::cos(pose.heading_rad);
  const double ahead_y = std::sin(pose.heading_rad);
  seam::RawProfile profile{std::vector<float>(columns, kMissing), time_s};
  Reflections reflections(options_);
  CorrelatedNoise noise(options_.row_correlation_columns);
  double height = 0.0;
  for (std::size_t c = 0; c < columns; ++c) {
    // A column is a plane through the camera: where it meets the surface depends on the height
    // there. The neighbor's height is near enough on all but steep places.
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

// Follows each column's ray down to the first level face or riser that it meets.
seam::CalibrationScan StripeSensor::ScanBodyAt(const seam::CalibrationBody& body, double base_m,
                                               base::Rng& rng) const {
  const auto columns = static_cast<std::size_t>(options_.line.columns);
  const std::vector<double> levels = BodyLevels(body, base_m);
  seam::CalibrationScan scan{{std::vector<float>(columns, kMissing), 0.0}, base_m};
  for (std::size_t c = 0; c < columns; ++c) {
    double height = base_m;
    for (const double level : levels) {
      const double x = LateralAt(static_cast<double>(c), level);
      if (BodyHeight(body, base_m, x) < level) continue;
      height = level;
      break;
    }
    const double row = RowOf(height) + options_.row_sigma_px * rng.Normal();
    if (row >= 0.0 && row <= options_.rows - 1.0) {
      scan.profile.row_px[c] = static_cast<float>(row);
    }
  }
  return scan;
}

std::vector<seam::CalibrationScan> StripeSensor::ScanBody(const seam::CalibrationBody& body,
                                                          int distances, base::Rng& rng) const {
  if (distances < 2) throw std::invalid_argument("stripe sensor: distances must be at least 2");
  const double top = *std::max_element(body.step_heights_m.begin(), body.step_heights_m.end());
  const double low = -options_.range_below_m;
  const double high = std::max(low, options_.range_above_m - top);
  std::vector<seam::CalibrationScan> scans;
  for (int i = 0; i < distances; ++i) {
    const double base = low + (high - low) * i / (distances - 1);
    scans.push_back(ScanBodyAt(body, base, rng));
  }
  return scans;
}

seam::Calibration StripeSensor::Calibrate(int distances, base::Rng& rng) const {
  const seam::CalibrationBody body;
  return seam::CalibrateFromBody(body, ScanBody(body, distances, rng));
}

}  // namespace rangegrasp::stitching
