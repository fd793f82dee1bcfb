#include "parts/cloud/cloud_mesh.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "geometry/plane.h"
#include "mesh/solid.h"
#include "parts/cloud/internal/seen_side.h"
#include "parts/cloud/internal/surface_points.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;

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

/// A vertex that says how its edges are queued by the front: by priority, as CGAL's own, but ties
/// by the numbers of their points. CGAL breaks them by addresses, and edges that wait for a wider
/// gap are all ties, so that a mesh would depend on the heap.
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

/// Gaps that are bridged, in spacings: a random sample has some of three, a scan more.
constexpr double kMaxGap = 6.0;
/// Of the area, below which a piece is no part of the surface; as HierarchyOptions::min_area.
constexpr double kMinPiece = 0.005;

/// Noise, in spacings, from which what is thin crumbles: both of its sides become one, in shreds.
/// Of the models for tuning 0.5 % of noise is 0.40 to 1.5, 0.3 % is 0.24 to 0.7.
constexpr double kCrumbles = 0.35;
/// Of the wrap, in spacings: radius of what is bridged, and how far it stands off. On the tuning
/// models with 0.5 % of noise 1.5 and 0.5 give the same, 3 and 1 blunt creases; both cost time or
/// borders.
constexpr double kBridged = 2.0, kOffset = 0.5;

/// Whether a mesh has to be wrapped to be whole. What is seen from one side would get a far side.
bool IsInShreds(const Shape& mesh, const SurfacePoints& surface) {
  return surface.noise > kCrumbles * surface.spacing &&
         FewestLayers(mesh) > SeenSideOptions{}.max_layers;
}

void LeaveSmallPiecesOut(Shape& mesh) {
  const FaceGraph graph = BuildFaceGraph(mesh);
  const FaceFrames frames = BuildFaceFrames(mesh);
  Labels piece;
  const std::int32_t count = LabelPieces(graph, std::vector<bool>(mesh.faces.size(), true), piece);
  std::vector<double> area(count, 0.0);
  for (std::size_t f = 0; f < piece.size(); ++f) area[piece[f]] += frames.area[f];
  std::size_t kept = 0;
  for (std::size_t f = 0; f < piece.size(); ++f) {
    if (area[piece[f]] < kMinPiece * frames.total_area) continue;
    mesh.faces[kept++] = mesh.faces[f];
  }
  mesh.faces.resize(kept);
}

}  // namespace

std::vector<Face> AdvancingFront(const Points& points, double max_edge) {
  std::vector<std::pair<FrontKernel::Point_3, std::size_t>> input;
  for (const Eigen::Vector3d& p : points) input.push_back({{p.x(), p.y(), p.z()}, input.size()});
  Delaunay delaunay(input.begin(), input.end());
  CGAL::Advancing_front_surface_reconstruction<Delaunay, ShortEdgesOnly> front(
      delaunay, ShortEdgesOnly{max_edge});
  front.run();
  std::vector<std::array<std::size_t, 3>> found;
  CGAL::write_triple_indices(std::back_inserter(found), front);
  std::vector<Face> faces;
  const auto number = [](std::size_t v) { return static_cast<std::uint32_t>(v); };
  for (const auto& [a, b, c] : found) faces.push_back({number(a), number(b), number(c)});
  return faces;
}

CloudMesh MeshOfCloud(const Points& points) {
  const CanonicalCloud canonical = MakeCanonicalCloud(points);
  SurfacePoints surface = PointsOfSurface(canonical.points);
  CloudMesh result;
  Shape& mesh = result.mesh;
  mesh.points = std::move(surface.points);
  // Flat, or all but: it would have no third dimension to triangulate.
  if (geometry::IsFlat(mesh.points)) return {};
  mesh.faces = AdvancingFront(mesh.points, kMaxGap * surface.spacing);
  if (mesh.faces.empty()) return {};
  mesh.faces = TurnedOutwards(mesh);
  LeaveSmallPiecesOut(mesh);
  if (IsInShreds(mesh, surface)) {
    const geometry::TriangleMesh wrap = geometry::AlphaWrap(
        {mesh.points, mesh.faces}, kBridged * surface.spacing, kOffset * surface.spacing);
    mesh.points = wrap.vertices;
    mesh.faces = wrap.triangles;
  }
  const FaceFrames frames = BuildFaceFrames(mesh);
  const KdTree faces(frames.center);
  std::vector<KdTree::Neighbor> near;
  result.face_of_point.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    faces.Nearest(canonical.points[i], 1, near);
    result.face_of_point[canonical.origin[i]] = near.front().index;
  }
  return result;
}

}  // namespace rangegrasp::parts
