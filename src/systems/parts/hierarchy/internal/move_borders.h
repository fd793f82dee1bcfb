#pragma once

#include <cstdint>
#include <vector>

#include "parts/shape/face_frames.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// Moves the border of any two parts to the cheapest place (sum of `costs`, parallel to
/// FaceGraph::neighbor) within `width` of where it is: a minimum cut between their faces that are
/// farther. Pairs of parts one after the other, ascending. No part vanishes.
void MoveBorders(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                 double width, std::vector<std::int32_t>& label);

}  // namespace rangegrasp::parts
