#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// The vertices and edges of a mesh, kept to compare many labellings of its faces.
class CutMeasure {
 public:
  explicit CutMeasure(const Shape& mesh);

  /// Cut discrepancy (Chen et al. 2009): for every vertex on a cut of one labelling the shortest
  /// distance along edges to a cut of the other, both ways, averaged over all those vertices,
  /// divided by the area-weighted mean distance of the surface to its centroid. nullopt where one
  /// of the two has no cut. Where no edges lead from a vertex to a cut of the other labelling (a
  /// mesh in several pieces), the straight distance counts. O(n log n).
  /// @throws std::invalid_argument if a length is not the number of faces.
  std::optional<double> Discrepancy(std::span<const std::int32_t> a,
                                    std::span<const std::int32_t> b) const;

 private:
  std::vector<std::uint32_t> CutVertices(std::span<const std::int32_t> label) const;
  double SumOfDistances(const std::vector<std::uint32_t>& from,
                        const std::vector<std::uint32_t>& to) const;

  geometry::Points points_;
  FaceGraph faces_;
  VertexGraph vertices_;
  double radius_ = 0.0;  ///< mean distance of the surface to its centroid
};

/// The same for a single comparison.
std::optional<double> CutDiscrepancy(const Shape& mesh, std::span<const std::int32_t> a,
                                     std::span<const std::int32_t> b);

}  // namespace rangegrasp::parts
