#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/mesh_colors.h"

namespace rangegrasp::recognition::internal {

/// A color as its distance to others is measured: the shares of red and of blue in its light, which
/// the light's brightness leaves as they are, and less of the logarithm of its brightness, for a
/// face that is turned from the lamps is darker.
Eigen::Vector3f ToneOf(const geometry::Rgb& color);

/// The tones of a mesh's colors, ready to be asked for often.
class MeshTones {
 public:
  /// @param colors  kept: must outlive it
  explicit MeshTones(const geometry::MeshColors& colors);

  bool known() const { return !print_.empty() || !plain_.empty(); }
  /// NaN where the color is not known.
  Eigen::Vector3f At(const geometry::Hit& hit) const;

 private:
  const geometry::MeshColors* colors_;
  std::vector<Eigen::Vector3f> print_;  // of each texel
  std::vector<Eigen::Vector3f> plain_;  // of each triangle
};

}  // namespace rangegrasp::recognition::internal
