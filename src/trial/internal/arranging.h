#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "robot/robot.h"
#include "sensing/line_scanner_options.h"
#include "sim/resting_poses.h"
#include "sim/world.h"
#include "trial/arranger.h"

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

/// The objects that do not lie in the scanner's field of view with all vertices, ascending.
std::vector<int> OutOfView(const sim::World& world, const base::Pose& X_WS,
                           const sensing::LineScannerOptions& scanner);

/// Of an object's surface that the scanner would see if nothing else were there, as it appears from
/// the laser, the share that it sees.
double SeenShare(const sim::World& world, int object, const base::Pose& X_WS,
                 const sensing::LineScannerOptions& scanner);

/// How single objects come to rest on the table, as often as a drop ends so.
class Resting {
 public:
  /// @param objects  those that may be put down
  /// @throws base::InputError if one has no resting pose.
  Resting(const Options& options, const robot::Robot& robot,
          const std::vector<std::string>& objects);

  /// Drops an object of a world onto the table, turned at random.
  /// @return how it came to rest; nullopt for a pose that is left out.
  std::optional<sim::AtRest> Drop(sim::World& world, int object, base::Rng& rng) const;

  /// A pose in which the model's axis z is vertical, as often as a body that is set down without a
  /// bounce ends in it.
  /// @return nullopt if it has none.
  std::optional<sim::AtRest> Standing(const std::string& object, base::Rng& rng) const;
  static bool Stands(const sim::RestingFace& face);

  /// Puts it down on a face, at a random place in a disc round the middle of the workspace and yaw.
  /// @return its pose.
  base::Pose PutDown(const sim::RestingFace& face, double radius_m, sim::World& world, int object,
                     base::Rng& rng) const;

  /// Whether it lies as it was put down: an object may creep into place, but not turn further.
  static bool IsAsPutDown(const base::Pose& X_WO, const sim::World& world, int object);

 private:
  const robot::Robot& robot_;
  std::map<std::string, std::vector<sim::RestingPose>> poses_;
};

}  // namespace rangegrasp::trial::internal
