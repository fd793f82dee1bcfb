#pragma once

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "robot/robot.h"
#include "sensing/line_scanner_options.h"
#include "sim/world.h"

namespace rangegrasp::trial::internal {

/// Uniform over all rotations (Shoemake 1992).
Eigen::Quaterniond RandomRotation(base::Rng& rng);

/// Uniform over a disc round the middle of the workspace, in W.
Eigen::Vector3d PlaceInDisc(const base::Pose& X_WWorkspace, double radius_m, base::Rng& rng);

/// In random order; std::shuffle differs between libraries.
template <typename T>
void Shuffle(std::vector<T>& items, base::Rng& rng) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[rng.Index(i)]);
}

/// The objects of whose visual surfaces not all vertices lie in the scanner's field of view,
/// ascending.
std::vector<int> OutOfView(const sim::World& world, const base::Pose& X_WS,
                           const sensing::LineScannerOptions& scanner);

/// Of the surface of an object that the scanner would see if nothing else were there, as it appears
/// from the laser, the share that it sees.
double SeenShare(const sim::World& world, int object, const base::Pose& X_WS,
                 const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::trial::internal
