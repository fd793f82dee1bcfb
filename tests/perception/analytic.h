#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/units.h"
#include "perception/internal/objects.h"

/// Points and normals of exact surfaces on the table z = 0, for unit tests.
namespace rangegrasp::perception::samples {

constexpr double kStep_m = 0.002;  ///< between points

/// A cloud that is built surface by surface; each call returns the indices of its points.
class Analytic {
 public:
  geometry::PointCloud cloud;

  std::uint32_t Add(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    cloud.points.push_back(p);
    cloud.normals.push_back(normal.normalized());
    return static_cast<std::uint32_t>(cloud.size() - 1);
  }
  /// Turns the whole cloud about the origin.
  void Turn(const Eigen::AngleAxisd& turn) {
    for (Eigen::Vector3d& p : cloud.points) p = turn * p;
    for (Eigen::Vector3d& n : cloud.normals) n = turn * n;
  }

  /// The rectangle with center c and half sides u and v, corners included; it faces u x v.
  geometry::Indices AddRectangle(const Eigen::Vector3d& c, const Eigen::Vector3d& u,
                                 const Eigen::Vector3d& v) {
    const std::size_t first = cloud.size();
    const int nu = static_cast<int>(std::lround(2.0 * u.norm() / kStep_m));
    const int nv = static_cast<int>(std::lround(2.0 * v.norm() / kStep_m));
    for (int i = 0; i <= nu; ++i) {
      for (int k = 0; k <= nv; ++k) {
        Add(c + (2.0 * i / nu - 1.0) * u + (2.0 * k / nv - 1.0) * v, u.cross(v));
      }
    }
    return From(first);
  }

  /// Rings of an upright wall about (x, y) from the angle `from` to `to` (both included unless this
  /// is a full turn), facing outward or towards the axis.
  geometry::Indices AddWall(const Eigen::Vector2d& center, double radius_m, double low_m,
                            double high_m, double from_rad = 0.0, double to_rad = 2.0 * base::kPi,
                            bool inward = false) {
    const std::size_t first = cloud.size();
    const int rows = static_cast<int>(std::lround((high_m - low_m) / kStep_m));
    const int around = static_cast<int>(std::lround((to_rad - from_rad) * radius_m / kStep_m));
    for (int row = 0; row < rows; ++row) {
      for (int k = 0; k < around; ++k) {
        const double a = from_rad + (to_rad - from_rad) * k / around;
        const Eigen::Vector3d out(std::cos(a), std::sin(a), 0.0);
        Add(Eigen::Vector3d(center.x(), center.y(), low_m + (row + 0.5) * kStep_m) + radius_m * out,
            inward ? Eigen::Vector3d(-out) : out);
      }
    }
    return From(first);
  }

  /// A level disc or ring, made of rings of points; the outermost is on the edge.
  geometry::Indices AddDisc(const Eigen::Vector3d& center, double radius_m, double inner_m = 0.0) {
    const std::size_t first = cloud.size();
    for (double r = radius_m; r > inner_m + 1e-9; r -= kStep_m) {
      const int around = std::max(6, static_cast<int>(std::lround(2.0 * base::kPi * r / kStep_m)));
      for (int k = 0; k < around; ++k) {
        const double a = 2.0 * base::kPi * k / around;
        Add(center + r * Eigen::Vector3d(std::cos(a), std::sin(a), 0.0), Eigen::Vector3d::UnitZ());
      }
    }
    return From(first);
  }

 private:
  geometry::Indices From(std::size_t first) const {
    geometry::Indices added(cloud.size() - first);
    std::iota(added.begin(), added.end(), static_cast<std::uint32_t>(first));
    return added;
  }
};

inline geometry::Indices All(const geometry::PointCloud& cloud) {
  geometry::Indices all(cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

/// The level plane at a height.
inline geometry::Plane LevelAt(double z) { return {Eigen::Vector3d::UnitZ(), -z}; }

/// Input of the steps from segments to objects, for an exact cloud seen from one place.
struct Given {
  geometry::PointCloud cloud;
  geometry::Plane table{Eigen::Vector3d::UnitZ(), 0.0};
  internal::SensorViews views;
  FeatureOptions options;

  /// @param measured  points that define the sensor's free space; if empty, the cloud
  explicit Given(geometry::PointCloud of, const geometry::Points& measured = {},
                 const Eigen::Vector3d& sensor = {0.8, 0.0, 0.62})
      : cloud(std::move(of)) {
    views.places.emplace_back(measured.empty() ? cloud.points : measured, sensor);
    views.place_of.assign(cloud.size(), 0);
  }
  Given(geometry::PointCloud of, const FeatureOptions& with) : Given(std::move(of)) {
    options = with;
  }
  internal::ObjectContext Context() const { return {cloud, table, views, options}; }
  internal::Part Describe(geometry::Indices points, std::uint64_t seed = 1) const {
    base::Rng rng(seed);
    std::sort(points.begin(), points.end());
    return internal::DescribePart(Context(), std::move(points), rng);
  }
};

inline geometry::Indices Joined(geometry::Indices a, const geometry::Indices& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace rangegrasp::perception::samples
