#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "recognition/views/look_options.h"
#include "recognition/views/merge.h"
#include "recognition/views/next_view.h"
#include "sensing/line_scanner_options.h"
#include "sim/move_arm.h"
#include "sim/world.h"
#include "trial/attempt.h"

namespace rangegrasp::views {

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
  /// @throws base::InputError if the scene has no site "wrist_scanner", or if the sensor's file or
  /// look.hand_eye is none, or is of another head
  Looker(const trial::Options& options, const robot::Robot& robot, std::uint64_t seed);

  /// A box about the highest of what was seen above the table within the workspace, down to the
  /// table; nullopt if there is nothing.
  std::optional<Eigen::AlignedBox3d> RegionOfHighest(const geometry::Observation& so_far) const;
  /// The same about any place: LookOptions::region_radius_m round it, from the table to
  /// the highest seen there.
  Eigen::AlignedBox3d RegionAbout(const Eigen::Vector3d& place_W,
                                  const geometry::Observation& so_far) const;

  /// The next best view of a region (views/next_view.h). Knows no truth.
  std::optional<Look> Next(const geometry::Observation& so_far, const Eigen::AlignedBox3d& region_W,
                           const Eigen::VectorXd& q_now);
  /// Moves the arm there in the simulation, by its servos. @return whether it came there; if not,
  /// it met something that was not foreseen and stands where it was stopped.
  sim::MoveLog Go(sim::World& world, const Look& look) const;
  /// A scan from where the arm stands. The view is where the robot believes it to be: the arm's
  /// own error, one draw a scan, and that of the mount, one draw a looker.
  trial::Sensed SenseHere(const sim::World& world);
  /// Joins a look to the ones before; its pose is corrected by what both see, where the options
  /// say so. @return the correction
  Refinement Add(trial::Sensed look, trial::Sensed& to) const;

  /// All four in turn: what is seen of a region from the next best place is added.
  /// @param q  where the arm stands; receives where it stands then
  /// @return nullopt if there is nothing to be seen that is worth the way
  std::optional<trial::LookRecord> LookAt(const Eigen::AlignedBox3d& region_W, sim::World& world,
                                          Eigen::VectorXd& q, trial::Sensed& to);

  const sensing::LineScannerOptions& scanner() const { return scanner_; }

 private:
  base::Rng Stream(const char* name) const;
  void BelieveCalibration(const base::Pose& X_HS);

  const trial::Options& options_;
  const LookOptions look_;
  const robot::Robot& robot_;
  std::uint64_t seed_;
  sensing::LineScannerOptions scanner_;
  base::Pose X_SBelieved_;  ///< the head as the robot believes it to be, in its true frame
  double mount_error_m_;    ///< of that, root mean square
  double mount_error_rad_;
  std::uint64_t looks_ = 0;
};

/// Looks from as many places as the options say, if that many are worth it, at the highest thing.
/// @param first  of the cell's own sensor
trial::LookedAround LookAround(const trial::Cell& cell, trial::Sensed first, sim::World& world,
                               std::uint64_t seed);

}  // namespace rangegrasp::views
