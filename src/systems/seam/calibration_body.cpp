#include "seam/calibration_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/quantile.h"

namespace rangegrasp::seam {
namespace {

// Columns on either side whose medians are compared: half of the narrowest step (16 columns).
constexpr int kWindow = 8;
// Columns between two risers, at least: the narrowest step.
constexpr int kSeparation = 16;
// Columns beside a riser that are left out of a plateau: the camera sees the riser blurred.
constexpr int kMargin = 3;
// Of a plateau: fewer have no median that two outliers could not move.
constexpr std::size_t kMinBodyPoints = 5;
// Rows a metre and columns a metre change over the body by perspective, by some tens of per cent; a
// riser that is none is off by far more.
constexpr double kMaxChange = 2.0;

double MedianRow(const std::vector<float>& rows, int begin, int end) {
  std::vector<double> finite;
  for (int i = std::max(0, begin); i < std::min(static_cast<int>(rows.size()), end); ++i) {
    if (std::isfinite(rows[static_cast<std::size_t>(i)])) {
      finite.push_back(static_cast<double>(rows[static_cast<std::size_t>(i)]));
    }
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

// The columns where the row changes most, `count` of them, ascending.
std::vector<int> StrongestChanges(const std::vector<float>& rows, std::size_t count) {
  const auto m = static_cast<int>(rows.size());
  std::vector<double> change(rows.size(), 0.0);
  for (int i = kWindow; i + kWindow < m; ++i) {
    const double step = MedianRow(rows, i, i + kWindow) - MedianRow(rows, i - kWindow, i);
    change[static_cast<std::size_t>(i)] = std::isfinite(step) ? std::abs(step) : 0.0;
  }
  std::vector<int> columns;
  while (columns.size() < count) {
    const auto at = std::max_element(change.begin(), change.end());
    if (!(*at > 0.0)) break;
    const auto column = static_cast<int>(at - change.begin());
    columns.push_back(column);
    const int begin = std::max(0, column - kSeparation);
    const int end = std::min(m, column + kSeparation + 1);
    std::fill(change.begin() + begin, change.begin() + end, 0.0);
  }
  std::sort(columns.begin(), columns.end());
  return columns;
}

// How many points round a riser lie on the wrong side of the middle between its two plateaus if it
// stands left of the column `border`.
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

// The column at which the row passes from one plateau to the next, near `column`: the border with
// the fewest points on the wrong side; the middle of equal ones, such as round a missing column.
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

// True if all of the values lie within a factor of their middle one, whatever its sign.
bool AreAlike(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const double middle = values[values.size() / 2];
  return std::all_of(values.begin(), values.end(), [&](double value) {
    return value / middle > 1.0 / kMaxChange && value / middle < kMaxChange;
  });
}

// Rows a metre of height at each riser, and columns a metre of width between two: both change
// little over the body, so that a wrong riser stands out.
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

Calibration CalibrateFromBody(const CalibrationBody& body, std::span<const CalibrationScan> scans) {
  const auto risers = RisersOf(body);
  if (risers.size() < 2 || !(body.step_width_m > 0.0)) {
    throw base::InputError("calibration body: needs at least one step with a height and a width");
  }
  if (scans.empty()) throw base::InputError("calibration: no scans");
  LookUpTable table;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].profile.row_px.size() != scans[0].profile.row_px.size()) {
      FailScan(i, fmt::format("has {} columns, the first {}", scans[i].profile.row_px.size(),
                              scans[0].profile.row_px.size()));
    }
    TakeScan(risers, scans[i], i, table);
  }
  return FitCalibration(table.heights, table.laterals,
                        static_cast<int>(scans[0].profile.row_px.size()));
}

}  // namespace rangegrasp::seam
