#pragma once

#include "grasp/grasp.h"

namespace rangegrasp::grasp {

/// A grasp that another program proposes.
struct Proposal {
  /// Frame G (base/frames.h): its origin is midway between the pads, closed on width_m.
  base::Pose X_CG = base::Pose::Identity();
  double width_m = 0.0;                        ///< what the pads are expected to close on
  Eigen::Vector3d approach_C{0.0, 0.0, -1.0};  ///< unit: the hand's way to the grasp
  double score = 0.0;                          ///< higher is better
};

/// Puts the hand there, open for the width and options.placing.opening_m more (fully without
/// options.preshape), without a look at what is in the way; what is wider than the hand opens
/// counts as colliding.
Grasp PlaceHand(const Proposal& proposal, const robot::HandModel& hand,
                const GraspOptions& options);

/// Positions of the points between the fingers of the hand as it stands there, open: in the box,
/// along the axes of G, about thumb and fingers. O(n).
geometry::Indices BetweenFingers(const Grasp& grasp, const robot::HandModel& hand,
                                 geometry::PointSpan points_C);

/// The baseline that any other detector has to beat: straight down onto the middle of the points,
/// closing across the shorter of their principal axes in the table's plane, thumb and fingers
/// either way. The pads come 30 mm below the highest point, but stay 10 mm above the table, or
/// halfway up what is lower than 20 mm.
/// @param points_C  of one thing, above the table [m]
/// @return none of fewer than three points.
std::vector<Proposal> ProposeStraightDown(geometry::PointSpan points_C,
                                          const geometry::Plane& table_C);

/// Checks the hand of each proposal against everything else, with the opening that PlaceHand gives
/// it or the narrow one: sets their openings and verdicts.
/// @param object  position in scene.objects: what all are for
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
/// @throws std::invalid_argument if there is no such object.
void CheckProposals(const perception::Scene& scene, std::size_t object,
                    const robot::HandModel& hand, const GraspOptions& options,
                    std::span<const geometry::TriangleMesh> obstacles_C,
                    std::vector<Grasp>& grasps);

/// A part that stands out of an object, as a mug's handle, by its measured points.
struct Handle {
  geometry::PointSpan points_C;
  Eigen::Vector3d body_C;  ///< the middle of what it is joined to
};

struct HandleOptions {
  /// Gripped is what is within this of the handle's outermost place: a bar and what bends away.
  double bar_m = 0.012;
  /// Points of one side only measure less than the bar; thinner is no handle for a person's hand.
  double min_width_m = 0.008;
  double step_rad = 0.2618;      ///< between approaches: 15 deg
  double max_rise_rad = 0.1745;  ///< the hand comes from above or level, to 10 deg
};

/// Ways to take a handle: the fingers close across the plane that it lies in (its least principal
/// axis), about what is farthest from the body, and come in that plane, the steepest first, thumb
/// and fingers either way.
/// @param up_C  the table's normal
/// @return none of fewer than three points.
std::vector<Proposal> ProposeHandleGrasps(const Handle& handle, const Eigen::Vector3d& up_C,
                                          const HandleOptions& options = {});

}  // namespace rangegrasp::grasp
