#include "seam/stitching/internal/head.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rangegrasp::stitching::internal {
namespace {

// Between points of a route: the needle moves by 0.3 mm in a control period at 30 mm/s.
constexpr double kSpacing_m = 0.25e-3;
// Points on each side over which corners are rounded, twice: wider cuts corners, narrower makes the
// head stop at them.
constexpr int kRoundHalf = 6;
// Points on each side from which the curvature is taken: within the rounding.
constexpr int kCurvatureHalf = 4;
// How a route spends the acceleration: 0.5^2 + 0.6^2 < 0.8^2, what is left serves corrections.
constexpr double kAlong = 0.5;
constexpr double kAcross = 0.6;
// And the lateral speed.
constexpr double kLateralShare = 0.95;
// How fast the heading follows: a third of a second, against the 2.7 s that the line is ahead.
constexpr double kHeadingGain_1_s = 3.0;
// The share of the rotational acceleration that braking counts on.
constexpr double kBrakingShare = 0.8;
// Keeps divisions by a curvature or slope of 0 finite.
constexpr double kTiny = 1e-9;

Point Limited(const Point& v, double max) {
  const double norm = v.norm();
  return norm > max ? Point(v * (max / norm)) : v;
}

// Both limits hold for every point between two points that keep them.
Point LimitedVelocity(const Point& wanted, const HeadOptions& options) {
  Point v = Limited(wanted, options.speed_m_s);
  v.x() = std::clamp(v.x(), -options.max_lateral_speed_m_s, options.max_lateral_speed_m_s);
  return v;
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

}  // namespace

LinePose HeadState::Line(double ahead_m) const {
  LinePose pose;
  pose.x_m = needle.x() - ahead_m * std::sin(heading_rad);
  pose.y_m = needle.y() + ahead_m * std::cos(heading_rad);
  pose.heading_rad = heading_rad;
  return pose;
}

HeadState Move(const HeadState& head, const HeadCommand& command, const HeadOptions& options) {
  constexpr double dt = kControlPeriod_s;
  HeadState next = head;
  const Point wanted = LimitedVelocity(command.velocity, options);
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
  speed_.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    speed_[i] = std::min(speed_m_s, SpeedAt(points_, i, options));
  }
  // Brake in time for what comes.
  const double gain = 2.0 * kAlong * options.max_acceleration_m_s2;
  for (std::size_t i = points_.size(); i-- > 1;) {
    const double from = speed_[i] * speed_[i] + gain * (points_[i] - points_[i - 1]).norm();
    speed_[i - 1] = std::min(speed_[i - 1], std::sqrt(from));
  }
}

Route::Place Route::Nearest(const Point& to) const {
  Place best;
  double nearest = std::numeric_limits<double>::infinity();
  double s = 0.0;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Point along = points_[i] - points_[i - 1];
    const double length = along.norm();
    if (length <= 0.0) continue;
    const double t = std::clamp((to - points_[i - 1]).dot(along) / (length * length), 0.0, 1.0);
    const Point point = points_[i - 1] + t * along;
    const double distance = (to - point).norm();
    if (distance < nearest) {
      nearest = distance;
      best = {point, along / length, std::min(speed_[i - 1], speed_[i]), s + t * length};
    }
    s += length;
  }
  return best;
}

double Route::LengthTo(const Place& from, double y_m) const {
  double s = 0.0;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const double rise = points_[i].y() - points_[i - 1].y();
    const double length = (points_[i] - points_[i - 1]).norm();
    if (points_[i].y() >= y_m && s + length >= from.s_m) {
      const double t = rise > 0.0 ? std::clamp((y_m - points_[i - 1].y()) / rise, 0.0, 1.0) : 0.0;
      return std::max(0.0, s + t * length - from.s_m);
    }
    s += length;
  }
  return std::numeric_limits<double>::infinity();
}

Point Route::AtDistance(const Place& from, double distance_m) const {
  double s = 0.0;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    s += (points_[i] - points_[i - 1]).norm();
    if (s > from.s_m && (points_[i] - from.point).norm() >= distance_m) return points_[i];
  }
  return points_.back();
}

}  // namespace rangegrasp::stitching::internal
