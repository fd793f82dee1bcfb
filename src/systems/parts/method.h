#pragma once

#include <optional>
#include <string_view>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

enum class Method { kMirror, kHierarchy, kKMeans, kSdf, kCore };
constexpr std::array<std::string_view, 5> WordsOf(Method) {
  return {"mirror", "hierarchy", "kmeans", "sdf", "core"};
}

/// What a caller may choose; all else is at its default.
struct MethodOptions {
  std::optional<int> clusters;        ///< hierarchy: parts; kmeans, sdf: clusters; absent: theirs
  std::optional<int> level;           ///< hierarchy: at most so many cuts deep; core: levels, >= 1
  std::optional<double> cut_quality;  ///< hierarchy: > 0; a worse cut is not made
  bool pose_invariant = false;        ///< mirror: of the shape with its limbs stretched out
  bool go_on_outside = false;         ///< mirror: also where no center inside of the shape is found
};

/// Whether it segments point clouds, too; all others need a mesh.
constexpr bool ReadsClouds(Method method) {
  return method == Method::kMirror || method == Method::kHierarchy;
}

/// Segments with a method; options of other methods are not looked at.
/// @throws what the method throws.
Segmentation SegmentBy(Method method, const Shape& shape, const MethodOptions& options);

}  // namespace rangegrasp::parts
