#include "parts/baselines/sdf.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/mesh_segmentation.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"

namespace rangegrasp::parts {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using SdfFace = Mesh::Face_index;
using Diameters = Mesh::Property_map<SdfFace, double>;
using SdfFaces = std::vector<std::array<std::size_t, 3>>;

SdfFaces FacesOf(const Shape& shape) {
  // The diameter is measured against the normals: a mesh that is inside out is turned.
  const bool turn = geometry::Volume({shape.points, shape.faces}) < 0.0;
  SdfFaces faces;
  for (const auto& [a, b, c] : shape.faces) {
    faces.push_back(turn ? std::array<std::size_t, 3>{a, c, b}
                         : std::array<std::size_t, 3>{a, b, c});
  }
  return faces;
}

/// Vertices and edges that the half-edge structure cannot hold (more than two faces at an edge,
/// faces that meet in a point only, neighbors of opposite orientation) are doubled; faces keep
/// their numbers.
Mesh ToMesh(const Shape& shape) {
  std::vector<Kernel::Point_3> points;
  for (const Eigen::Vector3d& p : shape.points) points.emplace_back(p.x(), p.y(), p.z());
  SdfFaces faces = FacesOf(shape);
  namespace processing = CGAL::Polygon_mesh_processing;
  if (!processing::is_polygon_soup_a_polygon_mesh(faces)) {
    processing::orient_polygon_soup(points, faces);
  }
  Mesh mesh;
  processing::polygon_soup_to_polygon_mesh(points, faces, mesh);
  return mesh;
}

void Check(const SdfOptions& options) {
  if (options.clusters < 1 || options.rays < 1 || !(options.smoothing >= 0.0) ||
      options.smoothing > 1.0 || !(options.cone_rad > 0.0) || !(options.cone_rad < base::kPi)) {
    throw std::invalid_argument(
        "SegmentBySdf: clusters, rays >= 1, smoothing from 0 to 1, cone_rad between 0 and pi");
  }
}

/// Values farther apart than rounding, of 0 .. 1. With more clusters than that the mixture would
/// draw from nothing.
std::size_t DifferentValues(const Mesh& mesh, const Diameters& diameter) {
  std::vector<double> values;
  for (const SdfFace face : mesh.faces()) values.push_back(diameter[face]);
  std::sort(values.begin(), values.end());
  constexpr double kApart = 1e-9;  // of values from 0 to 1: far above rounding, far below noise
  std::size_t different = 1;
  for (std::size_t i = 1; i < values.size(); ++i) {
    different += values[i] > values[i - 1] + kApart ? 1 : 0;
  }
  return different;
}

Segmentation OnePart(std::size_t elements, const std::string& note) {
  return {std::vector<std::int32_t>(elements, 0), 1, false, note};
}

Segmentation EachFaceAPart(std::size_t faces) {
  Segmentation result{std::vector<std::int32_t>(faces), static_cast<int>(faces), false,
                      "no two faces share an edge: each is a part"};
  std::iota(result.label.begin(), result.label.end(), 0);
  return result;
}

}  // namespace

Segmentation SegmentBySdf(const Shape& shape, const SdfOptions& options) {
  if (!shape.IsMesh()) {
    throw base::InputError("the shape diameter function needs a mesh; the input is a point cloud");
  }
  Check(options);
  const std::size_t faces = shape.faces.size();
  Mesh mesh = ToMesh(shape);
  Diameters diameter = mesh.add_property_map<SdfFace, double>("f:diameter").first;
  const auto [min, max] =
      CGAL::sdf_values(mesh, diameter, options.cone_rad, static_cast<std::size_t>(options.rays),
                       /*postprocess=*/true);
  const std::size_t different = max > min ? DifferentValues(mesh, diameter) : 1;
  if (different < 2) return OnePart(faces, "the diameter is the same everywhere: one part");
  // CGAL takes the first of the edges between faces, whether there is one or not.
  const auto edges = mesh.edges();
  const bool apart =
      std::all_of(edges.begin(), edges.end(), [&](const auto e) { return mesh.is_border(e); });
  if (apart) return EachFaceAPart(faces);
  auto segment = mesh.add_property_map<SdfFace, std::size_t>("f:segment").first;
  const auto clusters = std::min(static_cast<std::size_t>(options.clusters), different);
  CGAL::segmentation_from_sdf_values(mesh, diameter, segment, clusters, options.smoothing);

  Segmentation result;
  result.label.assign(faces, 0);
  for (const SdfFace face : mesh.faces()) {
    result.label[face.idx()] = static_cast<std::int32_t>(segment[face]);
    result.parts = std::max(result.parts, result.label[face.idx()] + 1);
  }
  return result;
}

}  // namespace rangegrasp::parts
