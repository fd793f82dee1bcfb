#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/mesh.h"

namespace rangegrasp::parts {

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
  std::vector<std::uint32_t> begin_, neighbor_;  // facets that share an edge
  bool center_inside_ = false;
  double inner_squared_ = 0.0;  // of the sphere that fits in, and of the one round it
  double outer_squared_ = 0.0;
};

}  // namespace rangegrasp::parts
