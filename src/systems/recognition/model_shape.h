#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::recognition {

/// The first point in each cell of a grid with this edge length [m], with its normal.
geometry::PointCloud Thinned(const geometry::PointCloud& cloud, double edge_m);

/// Points drawn evenly over the triangles, then thinned to one per grid cell; the normals are those
/// of the triangles. The same mesh gives bit-identical results.
geometry::PointCloud SampledSurface(const geometry::TriangleMesh& mesh, double spacing_m);

/// Rotations that map a surface onto itself, so that no range sensor can distinguish them.
struct Symmetry {
  Eigen::Vector3d center_B = Eigen::Vector3d::Zero();  ///< [m]; fixed by every rotation
  std::optional<Eigen::Vector3d> axis_B;  ///< unit; solid of revolution: free rotation about it
  /// Rotations about the center, first the identity. With an axis_B, those about it are omitted.
  std::vector<Eigen::Matrix3d> rotations = {Eigen::Matrix3d::Identity()};
};

/// Finds the symmetry by testing rotations of the surface about its principal axes, the normals of
/// its hull's larger faces and the axes between two of these.
/// @param surface_B  evenly sampled, with normals; distances are measured to the planes of the
/// nearest samples, so that its spacing may exceed the tolerance of a rotation (1.5 mm)
Symmetry SymmetryOf(const geometry::TriangleMesh& mesh_B, const geometry::PointCloud& surface_B);

/// The motion that turns a body about a point.
base::Pose TurnAbout(const Eigen::Matrix3d& turn, const Eigen::Vector3d& about_B);

/// The poses in which a body looks as at X_CB, the first; without rotation about an axis_B.
std::vector<base::Pose> EqualPoses(const base::Pose& X_CB, const Symmetry& symmetry);

/// Angle between two orientations, modulo symmetry; of solids of revolution: between their axes.
double AngleBetween(const Eigen::Matrix3d& R_CB, const Eigen::Matrix3d& other_CB,
                    const Symmetry& symmetry);

/// Difference between two poses, modulo symmetry.
struct PoseDifference {
  double distance_m = 0.0;  ///< between the centers
  double angle_rad = 0.0;   ///< AngleBetween
};
PoseDifference Difference(const base::Pose& X_CB, const base::Pose& other_CB,
                          const Symmetry& symmetry);

/// A line in the body's frame.
struct Axis {
  Eigen::Vector3d point_B;
  Eigen::Vector3d direction_B;  ///< unit
};

/// The axis about which most of a surface is rotationally symmetric, such as a cup without its
/// handle; nullopt for less than 70 %. The normal lines of a surface of revolution meet its axis;
/// they form a linear complex, which is found by least squares (Pottmann and Randrup 1998,
/// "Rotational and helical surface approximation for reverse engineering") with iterative
/// reweighting.
/// @param surface_B  evenly sampled, with normals
std::optional<Axis> AxisOfRevolution(const geometry::PointCloud& surface_B);

/// Directions (unit vectors in B) that may point down when the body lies on a plane: the normals of
/// the hull's faces onto which the middle of the hull projects, or which it misses by at most
/// slack_m, since the body's center of mass is unknown.
std::vector<Eigen::Vector3d> LyingDirections(geometry::PointSpan points_B, double slack_m);

}  // namespace rangegrasp::recognition
