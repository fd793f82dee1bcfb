#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "geometry/mesh.h"

/// Scans of triangle meshes on a table for tests, made with a depth buffer: one ray per pixel from
/// one place, noise along the ray, no points at grazing incidence, mixed points at depth edges.
/// Independent of the scanner model.
namespace rangegrasp::synthetic {

struct RasterOptions {
  Eigen::Vector3d sensor_W{0.8, 0.0, 0.62};
  double table_half_m = 0.19;
  double pitch_rad = 0.0018;  ///< angle between rays: about 1.8 mm at 1 m
  double sigma_m = 0.0004;
  double grazing_rad = 1.31;  ///< no points beyond this incidence (75 deg)
  double mixed_share = 0.1;   ///< share of mixed pixels at depth edges
  std::uint64_t seed = 1;
};

struct RasterScan {
  geometry::Points points_W;
  std::vector<int> label;  ///< -1 table, else the mesh's index
  std::vector<Eigen::Vector3d> normals_W;
};

namespace internal {

struct Pixel {
  double range = std::numeric_limits<double>::infinity();
  int label = -2;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

class DepthBuffer {
 public:
  explicit DepthBuffer(const RasterOptions& options) : options_(options) {
    axes_.col(2) = (Eigen::Vector3d(0, 0, 0.04) - options.sensor_W).normalized();
    axes_.col(0) = axes_.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
    axes_.col(1) = axes_.col(2).cross(axes_.col(0));
    half_ = static_cast<int>(0.40 / options.pitch_rad);
    side_ = 2 * half_ + 1;
    pixels_.resize(static_cast<std::size_t>(side_ * side_));
  }

  Eigen::Vector3d Ray(int x, int y) const {
    return (axes_ * Eigen::Vector3d((x - half_) * options_.pitch_rad,
                                    (y - half_) * options_.pitch_rad, 1.0))
        .normalized();
  }

  void Draw(const std::array<Eigen::Vector3d, 3>& t, int label) {
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    Eigen::Matrix<double, 2, 3> q;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d c =
          axes_.transpose() * (t[static_cast<std::size_t>(i)] - options_.sensor_W);
      q.col(i) = c.head<2>() / c.z() / options_.pitch_rad;
    }
    const Eigen::Vector2d low = q.rowwise().minCoeff();
    const Eigen::Vector2d high = q.rowwise().maxCoeff();
    Eigen::Matrix3d corners;
    for (int i = 0; i < 3; ++i) corners.col(i) = t[static_cast<std::size_t>(i)] - options_.sensor_W;
    if (std::abs(corners.determinant()) < 1e-18) return;
    const Eigen::Matrix3d inverse = corners.inverse();
    for (int y = Clamp(std::ceil(low.y())); y <= Clamp(std::floor(high.y())); ++y) {
      for (int x = Clamp(std::ceil(low.x())); x <= Clamp(std::floor(high.x())); ++x) {
        const Eigen::Vector3d ray = Ray(x, y);
        const Eigen::Vector3d weights = inverse * ray;
        if (weights.minCoeff() < -1e-12) continue;
        const double range = 1.0 / weights.sum();
        Pixel& pixel = At(x, y);
        if (range < pixel.range) pixel = {range, label, normal.dot(ray) > 0 ? -normal : normal};
      }
    }
  }

  Pixel& At(int x, int y) { return pixels_[static_cast<std::size_t>(y * side_ + x)]; }
  int side() const { return side_; }

 private:
  int Clamp(double v) const { return std::clamp(static_cast<int>(v) + half_, 0, side_ - 1); }
  RasterOptions options_;
  Eigen::Matrix3d axes_;
  int half_ = 0;
  int side_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace internal

/// The scan of the table (z = 0) and the meshes; depends only on the arguments.
inline RasterScan MakeRasterScan(const std::vector<geometry::TriangleMesh>& meshes_W,
                                 const RasterOptions& options = {}) {
  internal::DepthBuffer buffer(options);
  const double h = options.table_half_m;
  const std::array<Eigen::Vector3d, 4> t{{{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}}};
  buffer.Draw({t[0], t[1], t[2]}, -1);
  buffer.Draw({t[0], t[2], t[3]}, -1);
  for (std::size_t m = 0; m < meshes_W.size(); ++m) {
    for (const auto& f : meshes_W[m].triangles) {
      const auto& v = meshes_W[m].vertices;
      buffer.Draw({v[f[0]], v[f[1]], v[f[2]]}, static_cast<int>(m));
    }
  }
  RasterScan scan;
  base::Rng rng(options.seed);
  for (int y = 0; y < buffer.side(); ++y) {
    for (int x = 0; x + 1 < buffer.side(); ++x) {
      const auto& pixel = buffer.At(x, y);
      const auto& next = buffer.At(x + 1, y);
      if (pixel.label == -2) continue;
      const Eigen::Vector3d ray = buffer.Ray(x, y);
      if (-pixel.normal.dot(ray) < std::cos(options.grazing_rad)) continue;
      double range = pixel.range + options.sigma_m * rng.Normal();
      const double jump = next.range - pixel.range;
      if (std::isfinite(next.range) && std::abs(jump) > 0.01 &&
          rng.Uniform() < options.mixed_share) {
        range += rng.Uniform() * jump;
      }
      scan.points_W.push_back(options.sensor_W + range * ray);
      scan.label.push_back(pixel.label);
      scan.normals_W.push_back(pixel.normal);
    }
  }
  return scan;
}

/// The polygon (counter-clockwise, x-y) extruded along z from -length/2 to length/2.
inline geometry::TriangleMesh Extrude(const std::vector<Eigen::Vector2d>& polygon,
                                      double length_m) {
  geometry::TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {-0.5 * length_m, 0.5 * length_m}) {
    for (const auto& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, j + n});
    mesh.triangles.push_back({i, j + n, i + n});
    if (i >= 1 && i + 1 < n) {
      mesh.triangles.push_back({0, i + 1, i});
      mesh.triangles.push_back({n, n + i, n + i + 1});
    }
  }
  return mesh;
}

/// A regular polygon with n corners; the first is at the angle `start`.
inline std::vector<Eigen::Vector2d> Regular(int n, double radius_m, double start_rad = 0.0) {
  std::vector<Eigen::Vector2d> polygon;
  for (int i = 0; i < n; ++i) {
    const double a = start_rad + 2.0 * base::kPi * i / n;
    polygon.emplace_back(radius_m * std::cos(a), radius_m * std::sin(a));
  }
  return polygon;
}

inline geometry::TriangleMesh CylinderMesh(double radius_m, double height_m) {
  return Extrude(Regular(96, radius_m), height_m);
}

inline geometry::TriangleMesh BoxMesh(double x, double y, double z) {
  return Extrude({{-x / 2, -y / 2}, {x / 2, -y / 2}, {x / 2, y / 2}, {-x / 2, y / 2}}, z);
}

/// The surface of revolution of a profile (radius, z) about z.
inline geometry::TriangleMesh Turned(const std::vector<Eigen::Vector2d>& profile, int sides = 96) {
  geometry::TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(sides);
  for (const auto& p : profile) {
    for (const auto& q : Regular(sides, 1.0)) {
      mesh.vertices.emplace_back(p.x() * q.x(), p.x() * q.y(), p.y());
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t a = ring * n + k;
      const std::uint32_t b = ring * n + (k + 1) % n;
      mesh.triangles.push_back({a, b, b + n});
      mesh.triangles.push_back({a, b + n, a + n});
    }
  }
  return mesh;
}

/// An open mug with its handle (a box of 30 x 12 x 60 mm) towards +x and the center of its base at
/// the origin.
inline geometry::TriangleMesh MugMesh(double radius_m = 0.041, double height_m = 0.095,
                                      double wall_m = 0.004) {
  geometry::TriangleMesh mesh = Turned({{0.0, 0.0},
                                        {radius_m, 0.0},
                                        {radius_m, height_m},
                                        {radius_m - wall_m, height_m},
                                        {radius_m - wall_m, wall_m},
                                        {0.0, wall_m}});
  geometry::Append(geometry::Transformed(BoxMesh(0.030, 0.012, 0.060),
                                         base::MakePose(Eigen::Matrix3d::Identity(),
                                                        {radius_m + 0.014, 0.0, 0.5 * height_m})),
                   mesh);
  return mesh;
}

/// A pose whose z axis is parallel to the table at `yaw` from the x axis.
inline base::Pose Lying(double yaw_rad, const Eigen::Vector3d& position) {
  Eigen::Matrix3d R;
  R.col(2) = Eigen::Vector3d(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
  R.col(1) = Eigen::Vector3d::UnitZ();
  R.col(0) = R.col(1).cross(R.col(2));
  return base::MakePose(R, position);
}

inline base::Pose Standing(double yaw_rad, const Eigen::Vector3d& position) {
  return base::MakePose(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                        position);
}

}  // namespace rangegrasp::synthetic
