#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/rng.h"
#include "robot/robot.h"
#include "sensing/line_scanner_options.h"
#include "sim/world.h"
#include "tasks/grasping/options.h"

namespace rangegrasp::tasks::grasping {

/// A settled world with the target in it.
struct Arrangement {
  sim::World world;
  int target = 0;
  std::string pose_class;  ///< of the target's resting pose
  int redraws = 0;         ///< arrangements that were drawn again
};

/// Stage 1: lays objects out.
class Arranger {
 public:
  virtual ~Arranger() = default;
  /// @param target  the row's object
  /// @return nullopt if no arrangement came to rest in the sensor's view.
  virtual std::optional<Arrangement> Arrange(const std::string& target, core::Rng& rng) const = 0;
};

/// Alone on the table: the resting pose is the one that a simulated drop from 50 mm, turned at
/// random, ends in; place in the workspace disc and yaw are drawn, and all of it again until the
/// object rests in the scanner's view.
/// The arguments must outlive it. @throws core::InputError if an object has no resting pose.
std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::tasks::grasping
