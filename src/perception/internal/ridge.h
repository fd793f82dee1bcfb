#pragma once

#include <optional>

#include "geometry/plane.h"
#include "geometry/point_cloud.h"
#include "perception/feature_options.h"

namespace rangegrasp::perception::internal {

/// A ridge: the surface next to it curves (or is folded) about `axis`, and is highest there.
struct Ridge {
  Eigen::Vector3d axis;    ///< unit
  Eigen::Vector3d normal;  ///< unit, across the axis, away from the table
  Eigen::Vector3d point;   ///< on the ridge
};

/// Looks at the normals of the segment's upward points. One direction that they are all square to
/// and a wide spread about it make a ridge, which lies where the normal passes through the vertical
/// plane of the axis: with u the offset across the axis and theta the normal's turn about it, u is
/// fitted by a line over sin(theta), and the ridge is at theta = 0. For a circle, an ellipse or a
/// roof alike that is its highest line.
/// @return nullopt where the upward points are no ridge (RidgeOptions says what is asked of one).
std::optional<Ridge> FindRidge(const geometry::PointCloud& cloud, const geometry::Indices& segment,
                               const geometry::Plane& table, const FeatureOptions& options);

/// The points of the segment whose normals are within the angle of `up`.
geometry::Indices UpwardPoints(const geometry::PointCloud& cloud, const geometry::Indices& segment,
                               const Eigen::Vector3d& up, double angle_rad);

}  // namespace rangegrasp::perception::internal
