#pragma once

#include <optional>

#include "grasp/grasp.h"
#include "grasp/hand_profiles.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp::internal {

/// All that candidates of one object need. C is the cloud's frame.
struct Task {
  const perception::Scene& scene;
  const perception::PerceivedObject& object;
  const robot::HandModel& hand;
  Eigen::Vector3d arm_C;
  Eigen::Vector3d up_C;  ///< the table's normal
  const GraspOptions& options;
  SurfaceSamples samples;  ///< dense, for contacts
  SurfaceSamples coarse;   ///< for extents and for coming down
  Eigen::Vector3d com_C;
  HandProfiles profiles;

  double MaxWidth() const { return hand.MaxGap() - 2.0 * options.object_clearance_m; }
};

/// The object in a frame A with the axes of G: z the approach, x the closing direction.
struct View {
  base::Pose X_CA;
  geometry::Points coarse;
  Eigen::Vector3d com;
  Eigen::Vector3d up;     ///< the table's normal
  double table_offset_m;  ///< up . p + offset = height above the table
  double top_m;           ///< smallest z of the object: its highest point along the approach
  double bottom_m;
  double y_min_m, y_max_m;
  double thumb_to_arm;  ///< cosine
};
/// @param closing_C  need not be normal to the approach, but not along it
View MakeView(const Task& task, const SurfaceSamples& coarse, const Eigen::Vector3d& origin_C,
              const Eigen::Vector3d& approach_C, const Eigen::Vector3d& closing_C);

/// The dense samples that pads at y0 may meet, in A.
struct Band {
  double y_m = 0.0;
  geometry::Points points;
  geometry::Points normals;
};
Band MakeBand(const Task& task, const View& view, double y0_m);

/// The extent of the object along x, in the part that the hand passes: |y - y0| <= half_band and
/// not deeper than reach below the top of that part.
struct Slab {
  double x_min_m = 0.0;
  double x_max_m = 0.0;
  double top_m = 0.0;
  double Width() const { return x_max_m - x_min_m; }
  double Middle() const { return 0.5 * (x_min_m + x_max_m); }
};
std::optional<Slab> SlabAt(const View& view, double y0_m, double half_band_m, double reach_m);

/// How far down T's origin can go along the approach at (x, y) until the hand, coming straight
/// down, is object_clearance above the object.
double DescentLimit(const View& view, const HandProfiles::Lower& lower, double x_m, double y_m,
                    double clearance_m);
/// How far the hand reaches below T's origin, towards the table, in any state from `open` to
/// `closed`: fingers and thumb swing down while they close.
double ReachDown(Task& task, const View& view, double pitch_rad, std::size_t open,
                 std::size_t closed);
/// How far down T's origin can go along the approach at (x, y) until a hand that reaches reach_m
/// below it is clearance_m above the table.
double TableLimit(const View& view, double reach_m, double x_m, double y_m, double clearance_m);

/// The hand on its way down: how far T's origin can go at (x, y) with a hand that reaches reach_m
/// below it, until it is at its clearance above the table or the object.
double DepthLimit(const Task& task, const View& view, const HandProfiles::Lower& lower,
                  double reach_m, double x_m, double y_m);

/// A unit vector normal to the axis, in the direction of v where that is possible.
Eigen::Vector3d NormalPart(const Eigen::Vector3d& v, const Eigen::Vector3d& axis);

/// The rotation axis, turned away from the table; nullopt where it is not upright enough
/// (CylindricalOptions::max_tilt_rad) to be approached along from above.
std::optional<Eigen::Vector3d> UprightAxis(const Task& task);

}  // namespace rangegrasp::grasp::internal
