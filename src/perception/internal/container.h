#pragma once

#include <vector>

#include "geometry/plane.h"
#include "geometry/point_cloud.h"
#include "perception/feature_options.h"

namespace rangegrasp::perception::internal {

/// Takes the walls and the floor of an open box out of the segments: what stands round other things
/// is in the hand's way, and nothing to grasp. A box is known by its geometry alone: sheets that
/// stand upright along the border of one rectangle, which is wider both ways than a hand can grasp,
/// go round most of it, and leave its middle to others.
/// @return positions in the cloud, ascending; empty where there is no box.
geometry::Indices TakeContainer(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                const FeatureOptions& options,
                                std::vector<geometry::Indices>& segments);

}  // namespace rangegrasp::perception::internal
