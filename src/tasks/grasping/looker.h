#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/rng.h"
#include "sensing/line_scanner_options.h"
#include "sim/move_arm.h"
#include "sim/world.h"
#include "tasks/grasping/options.h"
#include "tasks/grasping/sensor.h"
#include "views/merge.h"
#include "views/next_view.h"

namespace rangegrasp::tasks::grasping {

/// What one look from the wrist was.
struct LookRecord {
  double gain_m3 = 0.0;
  double unseen_m3 = 0.0;
  double way_s = 0.0;
  bool arrived = false;
  views::Refinement refinement;
};

/// Stage 2 from several places: the cell's own sensor first, then the one on the wrist from
/// wherever the arm can hold it. Who uses it looks, decides, looks again:
///
///   Looker looker(cell.options, cell.robot, seed);
///   Sensed sensed = cell.sensor->Sense(world, rng);               // with the arm out of its way
///   while (!sure) {
///     auto look = looker.Next(sensed.observation, looker.RegionAbout(...), world.ArmPositions());
///     if (!look || !looker.Go(world, *look)) break;               // nothing new to see, or
///     stopped looker.Add(looker.SenseHere(world), sensed);
///   }
///
/// Every draw is of a stream of the seed, numbered by its look. The arguments must outlive it.
class Looker {
 public:
  /// @throws core::InputError if the scene has no site "wrist_scanner", or if the sensor's file or
  /// look.hand_eye is none, or is of another head
  Looker(const Options& options, const robot::Robot& robot, std::uint64_t seed);

  /// A box about the highest of what was seen above the table within the workspace, down to the
  /// table; nullopt if there is nothing.
  std::optional<Eigen::AlignedBox3d> RegionOfHighest(const geometry::Observation& so_far) const;
  /// The same about any place: LookOptions::region_radius_m round it, from the table to
  /// the highest seen there.
  Eigen::AlignedBox3d RegionAbout(const Eigen::Vector3d& place_W,
                                  const geometry::Observation& so_far) const;

  /// The next best view of a region (views/next_view.h). Knows no truth.
  std::optional<views::Look> Next(const geometry::Observation& so_far,
                                  const Eigen::AlignedBox3d& region_W,
                                  const Eigen::VectorXd& q_now);
  /// Moves the arm there in the simulation, by its servos. @return whether it came there; if not,
  /// it met something that was not foreseen and stands where it was stopped.
  sim::MoveLog Go(sim::World& world, const views::Look& look) const;
  /// A scan from where the arm stands. The view is where the robot believes it to be: the arm's
  /// own error, one draw a scan, and that of the mount, one draw a looker.
  Sensed SenseHere(const sim::World& world);
  /// Joins a look to the ones before; its pose is corrected by what both see, where the options
  /// say so. @return the correction
  views::Refinement Add(Sensed look, Sensed& to) const;

  /// All four in turn: what is seen of a region from the next best place is added.
  /// @param q  where the arm stands; receives where it stands then
  /// @return nullopt if there is nothing to be seen that is worth the way
  std::optional<LookRecord> LookAt(const Eigen::AlignedBox3d& region_W, sim::World& world,
                                   Eigen::VectorXd& q, Sensed& to);

  const sensing::LineScannerOptions& scanner() const { return scanner_; }

 private:
  core::Rng Stream(const char* name) const;
  void BelieveCalibration(const core::Pose& X_HS);

  const Options& options_;
  const robot::Robot& robot_;
  std::uint64_t seed_;
  sensing::LineScannerOptions scanner_;
  core::Pose X_SBelieved_;  ///< the head as the robot believes it to be, in its true frame
  double mount_error_m_;    ///< of that, root mean square
  double mount_error_rad_;
  std::uint64_t looks_ = 0;
};

/// All looks of a trial: what was sensed, and where the arm stands after it.
struct LookedAround {
  Sensed sensed;
  Eigen::VectorXd q;
  std::vector<LookRecord> looks;  ///< from the wrist
};

/// Looks from as many places as the options say, if that many are worth it, at the highest thing.
/// @param first  of the cell's own sensor
LookedAround LookAround(const Options& options, const robot::Robot& robot, Sensed first,
                        sim::World& world, std::uint64_t seed);

}  // namespace rangegrasp::tasks::grasping
