#pragma once

#include <filesystem>

#include "cylinders/detect.h"

namespace rangegrasp::draw {

/// Draws what the detection of given cylinders made of a cloud (figures 4.4, 4.7, 4.11): the table
/// grey-blue, outliers red, curvature points by normals green and by scan lines orange, the barrel
/// of every found cylinder blue, the cylinder itself in its given one's colour, its axis black.
void DrawCylinders(const cylinders::CylinderScene& scene, const Eigen::Vector3d& sensor_origin_C,
                   const std::filesystem::path& png);

}  // namespace rangegrasp::draw
