#pragma once

#include <vector>

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// What the faces of a mesh are, each.
struct FaceFrames {
  geometry::Points center;  ///< mean of the corners
  geometry::Points normal;  ///< unit
  std::vector<double> area;
  double total_area = 0.0;
};
FaceFrames BuildFaceFrames(const Shape& mesh);

}  // namespace rangegrasp::parts
