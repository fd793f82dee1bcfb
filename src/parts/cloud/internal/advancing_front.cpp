#include "parts/cloud/internal/advancing_front.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <iterator>

namespace rangegrasp::parts {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// Which triangle comes first: that of the smallest ball, as CGAL's own; never one with a long
/// edge.
struct ShortEdgesOnly {
  double max_edge;

  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, const int& index) const {
    const auto is_long = [&](int i, int j) {
      return CGAL::squared_distance(cell->vertex((index + i) % 4)->point(),
                                    cell->vertex((index + j) % 4)->point()) > max_edge * max_edge;
    };
    if (is_long(1, 2) || is_long(2, 3) || is_long(3, 1)) return front.infinity();
    return front.smallest_radius_delaunay_sphere(cell, index);
  }
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> AdvancingFront(const geometry::Points& points,
                                                         double max_edge) {
  std::vector<Kernel::Point_3> input;
  for (const Eigen::Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::array<std::size_t, 3>> found;
  CGAL::advancing_front_surface_reconstruction(input.begin(), input.end(),
                                               std::back_inserter(found), ShortEdgesOnly{max_edge});
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (const auto& [a, b, c] : found) {
    faces.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                     static_cast<std::uint32_t>(c)});
  }
  return faces;
}

}  // namespace rangegrasp::parts
