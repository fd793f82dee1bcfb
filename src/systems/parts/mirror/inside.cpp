#include "parts/mirror/inside.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/units.h"
#include "parts/mirror/internal/space.h"
#include "parts/shape/turn_outwards.h"

namespace rangegrasp::parts {
namespace {

using InsideFace = std::array<std::uint32_t, 3>;

// The solid angle of a triangle seen from the origin (van Oosterom and Strackee 1983), positive if
// it is seen from behind.
double SolidAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double det = a.dot(b.cross(c));
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(det, rest);
}

bool IsInsideMesh(const Shape& mesh, const Eigen::Vector3d& p) {
  double angle = 0.0;
  for (const InsideFace& f : TurnedOutwards(mesh)) {
    angle += SolidAngle(mesh.points[f[0]] - p, mesh.points[f[1]] - p, mesh.points[f[2]] - p);
  }
  return angle >= 0.5 * 4.0 * base::kPi;
}

// Cells of equal width on the faces of a cube round p; a cell is covered if a point is seen in it.
bool IsInsideCloud(const geometry::Points& points, const Eigen::Vector3d& p) {
  constexpr double kPointsACell = 8.0;  // fewer: gaps between points leave cells uncovered
  constexpr double kMaxSide = 8.0;      // 384 cells; more would see through holes of the surface
  const auto side = static_cast<int>(std::clamp(
      std::sqrt(static_cast<double>(points.size()) / (6.0 * kPointsACell)), 1.0, kMaxSide));
  std::vector<bool> covered(static_cast<std::size_t>(6 * side * side), false);
  for (const Eigen::Vector3d& q : points) {
    const Eigen::Vector3d d = q - p;
    if (!(d.squaredNorm() > 0.0)) return true;
    covered[CubeCell(d, side)] = true;
  }
  const auto count = std::count(covered.begin(), covered.end(), true);
  return 2 * static_cast<std::size_t>(count) >= covered.size();
}

}  // namespace

bool IsInside(const Shape& shape, const Eigen::Vector3d& p) {
  return shape.IsMesh() ? IsInsideMesh(shape, p) : IsInsideCloud(shape.points, p);
}

}  // namespace rangegrasp::parts
