#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "geometry/point_cloud.h"

namespace rangegrasp::pcl_bridge {

/// Points as the Point Cloud Library keeps them, made once and given to any number of calls.
///
/// Making one copies: the library's points are four floats (16 bytes), ours three doubles. They are
/// stored relative to `origin`, the place that they were seen from: the library turns normals
/// towards zero, and single precision is finest there (0.06 um at 1 m). Points that are not finite
/// are left out. Results count as if none of this were so: indices and labels are positions in the
/// points given, lengths and places are in their frame.
///
/// Immutable; a copy shares the points. The first one made in a process silences the library's
/// messages on the console for good: what they would say is in the results here.
class Cloud {
 public:
  /// @param points  n >= 0 points [m]; not needed afterwards.
  /// @param origin  where the sensor stood [m], in their frame.
  /// @throws std::invalid_argument if origin is not finite.
  explicit Cloud(geometry::PointSpan points,
                 const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

  /// The number of points given, finite or not.
  std::size_t size() const;
  const Eigen::Vector3d& origin() const;

  /// The points at these positions, without the way through doubles; they count anew from 0.
  /// @throws std::invalid_argument if a position is not below size().
  Cloud Select(std::span<const std::uint32_t> indices) const;

  /// What the module's sources see of it (internal/cloud_data.h).
  struct Data;
  explicit Cloud(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

}  // namespace rangegrasp::pcl_bridge
