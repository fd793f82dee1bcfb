#include "seam/stitching/internal/control_unit.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::stitching::internal {
namespace {

// Over this share of the distance from needle to line the needle moves from CAD to the edge.
constexpr double kJoinShare = 0.75;
// The needle rests this far before a mat's end, or before where nothing is known any more.
constexpr double kStopMargin_m = 5e-3;
constexpr double kBehind_m = 5e-3;     // the route's part behind the needle
constexpr double kSmoothed_m = 40e-3;  // the edge's part behind the needle that smoothing sees
// By which the route goes beyond what is known: more than twice the wanted distance, so that the
// offset curve is whole up to where the head may come.
constexpr double kAhead_m = 30e-3;
// Between the points at which the offset curve is computed; the route resamples it.
constexpr double kPathSpacing_m = 0.5e-3;
// A head that is this near to where it must stop is there: a twentieth of what counts as good.
constexpr double kAtRest_m = 0.05e-3;
// How fast the needle returns to its route: a tenth of a second, the period of corrections.
constexpr double kFollowGain_1_s = 10.0;

// Length over which an obstacle is high enough, in the widths of the stretch that must be high: it
// is twice as long as those, less its borders. As many profiles as must show it lie within.
constexpr double kSeenLength = 1.4;
// Of a line that is turned, from its middle: so far out an edge may have been.
constexpr double kTurned_m = 20e-3;
// Points that a jump is measured from: a stray one among them does no harm.
constexpr std::size_t kLast = 3;

double SmoothStep(double t) {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

ControlUnit::ControlUnit(const TrackOptions& options, double line_ahead_m, double rate_hz)
    : options_(options),
      ahead_m_(line_ahead_m),
      window_s_(options.monitor.window / rate_hz + options.head.correction_period_s),
      speed_m_s_(std::min(
          SafeSpeed(line_ahead_m - 2.0 * kStopMargin_m, window_s_ + kControlPeriod_s, options.head),
          kSeenLength * options.monitor.obstacle_width_m * rate_hz /
              options.monitor.obstacle_profiles)),
      sure_to_y_m_(line_ahead_m),
      known_to_y_m_(line_ahead_m) {}

HeadState ControlUnit::PoseAt(double time_s) const {
  const double step =
      std::clamp(time_s / kControlPeriod_s, 0.0, static_cast<double>(poses_.size() - 1));
  const auto before = static_cast<std::size_t>(step);
  const HeadState& a = poses_[before];
  const HeadState& b = poses_[std::min(before + 1, poses_.size() - 1)];
  const double t = step - static_cast<double>(before);
  HeadState pose = a;
  pose.needle += t * (b.needle - a.needle);
  pose.heading_rad += t * (b.heading_rad - a.heading_rad);
  return pose;
}

std::optional<TrackPoint> ControlUnit::Receive(const std::string& xml) {
  const Correction correction = FromXml(xml);
  if (correction.stop) TakeStop(correction);
  // Beyond doubt the edge is there again: it was not the mats' end.
  if (!correction.stop && correction.valid && correction.sure.value_or(false)) mat_end_y_m_.reset();
  if (!correction.valid || mat_end_y_m_) return std::nullopt;
  const LinePose line = PoseAt(correction.time_s).Line(ahead_m_);
  const Point edge(line.x_m + correction.edge_x_m * std::cos(line.heading_rad),
                   line.y_m + correction.edge_x_m * std::sin(line.heading_rad));
  if (IsJump(edge, correction.time_s)) return std::nullopt;
  last_.push_back({correction.time_s, edge.x(), edge.y(), line.heading_rad, 0.0});
  if (last_.size() > kLast) last_.erase(last_.begin());
  if (correction.sure.value_or(true)) sure_to_y_m_ = std::max(sure_to_y_m_, edge.y());
  TakeEdge(edge);
  return TrackPoint{correction.time_s, edge.x(), edge.y(), line.heading_rad, 0.0};
}

void ControlUnit::TakeStop(const Correction& correction) {
  if (*correction.stop == seam::StopReason::kObstacle) obstacle_ = true;
  if (*correction.stop != seam::StopReason::kMatEnd || mat_end_y_m_) return;
  // The mats ended no earlier than where the line was when the monitor's window began, and not
  // before the last edge that was surely seen; the nearer of both is safe.
  const LinePose line = PoseAt(correction.time_s - window_s_).Line(ahead_m_);
  const double seen_y = edge_.empty() ? line.y_m : std::min(line.y_m, sure_to_y_m_);
  // A line that is turned sees the mats' end as an edge that runs along it, before its middle.
  mat_end_y_m_ = seen_y - kTurned_m * std::abs(std::tan(line.heading_rad));
}

// Further from each of the last points than the head could go.
bool ControlUnit::IsJump(const Point& edge, double time_s) const {
  if (last_.size() < kLast) return false;
  return std::ranges::all_of(last_, [&](const TrackPoint& p) {
    const double reach = options_.head.max_jump_m +
                         options_.head.max_lateral_speed_m_s * std::max(0.0, time_s - p.time_s);
    return std::abs(edge.x() - p.x_m) > reach;
  });
}

void ControlUnit::TakeEdge(const Point& edge) {
  const auto after = std::upper_bound(edge_.begin(), edge_.end(), edge.y(),
                                      [](double y, const Point& p) { return y < p.y(); });
  edge_.insert(after, edge);
  PlanRoute();
}

// The edge's offset curve, which takes over from the CAD track smoothly.
double ControlUnit::PathX(const std::vector<Point>& edge, double y_m) const {
  const double cad = -options_.wanted_distance_m;
  if (!join_y_m_) return cad;
  const double x = OffsetX(edge, options_.wanted_distance_m, y_m);
  return cad + SmoothStep((y_m - *join_y_m_) / (kJoinShare * ahead_m_)) * (x - cad);
}

// The smoothed edge about the route, carried on at both ends; empty if nothing can be trusted.
std::vector<Point> ControlUnit::EdgeFrom(double from_y) {
  const auto first = std::find_if(edge_.begin(), edge_.end(),
                                  [&](const Point& p) { return p.y() >= from_y - kSmoothed_m; });
  std::vector<Point> edge = SmoothEdge(std::span(first, edge_.end()));
  if (edge.empty()) return edge;
  if (!join_y_m_) join_y_m_ = poses_.back().needle.y();
  known_to_y_m_ = std::min(edge.back().y(), sure_to_y_m_);
  const double reach = 2.0 * options_.wanted_distance_m;
  return Extend(std::move(edge), std::max(0.0, edge.front().y() - from_y) + reach,
                kAhead_m + reach);
}

void ControlUnit::PlanRoute() {
  const double from_y = poses_.back().needle.y() - kBehind_m;
  const std::vector<Point> edge = EdgeFrom(from_y);
  if (edge.empty() && join_y_m_) return;
  const double to_y = known_to_y_m_ + kAhead_m;
  std::vector<Point> path;
  for (int i = 0; from_y + i * kPathSpacing_m <= to_y; ++i) {
    const double y = from_y + i * kPathSpacing_m;
    path.emplace_back(PathX(edge, y), y);
  }
  route_ = Route(path, speed_m_s_, options_.head);
}

HeadCommand ControlUnit::Command() {
  const HeadState& head = poses_.back();
  if (poses_.size() == 1) PlanRoute();
  const Route::Place place = route_.Nearest(head.needle);
  double speed = place.speed_m_s;
  const auto stop_at = [&](double y_m, TrackEnd why) {
    const double left = route_.LengthTo(place, y_m);
    speed = std::min({speed, BrakingSpeed(left, options_.head), left / kControlPeriod_s});
    if (left < kAtRest_m && !end_) end_ = why;
  };
  if (mat_end_y_m_) stop_at(*mat_end_y_m_ - kStopMargin_m, TrackEnd::kMatEnd);
  stop_at(options_.length_m, TrackEnd::kDone);
  stop_at(known_to_y_m_ - kStopMargin_m, TrackEnd::kLost);
  if (obstacle_) end_ = TrackEnd::kObstacle;
  HeadCommand command{Point::Zero(), head.heading_rad};
  if (end_) return command;
  command.velocity = speed * place.tangent + kFollowGain_1_s * (place.point - head.needle);
  const Point aim = route_.AtDistance(place, ahead_m_) - head.needle;
  command.heading_rad = std::atan2(-aim.x(), aim.y());
  return command;
}

}  // namespace rangegrasp::stitching::internal
