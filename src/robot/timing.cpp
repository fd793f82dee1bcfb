#include "robot/timing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rangegrasp::robot {
namespace {

using Eigen::VectorXd;

constexpr double kMinLength_rad = 1e-9;  ///< closer waypoints count as one; rounding
constexpr double kStraight_rad = 1e-7;   ///< a smaller turn is not a corner; rounding
/// A corner that turns by more (160 deg) is not rounded: a stop costs less than such a tight arc.
constexpr double kMaxTurn_rad = 2.8;

std::vector<VectorXd> WithoutRepeats(const std::vector<VectorXd>& waypoints) {
  std::vector<VectorXd> out{waypoints.front()};
  for (const VectorXd& q : waypoints) {
    if ((q - out.back()).norm() > kMinLength_rad) out.push_back(q);
  }
  return out;
}

struct Corner {
  PathPiece arc;      ///< length 0: none
  double cut = 0.0;   ///< length taken from both legs
  bool stop = false;  ///< cannot be rounded
};

Corner RoundCorner(const VectorXd& before, const VectorXd& at, const VectorXd& after,
                   double corner_rad) {
  const VectorXd in = (at - before).normalized();
  const VectorXd out = (after - at).normalized();
  const double turn = 2.0 * std::asin(std::min(1.0, 0.5 * (out - in).norm()));
  Corner corner;
  if (turn < kStraight_rad) return corner;
  const double room = 0.5 * std::min((at - before).norm(), (after - at).norm());
  const double radius =
      std::min(corner_rad / (1.0 / std::cos(0.5 * turn) - 1.0), room / std::tan(0.5 * turn));
  if (turn > kMaxTurn_rad || radius < kMinLength_rad) {
    corner.stop = true;
    return corner;
  }
  corner.cut = radius * std::tan(0.5 * turn);
  corner.arc.radius = radius;
  corner.arc.length = radius * turn;
  corner.arc.origin = at + (out - in).normalized() * (radius / std::cos(0.5 * turn));
  corner.arc.start = (at - corner.cut * in - corner.arc.origin) / radius;
  corner.arc.along = in;
  return corner;
}

/// Longest interval along the path. Longer: slightly slower motion; shorter: more computing time.
constexpr double kGrid_rad = 0.01;
constexpr double kArcGrid_rad = 0.1;  ///< largest turn of the direction per interval of an arc
constexpr int kMinIntervals = 4;      ///< per piece, however short: to speed up and slow down
/// Fine samples per period, for the moving average: 2 ms of the usual 10 ms, as the servo's.
constexpr int kFinePerSample = 5;
constexpr double kReserve = 0.995;  ///< an arc bends between grid points: (0.1 / 2)^2 / 2 = 0.1 %
/// [rad^2/s^2] squared path speed that counts as rest, so that every interval ends.
constexpr double kMinSpeed2 = 1e-12;
/// A joint with a smaller share of the path's direction does not bound its speed.
constexpr double kMinSlope = 1e-12;
/// Bisection for the controllable speeds ends at this share of the speed, or after this many steps.
constexpr double kRelativeSpeed2 = 1e-9;
constexpr int kBisections = 40;

/// One interval of the grid with the path's derivatives at its ends. With x = (ds/dt)^2 and
/// u = d2s/dt2 constant in it, x grows by 2 u ds; q'' terms: acceleration = q' u + q'' x.
struct Interval {
  const PathPiece* piece = nullptr;
  double s = 0.0, ds = 0.0;
  VectorXd tangent[2], curvature[2];
  bool stop_before = false;
};

std::vector<Interval> MakeGrid(const std::vector<PathPiece>& pieces) {
  std::vector<Interval> grid;
  for (const PathPiece& piece : pieces) {
    const double turn = piece.radius > 0.0 ? piece.length / piece.radius : 0.0;
    const int count =
        std::max({kMinIntervals, static_cast<int>(std::ceil(piece.length / kGrid_rad)),
                  static_cast<int>(std::ceil(turn / kArcGrid_rad))});
    for (int i = 0; i < count; ++i) {
      Interval interval;
      interval.piece = &piece;
      interval.ds = piece.length / count;
      interval.s = i * interval.ds;
      for (int end = 0; end < 2; ++end) {
        interval.tangent[end] = piece.Tangent(interval.s + end * interval.ds);
        interval.curvature[end] = piece.Curvature(interval.s + end * interval.ds);
      }
      interval.stop_before = i == 0 && piece.stop_before;
      grid.push_back(std::move(interval));
    }
  }
  return grid;
}

struct Range {
  double low, high;
  void Meet(double a, double b) {
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
};

/// The accelerations u that are allowed in an interval entered with x and left with at most
/// x_end_max: |q' u + q'' x| <= a at its start, the same with x + 2 u ds at its end.
Range AllowedU(const Interval& interval, double x, double x_end_max, const VectorXd& acceleration) {
  const double ds = interval.ds;
  Range u{-x / (2.0 * ds), (x_end_max - x) / (2.0 * ds)};
  for (Eigen::Index j = 0; j < acceleration.size(); ++j) {
    for (int end = 0; end < 2; ++end) {
      const double bend = interval.curvature[end][j] * x;
      const double slope =
          interval.tangent[end][j] + (end == 1 ? 2.0 * ds * interval.curvature[end][j] : 0.0);
      if (std::abs(slope) > kMinSlope) {
        u.Meet((-acceleration[j] - bend) / slope, (acceleration[j] - bend) / slope);
      } else if (std::abs(bend) > acceleration[j]) {
        return {1.0, 0.0};
      }
    }
  }
  return u;
}

double FastestX(const VectorXd& tangent, const VectorXd& velocity) {
  double x = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < velocity.size(); ++j) {
    const double speed = std::abs(tangent[j]);
    if (speed > kMinSlope) x = std::min(x, (velocity[j] / speed) * (velocity[j] / speed));
  }
  return x;
}

/// The largest x at each grid point from which the path's end (or next stop) can still be reached
/// at rest. The feasible x form an interval from 0, so bisection finds its top.
std::vector<double> Controllable(const std::vector<Interval>& grid, const VectorXd& velocity,
                                 const VectorXd& acceleration) {
  std::vector<double> top(grid.size() + 1, 0.0);
  for (std::size_t i = grid.size(); i-- > 0;) {
    const Interval& interval = grid[i];
    const double end = std::min(top[i + 1], FastestX(interval.tangent[1], velocity));
    const auto feasible = [&](double x) {
      const Range u = AllowedU(interval, x, end, acceleration);
      return u.low <= u.high;
    };
    double low = 0.0;
    double high = i == 0 || interval.stop_before ? 0.0 : FastestX(interval.tangent[0], velocity);
    for (int k = 0; k < kBisections && high - low > kRelativeSpeed2 * high; ++k) {
      const double middle = k == 0 ? high : 0.5 * (low + high);
      (feasible(middle) ? low : high) = middle;
    }
    top[i] = low;
  }
  return top;
}

/// The fastest profile from rest that the controllable sets allow.
std::vector<double> FastestProfile(const std::vector<Interval>& grid, const VectorXd& velocity,
                                   const VectorXd& acceleration) {
  const std::vector<double> top = Controllable(grid, velocity, acceleration);
  std::vector<double> x(grid.size() + 1, 0.0);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double end = std::min(top[i + 1], FastestX(grid[i].tangent[1], velocity));
    const Range u = AllowedU(grid[i], x[i], end, acceleration);
    x[i + 1] = std::clamp(x[i] + 2.0 * grid[i].ds * std::max(u.low, u.high), 0.0, end);
  }
  return x;
}

/// The path at every dt from start to end.
std::vector<VectorXd> SampleInTime(const std::vector<Interval>& grid, const std::vector<double>& x,
                                   double dt) {
  std::vector<VectorXd> samples;
  double begin = 0.0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double v0 = std::sqrt(std::max(x[i], kMinSpeed2));
    const double v1 = std::sqrt(std::max(x[i + 1], kMinSpeed2));
    const double duration = 2.0 * grid[i].ds / (v0 + v1);
    const double u = (v1 - v0) / duration;
    for (double t = static_cast<double>(samples.size()) * dt - begin; t < duration;
         t = static_cast<double>(samples.size()) * dt - begin) {
      const double along = std::clamp(t * (v0 + 0.5 * u * t), 0.0, grid[i].ds);
      samples.push_back(grid[i].piece->Position(grid[i].s + along));
    }
    begin += duration;
  }
  return samples;
}

/// Samples at every `stride`-th fine step of the mean over the last `window` fine samples, resting
/// at both ends before and after.
std::vector<VectorXd> SlidingMean(const std::vector<VectorXd>& fine, const VectorXd& end,
                                  int window, int stride) {
  const auto at = [&](long i) -> const VectorXd& {
    if (i < 0) return fine.front();
    return i < static_cast<long>(fine.size()) ? fine[i] : end;
  };
  std::vector<VectorXd> out;
  const long last = static_cast<long>(fine.size()) + window - 1;  // from here on all is at rest
  for (long k = 0; k < last + stride; k += stride) {
    VectorXd sum = VectorXd::Zero(end.size());
    for (long j = 0; j < window; ++j) sum += at(k - j);
    out.push_back(sum / static_cast<double>(window));
  }
  return out;
}

}  // namespace

VectorXd PathPiece::Position(double s) const {
  if (radius == 0.0) return origin + s * along;
  const double angle = s / radius;
  return origin + radius * (std::cos(angle) * start + std::sin(angle) * along);
}

VectorXd PathPiece::Tangent(double s) const {
  if (radius == 0.0) return along;
  const double angle = s / radius;
  return std::cos(angle) * along - std::sin(angle) * start;
}

VectorXd PathPiece::Curvature(double s) const {
  if (radius == 0.0) return VectorXd::Zero(along.size());
  const double angle = s / radius;
  return -(std::cos(angle) * start + std::sin(angle) * along) / radius;
}

std::vector<PathPiece> RoundCorners(const std::vector<VectorXd>& waypoints, double corner_rad) {
  const std::vector<VectorXd> q = WithoutRepeats(waypoints);
  std::vector<PathPiece> pieces;
  VectorXd from = q.front();
  bool stop = false;
  for (std::size_t i = 1; i < q.size(); ++i) {
    const bool last = i + 1 == q.size();
    const Corner corner = last ? Corner() : RoundCorner(q[i - 1], q[i], q[i + 1], corner_rad);
    const VectorXd to =
        corner.cut > 0.0 ? VectorXd(q[i] - corner.cut * (q[i] - q[i - 1]).normalized()) : q[i];
    if ((to - from).norm() > kMinLength_rad) {
      PathPiece& straight = pieces.emplace_back();
      straight.length = (to - from).norm();
      straight.origin = from;
      straight.along = (to - from) / straight.length;
      straight.stop_before = stop;
    }
    stop = corner.stop;
    if (corner.arc.length > 0.0) pieces.push_back(corner.arc);
    from = corner.arc.length > 0.0 ? corner.arc.Position(corner.arc.length) : to;
  }
  return pieces;
}

base::JointTrajectory TimeParameterise(const Robot& robot, const std::vector<VectorXd>& path,
                                       const TimingOptions& options) {
  const std::vector<PathPiece> pieces = RoundCorners(path, options.corner_rad);
  if (pieces.empty()) return {options.period_s, {path.front()}};
  const std::vector<Interval> grid = MakeGrid(pieces);
  const VectorXd velocity = kReserve * options.velocity_scale * robot.velocity;
  const VectorXd acceleration = kReserve * options.acceleration_scale * robot.acceleration;
  const std::vector<double> x = FastestProfile(grid, velocity, acceleration);
  const double dt = options.period_s / kFinePerSample;
  const int window = std::max(1, static_cast<int>(std::lround(options.smoothing_s / dt)));
  base::JointTrajectory trajectory{
      options.period_s,
      SlidingMean(SampleInTime(grid, x, dt), path.back(), window, kFinePerSample)};
  trajectory.positions.front() = path.front();
  trajectory.positions.back() = path.back();
  return trajectory;
}

}  // namespace rangegrasp::robot
