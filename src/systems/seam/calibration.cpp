#include "seam/calibration.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "base/yaml_map.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();
// Coefficients of a 4th-order polynomial (section 3.2).
constexpr std::size_t kTerms = 5;
// Intervals in which the fitted polynomial must have the same direction. A 4th-order polynomial has
// at most three extrema, and none within an interval is large enough to matter.
constexpr int kMonotonySamples = 256;
// Bounds of a calibration file that reject wrong units: [m] and [px].
constexpr double kMaxBodyHeight_m = 100.0;
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
  std::copy(c.begin(), c.end(), calibration.height_m.begin());
  const double squares = (powers * c - heights).squaredNorm();
  calibration.residual_m = std::sqrt(squares / static_cast<double>(samples.size()));
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
        "calibration: the fitted function from row to height is not monotonic within the measured "
        "rows; some scans, or heights of the body's base, are wrong or too noisy");
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
  const Eigen::Vector2d k = base::SolveLdlt(normal, right);
  calibration.meters_per_column = {k.x(), k.y()};
  if (!(k.x() + k.y() * *heights.begin() > 0.0 && k.x() + k.y() * *heights.rbegin() > 0.0)) {
    throw base::InputError("calibration: the columns do not increase along the body");
  }
}

// HeightAt for a whole line, without branches.
RANGEGRASP_VECTORISED void HeightsAt(const Calibration& calibration, const float* row_px,
                                     std::size_t count, float* height_m) {
  const Calibration c = calibration;  // a copy that height_m cannot alias
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<double>(row_px[i]);
    const double height = Polynomial(c.height_m, Mapped(c, row));
    const bool calibrated = (row >= c.row_min_px) & (row <= c.row_max_px);
    height_m[i] = static_cast<float>(calibrated ? height : kNoHeight);
  }
}

// ---- from scans of the body to the look-up table ----

// Columns on either side whose medians are compared: half of the narrowest step (16 columns).
constexpr int kWindow = 8;
// Minimum number of columns between two risers: the narrowest step.
constexpr int kSeparation = 16;
// Columns next to a riser that are excluded from a plateau: the camera sees the riser blurred.
constexpr int kMargin = 3;
// Minimum number of points on a plateau: with fewer, two outliers could shift the median.
constexpr std::size_t kMinBodyPoints = 5;
// Perspective changes rows per metre and columns per metre by some tens of per cent over the body;
// at a false riser they differ far more.
constexpr double kMaxChange = 2.0;

double MedianRow(const std::vector<float>& rows, int begin, int end) {
  std::vector<double> finite;
  for (const float row : Within(rows, begin, end)) {
    if (std::isfinite(row)) finite.push_back(static_cast<double>(row));
  }
  if (finite.size() < kMinBodyPoints) return std::numeric_limits<double>::quiet_NaN();
  return base::MedianOf(std::move(finite));
}

// A change of height along the body.
struct Riser {
  double x_m;
  double left_m, right_m;  // heights above the base
};

std::vector<Riser> RisersOf(const CalibrationBody& body) {
  std::vector<Riser> risers;
  const auto n = static_cast<double>(body.step_heights_m.size());
  double before = 0.0;
  for (std::size_t i = 0; i <= body.step_heights_m.size(); ++i) {
    const double after = i < body.step_heights_m.size() ? body.step_heights_m[i] : 0.0;
    const double x = (static_cast<double>(i) - 0.5 * n) * body.step_width_m;
    if (after != before) risers.push_back({x, before, after});
    before = after;
  }
  return risers;
}

// The `count` columns where the row changes most, ascending.
std::vector<int> StrongestChanges(const std::vector<float>& rows, std::size_t count) {
  const auto m = static_cast<int>(rows.size());
  std::vector<double> change(rows.size(), 0.0);
  for (int i = kWindow; i + kWindow < m; ++i) {
    const double step = MedianRow(rows, i, i + kWindow) - MedianRow(rows, i - kWindow, i);
    change[static_cast<std::size_t>(i)] = std::isfinite(step) ? std::abs(step) : 0.0;
  }
  std::vector<int> columns;
  while (columns.size() < count) {
    const auto at = std::ranges::max_element(change);
    if (!(*at > 0.0)) break;
    const auto column = static_cast<int>(at - change.begin());
    columns.push_back(column);
    const int begin = std::max(0, column - kSeparation);
    const int end = std::min(m, column + kSeparation + 1);
    std::fill(change.begin() + begin, change.begin() + end, 0.0);
  }
  std::ranges::sort(columns);
  return columns;
}

// Number of points around a riser on the wrong side of the middle between its two plateaus, if the
// riser is just left of column `border`.
int PointsOnWrongSide(const std::vector<float>& rows, int column, int border, double left,
                      double right) {
  const int begin = std::max(0, column - kWindow);
  const int end = std::min(static_cast<int>(rows.size()), column + kWindow + 1);
  const double middle = 0.5 * (left + right);
  int wrong = 0;
  for (int i = begin; i < end; ++i) {
    const auto row = static_cast<double>(rows[static_cast<std::size_t>(i)]);
    if (!std::isfinite(row)) continue;
    const bool on_right = (row > middle) == (right > left);
    wrong += on_right != (i >= border) ? 1 : 0;
  }
  return wrong;
}

// Column near `column` where the row passes from one plateau to the next: the border with the
// fewest points on the wrong side, or the middle of equal ones (e.g. around a missing column).
double CrossingNear(const std::vector<float>& rows, int column, double left, double right) {
  int min_wrong = std::numeric_limits<int>::max();
  int first = column;
  int last = column;
  for (int border = column - kWindow; border <= column + kWindow; ++border) {
    const int wrong = PointsOnWrongSide(rows, column, border, left, right);
    if (wrong < min_wrong) first = border;
    if (wrong <= min_wrong) last = border;
    min_wrong = std::min(min_wrong, wrong);
  }
  return 0.5 * (first + last) - 0.5;
}

struct LookUpTable {
  std::vector<HeightSample> heights;
  std::vector<LateralSample> laterals;
};

[[noreturn]] void FailScan(std::size_t number, const std::string& what) {
  throw base::InputError(fmt::format("calibration scan {}: {}", number + 1, what));
}

// The rows of the plateaus: left of each riser, and right of the last.
std::vector<double> PlateauRows(const std::vector<float>& rows, const std::vector<int>& columns) {
  const int gap = columns[1] - columns[0];
  std::vector<double> plateaus;
  for (std::size_t i = 0; i <= columns.size(); ++i) {
    const int begin = i == 0 ? columns[0] - gap : columns[i - 1];
    const int end = i == columns.size() ? columns.back() + gap : columns[i];
    plateaus.push_back(MedianRow(rows, begin + kMargin, end - kMargin));
  }
  return plateaus;
}

// True if all values have the sign of their median and are within a factor kMaxChange of it.
bool AreAlike(const std::vector<double>& values) {
  const double middle = base::UpperMedianOf(values);
  return std::ranges::all_of(values, [&](double value) {
    return value / middle > 1.0 / kMaxChange && value / middle < kMaxChange;
  });
}

// Compares rows per metre of height at the risers, and columns per metre of width between them:
// both change little over the body, so a wrong riser stands out.
bool LooksLikeTheBody(const std::vector<Riser>& risers, const std::vector<int>& columns,
                      const std::vector<double>& plateaus) {
  std::vector<double> rows_per_m;
  std::vector<double> columns_per_m;
  for (std::size_t i = 0; i < risers.size(); ++i) {
    rows_per_m.push_back((plateaus[i + 1] - plateaus[i]) / (risers[i].right_m - risers[i].left_m));
    if (i == 0) continue;
    columns_per_m.push_back((columns[i] - columns[i - 1]) / (risers[i].x_m - risers[i - 1].x_m));
  }
  return AreAlike(rows_per_m) && AreAlike(columns_per_m);
}

void TakeScan(const std::vector<Riser>& risers, const CalibrationScan& scan, std::size_t number,
              LookUpTable& table) {
  const auto& rows = scan.profile.row_px;
  const auto columns = StrongestChanges(rows, risers.size());
  if (columns.size() < risers.size()) FailScan(number, "the staircase is not found");
  const auto plateaus = PlateauRows(rows, columns);
  for (std::size_t i = 0; i < plateaus.size(); ++i) {
    if (!std::isfinite(plateaus[i])) {
      FailScan(number, fmt::format("step {} of the staircase is not seen", i + 1));
    }
    const double height = i == 0 ? risers[0].left_m : risers[i - 1].right_m;
    table.heights.push_back({plateaus[i], scan.base_height_m + height});
  }
  if (!LooksLikeTheBody(risers, columns, plateaus)) {
    FailScan(number, "the staircase is not found: the largest changes are not its steps");
  }
  for (std::size_t i = 0; i < risers.size(); ++i) {
    // The camera sees the upper edge; what is below it is hidden.
    const double height = scan.base_height_m + std::max(risers[i].left_m, risers[i].right_m);
    table.laterals.push_back(
        {CrossingNear(rows, columns[i], plateaus[i], plateaus[i + 1]), height, risers[i].x_m});
  }
}

}  // namespace

double Calibration::HeightAt(double row_px) const {
  if (!(row_px >= row_min_px && row_px <= row_max_px)) return kNoHeight;
  return Polynomial(height_m, Mapped(*this, row_px));
}

double Calibration::LateralAt(double column, double height) const {
  return (column - 0.5 * (columns - 1)) * (meters_per_column[0] + meters_per_column[1] * height);
}

Calibration FitCalibration(std::span<const HeightSample> heights,
                           std::span<const LateralSample> laterals, int columns) {
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
  map.Read("columns", c.columns, kMinColumns, kMaxColumns, "number of columns of the camera");
  map.Read("row_min_px", c.row_min_px, -kMaxRow_px, kMaxRow_px, "first calibrated row");
  map.Read("row_max_px", c.row_max_px, -kMaxRow_px, kMaxRow_px, "last calibrated row");
  for (std::size_t k = 0; k < kTerms; ++k) {
    const std::string key = fmt::format("height_{}_m", k);
    map.Require(key);
    map.Read(key, c.height_m[k], -kMaxBodyHeight_m, kMaxBodyHeight_m,
             fmt::format("coefficient of u^{}; u is the row mapped to [-1, 1]", k));
  }
  map.Read("meters_per_column", c.meters_per_column[0], 1e-9, 1.0, "width of a column at height 0");
  map.Read("meters_per_column_per_m", c.meters_per_column[1], -kMaxBodyHeight_m, kMaxBodyHeight_m,
           "increase of this width per metre of height");
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

Calibration CalibrateFromBody(const CalibrationBody& body, std::span<const CalibrationScan> scans) {
  const auto risers = RisersOf(body);
  if (risers.size() < 2) {
    throw base::InputError("calibration body: needs at least one step with a height");
  }
  LookUpTable table;
  for (std::size_t i = 0; i < scans.size(); ++i) TakeScan(risers, scans[i], i, table);
  return FitCalibration(table.heights, table.laterals,
                        static_cast<int>(scans[0].profile.row_px.size()));
}

}  // namespace rangegrasp::seam
