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
  /// Expected depth of sight into unseen space: about half of an object.
  double depth_m = 0.03;
  double min_gain_m3 = 125e-6;  ///< a cube of 50 mm
  /// Candidate sensor positions are on spheres about the region's middle, at these elevations above
  /// the table's plane and this number of azimuths.
  std::vector<double> distances_m = {0.32, 0.42};
  std::vector<double> elevations_rad = {base::Deg(25.0), base::Deg(45.0), base::Deg(65.0)};
  int azimuths = 16;
  int rolls = 8;        ///< rotations about the line of sight
  int max_places = 40;  ///< that arm motions are planned to, highest gain first
  /// Cells of the space that motions avoid: unseen space may contain an obstacle.
  double obstacle_cell_m = 0.02;
  double clearance_m = 0.01;  ///< above that space
  int ik_solutions = 4;       ///< per sensor pose
};

/// Request for a view.
struct ViewRequest {
  Eigen::AlignedBox3d region_C;  ///< the space to be seen; stands on the table
  /// Space on the table that motions may cross; they avoid what is not free in it, known or not.
  Eigen::AlignedBox3d obstacles_C;
  geometry::Field field;                     ///< of the sensor
  base::Pose X_HS = base::Pose::Identity();  ///< its pose on the hand's root body
  Eigen::VectorXd q_now;                     ///< current configuration of the arm
};

/// A viewpoint and the motion to it.
struct PlannedView {
  Eigen::VectorXd q;
  base::Pose X_CS = base::Pose::Identity();  ///< pose of the sensor there
  base::JointTrajectory way;                 ///< from q_now, with no expected collision
  double gain_m3 = 0.0;                      ///< SeenSpace::GainFrom
  double unseen_m3 = 0.0;                    ///< unseen volume of the region before it
};

/// Of the viewpoints around the region that the arm can reach, the one that is expected to see most
/// of the unseen space; nullopt if that is less than min_gain_m3, or if none of max_places can be
/// reached. C is W. Depends only on its arguments.
std::optional<PlannedView> NextBestView(const robot::Robot& robot,
                                        const geometry::Observation& so_far,
                                        const ViewRequest& request, const NextViewOptions& options,
                                        const planning::PlanOptions& planning, base::Rng& rng);

/// Poses on spheres about a point that look at it, with S's y axis as low as possible.
std::vector<base::Pose> PosesAbout(const Eigen::Vector3d& center_C, const NextViewOptions& options);

}  // namespace rangegrasp::views
