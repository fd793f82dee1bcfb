#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "robot/robot.h"
#include "sensing/range_sensor.h"
#include "sim/resting_poses.h"
#include "sim/world.h"
#include "trial/arranger.h"

namespace rangegrasp::trial::internal {

/// Uniform over all rotations (Shoemake 1992).
Eigen::Quaterniond RandomRotation(base::Rng& rng);

/// Uniform over a disc around the center of the workspace, in W.
Eigen::Vector3d PlaceInDisc(const base::Pose& X_WWorkspace, double radius_m, base::Rng& rng);

/// Shuffles the items. Not std::shuffle, since its results differ between libraries.
template <typename T>
void Shuffle(std::vector<T>& items, base::Rng& rng) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[rng.Index(i)]);
}

/// The objects with a vertex outside the scanner's field of view, ascending.
std::vector<int> OutOfView(const sim::World& world, const base::Pose& X_WS,
                           const sensing::LineScannerOptions& scanner);

/// Draws resting poses of single objects on the table, with the frequencies of simulated drops.
class Resting {
 public:
  /// @param objects  the objects that may be put down
  /// @throws base::InputError if one has no resting pose.
  Resting(const Options& options, const robot::Robot& robot,
          const std::vector<std::string>& objects);

  /// Drops an object of a world onto the table with a random rotation.
  /// @return its resting pose; nullopt if that pose is excluded.
  std::optional<sim::AtRest> Drop(sim::World& world, int object, base::Rng& rng) const;

  /// Drop or, with as_drawn, puts the object down upright: few drops end so, and hardly ever all of
  /// several.
  std::optional<sim::AtRest> ComeToRest(sim::World& world, int object, base::Rng& rng) const;

  /// Draws a resting pose in which the model's z axis is vertical, with the quasi-static
  /// probabilities (sim::RestingPose).
  /// @return nullopt if the object has none.
  std::optional<sim::AtRest> Standing(const std::string& object, base::Rng& rng) const;
  static bool Stands(const sim::RestingFace& face);

  /// Puts the object down on a face, with a random yaw at a random place in a disc around the
  /// center of the workspace.
  /// @return its pose.
  base::Pose PutDown(const sim::RestingFace& face, double radius_m, sim::World& world, int object,
                     base::Rng& rng) const;

  /// Whether the object still has the orientation in which it was put down, up to a small rotation.
  /// It may shift.
  static bool IsAsPutDown(const base::Pose& X_WO, const sim::World& world, int object);

 private:
  const robot::Robot& robot_;
  bool as_drawn_;
  std::map<std::string, std::vector<sim::RestingPose>> poses_;
};

}  // namespace rangegrasp::trial::internal
