#pragma once

#include <span>

#include "geometry/graph.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};
/// The exact smallest enclosing sphere (Gaertner 1999; CGAL).
Sphere SmallestEnclosingSphere(geometry::PointSpan points);
/// The smallest sphere around a given center that contains the points (R of eq. 6.1).
Sphere SphereRound(const Eigen::Vector3d& center, geometry::PointSpan points);

/// Eq. 6.2: moves p as far outside the sphere as it was inside. A point at the center moves along
/// +x.
Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere);
/// MirrorOut for all points.
Points MirrorOut(geometry::PointSpan points, const Sphere& sphere);
/// Eq. 6.5, with the sign that maps a mirrored point back: to its old radius plus 2 * offset.
Eigen::Vector3d MirrorIn(const Eigen::Vector3d& mirrored, const Sphere& sphere, double offset);
/// Mean of | |p_n - C| - |p - C| |, eq. 6.4 (cloud: neighbors nearer than d_max, the largest of all
/// nearest-neighbor distances) and 6.7 (mesh: vertices joined by an edge); 0 without neighbors.
double Offset(const Eigen::Vector3d& p, std::span<const Eigen::Vector3d> neighbors,
              const Eigen::Vector3d& center);

/// The cell of a direction on a cube with side^2 cells per face; 0 for a zero vector.
std::size_t CubeCell(const Eigen::Vector3d& direction, int side);

/// Order of the points along a Z-order curve (Morton 1966): points close in space are close in
/// memory, so that searching a large cloud point by point does not wait for memory. O(n log n).
Indices SpatialOrder(geometry::PointSpan points);

/// Tests whether points lie inside a convex hull.
class HullSide {
 public:
  /// A hull made by geometry::ConvexHull; if it is empty, nothing is inside.
  HullSide(const geometry::TriangleMesh& hull, const Eigen::Vector3d& center);

  /// Where the last search ended: consecutive query points are often close to each other.
  struct Hint {
    std::uint32_t facet = 0;
  };
  /// True inside or on the hull, to a billionth of its size. If the center is inside, the facet
  /// through which the ray from it to p leaves is searched for uphill over neighboring facets,
  /// starting at the hint: O(sqrt(facets)), less with a good hint. Otherwise all facets are tested.
  bool Contains(const Eigen::Vector3d& p, Hint& hint) const;
  /// True if p is inside and not within that tolerance of the hull; false if the center is outside.
  bool ContainsWell(const Eigen::Vector3d& p, Hint& hint) const;

 private:
  // x is relative to the center: n . x <= 1, or n . x <= offset if the center is outside.
  struct Facet {
    Eigen::Vector3d normal;
    double offset;
  };
  void LinkFacets(const geometry::TriangleMesh& hull);
  double Highest(const Eigen::Vector3d& d, Hint& hint) const;

  Eigen::Vector3d center_;
  std::vector<Facet> facets_;
  geometry::Adjacency neighbors_;  // facets that share an edge
  bool center_inside_ = false;
  double inner_squared_ = 0.0;  // squared radii of the inscribed and the enclosing sphere
  double outer_squared_ = 0.0;
};

}  // namespace rangegrasp::parts
