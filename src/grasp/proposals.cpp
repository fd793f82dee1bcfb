#include "grasp/proposals.h"

#include <algorithm>
#include <stdexcept>

#include "grasp/internal/choosing.h"
#include "grasp/internal/object_surfaces.h"
#include "robot/collision/hand_collider.h"

namespace rangegrasp::grasp {
namespace {

using robot::HandModel;

std::size_t OpenState(double width_m, double room_m, const HandModel& hand,
                      const GraspOptions& options) {
  return options.preshape ? hand.IndexAtGap(width_m + room_m) : 0;
}

/// About thumb and fingers, along the axes of G.
Eigen::AlignedBox3d FingerBox(const HandModel::State& state, const base::Pose& X_GH) {
  Eigen::AlignedBox3d box_G;
  for (std::size_t i = 0; i < state.shapes.size(); ++i) {
    if (!state.is_finger[i]) continue;
    for (const auto& vertex_H : geometry::Tessellate(state.shapes[i]).vertices) {
      box_G.extend(X_GH * vertex_H);
    }
  }
  return box_G;
}

}  // namespace

Grasp PlaceHand(const Proposal& proposal, const HandModel& hand, const GraspOptions& options) {
  const HandModel::State& held = hand.AtGap(proposal.width_m);
  const base::Pose X_HG =
      base::MakePose(hand.X_HG_tip.linear(), 0.5 * (held.thumb_pad_H + held.finger_pad_H));
  const std::size_t open = OpenState(proposal.width_m, options.placing.opening_m, hand, options);
  Grasp grasp;
  grasp.X_CG = proposal.X_CG;
  grasp.X_CH = proposal.X_CG * X_HG.inverse();
  grasp.opening_m = hand.states[open].gap_m;
  grasp.width_m = proposal.width_m;
  grasp.score = proposal.score;
  grasp.collides = proposal.width_m > hand.MaxGap();
  return grasp;
}

geometry::Indices BetweenFingers(const Grasp& grasp, const HandModel& hand,
                                 geometry::PointSpan points_C) {
  const base::Pose X_GC = grasp.X_CG.inverse();
  const auto box_G = FingerBox(hand.AtGap(grasp.opening_m), X_GC * grasp.X_CH);
  geometry::Indices between;
  for (std::uint32_t i = 0; i < points_C.size(); ++i) {
    if (box_G.contains(X_GC * points_C[i])) between.push_back(i);
  }
  return between;
}

void CheckProposals(const perception::Scene& scene, std::size_t object, const HandModel& hand,
                    const GraspOptions& options,
                    std::span<const geometry::TriangleMesh> obstacles_C,
                    std::vector<Grasp>& grasps) {
  if (object >= scene.objects.size()) throw std::invalid_argument("CheckProposals: no such object");
  const collision::HandCollider collider(hand, internal::Others(scene, object, obstacles_C),
                                         internal::SurfaceOf(scene.objects[object]),
                                         scene.table.plane,
                                         {options.object_clearance_m, options.table_clearance_m});
  for (Grasp& grasp : grasps) {
    if (grasp.collides) continue;
    const internal::Openings openings{
        hand.IndexAtGap(grasp.opening_m),
        OpenState(grasp.width_m, options.placing.narrow_opening_m, hand, options),
        hand.IndexAtGap(grasp.width_m)};
    grasp.collides = internal::HitsTableClosing(collider, hand, grasp.X_CH, openings) ||
                     collider.HitsObstacle(grasp.X_CH, openings.held);
    if (grasp.collides) continue;
    const auto opening = internal::FreeOpening(collider, grasp.X_CH, openings);
    grasp.collides = !opening;
    if (opening) grasp.opening_m = hand.states[*opening].gap_m;
  }
}

}  // namespace rangegrasp::grasp
