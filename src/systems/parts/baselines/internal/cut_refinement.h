#pragma once

#include <cstdint>
#include <vector>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// What a cut along the edges of a mesh costs (Katz and Tal 2003): an edge's length over
/// 1 + a / mean(a), a = eta (1 - cos of the dihedral angle), eta = 1 for a concave and 0.2 for a
/// convex edge. Parallel to FaceGraph::neighbor.
std::vector<double> CutCosts(const Shape& mesh, const FaceGraph& faces);

/// Moves the boundary of the faces labelled `segment` to the cheapest place not farther from it
/// than `width`, along the surface: minimum cut between the segment's faces that are farther and
/// all others. Only faces of `segment` and of label 0 change.
void RefineBoundary(const Shape& mesh, const VertexGraph& graph, const FaceGraph& faces,
                    const std::vector<double>& costs, std::int32_t segment, double width,
                    std::vector<std::int32_t>& label);

}  // namespace rangegrasp::parts
