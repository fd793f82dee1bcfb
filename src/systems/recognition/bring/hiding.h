#pragma once

#include "geometry/observation.h"
#include "recognition/bring/understanding.h"
#include "recognition/library.h"

namespace rangegrasp::bring {

/// The area of the table [m^2] over which nothing was seen, low above it, in any view, and no known
/// object stands: there another one may stand. Counted in cells of 10 mm, from 10 mm (what noise
/// makes of the table) to 40 mm above it.
/// @param radius_m  about middle_C, a place on the table
double HidingArea(const geometry::Observation& observation, const Understanding& understanding,
                  const recognition::Library& library, const Eigen::Vector3d& middle_C,
                  double radius_m);

/// The area of the smallest face of an object's box [m^2]: it may stand on that.
double SmallestFootprint(const recognition::KnownObject& object);

}  // namespace rangegrasp::bring
