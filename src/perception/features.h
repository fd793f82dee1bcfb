#pragma once

#include <vector>

#include "core/rng.h"
#include "perception/circle.h"
#include "perception/feature_options.h"
#include "perception/rotational.h"
#include "perception/scene.h"
#include "perception/sensor_view.h"
#include "perception/top_surface.h"

namespace rangegrasp::perception {

/// The radius [m] of the sphere of eq. 5.9: the options' factor times the distance from the top
/// surface's centre of gravity to the nearest rim point.
double OpenSphereRadius(const geometry::PointCloud& cloud, const TopSurface& top,
                        const FeatureOptions& options);

/// Open or closed by that sphere in the top surface's centre of gravity: open if no point (but for
/// the options' strays) is inside.
bool IsOpen(const geometry::PointCloud& cloud, const geometry::Indices& object,
            const TopSurface& top, const FeatureOptions& options);

/// Sections 5.1.3 and 5.1.4 over all segments: top surfaces, circles, merging of clipped rotational
/// parts, completion, order: topmost first, to the millimetre; then the larger.
std::vector<PerceivedObject> BuildObjects(const geometry::PointCloud& cloud,
                                          const std::vector<geometry::Indices>& segments,
                                          const geometry::Plane& table, const SensorView& view,
                                          const FeatureOptions& options, core::Rng& rng,
                                          StageSeconds& seconds);

}  // namespace rangegrasp::perception
