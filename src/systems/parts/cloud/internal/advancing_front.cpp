#include "parts/cloud/internal/advancing_front.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <tuple>
#include <utility>

namespace rangegrasp::parts {
namespace {

using FrontKernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// A vertex or cell that CGAL compares by the order of creation, not by its address.
template <class Base>
class Stamped : public Base {
 public:
  template <class Tds>
  struct Rebind_TDS {
    using Other = Stamped<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  using Has_timestamp = CGAL::Tag_true;
  using Base::Base;

  std::size_t time_stamp() const { return stamp_; }
  void set_time_stamp(std::size_t stamp) { stamp_ = stamp; }

 private:
  std::size_t stamp_ = static_cast<std::size_t>(-1);
};

/// A vertex that tells the front how its edges are queued: by priority, as CGAL's own, but ties by
/// the numbers of their points. CGAL breaks them by addresses, and edges that wait for a wider gap
/// are all ties, so that a mesh would depend on the heap.
template <class Base>
class QueuedByPoints : public Base {
 public:
  template <class Tds>
  struct Rebind_TDS {
    using Other = QueuedByPoints<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  using Base::Base;

  struct Radius_ptr_type {
    Radius_ptr_type(typename Base::criteria priority, typename Base::IO_edge_type* edge)
        : first(priority), second(edge) {
      const auto& [cell, i, j] = edge->first.first;
      ends = std::minmax({cell->vertex(i)->info(), cell->vertex(j)->info()});
    }
    bool operator<(const Radius_ptr_type& other) const {
      return std::tie(first, ends) < std::tie(other.first, other.ends);
    }

    typename Base::criteria first;
    typename Base::IO_edge_type* second;
    std::pair<std::size_t, std::size_t> ends;
  };
};

using Vertex = QueuedByPoints<
    Stamped<CGAL::Advancing_front_surface_reconstruction_vertex_base_3<FrontKernel>>>;
using FrontCell = Stamped<CGAL::Advancing_front_surface_reconstruction_cell_base_3<FrontKernel>>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<FrontKernel,
                                   CGAL::Triangulation_data_structure_3<Vertex, FrontCell>>;

/// Which triangle comes first: that of the smallest ball, as CGAL's own; never one with a long
/// edge.
struct ShortEdgesOnly {
  double max_edge;

  template <class Front, class FrontCell>
  double operator()(const Front& front, FrontCell& cell, const int& index) const {
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
  std::vector<std::pair<FrontKernel::Point_3, std::size_t>> input;
  for (const Eigen::Vector3d& p : points) input.push_back({{p.x(), p.y(), p.z()}, input.size()});
  Delaunay delaunay(input.begin(), input.end());
  CGAL::Advancing_front_surface_reconstruction<Delaunay, ShortEdgesOnly> front(
      delaunay, ShortEdgesOnly{max_edge});
  front.run();
  std::vector<std::array<std::size_t, 3>> found;
  CGAL::write_triple_indices(std::back_inserter(found), front);
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (const auto& [a, b, c] : found) {
    faces.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                     static_cast<std::uint32_t>(c)});
  }
  return faces;
}

}  // namespace rangegrasp::parts
