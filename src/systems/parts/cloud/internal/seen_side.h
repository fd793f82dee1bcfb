#pragma once

#include <optional>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// A line that a surface turns about.
struct RevolutionAxis {
  Eigen::Vector3d point;
  Eigen::Vector3d direction;  ///< unit; sign arbitrary
  double share;               ///< of the area: faces whose normals meet the line

  /// Distance from the line, height along it, and 0: a place in the half plane that turns about it.
  Eigen::Vector3d ProfileOf(const Eigen::Vector3d& p) const;
  /// How far a normal at p points past the line: the sine of the angle to the plane of p and the
  /// line; 0 on a surface of revolution.
  double Twist(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;
};

/// The axis that most of a surface's area turns about: the velocities a x p + m of a rotation are
/// tangential to it, so that a . (p x n) + m . n = 0 for each normal n at p (line complexes,
/// Pottmann and Randrup 1998). Least squares with |a| = 1, reweighted so that what stands off, as a
/// handle, does not count. O(faces).
/// @return nullopt without area.
std::optional<RevolutionAxis> FindRevolution(const FaceFrames& frames);

/// Joins parts that are the two sides of a thin wall, as of a cup: half of the smaller one's area
/// has the other before or behind it, as parallel, within four edges. Noise joins and pierces such
/// walls, and what is left of them comes apart along the holes.
Segmentation JoinWalls(const Shape& mesh, const Segmentation& found);

/// How many layers of a surface lie one behind the other, in the mean, seen from where they are
/// fewest: 1 of what was seen from one side, 2 of a closed surface. The sum of A |n . v| over the
/// area that is covered, least over about 200 directions v. O(faces) each.
double FewestLayers(const Shape& mesh);

/// More layers are not seen from one side: one view has 0.7 to 0.95, closed clouds 1.4 to 2.1.
inline constexpr double kMaxLayers = 1.15;

/// The axis of a body of revolution that is seen from one side, its inside perhaps, too.
/// @return nullopt of a surface that is not seen from one side, and if too little turns about one
/// axis.
std::optional<RevolutionAxis> FindSeenBody(const Shape& mesh);

/// Joins the parts that are of the body, as outside and inside of a mug, and those that stand off
/// on one side of its axis, as a handle whose middle the body hides. Faces at the border of both go
/// by the body's profile. The tree is the whole and what it came to.
Segmentation JoinTurned(const Shape& mesh, const RevolutionAxis& axis, const Segmentation& found);

}  // namespace rangegrasp::parts
