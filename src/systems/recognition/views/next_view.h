#pragma once

#include <optional>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "geometry/observation.h"
#include "robot/planning/planning.h"
#include "robot/robot.h"

namespace rangegrasp::views {

struct NextViewOptions {
  double cell_m = 0.010;
  /// How far it is likely to be seen into space that was not seen: about half of an object.
  double depth_m = 0.03;
  double min_gain_m3 = 125e-6;  ///< a cube of 50 mm
  /// Sensors stand on spheres about the region's middle, at these heights above the table's plane
  /// and as many places round.
  std::vector<double> distances_m = {0.32, 0.42};
  std::vector<double> elevations_rad = {base::Deg(25.0), base::Deg(45.0), base::Deg(65.0)};
  int azimuths = 16;
  int rolls = 8;        ///< turns about the line of sight
  int max_places = 40;  ///< that the arm is tried at, those that see most first
  /// Of the space that motions keep clear of: what was not seen may be something.
  double obstacle_cell_m = 0.02;
  double clearance_m = 0.01;  ///< above it
  int ik_solutions = 4;       ///< of a pose of the sensor
};

/// What a view is wanted for.
struct ViewRequest {
  Eigen::AlignedBox3d region_C;  ///< what is to be seen; stands on the table
  /// All that motions may meet on the table: known or not, what is not free in it is kept clear of.
  Eigen::AlignedBox3d obstacles_C;
  geometry::Field field;                     ///< of the sensor
  base::Pose X_HS = base::Pose::Identity();  ///< where it is on the hand's root body
  Eigen::VectorXd q_now;                     ///< where the arm stands
};

/// A place to look from, and the way there.
struct PlannedView {
  Eigen::VectorXd q;
  base::Pose X_CS = base::Pose::Identity();  ///< the sensor there
  base::JointTrajectory way;                 ///< from q_now, with no collision that is foreseen
  double gain_m3 = 0.0;                      ///< SeenSpace::GainFrom
  double unseen_m3 = 0.0;                    ///< of the region before it
};

/// Of the places about the region that the arm can bring the sensor to, the one expected to see
/// most of what no view has seen there; nullopt if that is less than min_gain_m3, or the arm gets
/// to none of max_places. C is W. Depends on its arguments alone.
std::optional<PlannedView> NextBestView(const robot::Robot& robot,
                                        const geometry::Observation& so_far,
                                        const ViewRequest& request, const NextViewOptions& options,
                                        const planning::PlanOptions& planning, base::Rng& rng);

/// Poses on spheres about a point that look at it, S's y axis as low as it may.
std::vector<base::Pose> PosesAbout(const Eigen::Vector3d& center_C, const NextViewOptions& options);

}  // namespace rangegrasp::views
