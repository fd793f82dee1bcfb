#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::recognition {

/// Positions of the first point in each cell of a grid of this edge [m], ascending.
geometry::Indices Thinned(geometry::PointSpan points, double edge_m);

/// Points drawn evenly over the triangles, then thinned to one a cell of the grid; normals are the
/// triangles'. The same mesh gives the same bytes.
geometry::PointCloud SampledSurface(const geometry::TriangleMesh& mesh, double spacing_m);

/// The turns that lay a surface on itself, so that no range sensor can tell them apart.
struct Symmetry {
  Eigen::Vector3d center_B = Eigen::Vector3d::Zero();  ///< [m]; every turn leaves it where it is
  std::optional<Eigen::Vector3d> axis_B;  ///< unit; a solid of revolution: any turn about it
  /// Turns about the center, the first is the identity. With an axis, turns about it do not count.
  std::vector<Eigen::Matrix3d> rotations = {Eigen::Matrix3d::Identity()};
};

/// Lays the surface on itself: turned about the principal axes of its points, the normals of its
/// hull's larger faces and the axes between two of these.
/// @param surface_B  evenly sampled, with normals; distances are taken to the planes of the nearest
/// samples, so that it need not be finer than a turn may be off (1.5 mm)
/// @throws std::invalid_argument if there are fewer than 4 points, or not one normal a point
Symmetry SymmetryOf(const geometry::TriangleMesh& mesh_B, const geometry::PointCloud& surface_B);

/// How far a pose is from another one, symmetry aside.
struct PoseDifference {
  double distance_m = 0.0;  ///< of the center
  double angle_rad = 0.0;   ///< of the turn; of a solid of revolution: between the axes
};
PoseDifference Difference(const base::Pose& X_CB, const base::Pose& other_CB,
                          const Symmetry& symmetry);

/// A line in the body's frame.
struct Axis {
  Eigen::Vector3d point_B;
  Eigen::Vector3d direction_B;  ///< unit
};

/// The axis that most of a surface turns about without leaving itself, as a cup's does but for its
/// handle; nullopt for less than 70 %. The lines of the normals of a surface of revolution meet its
/// axis, a linear complex, which is found by least squares (Pottmann and Randrup 1998, "Rotational
/// and helical surface approximation for reverse engineering"), weighted anew by the residuals.
/// @param surface_B  evenly sampled, with normals
std::optional<Axis> AxisOfRevolution(const geometry::PointCloud& surface_B);

/// Directions (unit, in B) that may point down when the body lies on a plane: the normals of the
/// hull's faces over which the middle of the hull stands, or which it misses by at most slack_m:
/// the body's center of mass is not known.
std::vector<Eigen::Vector3d> LyingDirections(geometry::PointSpan points_B, double slack_m);

}  // namespace rangegrasp::recognition
