#pragma once

#include "grasp/grasp.h"

namespace rangegrasp::grasp {

/// A grasp that another program proposes.
struct Proposal {
  /// Frame G (base/frames.h). Its origin is midway between the pads when closed on width_m.
  base::Pose X_CG = base::Pose::Identity();
  double width_m = 0.0;                        ///< expected gap of the pads after closing
  Eigen::Vector3d approach_C{0.0, 0.0, -1.0};  ///< unit: direction of the hand towards the grasp
  double score = 0.0;                          ///< higher is better
};

/// Places the hand at a proposal, opened to the width plus options.placing.opening_m (fully without
/// options.preshape). Obstacles are not checked. A width beyond the hand's largest opening counts
/// as a collision.
Grasp PlaceHand(const Proposal& proposal, const robot::HandModel& hand,
                const GraspOptions& options);

/// Positions of the points between the fingers of the open hand at the grasp: those in the box
/// about thumb and fingers along the axes of G. O(n).
geometry::Indices BetweenFingers(const Grasp& grasp, const robot::HandModel& hand,
                                 geometry::PointSpan points_C);

/// The baseline that any other detector has to beat: the hand comes straight down onto the middle
/// of the points and closes across the shorter of their principal axes in the table's plane, with
/// the thumb on either side. The pads stop 30 mm below the highest point, but at least 10 mm above
/// the table, or at half the height of a thing lower than 20 mm.
/// @param points_C  points of one thing, above the table [m]
/// @return none for fewer than three points.
std::vector<Proposal> ProposeStraightDown(geometry::PointSpan points_C,
                                          const geometry::Plane& table_C);

/// Checks the hand of each proposal against everything else, with the opening from PlaceHand or the
/// narrow one, and sets its opening and collision verdict.
/// @param object  position in scene.objects of the object to grasp
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
void CheckProposals(const perception::Scene& scene, std::size_t object,
                    const robot::HandModel& hand, const GraspOptions& options,
                    std::span<const geometry::TriangleMesh> obstacles_C,
                    std::vector<Grasp>& grasps);

/// Grasps of a handle, a part that stands out from an object: the fingers close across the plane of
/// the handle (along its least principal axis), around the part farthest from the body. They
/// approach in that plane, the steepest way first, with the thumb on either side.
/// @param handle_C  its measured points
/// @param body_C  middle of the body that it is joined to
/// @param up_C  the table's normal
/// @return none for fewer than three points.
std::vector<Proposal> ProposeHandleGrasps(geometry::PointSpan handle_C,
                                          const Eigen::Vector3d& body_C,
                                          const Eigen::Vector3d& up_C);

}  // namespace rangegrasp::grasp
