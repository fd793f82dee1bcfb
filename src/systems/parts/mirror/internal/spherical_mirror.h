#pragma once

#include <span>

#include "geometry/graph.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};
/// The exact smallest enclosing sphere (Gaertner 1999; CGAL). @throws std::invalid_argument without
/// points.
Sphere SmallestEnclosingSphere(geometry::PointSpan points);
/// The smallest sphere round a given center that holds the points (R of eq. 6.1).
Sphere SphereRound(const Eigen::Vector3d& center, geometry::PointSpan points);

/// Eq. 6.2: outside of the sphere, as far as p was inside of it. A point in the center goes along
/// +x.
Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere);
/// The same of all points.
Points MirrorOut(geometry::PointSpan points, const Sphere& sphere);
/// Eq. 6.5 with the sign that brings a mirrored point back: to its own radius plus 2 * offset.
Eigen::Vector3d MirrorIn(const Eigen::Vector3d& mirrored, const Sphere& sphere, double offset);
/// Eq. 6.4 (cloud: neighbors nearer than d_max, the largest of all nearest-neighbor distances)
/// and 6.7 (mesh: vertices joined by an edge): the mean of | |p_n - C| - |p - C| |; 0 without
/// neighbors.
double Offset(const Eigen::Vector3d& p, std::span<const Eigen::Vector3d> neighbors,
              const Eigen::Vector3d& center);

/// The cell of a direction on a cube whose faces are cut into side^2 cells; 0 for a zero vector.
std::size_t CubeCell(const Eigen::Vector3d& direction, int side);

/// The points along a Z-order curve (Morton 1966): what is near in space is near in memory, so that
/// searching a large cloud point after point does not wait for memory. O(n log n).
Indices SpatialOrder(geometry::PointSpan points);

/// On which side of a convex hull points lie.
class HullSide {
 public:
  /// A hull as geometry::ConvexHull makes it; empty: nothing is inside.
  HullSide(const geometry::TriangleMesh& hull, const Eigen::Vector3d& center);

  /// Where the last search ended: points that are asked for one after the other are often near.
  struct Hint {
    std::uint32_t facet = 0;
  };
  /// Inside or on the hull, to a billionth of its size. If the center is inside: the facet that the
  /// ray from it to p leaves through is searched for from the hint, uphill over neighboring
  /// facets; O(sqrt(facets)), less with a good hint. Else all facets are tried.
  bool Contains(const Eigen::Vector3d& p, Hint& hint) const;
  /// Inside and not nearer to the hull than that; false if the center is outside.
  bool ContainsWell(const Eigen::Vector3d& p, Hint& hint) const;

 private:
  // A facet n . x <= 1 round the center, or n . x <= offset if the center is outside.
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
  double inner_squared_ = 0.0;  // of the sphere that fits in, and of the one round it
  double outer_squared_ = 0.0;
};

}  // namespace rangegrasp::parts
