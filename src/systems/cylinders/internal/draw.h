#pragma once

#include "cylinders/detect.h"
#include "geometry/draw/canvas.h"

namespace rangegrasp::draw {

/// What the detection of given cylinders made of a cloud (figures 4.4, 4.7, 4.11): the table
/// grey-blue, outliers red, curvature points by normals green and by scan lines orange, the barrel
/// of every found cylinder blue, the cylinder itself in its given one's colour, its axis black.
Canvas DrawCylinders(const cylinders::CylinderScene& scene);

}  // namespace rangegrasp::draw
