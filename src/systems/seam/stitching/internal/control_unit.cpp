#include "seam/stitching/internal/control_unit.h"

#include <cmath>
#include <limits>

#include "seam/stitching/internal/mat_texture.h"

namespace rangegrasp::seam {
namespace {

// ---- the head and its route ----

// Distance between points of a route: the needle moves by 0.3 mm per control period at 30 mm/s.
constexpr double kSpacing_m = 0.25e-3;
// Points on each side over which corners are rounded, twice. More points cut corners, fewer make
// the head stop at them.
constexpr int kRoundHalf = 6;
// Points on each side from which the curvature is computed: within the rounding.
constexpr int kCurvatureHalf = 4;
// A route's shares of the acceleration: 0.5^2 + 0.6^2 < 0.8^2; the rest is for corrections.
constexpr double kAlong = 0.5;
constexpr double kAcross = 0.6;
// Share of the lateral speed that a route uses.
constexpr double kLateralShare = 0.95;
// Gain of the heading: it follows in a third of a second, whereas the line is 2.7 s ahead.
constexpr double kHeadingGain_1_s = 3.0;
// The share of the rotational acceleration that is used for braking.
constexpr double kBrakingShare = 0.8;
// Keeps divisions by a curvature or slope of 0 finite.
constexpr double kTiny = 1e-9;

Point Limited(const Point& v, double max) {
  const double norm = v.norm();
  return norm > max ? Point(v * (max / norm)) : v;
}

double WantedRotation(double error_rad, const HeadOptions& options) {
  const double brakes = std::sqrt(2.0 * kBrakingShare * options.max_rotation_acceleration_rad_s2 *
                                  std::abs(error_rad));
  const double max = std::min(brakes, options.max_rotation_rad_s);
  return std::clamp(kHeadingGain_1_s * error_rad, -max, max);
}

// Curvature of the circle through three points [1/m].
double Curvature(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a, v = c - b;
  const double product = u.norm() * v.norm() * (c - a).norm();
  return product > 0.0 ? 2.0 * std::abs(u.x() * v.y() - u.y() * v.x()) / product : 0.0;
}

double SpeedAt(const std::vector<Point>& p, std::size_t i, const HeadOptions& options) {
  const std::size_t a = i - std::min<std::size_t>(i, kCurvatureHalf);
  const std::size_t c = std::min<std::size_t>(i + kCurvatureHalf, p.size() - 1);
  double speed = options.speed_m_s;
  const Point along = p[c] - p[a];
  if (along.norm() > 0.0) {
    const double across = std::abs(along.x()) / along.norm();
    speed =
        std::min(speed, kLateralShare * options.max_lateral_speed_m_s / std::max(across, kTiny));
  }
  const double curvature = a < i && i < c ? Curvature(p[a], p[i], p[c]) : 0.0;
  return std::min(speed,
                  std::sqrt(kAcross * options.max_acceleration_m_s2 / std::max(curvature, kTiny)));
}

// ---- the control unit ----

// Over this share of the distance from needle to line, the needle moves from CAD to the edge.
constexpr double kJoinShare = 0.75;
// The needle stops this far before a mat's end, or before the end of what is known.
constexpr double kStopMargin_m = 5e-3;
constexpr double kBehind_m = 5e-3;     // length of the route behind the needle
constexpr double kSmoothed_m = 40e-3;  // length of edge behind the needle that is smoothed
// Length of the route beyond what is known: more than twice the wanted distance, so that the offset
// curve is complete wherever the head may go.
constexpr double kAhead_m = 30e-3;
// Distance between points at which the offset curve is computed; the route resamples it.
constexpr double kPathSpacing_m = 0.5e-3;
// A head this close to where it must stop has arrived: a twentieth of what counts as good.
constexpr double kAtRest_m = 0.05e-3;
// Gain of the needle's return to its route: a tenth of a second, the period of corrections.
constexpr double kFollowGain_1_s = 10.0;

// Length over which an obstacle is high enough, in widths of the run that must be high: twice the
// width, less the obstacle's borders. It must contain the required number of profiles.
constexpr double kSeenLength = 1.4;
// Maximum distance of an edge from the middle of a turned line.
constexpr double kTurned_m = 20e-3;
// Maximum jump of the edge between two packets, in addition to the possible movement of the head in
// this time. The half circle of fig. 3.25 begins with a jump of 10.5 mm.
constexpr double kMaxJump_m = 12e-3;
// Number of points from which a jump is measured: a stray one among them does no harm.
constexpr std::size_t kLast = 3;

}  // namespace

LinePose HeadState::Line(double ahead_m) const {
  return {.x_m = needle.x() - ahead_m * std::sin(heading_rad),
          .y_m = needle.y() + ahead_m * std::cos(heading_rad),
          .heading_rad = heading_rad};
}

HeadState Move(const HeadState& head, const HeadCommand& command, const HeadOptions& options) {
  constexpr double dt = kControlPeriod_s;
  HeadState next = head;
  // Every velocity between two that satisfy both limits also satisfies them.
  Point wanted = Limited(command.velocity, options.speed_m_s);
  const double lateral = options.max_lateral_speed_m_s;
  wanted.x() = std::clamp(wanted.x(), -lateral, lateral);
  next.velocity += Limited(wanted - head.velocity, options.max_acceleration_m_s2 * dt);
  next.needle += next.velocity * dt;
  if (!options.rotate) return next;
  const double rotation = WantedRotation(command.heading_rad - head.heading_rad, options);
  const double max = options.max_rotation_acceleration_rad_s2 * dt;
  next.rotation_rad_s += std::clamp(rotation - head.rotation_rad_s, -max, max);
  next.heading_rad += next.rotation_rad_s * dt;
  return next;
}

double BrakingSpeed(double distance_m, const HeadOptions& options) {
  return std::sqrt(2.0 * kAlong * options.max_acceleration_m_s2 * std::max(0.0, distance_m));
}

double SafeSpeed(double distance_m, double reaction_s, const HeadOptions& options) {
  // v t + v^2 / (2 a) = distance.
  const double at = kAlong * options.max_acceleration_m_s2 * reaction_s;
  const double brakes = BrakingSpeed(distance_m, options);
  return std::sqrt(at * at + brakes * brakes) - at;
}

Route::Route(std::span<const Point> path, double speed_m_s, const HeadOptions& options) {
  points_ = Resample(path, kSpacing_m);
  points_ = RoundCorners(RoundCorners(points_, kRoundHalf), kRoundHalf);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    speed_.push_back(std::min(speed_m_s, SpeedAt(points_, i, options)));
    s_m_.push_back(i == 0 ? 0.0 : s_m_.back() + (points_[i] - points_[i - 1]).norm());
  }
  // Brake in time for slower points ahead.
  const double gain = 2.0 * kAlong * options.max_acceleration_m_s2;
  for (std::size_t i = points_.size(); i-- > 1;) {
    const double from = speed_[i] * speed_[i] + gain * (points_[i] - points_[i - 1]).norm();
    speed_[i - 1] = std::min(speed_[i - 1], std::sqrt(from));
  }
}

Route::Place Route::Nearest(const Point& to) const {
  Place best;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Point along = points_[i] - points_[i - 1];
    const double length = along.norm();
    if (length <= 0.0) continue;
    const double t = std::clamp((to - points_[i - 1]).dot(along) / (length * length), 0.0, 1.0);
    const Point point = points_[i - 1] + t * along;
    const double distance = (to - point).norm();
    if (!(distance < nearest)) continue;
    nearest = distance;
    best = {point, along / length, std::min(speed_[i - 1], speed_[i]), s_m_[i - 1] + t * length};
  }
  return best;
}

double Route::LengthTo(const Place& from, double y_m) const {
  for (std::size_t i = 1; i < points_.size(); ++i) {
    if (points_[i].y() < y_m || s_m_[i] < from.s_m) continue;
    const double rise = points_[i].y() - points_[i - 1].y();
    const double length = (points_[i] - points_[i - 1]).norm();
    const double t = rise > 0.0 ? std::clamp((y_m - points_[i - 1].y()) / rise, 0.0, 1.0) : 0.0;
    return std::max(0.0, s_m_[i - 1] + t * length - from.s_m);
  }
  return std::numeric_limits<double>::infinity();
}

Point Route::AtDistance(const Place& from, double distance_m) const {
  for (std::size_t i = 1; i < points_.size(); ++i) {
    if (s_m_[i] > from.s_m && (points_[i] - from.point).norm() >= distance_m) return points_[i];
  }
  return points_.back();
}

ControlUnit::ControlUnit(const TrackOptions& options, double line_ahead_m, double rate_hz)
    : options_(options),
      ahead_m_(line_ahead_m),
      window_s_(options.monitor.window / rate_hz + options.tracker.packet_period_s),
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

std::optional<TrackPoint> ControlUnit::Receive(const Correction& correction) {
  if (correction.stop) TakeStop(correction);
  // The edge is seen again beyond doubt, so it was not the mats' end.
  if (!correction.stop && correction.valid && correction.sure.value_or(false)) mat_end_y_m_.reset();
  if (!correction.valid || mat_end_y_m_) return std::nullopt;
  const LinePose line = PoseAt(correction.time_s).Line(ahead_m_);
  const Point edge(line.x_m + correction.edge_x_m * std::cos(line.heading_rad),
                   line.y_m + correction.edge_x_m * std::sin(line.heading_rad));
  if (IsJump(edge, correction.time_s)) return std::nullopt;
  const TrackPoint point{correction.time_s, edge.x(), edge.y(), line.heading_rad, 0.0};
  last_.push_back(point);
  if (last_.size() > kLast) last_.erase(last_.begin());
  if (correction.sure.value_or(true)) sure_to_y_m_ = std::max(sure_to_y_m_, edge.y());
  const auto y_of = [](const Point& p) { return p.y(); };
  edge_.insert(std::ranges::upper_bound(edge_, edge.y(), {}, y_of), edge);
  PlanRoute();
  return point;
}

void ControlUnit::TakeStop(const Correction& correction) {
  if (*correction.stop == StopReason::kObstacle) obstacle_ = true;
  if (*correction.stop != StopReason::kMatEnd || mat_end_y_m_) return;
  // The mats ended no earlier than the line's position at the start of the monitor's window, and
  // not before the last edge that was seen beyond doubt; the nearer of both is safe.
  const LinePose line = PoseAt(correction.time_s - window_s_).Line(ahead_m_);
  const double seen_y = edge_.empty() ? line.y_m : std::min(line.y_m, sure_to_y_m_);
  // A turned line sees the mats' end as an edge that runs along it, before its middle.
  mat_end_y_m_ = seen_y - kTurned_m * std::abs(std::tan(line.heading_rad));
}

// True if the edge is further from each of the last points than the head could move.
bool ControlUnit::IsJump(const Point& edge, double time_s) const {
  if (last_.size() < kLast) return false;
  return std::ranges::all_of(last_, [&](const TrackPoint& p) {
    const double reach =
        kMaxJump_m + options_.head.max_lateral_speed_m_s * std::max(0.0, time_s - p.time_s);
    return std::abs(edge.x() - p.x_m) > reach;
  });
}

// The edge's offset curve, with a smooth transition from the CAD track.
double ControlUnit::PathX(const std::vector<Point>& edge, double y_m) const {
  const double cad = -options_.wanted_distance_m;
  if (!join_y_m_) return cad;
  const double x = OffsetX(edge, options_.wanted_distance_m, y_m);
  return cad + Ramp((y_m - *join_y_m_) / (kJoinShare * ahead_m_)) * (x - cad);
}

// The smoothed edge near the route, extended at both ends; empty if no points are reliable.
std::vector<Point> ControlUnit::EdgeFrom(double from_y) {
  const auto first =
      std::ranges::find_if(edge_, [&](const Point& p) { return p.y() >= from_y - kSmoothed_m; });
  std::vector<Point> edge = SmoothEdge({first, edge_.end()});
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

}  // namespace rangegrasp::seam
