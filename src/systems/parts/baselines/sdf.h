#pragma once

#include "base/units.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

struct SdfOptions {
  int clusters = 5;  ///< CGAL's defaults
  double smoothing = 0.26;
  int rays = 25;
  double cone_rad = 2.0 / 3.0 * base::kPi;
};
/// Shape diameter function (Shapira et al. 2008) by CGAL. Meshes only.
Segmentation SegmentBySdf(const Shape& shape, const SdfOptions& options);

}  // namespace rangegrasp::parts
