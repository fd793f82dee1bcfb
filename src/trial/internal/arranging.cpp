#include "trial/internal/arranging.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/units.h"
#include "sensing/surface_state.h"

namespace rangegrasp::trial::internal {

Eigen::Quaterniond RandomRotation(base::Rng& rng) {
  const double u = rng.Uniform();
  const double v = rng.Uniform(0.0, 2.0 * base::kPi);
  const double w = rng.Uniform(0.0, 2.0 * base::kPi);
  return {std::sqrt(1.0 - u) * std::sin(v), std::sqrt(1.0 - u) * std::cos(v),
          std::sqrt(u) * std::sin(w), std::sqrt(u) * std::cos(w)};
}

Eigen::Vector3d PlaceInDisc(const base::Pose& X_WWorkspace, double radius_m, base::Rng& rng) {
  const double radius = radius_m * std::sqrt(rng.Uniform());
  const double angle = rng.Uniform(0.0, 2.0 * base::kPi);
  return X_WWorkspace * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
}

namespace {

// Triangles are looked at in pieces of this size: what stands before an object hides more.
constexpr double kPiece_m = 0.015;

/// Points of a surface that faces the laser, with how large it appears there.
struct Facing {
  geometry::Points points_W;
  std::vector<double> sizes;
};

/// The middles of the upright ones of a triangle's n^2 equal pieces stand for three of them each.
void AddPieces(const std::array<Eigen::Vector3d, 3>& corners_W, const Eigen::Vector3d& laser_W,
               Facing& facing) {
  const auto& [a, b, c] = corners_W;
  const Eigen::Vector3d area_W = 0.5 * (b - a).cross(c - a);
  const double longest_m = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
  const int n = std::max(1, static_cast<int>(std::ceil(longest_m / kPiece_m)));
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      const Eigen::Vector3d p_W = a + ((i + 1.0 / 3.0) * (b - a) + (j + 1.0 / 3.0) * (c - a)) / n;
      const Eigen::Vector3d to_laser_W = laser_W - p_W;
      const double size = area_W.dot(to_laser_W) / std::pow(to_laser_W.norm(), 3);
      if (size <= 0.0) continue;
      facing.points_W.push_back(p_W);
      facing.sizes.push_back(size / (0.5 * n * (n + 1)));
    }
  }
}

double SeenSize(const Facing& facing, std::span<const sim::VisualMesh> meshes,
                const base::Pose& X_WS, const sensing::LineScannerOptions& scanner) {
  const auto states = sensing::ClassifySurface(facing.points_W, meshes, X_WS, scanner);
  double size = 0.0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (states[i] == sensing::SurfaceState::kSeen) size += facing.sizes[i];
  }
  return size;
}

bool Sees(const sensing::LineScannerOptions& scanner, const Eigen::Vector3d& p_S) {
  const double pan = std::atan2(p_S.x(), p_S.z());
  const double fan = std::atan2(p_S.y(), std::hypot(p_S.x(), p_S.z()));
  return std::abs(pan) <= 0.5 * scanner.pan_range_rad && std::abs(fan) <= 0.5 * scanner.fan_rad;
}

}  // namespace

std::vector<int> OutOfView(const sim::World& world, const base::Pose& X_WS,
                           const sensing::LineScannerOptions& scanner) {
  const base::Pose X_SW = X_WS.inverse();
  std::vector<int> unseen;
  for (const auto& visual : world.VisualMeshes()) {
    if (visual.label == 0 || visual.label == sim::kContainerLabel) continue;
    const auto& vertices_W = visual.mesh_W.vertices;
    if (!std::all_of(vertices_W.begin(), vertices_W.end(),
                     [&](const Eigen::Vector3d& p_W) { return Sees(scanner, X_SW * p_W); })) {
      unseen.push_back(static_cast<int>(visual.label) - 1);
    }
  }
  return unseen;
}

double SeenShare(const sim::World& world, int object, const base::Pose& X_WS,
                 const sensing::LineScannerOptions& scanner) {
  const auto all = world.VisualMeshes();
  std::vector<sim::VisualMesh> own;
  Facing facing;
  for (const auto& visual : all) {
    if (visual.label != static_cast<std::uint32_t>(object) + 1) continue;
    own.push_back(visual);
    const auto& vertices_W = visual.mesh_W.vertices;
    for (const auto& t : visual.mesh_W.triangles) {
      AddPieces(
          {vertices_W[static_cast<std::size_t>(t[0])], vertices_W[static_cast<std::size_t>(t[1])],
           vertices_W[static_cast<std::size_t>(t[2])]},
          X_WS.translation(), facing);
    }
  }
  const double alone = SeenSize(facing, own, X_WS, scanner);
  return alone > 0.0 ? SeenSize(facing, all, X_WS, scanner) / alone : 0.0;
}

}  // namespace rangegrasp::trial::internal
