#include "cylinders/task/cylinder_scans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "cylinders/cylinder.h"
#include "sensing/line_scanner.h"

namespace rangegrasp::cylinders {
namespace {

/// Repeats the scan until it has the requested number of points: the pitch is reduced by the
/// missing share and 1 % more. Excess points are removed evenly.
/// @param scan  scans with rays `pitch` apart at distance 1, shifted by `phase` pitches; each scan
/// draws the same noise
/// @throws base::InputError if `scans` scans do not suffice.
template <typename Scan>
geometry::Points ScanUntilEnough(const CylinderShape& shape, int points, int scans,
                                 const char* failure, base::Rng& rng, Scan scan) {
  const double phase_x = rng.Uniform();
  const double phase_y = rng.Uniform();
  const Eigen::Vector2d phase(phase_x, phase_y);
  const base::Rng noise(rng.Next());
  // The outline's area is approximately that of its bounding box.
  double pitch = std::sqrt(2.0 * shape.radius_m * shape.height_m / points) / kSensorDistance_m;
  for (int i = 0; i < scans; ++i) {
    geometry::Points found = scan(pitch, phase, noise);
    if (static_cast<int>(found.size()) >= points) {
      KeepEvenly(points, found);
      return found;
    }
    const double have = std::max(1.0, static_cast<double>(found.size()));
    pitch /= std::sqrt(1.01 * points / have);
  }
  throw base::InputError(failure);
}

// Rays through a square grid perpendicular to the line of sight, `pitch` apart at distance 1.
geometry::Points GridOfRays(const CylinderShape& shape, double pitch, const Eigen::Vector2d& phase,
                            double noise_m, base::Rng rng) {
  const Eigen::Vector3d eye = SensorPosition();
  const Eigen::Vector3d forward = -eye.normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitX().cross(forward).normalized();
  const Eigen::Vector3d down = forward.cross(right);
  const double reach = std::hypot(shape.radius_m, 0.5 * shape.height_m);
  const double half = reach / (eye.norm() - reach);
  const auto last = static_cast<int>(std::ceil(half / pitch));
  const Cylinder cylinder{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), shape.radius_m,
                          shape.height_m};
  geometry::Points points;
  for (int column = -last; column <= last; ++column) {
    for (int row = -last; row <= last; ++row) {
      const Eigen::Vector3d ray =
          (forward + (column + phase.x()) * pitch * right + (row + phase.y()) * pitch * down)
              .normalized();
      const auto entry = EntryOf(eye, ray, cylinder);
      if (!entry) continue;
      const double noise = noise_m * rng.Normal();
      points.push_back(eye + (entry->share + noise) * ray);
    }
  }
  return points;
}

}  // namespace

Eigen::Vector3d SensorPosition() {
  const double pitch_rad = base::Deg(37.0);
  return kSensorDistance_m * Eigen::Vector3d(std::sin(pitch_rad), 0.0, std::cos(pitch_rad));
}

geometry::Points SyntheticScan(const CylinderShape& shape, int points, double noise_m,
                               base::Rng& rng) {
  return ScanUntilEnough(
      shape, points, 12, "no grid of rays gives this number of points of the synthetic cylinder",
      rng, [&](double pitch, const Eigen::Vector2d& phase, const base::Rng& noise) {
        return GridOfRays(shape, pitch, phase, noise_m, noise);
      });
}

void KeepEvenly(int wanted, geometry::Points& points) {
  const auto have = static_cast<std::int64_t>(points.size());
  if (have <= wanted) return;
  std::size_t kept = 0;
  for (std::int64_t i = 0; i < have; ++i) {
    if ((i + 1) * wanted / have == i * wanted / have) continue;
    points[kept] = points[static_cast<std::size_t>(i)];
    ++kept;
  }
  points.resize(kept);
}

namespace {

/// Edge midpoints are r (1 - cos(pi / n)) inside the circle: half a micrometre at r = 25 mm.
constexpr std::uint32_t kEdges = 512;
/// The sweep is wider than the cylinder by this factor, so that it includes the outline.
constexpr double kMargin = 1.1;
/// Side length of the square table on which it stands.
constexpr double kTable_m = 0.6;
/// Points below this height above the table are removed: the clearance of the preselection.
constexpr double kClearance_m = 0.002;
/// The table reflects the laser like a matt, bright surface.
constexpr std::uint32_t kTableLabel = 0;
constexpr std::uint32_t kCylinderLabel = 1;

geometry::TriangleMesh MeshOf(const CylinderShape& shape) {
  geometry::TriangleMesh mesh;
  const double half_m = 0.5 * shape.height_m;
  for (std::uint32_t k = 0; k < kEdges; ++k) {
    const double angle = 2.0 * base::kPi * k / kEdges;
    const double y = shape.radius_m * std::cos(angle);
    const double z = shape.radius_m * std::sin(angle);
    mesh.vertices.emplace_back(-half_m, y, z);
    mesh.vertices.emplace_back(half_m, y, z);
  }
  const std::uint32_t low = 2 * kEdges;
  const std::uint32_t high = low + 1;
  mesh.vertices.emplace_back(-half_m, 0.0, 0.0);
  mesh.vertices.emplace_back(half_m, 0.0, 0.0);
  for (std::uint32_t k = 0; k < kEdges; ++k) {
    const std::uint32_t a = 2 * k;
    const std::uint32_t b = 2 * ((k + 1) % kEdges);
    mesh.triangles.push_back({a, b, a + 1});
    mesh.triangles.push_back({b, b + 1, a + 1});
    mesh.triangles.push_back({high, a + 1, b + 1});
    mesh.triangles.push_back({low, b, a});
  }
  return mesh;
}

geometry::TriangleMesh TableAt(double x) {
  const double half_m = 0.5 * kTable_m;
  return {{{x, -half_m, -half_m}, {x, half_m, -half_m}, {x, half_m, half_m}, {x, -half_m, half_m}},
          {{0, 1, 2}, {0, 2, 3}}};
}

// Scanner frame S: x right, y down, z forward (base/frames.h), turned by less than a sample.
base::Pose LookAtMiddle(const Eigen::Vector3d& eye, const Eigen::Vector2d& turn_rad) {
  const Eigen::Vector3d forward = -eye.normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitX()).normalized();
  Eigen::Matrix3d R_WS;
  R_WS << right, forward.cross(right), forward;
  const Eigen::AngleAxisd turn_x(turn_rad.x(), Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd turn_y(turn_rad.y(), Eigen::Vector3d::UnitY());
  return base::MakePose(R_WS * (turn_x * turn_y).toRotationMatrix(), eye);
}

geometry::Points AboveTable(const sensing::Scan& scan, double limit_x) {
  geometry::Points points;
  for (const Eigen::Vector3d& p : scan.view.image.points_C) {
    if (p.allFinite() && p.x() > limit_x) points.push_back(p);
  }
  return points;
}

}  // namespace

geometry::Points ScanCylinder(const CylinderShape& shape, int points,
                              sensing::LineScannerOptions scanner, base::Rng& rng) {
  constexpr const char* kFailure =
      "the scanner cannot measure this number of points of the cylinder";
  std::vector<sim::VisualMesh> meshes(2);
  meshes[0].mesh_W = TableAt(-0.5 * shape.height_m);
  meshes[0].label = kTableLabel;
  meshes[1].mesh_W = MeshOf(shape);
  meshes[1].label = kCylinderLabel;

  const double reach_m = std::hypot(shape.radius_m, 0.5 * shape.height_m);
  scanner.calibration_sigma_m = 0.0;
  scanner.calibration_sigma_rad = 0.0;
  scanner.fan_rad = 2.0 * kMargin * std::atan(reach_m / (kSensorDistance_m - reach_m));
  scanner.pan_range_rad = 2.0 * kMargin * std::atan(shape.radius_m / (kSensorDistance_m - reach_m));
  const auto scan = [&](double pitch, const Eigen::Vector2d& phase, base::Rng noise) {
    scanner.samples = static_cast<int>(std::ceil(scanner.fan_rad / pitch)) + 1;
    scanner.profiles = static_cast<int>(std::ceil(scanner.pan_range_rad / pitch)) + 1;
    const base::Pose X_WS = LookAtMiddle(SensorPosition(), phase * pitch);
    geometry::Points found = AboveTable(sensing::ScanScene(meshes, X_WS, scanner, noise),
                                        -0.5 * shape.height_m + kClearance_m);
    if (found.empty()) throw base::InputError(kFailure);
    return found;
  };
  return ScanUntilEnough(shape, points, 10, kFailure, rng, scan);
}

}  // namespace rangegrasp::cylinders
