#pragma once

#include <vector>

#include "geometry/plane.h"
#include "geometry/point_cloud.h"
#include "perception/feature_options.h"

namespace rangegrasp::perception::internal {

/// The walls of an open box: what stands round other things is in the hand's way, and nothing to
/// grasp. A box is known by its geometry alone: sheets that stand upright along the border of one
/// rectangle, which is wider both ways than a hand can grasp, and go round most of it. Its walls
/// are all points at that border up to the rim.
/// @param segments  those of all points, the walls' among them; a thing that touches the rim may be
/// in one segment with its wall.
/// @return positions in the cloud, ascending; empty where there is no box.
geometry::Indices FindContainer(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                const ContainerOptions& options,
                                const std::vector<geometry::Indices>& segments);

}  // namespace rangegrasp::perception::internal
