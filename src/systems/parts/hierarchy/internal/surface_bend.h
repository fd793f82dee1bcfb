#pragma once

#include <vector>

#include "parts/shape/face_frames.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// How much the surface bends across each edge, seen at a scale [rad; > 0 where it is concave]: the
/// curvature tensor of Cohen-Steiner and Morvan (2003) over the ball B of radius `scale` round the
/// edge, across its direction d: -sum_e beta(e) |e n B| w(e) (d . e)^2 / (2 scale), with the angle
/// beta of each edge e in B whose normal does not point away and its weight w = 2 (1 - distance /
/// scale). A long straight crease alone in the ball has its own dihedral angle. Parallel to
/// FaceGraph::neighbor. Where the mesh has more than 100,000 edges, as many, evenly taken, stand
/// for all. O(n log n) for a mesh of evenly large faces.
std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale);

/// What cutting along an edge costs: its length times exp(-gain * bend) where it is concave and
/// 1 + gain / 4 * |bend| where it is convex. Parallel to FaceGraph::neighbor.
std::vector<double> BendCosts(const Shape& mesh, const FaceGraph& faces,
                              const std::vector<double>& bends, double gain);

}  // namespace rangegrasp::parts
