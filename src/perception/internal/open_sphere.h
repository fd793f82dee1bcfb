#pragma once

#include "perception/feature_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// The radius [m] of the sphere of eq. 5.9: the options' factor times the distance from the top
/// surface's center of gravity to the nearest rim point; 0 without a rim.
double OpenSphereRadius(const geometry::PointCloud& cloud, const TopSurface& top,
                        const FeatureOptions& options);

/// Open or closed by that sphere in the top surface's center of gravity: open if no point (but for
/// the options' strays) is inside.
bool IsOpen(const geometry::PointCloud& cloud, const geometry::Indices& object,
            const TopSurface& top, const FeatureOptions& options);

}  // namespace rangegrasp::perception::internal
