#include "seam/calibration.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/yaml_map.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Of a function of 4th order (section 3.2).
constexpr std::size_t kTerms = 5;
// Places at which the fitted function must go the same way: a polynomial of 4th order turns at most
// three times, and between two of these places no turn is deep enough to matter.
constexpr int kMonotonySamples = 256;
// Bounds of a calibration file, which keep out slips of unit: [m] and [px].
constexpr double kMaxHeight_m = 100.0;
constexpr double kMaxRow_px = 1e6;
constexpr int kMaxColumns = 65536;

double Mapped(const Calibration& c, double row) {
  return 2.0 * (row - c.row_min_px) / (c.row_max_px - c.row_min_px) - 1.0;
}

double Polynomial(const std::array<double, kTerms>& c, double u) {
  return c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * c[4])));
}

void FitHeights(std::span<const HeightSample> samples, Calibration& calibration) {
  std::set<double> rows;
  for (const HeightSample& sample : samples) rows.insert(sample.row_px);
  if (rows.size() < kTerms) {
    throw base::InputError(
        fmt::format("calibration: {} distinct rows; a function of 4th order needs at least {}",
                    rows.size(), kTerms));
  }
  calibration.row_min_px = *rows.begin();
  calibration.row_max_px = *rows.rbegin();
  Eigen::MatrixXd powers(static_cast<Eigen::Index>(samples.size()), kTerms);
  Eigen::VectorXd heights(static_cast<Eigen::Index>(samples.size()));
  for (Eigen::Index i = 0; i < heights.size(); ++i) {
    const HeightSample& sample = samples[static_cast<std::size_t>(i)];
    const double u = Mapped(calibration, sample.row_px);
    double power = 1.0;
    for (Eigen::Index k = 0; k < powers.cols(); ++k, power *= u) powers(i, k) = power;
    heights(i) = sample.height_m;
  }
  const Eigen::VectorXd c = powers.colPivHouseholderQr().solve(heights);
  for (std::size_t k = 0; k < kTerms; ++k) {
    calibration.height_m[k] = c(static_cast<Eigen::Index>(k));
  }
}

void CheckSamples(std::span<const HeightSample> heights, std::span<const LateralSample> laterals) {
  const bool whole =
      std::all_of(heights.begin(), heights.end(),
                  [](const HeightSample& s) { return std::isfinite(s.row_px + s.height_m); }) &&
      std::all_of(laterals.begin(), laterals.end(), [](const LateralSample& s) {
        return std::isfinite(s.column + s.height_m + s.x_m);
      });
  if (!whole) throw base::InputError("calibration: a sample is not a finite number");
}

void CheckMonotone(const Calibration& calibration) {
  int rises = 0;
  for (int i = 1; i <= kMonotonySamples; ++i) {
    const double u = 2.0 * i / kMonotonySamples - 1.0;
    const double before = Polynomial(calibration.height_m, u - 2.0 / kMonotonySamples);
    rises += Polynomial(calibration.height_m, u) > before ? 1 : 0;
  }
  if (rises != 0 && rises != kMonotonySamples) {
    throw base::InputError(
        "calibration: the fitted function from row to height turns back within the rows seen; "
        "some scans are wrong or too noisy");
  }
}

// x = (column - center) (k0 + k1 height)
void FitLateral(std::span<const LateralSample> samples, Calibration& calibration) {
  std::set<double> heights;
  for (const LateralSample& sample : samples) heights.insert(sample.height_m);
  if (samples.size() < 3 || heights.size() < 2) {
    throw base::InputError(
        fmt::format("calibration: {} lateral samples at {} heights; at least 3 at 2 heights are "
                    "needed",
                    samples.size(), heights.size()));
  }
  const double center = 0.5 * (calibration.columns - 1);
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const LateralSample& sample : samples) {
    const Eigen::Vector2d row = (sample.column - center) * Eigen::Vector2d(1.0, sample.height_m);
    normal += row * row.transpose();
    right += row * sample.x_m;
  }
  const Eigen::Vector2d k = normal.ldlt().solve(right);
  calibration.meters_per_column = {k.x(), k.y()};
  if (!(k.x() + k.y() * *heights.begin() > 0.0 && k.x() + k.y() * *heights.rbegin() > 0.0)) {
    throw base::InputError("calibration: the columns do not ascend along the body");
  }
}

// HeightAt of a whole line, without branches.
RANGEGRASP_VECTORISED void HeightsAt(const Calibration& calibration, const float* row_px,
                                     std::size_t count, float* height_m) {
  const Calibration c = calibration;  // which height_m cannot point into
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<double>(row_px[i]);
    const double height = Polynomial(c.height_m, Mapped(c, row));
    const bool calibrated = (row >= c.row_min_px) & (row <= c.row_max_px);
    height_m[i] = static_cast<float>(calibrated ? height : kNone);
  }
}

}  // namespace

double Calibration::HeightAt(double row_px) const {
  if (!(row_px >= row_min_px && row_px <= row_max_px)) return kNone;
  return Polynomial(height_m, Mapped(*this, row_px));
}

double Calibration::LateralAt(double column, double height) const {
  return (column - 0.5 * (columns - 1)) * (meters_per_column[0] + meters_per_column[1] * height);
}

Calibration FitCalibration(std::span<const HeightSample> heights,
                           std::span<const LateralSample> laterals, int columns) {
  if (columns < kMinColumns) {
    throw base::InputError(
        fmt::format("calibration: {} columns; at least {} are needed", columns, kMinColumns));
  }
  CheckSamples(heights, laterals);
  Calibration calibration;
  calibration.columns = columns;
  FitHeights(heights, calibration);
  CheckMonotone(calibration);
  FitLateral(laterals, calibration);
  return calibration;
}

Profile Calibrate(const RawProfile& raw, const Calibration& calibration) {
  if (static_cast<int>(raw.row_px.size()) != calibration.columns) {
    throw base::InputError(fmt::format("the profile has {} columns, the calibration {}",
                                       raw.row_px.size(), calibration.columns));
  }
  Profile profile;
  profile.time_s = raw.time_s;
  profile.height_m.resize(raw.row_px.size());
  HeightsAt(calibration, raw.row_px.data(), raw.row_px.size(), profile.height_m.data());
  return profile;
}

Calibration ReadCalibration(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  Calibration c;
  for (const char* key :
       {"columns", "row_min_px", "row_max_px", "meters_per_column", "meters_per_column_per_m"}) {
    map.Require(key);
  }
  map.Read("columns", c.columns, kMinColumns, kMaxColumns, "columns of the camera");
  map.Read("row_min_px", c.row_min_px, -kMaxRow_px, kMaxRow_px, "first row that was calibrated");
  map.Read("row_max_px", c.row_max_px, -kMaxRow_px, kMaxRow_px, "and the last one");
  for (std::size_t k = 0; k < kTerms; ++k) {
    const std::string key = fmt::format("height_{}_m", k);
    map.Require(key);
    map.Read(key, c.height_m[k], -kMaxHeight_m, kMaxHeight_m,
             fmt::format("factor of u^{}; u is the row mapped to [-1, 1]", k));
  }
  map.Read("meters_per_column", c.meters_per_column[0], 1e-9, 1.0, "width of a column at height 0");
  map.Read("meters_per_column_per_m", c.meters_per_column[1], -kMaxHeight_m, kMaxHeight_m,
           "by which it grows a metre of height");
  map.Finish();
  if (!(c.row_min_px < c.row_max_px)) map.Fail("row_max_px", "must be above row_min_px");
  return c;
}

void WriteCalibration(const Calibration& c, const std::filesystem::path& file) {
  std::string text = fmt::format(
      "# Row to height: a polynomial in u, the row mapped from [row_min_px, row_max_px] to [-1, "
      "1].\n"
      "columns: {}\nrow_min_px: {:.17g}\nrow_max_px: {:.17g}\n",
      c.columns, c.row_min_px, c.row_max_px);
  for (std::size_t k = 0; k < kTerms; ++k) {
    text += fmt::format("height_{}_m: {:.17g}\n", k, c.height_m[k]);
  }
  text += fmt::format("meters_per_column: {:.17g}\nmeters_per_column_per_m: {:.17g}\n",
                      c.meters_per_column[0], c.meters_per_column[1]);
  base::WriteFile(file, text);
}

}  // namespace rangegrasp::seam
