#pragma once

#include <span>

#include "geometry/mesh.h"
#include "geometry/observation.h"

namespace rangegrasp::grasp {

/// Of the space that single views did not see, what none of them saw: a motion need not keep clear
/// of the shadow of one view that another view looked into. Within the bounds of what was measured,
/// by cells of cell_m (SeenSpace): a cell counts if its middle lies in one of the shadows and no
/// ray went through it.
/// @param shadows_C  convex and closed, of any of the views
/// @return upright boxes, each closed, as one mesh; none if all of it was seen.
geometry::TriangleMesh UnseenByAll(const geometry::Observation& observation,
                                   std::span<const geometry::TriangleMesh> shadows_C,
                                   double cell_m);

}  // namespace rangegrasp::grasp
