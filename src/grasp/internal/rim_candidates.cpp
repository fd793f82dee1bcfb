#include "grasp/internal/rim_candidates.h"

#include <algorithm>
#include <cmath>

#include "grasp/rim.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

/// The wall between the pads at one sector. `out`: the thumb's side, +1 outside, -1 in the cavity.
Candidate WallCandidate(Task& task, const SurfaceSamples& samples, const RimSector& sector,
                        const Vector3d& axis, const Vector3d& radial, double out, double pitch) {
  const RimOptions& options = task.options.rim;
  const View view = MakeView(task, samples, task.object.axis->center_C, -axis, out * radial);
  const std::size_t open = task.hand.IndexAtGap(sector.wall_m + options.opening_m);
  const std::size_t held = task.hand.IndexAtGap(sector.wall_m);
  const Vector3d pads = task.profiles.PadCenter_T(pitch, held);
  Vector3d origin(out * sector.radius_m - pads.x(), -pads.y(), 0.0);
  const double limit = DepthLimit(task, view, task.profiles.LowerSide(pitch, open),
                                  ReachDown(task, view, pitch, open, held), origin.x(), origin.y());
  const double wanted = options.grip_depth_m - pads.z();
  origin.z() = std::min(limit, wanted);
  Candidate candidate = MakeCandidate(task, view, origin, origin + pads, pitch, GraspType::kRim);
  SetStates(task, open, held, sector.wall_m, candidate);
  const double near_arm = 0.5 * (1.0 + std::cos(sector.angle_rad));
  candidate.grasp.score =
      options.curvature_weight * sector.curvature + options.arm_weight * near_arm +
      (task.options.contact_ranking && out < 0.0 ? options.outside_bonus : 0.0) -
      options.shallow_per_m * std::max(0.0, wanted - origin.z());
  return candidate;
}

std::vector<Candidate> OpenRim(Task& task, const Vector3d& axis, const Vector3d& zero) {
  // The points themselves: the surface may close the cavity.
  SurfaceSamples samples;
  const geometry::TriangleMesh specks =
      SpeckMesh(task.object.completed_C, task.options.rim.speck_cell_m);
  for (std::size_t i = 0; i < specks.vertices.size(); i += 3) {
    samples.points.push_back(specks.vertices[i]);
    samples.normals.push_back(axis);
  }
  std::vector<Candidate> candidates;
  const auto rim = DescribeRim(task.scene, task.object, axis, zero,
                               task.options.cylindrical.yaw_steps, task.options.rim);
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const Vector3d radial = Eigen::AngleAxisd(rim[k].angle_rad, axis) * zero;
    for (const double out : {-1.0, 1.0}) {
      candidates.push_back(WallCandidate(task, samples, rim[k], axis, radial, out, 0.0));
      candidates.back().group = static_cast<int>(k);
    }
  }
  return candidates;
}

/// A closed top has no wall to hold: the tips close on two opposite points of the rim instead.
std::vector<Candidate> ClosedRim(Task& task, const Vector3d& axis, const Vector3d& zero) {
  std::vector<Candidate> candidates;
  const auto rim = DescribeRim(task.scene, task.object, axis, zero,
                               task.options.cylindrical.yaw_steps, task.options.rim);
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const View view = MakeView(task, task.coarse, task.object.axis->center_C, -axis,
                               Eigen::AngleAxisd(rim[k].angle_rad, axis) * zero);
    const double pitch = task.options.pitches ? task.options.cylindrical.pitch_rad : 0.0;
    const Aim aim{pitch, pitch, view.top_m + task.options.rim.tip_depth_m};
    auto candidate = Place(task, view, MakeBand(task, view, 0.0), aim, GraspType::kRim);
    if (!candidate) continue;
    candidate->group = static_cast<int>(k);
    candidate->grasp.score = task.options.rim.curvature_weight * rim[k].curvature +
                             task.options.rim.arm_weight * view.thumb_to_arm;
    candidates.push_back(*candidate);
  }
  return candidates;
}

}  // namespace

std::vector<Candidate> RimCandidates(Task& task) {
  const auto axis = UprightAxis(task);
  if (!axis) return {};
  const Vector3d zero = NormalPart(task.arm_C - task.object.axis->center_C, *axis);
  return task.object.open ? OpenRim(task, *axis, zero) : ClosedRim(task, *axis, zero);
}

}  // namespace rangegrasp::grasp::internal
