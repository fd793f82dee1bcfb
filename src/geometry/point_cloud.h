#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace rangegrasp::geometry {

using Points = std::vector<Eigen::Vector3d>;
using PointSpan = std::span<const Eigen::Vector3d>;
/// Positions in a cloud.
using Indices = std::vector<std::uint32_t>;

/// Points [m] of one frame; normals are absent or one a point (unit length).
struct PointCloud {
  Points points;
  Points normals;

  std::size_t size() const { return points.size(); }
};

/// points[indices[0]], points[indices[1]], ...
Points Select(PointSpan points, std::span<const std::uint32_t> indices);

/// The mean of n >= 1 points.
/// @throws std::invalid_argument if there is none.
Eigen::Vector3d Centroid(PointSpan points);

}  // namespace rangegrasp::geometry
