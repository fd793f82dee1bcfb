#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "geometry/point_cloud.h"

/// Synthetic tabletop scans for tests: the surfaces of simple solids in W as seen from one sensor
/// position, on a grid of about the given step, with noise along the line of sight. Independent of
/// the scanner model.
namespace rangegrasp::synthetic {

/// An upright box, rotated by yaw about z.
struct Box {
  Eigen::Vector3d center_W;
  Eigen::Vector3d size;  ///< full lengths [m]
  double yaw_rad = 0.0;
};
/// A closed upright cylinder.
struct Cylinder {
  Eigen::Vector3d center_W;
  double radius_m = 0.0;
  double height_m = 0.0;
};
struct Sphere {
  Eigen::Vector3d center_W;
  double radius_m = 0.0;
};
using Solid = std::variant<Box, Cylinder, Sphere>;

struct ScanOptions {
  Eigen::Vector3d sensor_W{0.8, 0.0, 0.62};
  Eigen::Vector2d table_half{0.14, 0.14};  ///< [m]; the table is z = 0
  double step_m = 0.002;
  double sigma_m = 0.0003;  ///< noise along the line of sight
  int outliers = 0;         ///< single points in the air, more than 15 mm from any surface
  std::uint64_t seed = 1;
};

struct Scan {
  geometry::Points points_W;
  std::vector<int> label;  ///< -2 outlier, -1 table, else the solid's index
};

struct Surfel {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
};

/// True if the segment p + t d, t in (0, 1), passes through the solid.
inline bool Blocks(const Box& box, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const double c = std::cos(box.yaw_rad);
  const double s = std::sin(box.yaw_rad);
  const auto turn = [c, s](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(c * v.x() + s * v.y(), -s * v.x() + c * v.y(), v.z());
  };
  const Eigen::Vector3d o = turn(p - box.center_W);
  const Eigen::Vector3d r = turn(d);
  double enter = 0.0;
  double leave = 1.0;
  for (int i = 0; i < 3; ++i) {
    const double half = box.size[i] / 2.0 - 1e-9;
    if (std::abs(r[i]) < 1e-15) {
      if (std::abs(o[i]) > half) return false;
      continue;
    }
    const double a = (-half - o[i]) / r[i];
    const double b = (half - o[i]) / r[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return leave - enter > 1e-9;
}

inline bool Blocks(const Sphere& sphere, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const Eigen::Vector3d o = p - sphere.center_W;
  const double t = std::clamp(-o.dot(d) / d.squaredNorm(), 1e-6, 1.0);
  return (o + t * d).norm() < sphere.radius_m - 1e-9;
}

inline bool Blocks(const Cylinder& cylinder, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const Eigen::Vector3d o = p - cylinder.center_W;
  const double half = cylinder.height_m / 2.0 - 1e-9;
  double enter = 0.0;
  double leave = 1.0;
  if (std::abs(d.z()) > 1e-15) {
    const double a = (-half - o.z()) / d.z();
    const double b = (half - o.z()) / d.z();
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  const double aa = d.head<2>().squaredNorm();
  const double bb = o.head<2>().dot(d.head<2>());
  const double cc = o.head<2>().squaredNorm() - std::pow(cylinder.radius_m - 1e-9, 2);
  const double root = bb * bb - aa * cc;
  if (root <= 0.0) return false;
  enter = std::max(enter, (-bb - std::sqrt(root)) / aa);
  leave = std::min(leave, (-bb + std::sqrt(root)) / aa);
  return leave - enter > 1e-9;
}

/// Calls add(surfel) on a grid over a rectangle with centre c and half sides u and v.
template <class Add>
void SampleRectangle(const Eigen::Vector3d& c, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                     double step, const Add& add) {
  const int nu = std::max(1, static_cast<int>(std::lround(2.0 * u.norm() / step)));
  const int nv = std::max(1, static_cast<int>(std::lround(2.0 * v.norm() / step)));
  const Eigen::Vector3d normal = u.cross(v).normalized();
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      add(Surfel{c + ((2.0 * i + 1.0) / nu - 1.0) * u + ((2.0 * j + 1.0) / nv - 1.0) * v, normal});
    }
  }
}

template <class Add>
void Sample(const Box& box, double step, const Add& add) {
  const Eigen::Vector3d x =
      box.size.x() / 2.0 * Eigen::Vector3d(std::cos(box.yaw_rad), std::sin(box.yaw_rad), 0.0);
  const Eigen::Vector3d y =
      box.size.y() / 2.0 * Eigen::Vector3d(-std::sin(box.yaw_rad), std::cos(box.yaw_rad), 0.0);
  const Eigen::Vector3d z = box.size.z() / 2.0 * Eigen::Vector3d::UnitZ();
  SampleRectangle(box.center_W + z, x, y, step, add);
  SampleRectangle(box.center_W + x, y, z, step, add);
  SampleRectangle(box.center_W - x, z, y, step, add);
  SampleRectangle(box.center_W + y, z, x, step, add);
  SampleRectangle(box.center_W - y, x, z, step, add);
}

template <class Add>
void Sample(const Cylinder& cylinder, double step, const Add& add) {
  const Eigen::Vector3d top =
      cylinder.center_W + cylinder.height_m / 2.0 * Eigen::Vector3d::UnitZ();
  SampleRectangle(top, {cylinder.radius_m, 0.0, 0.0}, {0.0, cylinder.radius_m, 0.0}, step,
                  [&](const Surfel& s) {
                    if ((s.point - top).norm() < cylinder.radius_m) add(s);
                  });
  const int around =
      std::max(6, static_cast<int>(std::lround(2.0 * base::kPi * cylinder.radius_m / step)));
  const int rows = std::max(1, static_cast<int>(std::lround(cylinder.height_m / step)));
  for (int i = 0; i < around; ++i) {
    const double angle = 2.0 * base::kPi * i / around;
    const Eigen::Vector3d normal(std::cos(angle), std::sin(angle), 0.0);
    for (int j = 0; j < rows; ++j) {
      const double z = cylinder.height_m * ((j + 0.5) / rows - 0.5);
      add(Surfel{cylinder.center_W + cylinder.radius_m * normal + z * Eigen::Vector3d::UnitZ(),
                 normal});
    }
  }
}

template <class Add>
void Sample(const Sphere& sphere, double step, const Add& add) {
  // A Fibonacci lattice with one point per step^2 of the surface.
  const int n =
      std::max(4, static_cast<int>(4.0 * base::kPi * std::pow(sphere.radius_m / step, 2)));
  const double golden = base::kPi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n;
    const double r = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d normal(r * std::cos(golden * i), r * std::sin(golden * i), z);
    add(Surfel{sphere.center_W + sphere.radius_m * normal, normal});
  }
}

inline double DistanceOutside(const Solid& solid, const Eigen::Vector3d& p) {
  // A bounding sphere is enough for outliers.
  if (const auto* box = std::get_if<Box>(&solid)) {
    return (p - box->center_W).norm() - box->size.norm() / 2.0;
  }
  if (const auto* c = std::get_if<Cylinder>(&solid)) {
    return (p - c->center_W).norm() - std::hypot(c->radius_m, c->height_m / 2.0);
  }
  const auto& sphere = std::get<Sphere>(solid);
  return (p - sphere.center_W).norm() - sphere.radius_m;
}

/// The scan of the table and the solids, in a fixed order; depends only on the arguments.
inline Scan MakeScan(const std::vector<Solid>& solids, const ScanOptions& options = {}) {
  Scan scan;
  base::Rng rng(options.seed);
  const auto add = [&](const Surfel& surfel, int label) {
    const Eigen::Vector3d to_sensor = options.sensor_W - surfel.point;
    if (surfel.normal.dot(to_sensor) <= 0.05 * to_sensor.norm() || surfel.point.z() < -1e-12)
      return;
    const Eigen::Vector3d from = surfel.point + 1e-6 * surfel.normal;
    for (const Solid& solid : solids) {
      const bool hidden = std::visit(
          [&](const auto& s) { return Blocks(s, from, options.sensor_W - from); }, solid);
      if (hidden) return;
    }
    scan.points_W.push_back(surfel.point + options.sigma_m * rng.Normal() * to_sensor.normalized());
    scan.label.push_back(label);
  };
  SampleRectangle({0.0, 0.0, 0.0}, {options.table_half.x(), 0.0, 0.0},
                  {0.0, options.table_half.y(), 0.0}, options.step_m,
                  [&](const Surfel& s) { add(s, -1); });
  for (std::size_t i = 0; i < solids.size(); ++i) {
    std::visit(
        [&](const auto& solid) {
          Sample(solid, options.step_m, [&](const Surfel& s) { add(s, static_cast<int>(i)); });
        },
        solids[i]);
  }
  while (static_cast<int>(std::count(scan.label.begin(), scan.label.end(), -2)) <
         options.outliers) {
    const double x = rng.Uniform(-options.table_half.x(), options.table_half.x());
    const double y = rng.Uniform(-options.table_half.y(), options.table_half.y());
    const Eigen::Vector3d p(x, y, rng.Uniform(0.02, 0.25));
    bool free = true;
    for (const Solid& solid : solids) free = free && DistanceOutside(solid, p) > 0.015;
    for (std::size_t i = 0; i < scan.label.size(); ++i) {
      free = free && (scan.label[i] != -2 || (scan.points_W[i] - p).norm() > 0.03);
    }
    if (!free) continue;
    scan.points_W.push_back(p);
    scan.label.push_back(-2);
  }
  return scan;
}

/// A table with several kinds of objects. With the default step, a scan has about 20,000 points on
/// the table and as many on the objects.
inline std::vector<Solid> MixedObjects() {
  return {Box{{0.00, -0.08, 0.06}, {0.08, 0.06, 0.12}, 0.3},
          Cylinder{{0.03, 0.06, 0.06}, 0.035, 0.12}, Sphere{{-0.08, 0.00, 0.04}, 0.04},
          Box{{-0.07, 0.10, 0.02}, {0.06, 0.05, 0.04}, -0.4},
          Cylinder{{-0.08, -0.10, 0.03}, 0.03, 0.06}};
}

/// A scan of MixedObjects.
inline Scan MixedScan(std::uint64_t seed, int outliers = 0, double step_m = 0.004) {
  ScanOptions options;
  options.seed = seed;
  options.step_m = step_m;
  options.outliers = outliers;
  return MakeScan(MixedObjects(), options);
}

}  // namespace rangegrasp::synthetic
