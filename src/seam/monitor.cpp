#include "seam/monitor.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

namespace rangegrasp::seam {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kStride = 4;             // every fourth column is enough for the surface
constexpr int kTrims = 12;             // a trimmed fit settles in a few rounds
constexpr double kAbove_m = 1e-3;      // mats are lower; what rises more is no surface
constexpr double kSamePlace_m = 3e-3;  // one obstacle, seen again

// A parabola under everything that rises: what stands out above the fit is left out of the next
// one.
std::array<double, 3> FitSurface(std::span<const float> height) {
  std::vector<float> surface(height.size() / kStride);
  for (std::size_t i = 0; i < surface.size(); ++i) surface[i] = height[i * kStride];
  auto curve = FitQuadratic(surface);
  for (int round = 0; round < kTrims; ++round) {
    bool trimmed = false;
    for (std::size_t i = 0; i < surface.size(); ++i) {
      const double u = 2.0 * static_cast<double>(i) / static_cast<double>(surface.size() - 1) - 1.0;
      const double above =
          static_cast<double>(surface[i]) - (curve[0] + u * (curve[1] + u * curve[2]));
      if (!(above > kAbove_m)) continue;
      surface[i] = std::numeric_limits<float>::quiet_NaN();
      trimmed = true;
    }
    if (!trimmed) break;
    curve = FitQuadratic(surface);
  }
  return curve;
}

std::size_t WidthColumns(const LineGeometry& line, double width_m) {
  return std::max<std::size_t>(1,
                               static_cast<std::size_t>(std::lround(width_m * line.columns_per_m)));
}

// The lowest of a window rises; half of a window may be missing.
Protrusion HighestOf(std::span<const float> above, std::size_t width) {
  Protrusion best;
  for (std::size_t begin = 0; begin + width <= above.size(); ++begin) {
    float low = std::numeric_limits<float>::infinity();
    std::size_t points = 0;
    for (std::size_t i = begin; i < begin + width; ++i) {
      if (!(above[i] > 0.0F) && std::isfinite(above[i])) {
        points = 0;
        break;
      }
      if (!std::isfinite(above[i])) continue;
      low = std::min(low, above[i]);
      ++points;
    }
    if (2 * points < width || points == 0 || static_cast<double>(low) <= best.height_m) continue;
    best = {static_cast<double>(low),
            static_cast<double>(begin) + 0.5 * static_cast<double>(width - 1)};
  }
  return best;
}

}  // namespace

const char* Name(StopReason reason) {
  return reason == StopReason::kMatEnd ? "mat_end" : "obstacle";
}

Protrusion FindProtrusion(const PreparedProfile& profile, const LineGeometry& line,
                          double width_m) {
  const auto& z = profile.original_m;
  const std::size_t m = z.size();
  if (m < 2 * kStride) return {};
  const auto curve = FitSurface(z);
  std::vector<float> above(m);
  // The surface was fitted to the columns 0, kStride, ..: u = 1 is the last of those.
  const double last = static_cast<double>((m / kStride - 1) * kStride);
  for (std::size_t i = 0; i < m; ++i) {
    const double u = 2.0 * static_cast<double>(i) / last - 1.0;
    above[i] = z[i] - static_cast<float>(curve[0] + u * (curve[1] + u * curve[2]));
  }
  return HighestOf(above, WidthColumns(line, width_m));
}

Protrusion FindRise(const PreparedProfile& before, const PreparedProfile& now,
                    const LineGeometry& line, double width_m) {
  if (before.original_m.size() != now.original_m.size()) return {};
  std::vector<float> above(now.original_m.size());
  for (std::size_t i = 0; i < above.size(); ++i)
    above[i] = now.original_m[i] - before.original_m[i];
  return HighestOf(above, WidthColumns(line, width_m));
}

SurfaceMonitor::SurfaceMonitor(const LineGeometry& line, const MonitorOptions& options)
    : line_(line), options_(options) {
  if (!(options.obstacle_height_m > 0.0) || !(options.obstacle_width_m > 0.0) ||
      options.obstacle_profiles < 1 || options.mat_end_profiles < 1 ||
      options.window < std::max(options.obstacle_profiles, options.mat_end_profiles)) {
    throw std::invalid_argument(
        "surface monitor: heights and widths must be above 0, counts at least 1, and the window "
        "not shorter than either count");
  }
}

// Above the surface round it; or, if it is so wide that it is taken for the surface itself, above
// what was there before.
Protrusion SurfaceMonitor::HighestProtrusion(const PreparedProfile& profile) {
  auto highest = FindProtrusion(profile, line_, options_.obstacle_width_m);
  if (!before_.empty()) {
    const auto rise = FindRise(before_.front(), profile, line_, options_.obstacle_width_m);
    if (rise.height_m > highest.height_m) highest = rise;
  }
  before_.push_back(profile);
  if (before_.size() > static_cast<std::size_t>(options_.window)) before_.pop_front();
  return highest;
}

std::optional<StopReason> SurfaceMonitor::Update(const PreparedProfile& profile,
                                                 const Reading& reading) {
  if (stop_) return stop_;
  const auto protrusion = HighestProtrusion(profile);
  const bool rises = protrusion.height_m >= options_.obstacle_height_m;
  obstacle_columns_.push_back(rises ? protrusion.column : kNone);
  edge_seen_ = edge_seen_ || reading.status == ProfileStatus::kEdge;
  // An edge that only goes on by what was seen before does not count here.
  const bool edge = reading.status == ProfileStatus::kEdge && reading.step_m >= options_.min_step_m;
  no_edge_.push_back(edge_seen_ && !edge);
  const auto window = static_cast<std::size_t>(options_.window);
  if (no_edge_.size() > window) {
    no_edge_.erase(no_edge_.begin());
    obstacle_columns_.erase(obstacle_columns_.begin());
  }
  const double same_place = kSamePlace_m * line_.columns_per_m;
  const auto here = std::count_if(
      obstacle_columns_.begin(), obstacle_columns_.end(),
      [&](double c) { return rises && std::abs(c - protrusion.column) <= same_place; });
  if (here >= options_.obstacle_profiles) {
    stop_ = StopReason::kObstacle;
  } else if (std::count(no_edge_.begin(), no_edge_.end(), true) >= options_.mat_end_profiles) {
    stop_ = StopReason::kMatEnd;
  }
  return stop_;
}

void SurfaceMonitor::Reset() { *this = SurfaceMonitor(line_, options_); }

}  // namespace rangegrasp::seam
