#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

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

/// Options of the views from the wrist, which follow that of the fixed sensor.
struct WristViewOptions {
  int views = 1;
  std::filesystem::path sensor;
  double mount_sigma_m = 0.001;  ///< mounted by hand, according to a drawing
  double mount_sigma_rad = base::Deg(0.3);
  std::filesystem::path hand_eye;
  double until_probability = 1.0;  ///< stops when the best grasp reaches it; 1: all views are taken
  NextViewOptions next;
};

/// Name of these options in trial::Options.
inline constexpr const char* kWristViews = "look";

/// Reads the keys `views` and `look`.
/// @throws base::InputError
void ReadWristViewOptions(base::YamlMap& map, WristViewOptions& options);

/// The wrist scanner, which adds views to those of the cell's own sensor:
///
///   WristScanner wrist(cell.options, cell.robot, seed);
///   Sensed sensed = cell.sensor->Sense(world, rng);  // with the arm out of its way
///   while (!sure) {
///     const auto look = wrist.AddBestView(wrist.RegionAbout(...), world, q, sensed);
///     if (!look || !look->arrived) break;  // nothing new to see, or stopped
///   }
///
/// All draws are from streams of the seed, numbered by look. The arguments must outlive it.
class WristScanner {
 public:
  /// @throws base::InputError if the scene has no site "wrist_scanner", or if the sensor's file or
  /// look.hand_eye cannot be read or belongs to another head
  WristScanner(const trial::Options& options, const robot::Robot& robot, std::uint64_t seed);

  /// A box about the highest point that was seen above the table within the workspace, down to the
  /// table; nullopt if there is none.
  std::optional<Eigen::AlignedBox3d> RegionOfHighest(const geometry::Observation& so_far) const;
  /// The same about any position, from the table to the highest point seen there.
  Eigen::AlignedBox3d RegionAbout(const Eigen::Vector3d& place_W,
                                  const geometry::Observation& so_far) const;

  /// Scans from the arm's current configuration. The view is where the robot believes it to be: it
  /// has the arm's own error, drawn for each scan, and the mount's, drawn once per scanner.
  trial::Sensed Scan(const sim::World& world);
  /// Moves the arm to the next best view of a region, scans, and adds the scan to the earlier
  /// views; its pose is corrected by their overlap (views/merge.h).
  /// @param q  the arm's configuration; receives the new one
  /// @return nullopt if no view is worth the motion; not arrived if the arm met something
  /// unexpected, and stays where it was stopped
  std::optional<trial::LookRecord> AddBestView(const Eigen::AlignedBox3d& region_W,
                                               sim::World& world, Eigen::VectorXd& q,
                                               trial::Sensed& to);

 private:
  base::Rng Stream(const char* name) const;
  void BelieveCalibration(const base::Pose& X_HS);
  Eigen::AlignedBox3d AroundWorkspace(double below_m) const;
  Refinement Add(trial::Sensed look, trial::Sensed& to) const;

  const trial::Options& options_;
  const WristViewOptions look_;
  const robot::Robot& robot_;
  std::uint64_t seed_;
  sensing::RangeSensor scanner_;
  base::Pose X_SBelieved_;  ///< believed pose of the head in its true frame
  double mount_error_m_;    ///< root mean square error of that
  double mount_error_rad_;
  std::uint64_t looks_ = 0;
};

/// Adds views of the highest object, as many as the options allow and are worth the motion.
/// @param first  the view of the cell's own sensor
/// @param promise  stops further views when it reaches until_probability; may be empty
trial::LookedAround AddWristViews(const trial::Cell& cell, trial::Sensed first, sim::World& world,
                                  std::uint64_t seed, const trial::Promise& promise = {});

}  // namespace rangegrasp::views
