#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "grasp/closing.h"
#include "grasp/grasp.h"
#include "grasp/hand_collider.h"
#include "grasp/hand_profiles.h"
#include "grasp/score.h"
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
  core::Pose X_CA;
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

struct Candidate {
  Grasp grasp;
  std::size_t open_state = 0;
  std::size_t narrow_state = 0;  ///< tried where the open state collides
  std::size_t held_state = 0;
  double depth_m = 0.0;  ///< z of the pads' middle in the view
  int group = 0;         ///< candidates of one group are alike; see Judge
};

/// Where the contacts are sought.
struct Aim {
  double pitch_rad = 0.0;
  double best_pitch_rad = 0.0;
  double depth_m = 0.0;     ///< wanted z of the pads' middle; the hand stops earlier where it must
  double back_off_m = 0.0;  ///< and then goes back up by this
};

/// Places the hand so that its pads close on the object in the band and at the aim, midway between
/// the contacts; nullopt if it does not fit or meets nothing on one side.
std::optional<Candidate> Place(Task& task, const View& view, const Band& band, const Aim& aim,
                               GraspType type);
/// Place at each of the depths, and, where the hand had to stop above the first of them, also a
/// little higher: the thumb's first segment touches a wide object's edge before its tip touches the
/// side.
void PlaceAtDepths(Task& task, const View& view, const Band& band, Aim aim,
                   const std::vector<double>& depths_m, GraspType type, int group,
                   std::vector<Candidate>& candidates);

/// The candidate for T at origin_A.
Candidate MakeCandidate(const Task& task, const View& view, const Eigen::Vector3d& origin_A,
                        const Eigen::Vector3d& center_A, double pitch_rad, GraspType type);

struct Quota {
  int most = 24;     ///< free candidates
  int each = 1;      ///< of one group
  int checks = 120;  ///< candidates looked at
};
/// Checks candidates in the order of their scores and appends those that are free to `accepted`;
/// the best one of every group that collides goes to `rejected`.
void Judge(const HandCollider& collider, const robot::HandModel& hand,
           std::vector<Candidate> candidates, const Quota& quota, std::vector<Grasp>& accepted,
           std::vector<Grasp>& rejected);

/// A unit vector normal to the axis, in the direction of v where that is possible.
Eigen::Vector3d NormalPart(const Eigen::Vector3d& v, const Eigen::Vector3d& axis);

/// The rotation axis, turned away from the table; nullopt where it is not upright enough (45 deg)
/// to be approached along from above.
std::optional<Eigen::Vector3d> UprightAxis(const Task& task);

std::vector<Candidate> CylindricalCandidates(Task& task);
std::vector<Candidate> RimCandidates(Task& task);
std::vector<Candidate> PowerCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
