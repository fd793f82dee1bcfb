#include "mesh/solid.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_with_circumcenter_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Poisson_reconstruction_function.h>
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Random.h>
#include <CGAL/Robust_circumcenter_traits_3.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_cell_base_3.h>
#include <CGAL/Surface_mesh_complex_2_in_triangulation_3.h>
#include <CGAL/Surface_mesh_default_criteria_3.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/Surface_mesh_vertex_base_3.h>
#include <CGAL/alpha_wrap_3.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <CGAL/make_surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "geometry/plane.h"

namespace rangegrasp::geometry {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// A vertex or cell that CGAL compares by its age instead of its address, so that their order is
/// the same in every process.
template <class Base>
class Aged : public Base {
 public:
  using Base::Base;
  using Has_timestamp = CGAL::Tag_true;
  template <class Tds>
  struct Rebind_TDS {  // names required by CGAL
    using Other = Aged<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  std::size_t time_stamp() const { return age_; }
  void set_time_stamp(const std::size_t& age) { age_ = age; }

 private:
  std::size_t age_ = static_cast<std::size_t>(-1);  // CGAL's mark for a new one
};

// A separate type, so that the specialization below changes nothing else.
struct PoissonKernel : Kernel {};
using PoissonTraits = CGAL::Reconstruction_triangulation_default_geom_traits_3<
    CGAL::Robust_circumcenter_filtered_traits_3<PoissonKernel>>;

}  // namespace
}  // namespace rangegrasp::geometry

namespace CGAL {

/// The cells that Poisson_reconstruction_function refines. Its queue sorts equally bad cells by
/// comparing them, which without an age would compare addresses. The function has no parameter for
/// the cell type, hence this specialization.
template <class Base>
class Triangulation_cell_base_with_info_3<int, rangegrasp::geometry::PoissonTraits, Base>
    : public rangegrasp::geometry::Aged<Triangulation_cell_base_with_info_3<
          std::size_t, rangegrasp::geometry::PoissonTraits, Base>> {};

}  // namespace CGAL

namespace rangegrasp::geometry {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
namespace sms = CGAL::Surface_mesh_simplification;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;

/// A polygon soup, as CGAL calls it.
struct Soup {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> faces;
};

Soup ToSoup(const TriangleMesh& mesh) {
  Soup soup;
  soup.points.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices) soup.points.emplace_back(p.x(), p.y(), p.z());
  soup.faces.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) soup.faces.push_back({a, b, c});
  return soup;
}

Surface ToSurface(Soup soup) {
  Surface surface;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.faces, surface);
  return surface;
}

// Vertices and faces in the surface's own order, which depends only on the input.
TriangleMesh FromSurface(Surface& surface) {
  surface.collect_garbage();
  TriangleMesh mesh;
  for (const auto v : surface.vertices()) {
    const Point& p = surface.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : surface.faces()) {
    std::array<std::uint32_t, 3> corners{};
    std::size_t i = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f))) {
      corners.at(i++) = static_cast<std::uint32_t>(v.idx());
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

// Merges vertices, removes triangles without area, and orients the others consistently.
Surface Assemble(const TriangleMesh& mesh, std::vector<std::string>& done) {
  Soup soup = ToSoup(mesh);
  pmp::merge_duplicate_points_in_polygon_soup(soup.points, soup.faces);
  const auto flat = std::erase_if(soup.faces, [&](const std::vector<std::size_t>& f) {
    return CGAL::collinear(soup.points[f[0]], soup.points[f[1]], soup.points[f[2]]);
  });
  if (flat > 0) done.push_back(base::Counted(flat, "triangle") + " without area removed");
  const std::size_t before = soup.faces.size();
  pmp::merge_duplicate_polygons_in_polygon_soup(soup.points, soup.faces);
  if (const std::size_t twice = before - soup.faces.size(); twice > 0) {
    done.push_back(base::Counted(twice, "triangle") + " removed as duplicates");
  }
  if (soup.faces.empty()) throw base::InputError("has no triangle with an area");
  const std::size_t points = soup.points.size();
  // False if it had to duplicate vertices: edges with three triangles, or a Moebius strip.
  if (!pmp::orient_polygon_soup(soup.points, soup.faces) && soup.points.size() > points) {
    done.push_back(base::Counted(soup.points.size() - points, "point") +
                   " split where surfaces meet");
  }
  Surface surface = ToSurface(std::move(soup));
  if (const std::size_t seams = pmp::stitch_borders(surface); seams > 0) {
    done.push_back(base::Counted(seams, "pair") + " of borders stitched");
  }
  return surface;
}

double DiagonalOf(const CGAL::Bbox_3& box) {
  return std::hypot(box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin());
}

double DiagonalOf(const Surface& surface) { return DiagonalOf(pmp::bbox(surface)); }

double WidthOf(const Surface& surface, Surface::Halfedge_index border) {
  CGAL::Bbox_3 box;
  for (const auto h : CGAL::halfedges_around_face(border, surface)) {
    box += surface.point(surface.target(h)).bbox();
  }
  return DiagonalOf(box);
}

// Whether the border is a straight line there and back, as left by a triangle without area.
bool IsSlit(const Surface& surface, Surface::Halfedge_index border) {
  const Point& a = surface.point(surface.source(border));
  const Point& b = surface.point(surface.target(border));
  const auto around = CGAL::halfedges_around_face(border, surface);
  return std::all_of(around.begin(), around.end(), [&](const auto h) {
    return CGAL::collinear(a, b, surface.point(surface.target(h)));
  });
}

// Closes a hole by triangles around the center of its border. Used if CGAL finds no patch, since
// every patch would have an edge that already exists. The triangles may intersect the surface.
void CloseByFan(Surface::Halfedge_index border, Surface& surface) {
  Kernel::Vector_3 sum(0.0, 0.0, 0.0);
  double count = 0.0;
  for (const auto h : CGAL::halfedges_around_face(border, surface)) {
    sum = sum + (surface.point(surface.target(h)) - CGAL::ORIGIN);
    count += 1.0;
  }
  CGAL::Euler::fill_hole(border, surface);
  const auto middle = CGAL::Euler::add_center_vertex(border, surface);
  surface.point(surface.target(middle)) = CGAL::ORIGIN + sum / count;
}

// Closes small holes. The error for a too large hole states the width of the largest one.
void CloseHoles(double max_hole, Surface& surface, std::vector<std::string>& done) {
  std::vector<Surface::Halfedge_index> borders;
  pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
  if (borders.empty()) return;
  const double diagonal = DiagonalOf(surface);
  double widest = 0.0;
  for (const auto border : borders) {
    if (!IsSlit(surface, border)) widest = std::max(widest, WidthOf(surface, border));
  }
  if (widest > max_hole * diagonal) {
    throw base::InputError(fmt::format(
        "is open: the widest of {} is {:.0f} % of its size across. Close it in a mesh editor (a "
        "cup's wall needs a thickness), or close every hole with --fill-holes",
        base::Counted(borders.size(), "hole"), 100.0 * widest / diagonal));
  }
  for (const auto border : borders) {
    std::vector<Surface::Face_index> patch;
    pmp::triangulate_hole(surface, border, std::back_inserter(patch));
    if (patch.empty()) CloseByFan(border, surface);
  }
  done.push_back(fmt::format("{} closed, the widest {:.1f} % of its size across",
                             base::Counted(borders.size(), "hole"), 100.0 * widest / diagonal));
}

/// A closed convex mesh as planes that face outward.
struct Convex {
  std::vector<Plane> planes;
  Eigen::AlignedBox3d box;

  explicit Convex(const TriangleMesh& mesh) : box(BoundsOf(mesh.vertices)) {
    for (const auto& [a, b, c] : mesh.triangles) {
      const Eigen::Vector3d normal = (mesh.vertices[b] - mesh.vertices[a])
                                         .cross(mesh.vertices[c] - mesh.vertices[a])
                                         .normalized();
      planes.push_back(PlaneAt(normal, mesh.vertices[a]));
    }
  }
  bool Holds(const Eigen::Vector3d& p) const {
    return box.contains(p) && std::ranges::all_of(planes, [&](const Plane& plane) {
             return plane.Distance(p) <= 0.0;
           });
  }
};

using MesherKernel = CGAL::Robust_circumcenter_traits_3<Kernel>;
using MesherCell = CGAL::Delaunay_triangulation_cell_base_with_circumcenter_3<
    MesherKernel, CGAL::Surface_mesh_cell_base_3<MesherKernel>>;
using MesherTriangulation = CGAL::Delaunay_triangulation_3<
    MesherKernel, CGAL::Triangulation_data_structure_3<
                      Aged<CGAL::Surface_mesh_vertex_base_3<MesherKernel>>, Aged<MesherCell>>>;

/// Meshes the zero set of a function within a sphere (Boissonnat and Oudot 2005). Empty if the
/// mesher's initial points are on surfaces too far apart for a facet.
/// @throws base::InputError once it has been evaluated `max_evaluations` times.
template <class Function>
Surface MeshOf(const Function& function, const Kernel::Sphere_3& sphere, double spacing_m,
               std::size_t max_evaluations) {
  // The minimum angle is CGAL's choice. Triangles are two thirds as large as CGAL's, for small
  // objects.
  constexpr double kMinAngle_deg = 20.0;
  constexpr double kMaxRadius = 20.0;
  constexpr double kMaxDistance = 0.25;
  constexpr double kError = 1e-3;  // of an intersection's position, relative to the max. distance
  std::size_t evaluations = 0;
  const auto counted = [&](const Point& p) {
    if (++evaluations > max_evaluations) {
      throw base::InputError(
          "the surface does not converge: the points are not a single object on a table");
    }
    return function(p);
  };
  using Implicit = CGAL::Implicit_surface_3<Kernel, decltype(counted)>;
  const Implicit implicit(counted, sphere,
                          kError * kMaxDistance * spacing_m / std::sqrt(sphere.squared_radius()));
  // The mesher draws its initial points from CGAL's generator. By default the clock seeds it.
  CGAL::get_default_random() = CGAL::Random(0);
  MesherTriangulation triangulation;
  CGAL::Surface_mesh_complex_2_in_triangulation_3<MesherTriangulation> complex(triangulation);
  const CGAL::Surface_mesh_default_criteria_3<MesherTriangulation> criteria(
      kMinAngle_deg, kMaxRadius * spacing_m, kMaxDistance * spacing_m);
  CGAL::make_surface_mesh(complex, implicit, criteria, CGAL::Manifold_with_boundary_tag());
  Surface surface;
  // CGAL looks for the highest facet, even if there is none.
  if (complex.number_of_facets() > 0) {
    CGAL::facets_in_complex_2_to_triangle_mesh(complex, surface);
  }
  return surface;
}

}  // namespace

Repaired RepairMesh(const TriangleMesh& mesh, double max_hole) {
  // Shares of the diagonal: 0.3 mm for 170 mm, the noise of a good scanner. The wrap bridges gaps
  // ten times as wide.
  constexpr double kWrapOffset = 0.0018;
  constexpr double kWrapGap = 0.018;
  // A mesh with less volume than this share of the diagonal cubed is a sheet (paper: 4e-5).
  constexpr double kMinVolume = 1e-5;
  Repaired result;
  Surface surface = Assemble(mesh, result.done);
  CloseHoles(max_hole, surface, result.done);
  if (pmp::does_self_intersect(surface)) {
    const double diagonal = DiagonalOf(surface);
    Surface wrap;
    CGAL::alpha_wrap_3(surface, kWrapGap * diagonal, kWrapOffset * diagonal, wrap);
    surface = std::move(wrap);
    result.done.push_back(
        fmt::format("it intersects itself: replaced by a wrapped surface, up to {:.2f} % of its "
                    "size outside the mesh",
                    100.0 * kWrapOffset));
  } else {
    const double before = CGAL::to_double(pmp::volume(surface));
    pmp::orient_to_bound_a_volume(surface);
    result.turned_inside_out = before < 0.0;
    if (result.turned_inside_out)
      result.done.emplace_back("it was inside out: orientation reversed");
  }
  const double volume = CGAL::to_double(pmp::volume(surface));
  if (!(volume > kMinVolume * std::pow(DiagonalOf(surface), 3))) {
    throw base::InputError("encloses almost no volume: it is a sheet, not a solid");
  }
  result.mesh = FromSurface(surface);
  return result;
}

TriangleMesh AlphaWrap(const TriangleMesh& mesh, double gap, double offset) {
  const Soup soup = ToSoup(mesh);
  Surface wrap;
  CGAL::alpha_wrap_3(soup.points, soup.faces, gap, offset, wrap);
  return FromSurface(wrap);
}

TriangleMesh Simplified(const TriangleMesh& mesh, std::size_t max_triangles) {
  if (mesh.triangles.size() <= max_triangles) return mesh;
  Surface surface = ToSurface(ToSoup(mesh));
  // A closed triangle mesh has three edges for every two triangles.
  const sms::Count_stop_predicate<Surface> stop(max_triangles * 3 / 2);
  const sms::GarlandHeckbert_plane_policies<Surface, Kernel> policies(surface);
  sms::edge_collapse(
      surface, stop,
      CGAL::parameters::get_cost(policies.get_cost()).get_placement(policies.get_placement()));
  return FromSurface(surface);
}

Overlap OverlapOf(const TriangleMesh& mesh, const std::vector<TriangleMesh>& parts) {
  const Surface surface = ToSurface(ToSoup(mesh));
  const CGAL::Side_of_triangle_mesh<Surface, Kernel> side(surface);
  std::vector<Convex> solids(parts.begin(), parts.end());
  Eigen::AlignedBox3d box = BoundsOf(mesh.vertices);
  for (const Convex& solid : solids) box.extend(solid.box);
  constexpr int kPoints = 48;  // lattice points along the longest edge of the box
  const double step = box.sizes().maxCoeff() / kPoints;
  std::size_t inside = 0, covered = 0, beyond = 0;
  // Starts half a step inside, so that no point lies on a face of an axis-aligned box.
  for (double x = box.min().x() + step / 2; x < box.max().x(); x += step) {
    for (double y = box.min().y() + step / 2; y < box.max().y(); y += step) {
      for (double z = box.min().z() + step / 2; z < box.max().z(); z += step) {
        const bool in = side(Point(x, y, z)) != CGAL::ON_UNBOUNDED_SIDE;
        const bool held = std::ranges::any_of(solids, [&](const Convex& solid) {
          return solid.Holds({x, y, z});
        });
        inside += in;
        covered += in && held;
        beyond += !in && held;
      }
    }
  }
  if (inside == 0) return {};
  const auto all = static_cast<double>(inside);
  return {static_cast<double>(covered) / all, static_cast<double>(beyond) / all};
}

std::optional<TriangleMesh> PoissonSurface(const PointCloud& cloud, double spacing_m) {
  if (cloud.points.size() != cloud.normals.size() || cloud.size() < 100) {
    throw std::invalid_argument("PoissonSurface: needs 100 points or more, and a normal for each");
  }
  using Oriented = std::pair<Point, Kernel::Vector_3>;
  std::vector<Oriented> oriented;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d& p = cloud.points[i];
    const Eigen::Vector3d& n = cloud.normals[i];
    oriented.emplace_back(Point(p.x(), p.y(), p.z()), Kernel::Vector_3(n.x(), n.y(), n.z()));
  }
  using PointMap = CGAL::First_of_pair_property_map<Oriented>;
  using NormalMap = CGAL::Second_of_pair_property_map<Oriented>;
  using Function = CGAL::Poisson_reconstruction_function<PoissonKernel>;
  using Triangulation = std::remove_cvref_t<decltype(std::declval<Function>().tr())>;
  static_assert(CGAL::internal::Has_timestamp<Triangulation::Cell>::value);  // specialized above
  Function inside(oriented.begin(), oriented.end(), PointMap(), NormalMap());
  if (!inside.compute_implicit_function()) return std::nullopt;
  // A sphere around an inner point, large enough to contain the whole surface.
  constexpr double kSphere = 5.0;
  const Kernel::Sphere_3 sphere(inside.get_inner_point(),
                                kSphere * kSphere * inside.bounding_sphere().squared_radius());
  // Per point. A ball of 4,000 points takes 22, a ball of which a third was seen 164, random
  // normals 2,100.
  constexpr std::size_t kMaxEvaluations = 3000;
  Surface surface;
  try {
    surface = MeshOf(inside, sphere, spacing_m, kMaxEvaluations * cloud.size());
  } catch (const CGAL::Failure_exception&) {  // rounding makes intersections coincide
    return std::nullopt;
  }
  if (surface.number_of_faces() == 0) return std::nullopt;
  TriangleMesh mesh = FromSurface(surface);
  if (Volume(mesh) < 0.0) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

}  // namespace rangegrasp::geometry
