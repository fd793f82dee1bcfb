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

/// Joins parts that are the two sides of a thin wall, as inside and outside of a cup: half of the
/// smaller one's area has the other before or behind it, as parallel, within four edges. Noise
/// joins and pierces such walls, and what is left of them comes apart along the holes.
Segmentation JoinWalls(const Shape& mesh, const Segmentation& found);

/// How many layers of a surface lie one behind the other, in the mean, seen from where they are
/// fewest: 1 of what was seen from one side, 2 of a closed surface. The sum of A |n . v| over the
/// area that is covered, least over about 200 directions v. O(faces) each.
double FewestLayers(const Shape& mesh);

struct SeenSideOptions {
  double max_layers = 1.15;    ///< one view: 0.7 to 0.95 were measured; closed clouds: 1.4 to 2.1
  double min_share = 0.6;      ///< of the area that turns about an axis, to be a body
  double max_twist = 0.3;      ///< of a face that turns about it: noise tilts faces by 0.1 to 0.2
  double min_turned = 0.5;     ///< of a part's area that does, to be of the body
  double sure_turned = 0.6;    ///< the same of parts that give the body's profile, and
  double sure_area = 0.02;     ///< how much of the area they have at least
  double profile_reach = 2.0;  ///< half of a part of the body is so near to its profile, in edges
  double min_off = 0.02;     ///< of the area; less than this does not stand off, it is of the body
  double border_zone = 3.0;  ///< faces so near to another part, in edges, are looked at again
  double border_step = 0.4;  ///< nearer than this to the body's profile, in edges, is of the body
  double same_side_rad = 0.8;  ///< what stands off, at angles less than this apart, is one
};

/// A body of revolution that is seen from one side, its inside perhaps, too: its axis.
/// @return nullopt of a surface that is not seen from one side, and if too little turns about one
/// axis.
std::optional<RevolutionAxis> FindSeenBody(const Shape& mesh, const SeenSideOptions& options = {});

/// Joins the parts that are of the body, as outside and inside of a mug, and those that stand off
/// on one side of its axis, as a handle whose middle the body hides. Faces at the border of both go
/// by the body's profile. The tree is the whole and what it came to.
Segmentation JoinTurned(const Shape& mesh, const RevolutionAxis& axis, const Segmentation& found,
                        const SeenSideOptions& options = {});

}  // namespace rangegrasp::parts
