#include "parts/method.h"

#include <stdexcept>

#include "parts/baselines/baselines.h"
#include "parts/hierarchy/hierarchy.h"
#include "parts/mirror/mirroring.h"
#include "parts/shape/shape_graph.h"
#include "parts/stretched/embedding.h"

namespace rangegrasp::parts {

Segmentation SegmentBy(Method method, const Shape& input, const MethodOptions& options) {
  // Which edges are concave depends on it, and files often mix orientations. Mirroring needs no
  // edges.
  Shape shape = input;
  if (shape.IsMesh() && method != Method::kMirror) shape.faces = TurnedOutwards(input);
  switch (method) {
    case Method::kMirror:
      // An embedding intersects itself, so that a center outside of it says nothing about the
      // shape.
      return options.pose_invariant
                 ? SegmentByMirroring(PoseInvariant(shape), /*go_on_outside=*/true)
                 : SegmentByMirroring(shape, options.go_on_outside);
    case Method::kHierarchy: {
      HierarchyOptions hierarchy{.parts = options.clusters};
      hierarchy.cut_quality = options.cut_quality.value_or(hierarchy.cut_quality);
      return SegmentHierarchy(shape, hierarchy);
    }
    case Method::kKMeans:
      return SegmentByKMeans(shape, {.clusters = options.clusters.value_or(kDefaultClusters)});
    case Method::kSdf:
      return SegmentBySdf(shape, options.clusters.value_or(kDefaultClusters));
    case Method::kCore:
      return SegmentByCoreExtraction(shape);
  }
  throw std::invalid_argument("SegmentBy: no such method");
}

}  // namespace rangegrasp::parts
