#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::recognition {

/// The turns that lay a surface on itself, so that no range sensor can tell them apart.
struct Symmetry {
  Eigen::Vector3d center_B = Eigen::Vector3d::Zero();  ///< [m]; every turn leaves it where it is
  std::optional<Eigen::Vector3d> axis_B;  ///< unit; a solid of revolution: any turn about it
  /// Turns about the center, the first is none. With an axis they count but for turns about it.
  std::vector<Eigen::Matrix3d> rotations = {Eigen::Matrix3d::Identity()};
};

struct SymmetryOptions {
  /// A turn counts if nothing of the turned surface is further from the surface than this, but for
  /// the given share of it: a scan of about 1 mm noise and calibration does not tell less.
  double tolerance_m = 0.0015;
  double stray_share = 0.02;
  int max_fold = 8;           ///< turns by 360 deg / n up to this n
  std::size_t samples = 600;  ///< of the surface that are turned
};

/// Found by laying the surface on itself: turned about the principal axes of its points, the
/// normals of its hull's larger faces and what lies between two of these.
/// @param surface_B  evenly sampled points; a grid of about options.tolerance_m or finer is not
/// needed, distances are taken to the triangles' planes at the nearest point.
/// @throws std::invalid_argument if there are fewer than 4 points, or not one normal a point
Symmetry SymmetryOf(const geometry::TriangleMesh& mesh_B, const geometry::PointCloud& surface_B,
                    const SymmetryOptions& options = {});

/// How far a pose is from another one, symmetry aside.
struct PoseDifference {
  double distance_m = 0.0;  ///< of the center
  double angle_rad = 0.0;   ///< of the turn; of a solid of revolution: between the axes
};
PoseDifference Difference(const base::Pose& X_CB, const base::Pose& other_CB,
                          const Symmetry& symmetry);

}  // namespace rangegrasp::recognition
