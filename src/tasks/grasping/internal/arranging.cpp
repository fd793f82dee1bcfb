#include "tasks/grasping/internal/arranging.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace rangegrasp::tasks::grasping::internal {

Eigen::Quaterniond RandomRotation(core::Rng& rng) {
  const double u = rng.Uniform();
  const double v = rng.Uniform(0.0, 2.0 * core::kPi);
  const double w = rng.Uniform(0.0, 2.0 * core::kPi);
  return {std::sqrt(1.0 - u) * std::sin(v), std::sqrt(1.0 - u) * std::cos(v),
          std::sqrt(u) * std::sin(w), std::sqrt(u) * std::cos(w)};
}

Eigen::Vector3d PlaceInDisc(const core::Pose& X_WWorkspace, double radius_m, core::Rng& rng) {
  const double radius = radius_m * std::sqrt(rng.Uniform());
  const double angle = rng.Uniform(0.0, 2.0 * core::kPi);
  return X_WWorkspace * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
}

namespace {

bool Sees(const sensing::LineScannerOptions& scanner, const Eigen::Vector3d& p_S) {
  const double pan = std::atan2(p_S.x(), p_S.z());
  const double fan = std::atan2(p_S.y(), std::hypot(p_S.x(), p_S.z()));
  return std::abs(pan) <= 0.5 * scanner.pan_range_rad && std::abs(fan) <= 0.5 * scanner.fan_rad;
}

}  // namespace

std::vector<int> OutOfView(const sim::World& world, const core::Pose& X_WS,
                           const sensing::LineScannerOptions& scanner) {
  const core::Pose X_SW = X_WS.inverse();
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

}  // namespace rangegrasp::tasks::grasping::internal
