#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "recognition/views/merge.h"
#include "recognition/views/next_view.h"
#include "sensing/range_sensor.h"
#include "sim/world.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::views {

/// Views from the wrist, after that of the fixed sensor.
struct WristViewOptions {
  int views = 1;
  std::filesystem::path sensor;
  double mount_sigma_m = 0.001;  ///< mounted by hand, after a drawing
  double mount_sigma_rad = base::Deg(0.3);
  std::filesystem::path hand_eye;
  bool refine = true;              ///< views/merge.h
  double region_radius_m = 0.15;   ///< half of the longest object
  double until_probability = 1.0;  ///< that the best grasp promises; 1: all views are taken
  NextViewOptions next;
};

/// Their name in trial::Options.
inline constexpr const char* kWristViews = "look";

/// Reads the keys `views` and `look`.
/// @throws base::InputError
void ReadWristViewOptions(base::YamlMap& map, WristViewOptions& options);

/// The scanner on the wrist, which adds views to those of the cell's own sensor:
///
///   WristScanner wrist(cell.options, cell.robot, seed);
///   Sensed sensed = cell.sensor->Sense(world, rng);  // with the arm out of its way
///   while (!sure) {
///     const auto look = wrist.AddBestView(wrist.RegionAbout(...), world, q, sensed);
///     if (!look || !look->arrived) break;  // nothing new to see, or stopped
///   }
///
/// Every draw is of a stream of the seed, numbered by its look. The arguments must outlive it.
class WristScanner {
 public:
  /// @throws base::InputError if the scene has no site "wrist_scanner", or if the sensor's file or
  /// look.hand_eye cannot be read, or is of another head
  WristScanner(const trial::Options& options, const robot::Robot& robot, std::uint64_t seed);

  /// A box about the highest of what was seen above the table within the workspace, down to the
  /// table; nullopt if there is nothing.
  std::optional<Eigen::AlignedBox3d> RegionOfHighest(const geometry::Observation& so_far) const;
  /// The same about any place: WristViewOptions::region_radius_m round it, from the table to
  /// the highest seen there.
  Eigen::AlignedBox3d RegionAbout(const Eigen::Vector3d& place_W,
                                  const geometry::Observation& so_far) const;

  /// From where the arm stands. The view is where the robot believes it to be: off by the arm's own
  /// error, one draw a scan, and by that of the mount, one draw a scanner.
  trial::Sensed Scan(const sim::World& world);
  /// Moves the arm to the next best view of a region, scans, and adds the scan to the views before;
  /// its pose is corrected by what both see, if the options say so.
  /// @param q  where the arm stands; receives where it stands then
  /// @return nullopt if no view is worth the way; not arrived if the arm met something that was not
  /// foreseen, and stands where it was stopped
  std::optional<trial::LookRecord> AddBestView(const Eigen::AlignedBox3d& region_W,
                                               sim::World& world, Eigen::VectorXd& q,
                                               trial::Sensed& to);

 private:
  base::Rng Stream(const char* name) const;
  void BelieveCalibration(const base::Pose& X_HS);
  Eigen::AlignedBox3d AroundWorkspace(double below_m) const;
  std::optional<PlannedView> NextView(const geometry::Observation& so_far,
                                      const Eigen::AlignedBox3d& region_W,
                                      const Eigen::VectorXd& q_now) const;
  Refinement Add(trial::Sensed look, trial::Sensed& to) const;

  const trial::Options& options_;
  const WristViewOptions look_;
  const robot::Robot& robot_;
  std::uint64_t seed_;
  sensing::RangeSensor scanner_;
  base::Pose X_SBelieved_;  ///< the head as the robot believes it to be, in its true frame
  double mount_error_m_;    ///< of that, root mean square
  double mount_error_rad_;
  std::uint64_t looks_ = 0;
};

/// Adds views of the highest thing, as many as the options say and are worth the way.
/// @param first  of the cell's own sensor
/// @param promise  ends it where it reaches until_probability; may be empty
trial::LookedAround AddWristViews(const trial::Cell& cell, trial::Sensed first, sim::World& world,
                                  std::uint64_t seed, const trial::Promise& promise = {});

}  // namespace rangegrasp::views
