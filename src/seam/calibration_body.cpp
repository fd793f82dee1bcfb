#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "seam/calibration.h"

namespace rangegrasp::seam {
namespace {

constexpr int kWindow = 8;        // columns on either side whose medians are compared
constexpr int kSeparation = 16;   // columns between risers, at least
constexpr int kFewestPoints = 5;  // of a plateau

double MedianOf(const std::vector<float>& rows, int begin, int end) {
  std::vector<float> finite;
  for (int i = std::max(0, begin); i < std::min(static_cast<int>(rows.size()), end); ++i) {
    if (std::isfinite(rows[static_cast<std::size_t>(i)])) {
      finite.push_back(rows[static_cast<std::size_t>(i)]);
    }
  }
  if (finite.size() < kFewestPoints) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = finite.begin() + static_cast<std::ptrdiff_t>(finite.size() / 2);
  std::nth_element(finite.begin(), middle, finite.end());
  return static_cast<double>(*middle);
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
std::vector<int> LargestChanges(const std::vector<float>& rows, std::size_t count) {
  const auto m = static_cast<int>(rows.size());
  std::vector<double> change(rows.size(), 0.0);
  for (int i = kWindow; i + kWindow < m; ++i) {
    const double step = MedianOf(rows, i, i + kWindow) - MedianOf(rows, i - kWindow, i);
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

// The column at which the row passes the middle between two plateaus, near a riser.
double CrossingNear(const std::vector<float>& rows, int column, double left, double right) {
  const double middle = 0.5 * (left + right);
  double best = column;
  int fewest_wrong = std::numeric_limits<int>::max();
  // The border with the fewest points on the wrong side of the middle.
  for (int border = column - kWindow; border <= column + kWindow; ++border) {
    int wrong = 0;
    for (int i = column - kWindow; i <= column + kWindow; ++i) {
      if (i < 0 || i >= static_cast<int>(rows.size())) continue;
      const auto row = static_cast<double>(rows[static_cast<std::size_t>(i)]);
      if (!std::isfinite(row)) continue;
      const bool on_right = (row > middle) == (right > left);
      wrong += on_right != (i >= border) ? 1 : 0;
    }
    if (wrong < fewest_wrong) {
      fewest_wrong = wrong;
      best = border - 0.5;
    }
  }
  return best;
}

struct LookUpTable {
  std::vector<HeightSample> heights;
  std::vector<LateralSample> laterals;
};

[[noreturn]] void FailScan(std::size_t number, const std::string& what) {
  throw core::InputError("calibration scan " + std::to_string(number + 1) + ": " + what);
}

void TakeScan(const std::vector<Riser>& risers, const CalibrationScan& scan, std::size_t number,
              LookUpTable& table) {
  const auto& rows = scan.profile.row_px;
  const auto columns = LargestChanges(rows, risers.size());
  if (columns.size() < risers.size()) FailScan(number, "the staircase is not found");
  const int margin = 3;
  std::vector<double> plateau;  // rows left of each riser, and right of the last
  for (std::size_t i = 0; i <= columns.size(); ++i) {
    const int gap = columns[1] - columns[0];
    const int begin = i == 0 ? columns[0] - gap : columns[i - 1];
    const int end = i == columns.size() ? columns.back() + gap : columns[i];
    plateau.push_back(MedianOf(rows, begin + margin, end - margin));
    if (!std::isfinite(plateau.back())) FailScan(number, "a step of the staircase is not seen");
    const double height = i == 0 ? risers[0].left_m : risers[i - 1].right_m;
    table.heights.push_back({plateau.back(), scan.base_height_m + height});
  }
  int sign = 0;
  for (std::size_t i = 0; i < risers.size(); ++i) {
    const bool up = risers[i].right_m > risers[i].left_m;
    const int its = (plateau[i + 1] > plateau[i]) == up ? 1 : -1;
    if (sign == 0) sign = its;
    if (its != sign) FailScan(number, "the steps do not go up and down as the body's do");
    // The camera sees the upper edge; what is below it is hidden.
    const double height = scan.base_height_m + std::max(risers[i].left_m, risers[i].right_m);
    table.laterals.push_back(
        {CrossingNear(rows, columns[i], plateau[i], plateau[i + 1]), height, risers[i].x_m});
  }
}

}  // namespace

Calibration CalibrateFromBody(const CalibrationBody& body, std::span<const CalibrationScan> scans) {
  const auto risers = RisersOf(body);
  if (risers.size() < 2 || !(body.step_width_m > 0.0)) {
    throw core::InputError("calibration body: needs at least one step with a height and a width");
  }
  if (scans.empty()) throw core::InputError("calibration: no scans");
  LookUpTable table;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].profile.row_px.size() != scans[0].profile.row_px.size()) {
      FailScan(i, "has " + std::to_string(scans[i].profile.row_px.size()) + " columns, the first " +
                      std::to_string(scans[0].profile.row_px.size()));
    }
    TakeScan(risers, scans[i], i, table);
  }
  return FitCalibration(table.heights, table.laterals,
                        static_cast<int>(scans[0].profile.row_px.size()));
}

}  // namespace rangegrasp::seam
