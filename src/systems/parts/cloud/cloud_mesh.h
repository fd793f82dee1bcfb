#pragma once

#include "geometry/kd_tree.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Density and noise with which a cloud samples a surface.
struct CloudSampling {
  double spacing = 0.0;  ///< square root of the surface area per point
  double noise = 0.0;    ///< standard deviation of the points from the surface, along its normal
};
/// Measures noise and spacing at about a thousand of the points, in balls that contain the
/// surface's neighborhood at any noise level. Noise is the residual of a fitted quadric (n - 6
/// degrees of freedom for n points); spacing follows from the number of points. Both are medians,
/// so that creases, thin walls and outliers have little influence.
/// @param tree  k-d tree of the points; at least one point
CloudSampling MeasureSampling(const Points& points, const geometry::KdTree& tree);

/// Outliers: points with only a few others within a ball that would contain dozens on the surface,
/// and points in groups of that size.
std::vector<bool> StrayPoints(const Points& points, const geometry::KdTree& tree,
                              const CloudSampling& sampling);

/// Evenly spread points on the surface that a cloud samples.
struct SurfacePoints {
  Points points;
  double spacing = 0.0;
  double noise = 0.0;  ///< noise of the cloud
};
/// Removes outliers, and measures noise and spacing. Thins the points to about 15,000 and, as far
/// as the noise requires, projects them onto the local plane (moving least squares, Alexa et al.
/// 2003). The plane is fitted in a ball in which its slope is known to 0.1. O(n log n).
SurfacePoints PointsOfSurface(const Points& points);

/// Triangulates evenly spread points of a surface by the advancing front of Cohen-Steiner and Da
/// (2004; CGAL). Adjacent triangles are oriented consistently. Gaps wider than max_edge stay open.
/// Ties are broken by the numbers of the points, not by addresses as in CGAL.
std::vector<Face> AdvancingFront(const Points& points, double max_edge);

/// A mesh of the surface that a cloud samples.
struct CloudMesh {
  Shape mesh;             ///< in its own frame and unit
  Indices face_of_point;  ///< per point: the nearest face
};
/// Triangulates the surface points in canonical form by an advancing front and orients the
/// triangles outwards. Pieces of less than 0.5 % of the area are dropped; regions that the cloud
/// does not show stay open. If noise fragments thin limbs and walls and more than one side was
/// seen, the mesh is wrapped (geometry::AlphaWrap): it is then closed and lies slightly outside of
/// the points. Except for rounding, the result does not depend on the order of the points, pose or
/// scale. O(n log n); 100,000 points take about a second.
/// @return a result without faces if the points lie too far apart or too few of them are inliers.
CloudMesh MeshOfCloud(const Points& points);

}  // namespace rangegrasp::parts
