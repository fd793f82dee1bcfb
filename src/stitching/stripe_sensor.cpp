#include "stitching/stripe_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace rangegrasp::stitching {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
// A second look at the surface is worth it where the height changed by more than this.
constexpr double kSameHeight_m = 20e-6;
// The calibration body is machined, dull and bright: only this much noise is left.
constexpr double kBodySigma_px = 0.15;

void Check(const StripeSensorOptions& o) {
  const auto check = [](bool good, const char* what) {
    if (!good) throw std::invalid_argument(std::string("stripe sensor: ") + what);
  };
  check(o.line.columns >= 32 && o.line.columns_per_m > 0.0, "line must have columns");
  check(!o.lines_ahead_m.empty(), "at least one line is needed");
  check(o.standoff_m > 0.0, "standoff_m must be above 0");
  check(o.angle_rad > 0.0 && o.angle_rad < 1.5, "angle_rad must be above 0 and below 1.5");
  check(o.rows >= 16, "rows must be at least 16");
  check(o.rate_min_hz > 0.0 && o.rate_max_hz >= o.rate_min_hz, "rates must be above 0, in order");
  check(o.outlier_run_columns >= 1.0, "outlier_run_columns must be at least 1");
  check(o.row_quantum_px >= 0.0, "row_quantum_px must not be negative");
}

double Quantised(double row, double quantum) {
  return quantum > 0.0 ? std::round(row / quantum) * quantum : row;
}

}  // namespace

StripeSensor::StripeSensor(const StripeSensorOptions& options) : options_(options) {
  Check(options);
}

double StripeSensor::Rate(const MatTexture& texture) const {
  return std::lerp(options_.rate_max_hz, options_.rate_min_hz,
                   std::clamp(texture.darkness, 0.0, 1.0));
}

// The camera stands at D from the origin of L, its axis at the angle a to the laser plane. A point
// (x, z) of that plane is D - z cos(a) away along the axis and z sin(a) above it.
double StripeSensor::RowOf(double height_m) const {
  const double focal_px = options_.line.columns_per_m * options_.standoff_m;
  const double depth = options_.standoff_m - height_m * std::cos(options_.angle_rad);
  return 0.5 * (options_.rows - 1) - focal_px * height_m * std::sin(options_.angle_rad) / depth;
}

double StripeSensor::ColumnOf(double x_m, double height_m) const {
  const double focal_px = options_.line.columns_per_m * options_.standoff_m;
  const double depth = options_.standoff_m - height_m * std::cos(options_.angle_rad);
  return options_.line.CenterColumn() + focal_px * x_m / depth;
}

double StripeSensor::XOf(double column, double height_m) const {
  const double depth = options_.standoff_m - height_m * std::cos(options_.angle_rad);
  return options_.line.ToMeters(column) * depth / options_.standoff_m;
}

seam::RawProfile StripeSensor::Scan(const Mats& mats, const LinePose& pose, double time_s,
                                    const seam::RawProfile* previous, core::Rng& rng) const {
  const double c = std::cos(pose.heading_rad);
  const double s = std::sin(pose.heading_rad);
  const auto spot = [&](double column, double height) {
    const double x = XOf(column, height);
    MatPoint point = mats.At(pose.x_m + c * x, pose.y_m + s * x);
    point.height_m -= pose.height_m;
    return point;
  };
  seam::RawProfile profile;
  profile.time_s = time_s;
  profile.row_px.resize(static_cast<std::size_t>(options_.line.columns));
  double height = 0.0;
  Disturbance disturbance(options_);
  for (std::size_t i = 0; i < profile.row_px.size(); ++i) {
    MatPoint point = spot(static_cast<double>(i), height);
    if (std::abs(point.height_m - height) > kSameHeight_m) {
      point = spot(static_cast<double>(i), point.height_m);
    }
    height = point.height_m;
    const float elsewhere =
        previous != nullptr && i < previous->row_px.size() ? previous->row_px[i] : kMissing;
    profile.row_px[i] = disturbance.Row(RowOf(height), point.return_strength, elsewhere, rng);
  }
  return profile;
}

float StripeSensor::Disturbance::Row(double row, double strength, float elsewhere, core::Rng& rng) {
  const double seen = strength * (1.0 - options_.speckle * rng.Uniform());
  if (seen < options_.lost_return) {
    if (!(rng.Uniform() < options_.phantom_share)) return kMissing;
    const bool ghost = rng.Uniform() < 0.5;
    const double anywhere = rng.Uniform(0.0, options_.rows - 1.0);
    if (ghost && std::isfinite(elsewhere)) return elsewhere;
    return static_cast<float>(std::round(anywhere));
  }
  if (outlier_columns_ <= 0 &&
      rng.Uniform() < options_.outlier_share / options_.outlier_run_columns) {
    outlier_columns_ =
        1 + static_cast<int>(-options_.outlier_run_columns * std::log(1.0 - rng.Uniform()));
    outlier_px_ = options_.outlier_sigma_px * rng.Normal();
  }
  row += options_.row_sigma_px / std::sqrt(std::max(seen, 0.05)) * rng.Normal();
  if (outlier_columns_ > 0) {
    --outlier_columns_;
    row += outlier_px_;
  }
  row = Quantised(row, options_.row_quantum_px);
  return row >= 0.0 && row <= options_.rows - 1 ? static_cast<float>(row) : kMissing;
}

seam::Calibration StripeSensor::Calibrate(int distances, core::Rng& rng) const {
  const seam::CalibrationBody body;
  const double top = *std::max_element(body.step_heights_m.begin(), body.step_heights_m.end());
  const double half_m = 0.5 * body.step_width_m * static_cast<double>(body.step_heights_m.size());
  std::vector<seam::CalibrationScan> scans;
  for (int k = 0; k < distances; ++k) {
    seam::CalibrationScan scan;
    scan.base_height_m =
        std::lerp(-calibrated_m - top, calibrated_m, k / std::max(1.0, distances - 1.0));
    double height = scan.base_height_m;
    for (int i = 0; i < options_.line.columns; ++i) {
      // Two looks, as in Scan.
      for (int look = 0; look < 2; ++look) {
        const double x = XOf(i, height);
        const auto step = static_cast<std::size_t>(std::max(0.0, (x + half_m) / body.step_width_m));
        const bool on_step = std::abs(x) < half_m && step < body.step_heights_m.size();
        height = scan.base_height_m + (on_step ? body.step_heights_m[step] : 0.0);
      }
      const double row = RowOf(height) + kBodySigma_px * rng.Normal();
      const bool inside = row >= 0.0 && row <= options_.rows - 1;
      scan.profile.row_px.push_back(inside ? static_cast<float>(row) : kMissing);
    }
    scans.push_back(std::move(scan));
  }
  return seam::CalibrateFromBody(body, scans);
}

}  // namespace rangegrasp::stitching
