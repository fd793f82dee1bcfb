#include "cylinders/task/synthetic_cylinder.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace rangegrasp::cylinder_task {
namespace {

/// A grid that gives too few points is made finer by its lack and this much more.
constexpr double kSpare = 1.01;
constexpr int kGrids = 12;

double RangeToWall(const CylinderShape& shape, const Eigen::Vector3d& eye,
                   const Eigen::Vector3d& ray) {
  const Eigen::Vector2d e = eye.tail<2>();
  const Eigen::Vector2d u = ray.tail<2>();
  const double a = u.squaredNorm();
  const double b = e.dot(u);
  const double root = b * b - a * (e.squaredNorm() - shape.radius_m * shape.radius_m);
  if (a == 0.0 || root < 0.0) return -1.0;
  const double range = (-b - std::sqrt(root)) / a;
  return std::abs(eye.x() + range * ray.x()) <= 0.5 * shape.height_m ? range : -1.0;
}

double RangeToEnd(const CylinderShape& shape, const Eigen::Vector3d& eye,
                  const Eigen::Vector3d& ray, double x) {
  if (ray.x() == 0.0) return -1.0;
  const double range = (x - eye.x()) / ray.x();
  const Eigen::Vector2d p = eye.tail<2>() + range * ray.tail<2>();
  return p.norm() <= shape.radius_m ? range : -1.0;
}

// Rays through a square grid on the plane square to the line of sight, `pitch` apart at distance 1.
CylinderView GridOfRays(const CylinderShape& shape, const Eigen::Vector3d& eye, double pitch,
                        const Eigen::Vector2d& phase, double noise_m, base::Rng rng) {
  const Eigen::Vector3d forward = -eye.normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitX().cross(forward).normalized();
  const Eigen::Vector3d down = forward.cross(right);
  const double reach = std::hypot(shape.radius_m, 0.5 * shape.height_m);
  const double half = reach / (eye.norm() - reach);
  const auto last = static_cast<int>(std::ceil(half / pitch));
  CylinderView view;
  view.eye = eye;
  for (int column = -last; column <= last; ++column) {
    for (int row = -last; row <= last; ++row) {
      const Eigen::Vector3d ray =
          (forward + (column + phase.x()) * pitch * right + (row + phase.y()) * pitch * down)
              .normalized();
      const double range = RangeTo(shape, eye, ray);
      if (range < 0.0) continue;
      const double noise = noise_m * rng.Normal();
      view.points.push_back(eye + (range + noise) * ray);
      view.lines.push_back(static_cast<std::uint32_t>(column + last));
    }
  }
  return view;
}

}  // namespace

Eigen::Vector3d Viewpoint::Eye() const {
  return distance_m * Eigen::Vector3d(std::sin(pitch_rad), 0.0, std::cos(pitch_rad));
}

double RangeTo(const CylinderShape& shape, const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const double range :
       {RangeToWall(shape, eye, ray), RangeToEnd(shape, eye, ray, 0.5 * shape.height_m),
        RangeToEnd(shape, eye, ray, -0.5 * shape.height_m)}) {
    if (range >= 0.0) nearest = std::min(nearest, range);
  }
  return std::isfinite(nearest) ? nearest : -1.0;
}

CylinderView SyntheticScan(const CylinderShape& shape, const Viewpoint& view, int points,
                           double noise_m, base::Rng& rng) {
  if (points < 3) throw base::InputError("a synthetic cylinder needs three points or more");
  const double phase_x = rng.Uniform();
  const double phase_y = rng.Uniform();
  const base::Rng noise(rng.Next());
  const Eigen::Vector3d eye = view.Eye();
  // The outline's area is about its box's.
  double pitch = std::sqrt(2.0 * shape.radius_m * shape.height_m / points) / view.distance_m;
  for (int i = 0; i < kGrids; ++i) {
    CylinderView found = GridOfRays(shape, eye, pitch, {phase_x, phase_y}, noise_m, noise);
    if (static_cast<int>(found.points.size()) >= points) {
      KeepEvenly(points, found);
      return found;
    }
    const double have = std::max(1.0, static_cast<double>(found.points.size()));
    pitch /= std::sqrt(kSpare * points / have);
  }
  throw base::InputError("no grid of rays gives so many points of the synthetic cylinder");
}

void KeepEvenly(int wanted, CylinderView& view) {
  const auto have = static_cast<std::int64_t>(view.points.size());
  if (have <= wanted) return;
  std::size_t kept = 0;
  for (std::int64_t i = 0; i < have; ++i) {
    if ((i + 1) * wanted / have == i * wanted / have) continue;
    view.points[kept] = view.points[static_cast<std::size_t>(i)];
    view.lines[kept] = view.lines[static_cast<std::size_t>(i)];
    ++kept;
  }
  view.points.resize(kept);
  view.lines.resize(kept);
}

}  // namespace rangegrasp::cylinder_task
