#include "parts/baselines/baselines.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/mesh_segmentation.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "geometry/graph.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

// ---- k-means ----

/// The faces with their centroids, and what it costs to go from one to the next.
struct DualGraph {
  FaceGraph faces;
  std::vector<double> cost;  ///< parallel to faces.neighbor
  FaceFrames frames;
};

/// 0 where the surface is flat or bends outwards, up to 2 in the sharpest concave fold: 1 - cos of
/// the angle between the normals, as in the weights of Funkhouser et al. 2004 that let cuts run
/// along concave edges.
double Concavity(const Eigen::Vector3d& normal, const Eigen::Vector3d& next_normal,
                 const Eigen::Vector3d& to_next) {
  if (normal.dot(to_next) - next_normal.dot(to_next) <= 0.0) return 0.0;
  return 1.0 - normal.dot(next_normal);
}

DualGraph MakeDualGraph(const Shape& mesh, double dihedral_weight) {
  DualGraph graph;
  graph.faces = BuildFaceGraph(mesh);
  graph.frames = BuildFaceFrames(mesh);
  const FaceFrames& frames = graph.frames;
  graph.cost.resize(graph.faces.neighbor.size());
  ForEachLink(graph.faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const Eigen::Vector3d to_next = frames.center[g] - frames.center[f];
    graph.cost[k] = to_next.norm() * (1.0 + dihedral_weight * Concavity(frames.normal[f],
                                                                        frames.normal[g], to_next));
  });
  return graph;
}

/// Of each face the nearest seed: along the graph or, in pieces without a seed, in a straight line.
Labels Assign(const DualGraph& graph, const Indices& seeds) {
  NearestSeeds nearest;
  GrowSeeds(graph.faces, graph.cost, seeds, 0, nearest);
  const Points& center = graph.frames.center;
  for (std::size_t f = 0; f < center.size(); ++f) {
    if (nearest.seed[f] >= 0) continue;
    const auto best = std::ranges::min_element(
        seeds, {}, [&](std::uint32_t s) { return (center[s] - center[f]).squaredNorm(); });
    nearest.seed[f] = static_cast<std::int32_t>(best - seeds.begin());
  }
  return nearest.seed;
}

/// The face farthest from the center of the surface, then again and again the one farthest along
/// the graph from all before; pieces that no seed reaches come first, by index.
Indices FarApart(const DualGraph& graph, int count) {
  const Points& centers = graph.frames.center;
  const auto middle = GroupFrames(graph.frames, Labels(centers.size(), 0), 1).center.front();
  const auto farthest = std::ranges::max_element(
      centers, {}, [&](const Eigen::Vector3d& p) { return (p - middle).squaredNorm(); });
  Indices seeds{static_cast<std::uint32_t>(farthest - centers.begin())};
  NearestSeeds nearest;
  for (GrowSeeds(graph.faces, graph.cost, seeds, 0, nearest);
       seeds.size() < static_cast<std::size_t>(count);
       GrowSeeds(graph.faces, graph.cost, seeds, seeds.size() - 1, nearest)) {
    const auto next = std::ranges::max_element(nearest.distance);
    if (*next <= 0.0) break;  // more clusters than faces
    seeds.push_back(static_cast<std::uint32_t>(next - nearest.distance.begin()));
  }
  return seeds;
}

// ---- shape diameter function ----

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using SdfFace = Mesh::Face_index;
using Diameters = Mesh::Property_map<SdfFace, double>;

/// Vertices and edges that the half-edge structure cannot hold (more than two faces at an edge,
/// faces that meet in a point only, neighbors of opposite orientation) are doubled; faces keep
/// their numbers.
Mesh ToMesh(const Shape& shape) {
  std::vector<Kernel::Point_3> points;
  for (const Eigen::Vector3d& p : shape.points) points.emplace_back(p.x(), p.y(), p.z());
  // The diameter is measured against the normals: a mesh that is inside out is turned.
  const bool turn = geometry::Volume({shape.points, shape.faces}) < 0.0;
  std::vector<std::array<std::size_t, 3>> faces;
  for (const auto& [a, b, c] : shape.faces) faces.push_back({a, turn ? c : b, turn ? b : c});
  namespace processing = CGAL::Polygon_mesh_processing;
  if (!processing::is_polygon_soup_a_polygon_mesh(faces)) {
    processing::orient_polygon_soup(points, faces);
  }
  Mesh mesh;
  processing::polygon_soup_to_polygon_mesh(points, faces, mesh);
  return mesh;
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

}  // namespace

Segmentation SegmentByKMeans(const Shape& shape, const KMeansOptions& options) {
  if (!shape.IsMesh()) throw base::InputError("k-means needs a mesh; the input is a point cloud");
  if (options.clusters < 1 || options.iterations < 1 || !(options.dihedral_weight >= 0.0)) {
    throw std::invalid_argument("SegmentByKMeans: clusters, iterations >= 1, dihedral_weight >= 0");
  }
  const DualGraph graph = MakeDualGraph(shape, options.dihedral_weight);
  Indices seeds = FarApart(graph, options.clusters);
  Segmentation result;
  result.label = Assign(graph, seeds);
  for (int i = 1; i < options.iterations; ++i) {
    const Points centers = GroupFrames(graph.frames, result.label, seeds.size()).center;
    seeds = MiddleFaces(graph.frames, result.label, centers, std::vector<bool>(seeds.size(), true));
    Labels label = Assign(graph, seeds);
    if (label == result.label) break;
    result.label = std::move(label);
  }
  result.parts = static_cast<int>(seeds.size());
  return result;
}

Segmentation SegmentBySdf(const Shape& shape, const SdfOptions& options) {
  if (!shape.IsMesh()) {
    throw base::InputError("the shape diameter function needs a mesh; the input is a point cloud");
  }
  if (options.clusters < 1) throw std::invalid_argument("SegmentBySdf: clusters must be >= 1");
  const std::size_t faces = shape.faces.size();
  Mesh mesh = ToMesh(shape);
  Diameters diameter = mesh.add_property_map<SdfFace, double>("f:diameter").first;
  const auto [min, max] = CGAL::sdf_values(mesh, diameter);
  const std::size_t different = max > min ? DifferentValues(mesh, diameter) : 1;
  Segmentation result{.label = Labels(faces, 0), .parts = 1, .note = ""};
  if (different < 2) {
    result.note = "the diameter is the same everywhere: one part";
    return result;
  }
  // CGAL takes the first of the edges between faces, whether there is one or not.
  const auto edges = mesh.edges();
  if (std::all_of(edges.begin(), edges.end(), [&](const auto e) { return mesh.is_border(e); })) {
    std::iota(result.label.begin(), result.label.end(), 0);
    result.parts = static_cast<int>(faces);
    result.note = "no two faces share an edge: each is a part";
    return result;
  }
  auto segment = mesh.add_property_map<SdfFace, std::size_t>("f:segment").first;
  const auto clusters = std::min(static_cast<std::size_t>(options.clusters), different);
  CGAL::segmentation_from_sdf_values(mesh, diameter, segment, clusters);
  for (const SdfFace face : mesh.faces()) {
    result.label[face.idx()] = static_cast<std::int32_t>(segment[face]);
    result.parts = std::max(result.parts, result.label[face.idx()] + 1);
  }
  return result;
}

}  // namespace rangegrasp::parts
