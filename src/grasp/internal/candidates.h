#pragma once

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// The Gaussian curvature [1/m^2] of a surface at `center` from neighboring points: least squares
/// of
///   h(u, v) = a u^2 + b u v + c v^2 + d u + e v + f
/// over the plane of the two largest principal axes, and
///   K = (4 a c - b^2) / (1 + d^2 + e^2)^2
/// (Porteous 1994). Positive on a dome, negative on a saddle, 0 on a cylinder.
/// @return nullopt for fewer than six points or a degenerate neighbourhood.
std::optional<double> GaussianCurvature(geometry::PointSpan neighbors, const Vector3d& center);

/// A circular Gaussian filter: values at angles [rad], smoothed with sigma_rad.
std::vector<double> SmoothAround(std::span<const double> angles_rad, std::span<const double> values,
                                 double sigma_rad);

/// A sector of the top rim, in equal angular steps about the rotation axis.
struct RimSector {
  double angle_rad = 0.0;  ///< from the given direction, positive about the axis
  double radius_m = 0.0;   ///< middle of the wall
  double wall_m = 0.0;     ///< thickness if both sides were seen, else an assumed one
  double curvature = 0.0;  ///< |K| after the Gaussian filter; the largest of the rim is 1
};
/// @param axis_C  unit, away from the table
/// @param zero_C  unit, normal to the axis: the direction of angle 0
std::vector<RimSector> DescribeRim(const Scene& scene, const PerceivedObject& object,
                                   const Vector3d& axis_C, const Vector3d& zero_C, int sectors,
                                   const RimOptions& options = {});

/// Grasps around an upright rotation axis, from all sides; none if the object is too wide.
std::vector<Candidate> CylindricalCandidates(Task& task);

/// Grasps with the wall of an open rotational object between the pads or, if its top is closed,
/// with the tips on two opposite points of its rim; none without an upright rotation axis.
std::vector<Candidate> RimCandidates(Task& task);

/// Power grasps from above.
std::vector<Candidate> PowerCandidates(Task& task);

/// Power grasps that close from all directions, no deeper than the centre of mass, and on an upper
/// part if the object is too wide. They are for objects between others, where few better grasps are
/// free.
/// @param round  0: from above; k: tilted by PowerOptions::crowded_leans_rad[k - 1]
std::vector<Candidate> CrowdedCandidates(Task& task, std::size_t round);

/// Power grasps from the side, with thumb and fingers left and right of the object, as section 7.2
/// asks for a tall one such as an aerosol can.
std::vector<Candidate> LateralCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
