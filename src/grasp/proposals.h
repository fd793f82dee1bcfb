#pragma once

#include <span>
#include <vector>

#include "grasp/grasp.h"

namespace rangegrasp::grasp {

/// A grasp that another program proposes.
struct Proposal {
  /// Frame G (base/frames.h): its origin is midway between the pads when they have closed on
  /// width_m.
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

/// The points, as positions in points_C, that lie between the fingers of the hand as it stands
/// there, open: in the box, along the axes of G, about all that may touch an object (thumb and
/// fingers). O(n).
geometry::Indices BetweenFingers(const Grasp& grasp, const robot::HandModel& hand,
                                 geometry::PointSpan points_C);

/// Checks the hand of each proposal against everything else, with the opening that PlaceHand gives
/// it or the narrow one: sets their openings and verdicts.
/// @param object  position in scene.objects: what all are for
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
/// @throws std::invalid_argument if there is no such object.
void CheckProposals(const perception::Scene& scene, std::size_t object,
                    const robot::HandModel& hand, const GraspOptions& options,
                    std::span<const geometry::TriangleMesh> obstacles_C,
                    std::vector<Grasp>& grasps);

}  // namespace rangegrasp::grasp
