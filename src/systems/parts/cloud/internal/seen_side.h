#pragma once

#include <optional>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Axis of a surface of revolution.
struct RevolutionAxis {
  Eigen::Vector3d point;
  Eigen::Vector3d direction;  ///< unit; sign arbitrary
  double share;               ///< fraction of the area: faces whose normals meet the axis

  /// Distance from the axis, height along it, and 0: the position in the half plane of revolution.
  Eigen::Vector3d ProfileOf(const Eigen::Vector3d& p) const;
  /// Sine of the angle between a normal at p and the plane through p and the axis: how far the
  /// normal misses the axis; 0 on a surface of revolution.
  double Twist(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;
};

/// Finds the axis about which most of a surface's area is rotationally symmetric. The velocities a
/// x p + m of a rotation about it are tangential to the surface, so that a . (p x n) + m . n = 0
/// for each normal n at p (line complexes, Pottmann and Randrup 1998). Least squares with |a| = 1,
/// reweighted so that protruding parts such as a handle do not count. O(faces).
/// @return nullopt if the surface has no area.
std::optional<RevolutionAxis> FindRevolution(const FaceFrames& frames);

/// Joins parts that are the two sides of a thin wall, e.g. of a cup: half of the smaller part's
/// area has the other part in front of or behind it, about parallel, within four edge lengths.
/// Noise merges and perforates such walls, and their remains are split along the holes.
Segmentation JoinWalls(const Shape& mesh, const Segmentation& found);

/// Mean number of surface layers behind each other, for the direction where it is lowest: 1 for a
/// surface seen from one side, 2 for a closed surface. It is the sum of A |n . v| divided by the
/// covered area, minimized over about 200 directions v. O(faces) per direction.
double FewestLayers(const Shape& mesh);

/// Maximum for a surface seen from one side: one view has 0.7 to 0.95, closed clouds 1.4 to 2.1.
inline constexpr double kMaxLayers = 1.15;

/// The axis of a body of revolution that is seen from one side, possibly with its inside.
/// @return nullopt if the surface is not seen from one side, or too little of it is symmetric about
/// one axis.
std::optional<RevolutionAxis> FindSeenBody(const Shape& mesh);

/// Joins the parts of the body, e.g. outside and inside of a mug, and the parts that protrude on
/// one side of its axis, e.g. a handle whose middle is hidden by the body. Faces at the border
/// between both are assigned by the body's profile.
Segmentation JoinTurned(const Shape& mesh, const RevolutionAxis& axis, const Segmentation& found);

}  // namespace rangegrasp::parts
