#pragma once

#include <Eigen/Core>
#include <array>
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

/// Red, green and blue as pictures hold them (sRGB, 8 bits each).
using Rgb = std::array<std::uint8_t, 3>;

/// The light that such a color stands for, each channel 0..1 (IEC 61966-2-1).
Eigen::Vector3d LightOf(const Rgb& color);
/// The nearest color of a light; what is brighter than 1 is clipped.
Rgb ColorOf(const Eigen::Vector3d& light);

}  // namespace rangegrasp::geometry
