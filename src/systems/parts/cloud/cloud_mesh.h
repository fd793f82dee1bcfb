#pragma once

#include "geometry/kd_tree.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// How a cloud samples a surface.
struct CloudSampling {
  double spacing = 0.0;  ///< root of the area that a point stands for
  double noise = 0.0;    ///< standard deviation of the points about the surface, along its normal
};
/// Measured at about a thousand of the points, in balls that hold the surface's neighborhood
/// however thick noise made it: noise is the residual of a quadric (six degrees of freedom less
/// than points), spacing comes from their number. Medians, so that creases, thin walls and strays
/// count little.
/// @param tree  of the points, >= 1
CloudSampling MeasureSampling(const Points& points, const geometry::KdTree& tree);

/// Points that do not lie on the surface: those that fewer than a few others lie about, within a
/// ball that would hold dozens if it were on it, and those in pieces as small.
std::vector<bool> StrayPoints(const Points& points, const geometry::KdTree& tree,
                              const CloudSampling& sampling);

/// Whether noise is more than a quarter of the spacing of points: then neighborhoods of points are
/// slabs, no surfaces.
bool IsNoisy(const CloudSampling& sampling);

/// Evenly spread points of the surface that a cloud samples.
struct SurfacePoints {
  Points points;
  double spacing = 0.0;
  double noise = 0.0;  ///< of the cloud
};
/// Strays are left out, noise and spacing measured. Points are thinned to about 15,000 and moved
/// onto the surface as far as noise asks for: to the local plane (moving least squares, Alexa et
/// al. 2003), in a ball in which it is known to a slope of 0.1. O(n log n).
SurfacePoints PointsOfSurface(const Points& points);

/// Triangles through evenly spread points of a surface, turned alike where they touch: the
/// advancing front of Cohen-Steiner and Da (2004; CGAL). Gaps wider than max_edge stay open. Ties
/// go by the points' numbers, not by addresses as CGAL's own.
std::vector<Face> AdvancingFront(const Points& points, double max_edge);

/// A mesh of the surface that a cloud samples.
struct CloudMesh {
  Shape mesh;             ///< in a frame and a unit of its own
  Indices face_of_point;  ///< the nearest face, one a point
};
/// An advancing front makes triangles of the points of the surface in canonical form, turned
/// outwards; pieces of less than 0.5 % of the area are left out, what the cloud does not show stays
/// open. Where noise tears thin limbs and walls to shreds, and more than one side was seen, the
/// mesh is wrapped (geometry::AlphaWrap): closed, a little outside of the points. Depends on
/// neither the order of the points nor on pose and scale, but for rounding. O(n log n); 100,000
/// points about a second.
/// @return without faces, if the points lie too far apart or too few of them are no strays.
CloudMesh MeshOfCloud(const Points& points);

}  // namespace rangegrasp::parts
