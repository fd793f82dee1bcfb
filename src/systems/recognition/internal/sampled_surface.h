#pragma once

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::recognition::internal {

/// Points drawn evenly over the triangles, then thinned to one a cell of the grid; normals are the
/// triangles'. The same mesh gives the same bytes.
geometry::PointCloud SampledSurface(const geometry::TriangleMesh& mesh, double spacing_m);

}  // namespace rangegrasp::recognition::internal
