#include "robot/internal/joint_path.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::robot::internal {
namespace {

constexpr double kMinLength_rad = 1e-9;  ///< waypoints nearer to each other are one; rounding
constexpr double kStraight_rad = 1e-7;   ///< a corner that turns by less is none; rounding
/// A corner that turns by more (160 deg) is not rounded: the arc's radius would be nearly nothing,
/// and a stop costs less.
constexpr double kMaxTurn_rad = 2.8;

PathPiece Straight(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  PathPiece piece;
  piece.length = (to - from).norm();
  piece.origin = from;
  piece.along = (to - from) / piece.length;
  return piece;
}

std::vector<Eigen::VectorXd> WithoutRepeats(const std::vector<Eigen::VectorXd>& waypoints) {
  std::vector<Eigen::VectorXd> out{waypoints.front()};
  for (const Eigen::VectorXd& q : waypoints) {
    if ((q - out.back()).norm() > kMinLength_rad) out.push_back(q);
  }
  return out;
}

struct Corner {
  PathPiece arc;      ///< length 0: none
  double cut = 0.0;   ///< taken from both legs
  bool stop = false;  ///< cannot be rounded
};

Corner RoundCorner(const Eigen::VectorXd& before, const Eigen::VectorXd& at,
                   const Eigen::VectorXd& after, double corner_rad) {
  const Eigen::VectorXd in = (at - before).normalized();
  const Eigen::VectorXd out = (after - at).normalized();
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

}  // namespace

Eigen::VectorXd PathPiece::Position(double s) const {
  if (radius == 0.0) return origin + s * along;
  const double angle = s / radius;
  return origin + radius * (std::cos(angle) * start + std::sin(angle) * along);
}

Eigen::VectorXd PathPiece::Tangent(double s) const {
  if (radius == 0.0) return along;
  const double angle = s / radius;
  return std::cos(angle) * along - std::sin(angle) * start;
}

Eigen::VectorXd PathPiece::Curvature(double s) const {
  if (radius == 0.0) return Eigen::VectorXd::Zero(along.size());
  const double angle = s / radius;
  return -(std::cos(angle) * start + std::sin(angle) * along) / radius;
}

std::vector<PathPiece> RoundCorners(const std::vector<Eigen::VectorXd>& waypoints,
                                    double corner_rad) {
  const std::vector<Eigen::VectorXd> q = WithoutRepeats(waypoints);
  std::vector<PathPiece> pieces;
  Eigen::VectorXd from = q.front();
  bool stop = false;
  for (std::size_t i = 1; i < q.size(); ++i) {
    const bool last = i + 1 == q.size();
    const Corner corner = last ? Corner() : RoundCorner(q[i - 1], q[i], q[i + 1], corner_rad);
    const Eigen::VectorXd to =
        corner.cut > 0.0 ? Eigen::VectorXd(q[i] - corner.cut * (q[i] - q[i - 1]).normalized())
                         : q[i];
    if ((to - from).norm() > kMinLength_rad) {
      pieces.push_back(Straight(from, to));
      pieces.back().stop_before = stop;
    }
    stop = corner.stop;
    if (corner.arc.length > 0.0) pieces.push_back(corner.arc);
    from = corner.arc.length > 0.0 ? corner.arc.Position(corner.arc.length) : to;
  }
  return pieces;
}

}  // namespace rangegrasp::robot::internal
