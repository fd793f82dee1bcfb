#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

struct MirrorOptions {
  bool go_on_outside =
      false;  ///< segment although no center inside was found (as in the chapter's evaluation)
};

/// The core: elements inside the inner hull (eq. 6.2-6.6). A face is inside if all of its vertices
/// are.
struct Core {
  Eigen::Vector3d center;
  bool center_inside = true;
  bool used_centroid = false;  ///< the smallest sphere's center was outside of the shape
  std::vector<std::uint32_t> hull_points;  ///< points whose images lie on the outer hull, ascending
  std::vector<bool> inside;                ///< one a point
};
/// Center: of the smallest enclosing sphere, else the center of gravity; nullopt if neither is
/// inside and options do not go on.
std::optional<Core> ExtractCore(const Shape& shape, const MirrorOptions& options);

}  // namespace rangegrasp::parts
