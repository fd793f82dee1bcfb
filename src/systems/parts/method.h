#pragma once

#include <optional>
#include <string_view>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

enum class Method { kMirror, kHierarchy, kKMeans, kSdf, kCore };
constexpr std::array<std::string_view, 5> WordsOf(Method) {
  return {"mirror", "hierarchy", "kmeans", "sdf", "core"};
}

/// Options that a caller may set; all others have their defaults.
struct MethodOptions {
  std::optional<int> clusters;        ///< hierarchy: parts; kmeans, sdf: clusters; absent: default
  std::optional<double> cut_quality;  ///< hierarchy: > 0; worse cuts are not made
  bool pose_invariant = false;        ///< mirror: segment the shape with its limbs stretched out
  bool go_on_outside = false;         ///< mirror: continue if no center inside the shape is found
};

/// True if the method can also segment point clouds; all others need a mesh.
constexpr bool ReadsClouds(Method method) {
  return method == Method::kMirror || method == Method::kHierarchy;
}

/// Segments a shape with a method; options of other methods are ignored. The faces of a mesh are
/// turned outwards first.
/// @throws whatever the method throws.
Segmentation SegmentBy(Method method, const Shape& input, const MethodOptions& options);

}  // namespace rangegrasp::parts
