#pragma once

#include <optional>

#include "geometry/point_cloud.h"
#include "parts/shape/face_frames.h"

namespace rangegrasp::parts {

/// A line that a surface turns about.
struct RevolutionAxis {
  Eigen::Vector3d point;
  Eigen::Vector3d direction;  ///< unit; sign arbitrary
  double share;               ///< of the area: faces whose normals meet the line

  /// Distance from the line, and height along it.
  Eigen::Vector2d ProfileOf(const Eigen::Vector3d& p) const;
  /// How far a normal at p points past the line: the sine of the angle to the plane of p and the
  /// line; 0 on a surface of revolution.
  double Twist(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;
};

struct RevolutionOptions {
  double max_twist = 0.3;  ///< of normals that meet the line: noise tilts them by 0.1 to 0.2
  double softness = 0.2;   ///< twist from which a face's weight falls (Geman and McClure 1987)
  int rounds = 20;         ///< of reweighting, from each of four first guesses
};

/// The axis that most of a surface's area turns about: the velocities a x p + m of a rotation are
/// tangential to it, so that a . (p x n) + m . n = 0 for each normal n at p (line complexes,
/// Pottmann and Randrup 1998). Least squares with |a| = 1, reweighted so that what stands off, as a
/// handle, does not count. O(faces).
/// @return nullopt without area.
std::optional<RevolutionAxis> FindRevolution(const FaceFrames& frames,
                                             const RevolutionOptions& options = {});

}  // namespace rangegrasp::parts
