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
#include "parts/baselines/internal/core_extraction.h"

namespace rangegrasp::parts {
namespace {

using geometry::ShortestPaths;

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

/// For each face the seed (a position in seeds) it is nearest to, and how far.
struct Nearest {
  std::vector<double> distance;
  Labels seed;
};

/// Takes the faces that are nearer to the seeds from `first` on than to those before.
void Grow(const DualGraph& graph, const Indices& seeds, std::size_t first, Nearest& nearest) {
  for (std::size_t s = first; s < seeds.size(); ++s) {
    nearest.seed[seeds[s]] = static_cast<std::int32_t>(s);
  }
  const FaceGraph& faces = graph.faces;
  const auto expand = [&](std::uint32_t f, double d, const auto& reach) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t next = faces.neighbor[k];
      if (reach(next, d + graph.cost[k])) nearest.seed[next] = nearest.seed[f];
    }
  };
  ShortestPaths().Lower(std::span(seeds).subspan(first), nearest.distance, expand);
}

Nearest Unreached(const DualGraph& graph) {
  return {std::vector<double>(graph.frames.center.size(), ShortestPaths::kFar),
          Labels(graph.frames.center.size(), -1)};
}

/// Faces in pieces of the mesh without a seed go with the seed nearest in a straight line.
Labels Assign(const DualGraph& graph, const Indices& seeds) {
  Nearest nearest = Unreached(graph);
  Grow(graph, seeds, 0, nearest);
  for (std::size_t f = 0; f < graph.frames.center.size(); ++f) {
    if (nearest.seed[f] >= 0) continue;
    const auto best = std::ranges::min_element(seeds, {}, [&](std::uint32_t s) {
      return (graph.frames.center[s] - graph.frames.center[f]).squaredNorm();
    });
    nearest.seed[f] = static_cast<std::int32_t>(best - seeds.begin());
  }
  return nearest.seed;
}

/// Area-weighted; one a cluster.
Points ClusterCenters(const DualGraph& graph, const Labels& label, std::size_t clusters) {
  Points centers(clusters, Eigen::Vector3d::Zero());
  std::vector<double> areas(clusters, 0.0);
  for (std::size_t f = 0; f < label.size(); ++f) {
    const std::int32_t cluster = label[f];
    centers[cluster] += graph.frames.area[f] * graph.frames.center[f];
    areas[cluster] += graph.frames.area[f];
  }
  for (std::size_t s = 0; s < clusters; ++s) centers[s] /= areas[s];
  return centers;
}

/// The face of each cluster that is nearest to the cluster's center.
Indices MiddleFaces(const DualGraph& graph, const Labels& label, std::size_t clusters) {
  const Points centers = ClusterCenters(graph, label, clusters);
  Indices seeds(clusters, 0);
  std::vector<double> best(clusters, ShortestPaths::kFar);
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    const std::int32_t cluster = label[f];
    const double d = (graph.frames.center[f] - centers[cluster]).squaredNorm();
    if (d >= best[cluster]) continue;
    best[cluster] = d;
    seeds[cluster] = f;
  }
  return seeds;
}

/// The face farthest from the center of the surface, then again and again the one farthest along
/// the graph from all before; pieces that no seed reaches come first, by index.
Indices FarApart(const DualGraph& graph, int count) {
  const Eigen::Vector3d center =
      ClusterCenters(graph, Labels(graph.frames.center.size(), 0), 1).front();
  const Points& centers = graph.frames.center;
  const auto farthest = std::ranges::max_element(
      centers, {}, [&](const Eigen::Vector3d& p) { return (p - center).squaredNorm(); });
  Indices seeds{static_cast<std::uint32_t>(farthest - centers.begin())};
  Nearest nearest = Unreached(graph);
  for (Grow(graph, seeds, 0, nearest); seeds.size() < static_cast<std::size_t>(count);
       Grow(graph, seeds, seeds.size() - 1, nearest)) {
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

// ---- core extraction ----

/// Some faces of a mesh as a shape of its own.
struct CorePiece {
  Shape shape;
  std::vector<bool> cut;  ///< a vertex: on an edge where it was cut from the rest
};

CorePiece Extract(const Shape& mesh, const FaceGraph& graph, const Indices& faces) {
  CorePiece piece;
  std::vector<bool> within(mesh.faces.size(), false);
  std::vector<bool> used(mesh.points.size(), false);
  std::vector<bool> cut(mesh.points.size(), false);
  for (const std::uint32_t f : faces) within[f] = true;
  for (const std::uint32_t f : faces) {
    for (const std::uint32_t v : mesh.faces[f]) used[v] = true;
    for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
      if (within[graph.neighbor[k]]) continue;
      for (const std::uint32_t v : graph.edge[k]) cut[v] = true;
    }
  }
  Indices number(mesh.points.size(), 0);
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    if (!used[v]) continue;
    number[v] = static_cast<std::uint32_t>(piece.shape.points.size());
    piece.shape.points.push_back(mesh.points[v]);
    piece.cut.push_back(cut[v]);
  }
  for (const std::uint32_t f : faces) {
    const auto& [a, b, c] = mesh.faces[f];
    piece.shape.faces.push_back({number[a], number[b], number[c]});
  }
  return piece;
}

/// A face has the label of two of its vertices' landmarks, else that of the core.
Labels LabelFaces(const Shape& mesh, const Indices& landmark, const Labels& of_landmark) {
  Labels label;
  for (const auto& [a, b, c] : mesh.faces) {
    const std::int32_t la = of_landmark[landmark[a]];
    const std::int32_t lb = of_landmark[landmark[b]];
    const std::int32_t lc = of_landmark[landmark[c]];
    label.push_back(la == lb || la == lc ? la : lb == lc ? lb : 0);
  }
  return label;
}

/// The faces of a part as its core and segments; empty if it stays whole.
std::vector<Indices> SplitPart(const Shape& shape, const FaceGraph& shape_graph,
                               const Indices& part, const CoreExtractionOptions& options) {
  const double share = static_cast<double>(part.size()) / static_cast<double>(shape.faces.size());
  const int landmarks = static_cast<int>(options.landmarks * std::sqrt(share));
  if (landmarks < options.min_landmarks) return {};
  const CorePiece piece = Extract(shape, shape_graph, part);
  const VertexGraph graph = GeodesicGraph(piece.shape);
  const LandmarkForm form = MakeLandmarkForm(graph, piece.cut, landmarks);
  if (form.size() < static_cast<std::uint32_t>(options.min_landmarks)) return {};
  Labels of_landmark;
  const std::int32_t segments = LabelLandmarks(form, options.hull_fraction, of_landmark);
  if (segments == 0) return {};

  Labels label = LabelFaces(piece.shape, form.spread.nearest, of_landmark);
  const FaceGraph faces = BuildFaceGraph(piece.shape);
  JoinCrumbs(faces, label);
  const std::vector<double> costs = CutCosts(piece.shape, faces);
  for (std::int32_t s = 1; s <= segments; ++s) {
    RefineBoundary(piece.shape, graph, faces, costs, s,
                   options.boundary_reach * form.spread.spacing, label);
  }
  JoinCrumbs(faces, label);
  std::map<std::int32_t, Indices> by_label;
  for (std::size_t i = 0; i < label.size(); ++i) by_label[label[i]].push_back(part[i]);
  std::vector<Indices> split;
  for (auto& [unused, some] : by_label) split.push_back(std::move(some));
  return split;
}

std::vector<Indices> ConnectedPieces(const Shape& mesh, const FaceGraph& graph) {
  Labels piece;
  const std::int32_t pieces = LabelPieces(graph, std::vector<bool>(mesh.faces.size(), true), piece);
  std::vector<Indices> result(pieces);
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) result[piece[f]].push_back(f);
  return result;
}

struct Part {
  Indices faces;
  bool whole;  ///< was looked at and cannot be split
};

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
    seeds = MiddleFaces(graph, result.label, seeds.size());
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
  Check(options);
  const std::size_t faces = shape.faces.size();
  Mesh mesh = ToMesh(shape);
  Diameters diameter = mesh.add_property_map<SdfFace, double>("f:diameter").first;
  const auto [min, max] =
      CGAL::sdf_values(mesh, diameter, options.cone_rad, static_cast<std::size_t>(options.rays),
                       /*postprocess=*/true);
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
  CGAL::segmentation_from_sdf_values(mesh, diameter, segment, clusters, options.smoothing);
  for (const SdfFace face : mesh.faces()) {
    result.label[face.idx()] = static_cast<std::int32_t>(segment[face]);
    result.parts = std::max(result.parts, result.label[face.idx()] + 1);
  }
  return result;
}

// The paper looks for feature points and the core in a coarsened mesh; here that is the landmarks
// and the contacts of their cells, so that there is nothing to simplify and to map back.
Segmentation SegmentByCoreExtraction(const Shape& shape, const CoreExtractionOptions& options) {
  if (!shape.IsMesh()) {
    throw base::InputError("core extraction needs a mesh; the input is a point cloud");
  }
  if (options.levels < 1 || options.landmarks < 1 || options.min_landmarks < 1) {
    throw std::invalid_argument(
        "core extraction: levels, landmarks and min_landmarks must be >= 1");
  }
  const FaceGraph graph = BuildFaceGraph(shape);
  Segmentation result;
  std::vector<Part> parts;
  for (Indices& faces : ConnectedPieces(shape, graph)) parts.push_back({std::move(faces), false});
  for (int level = 0; level < options.levels; ++level) {
    std::vector<Part> finer;
    for (Part& part : parts) {
      const std::vector<Indices> split =
          part.whole ? std::vector<Indices>{} : SplitPart(shape, graph, part.faces, options);
      if (split.size() < 2) {
        finer.push_back({std::move(part.faces), true});
        continue;
      }
      result.has_core = result.has_core || finer.empty();
      for (const Indices& faces : split) finer.push_back({faces, false});
    }
    parts = std::move(finer);
  }
  result.label.assign(shape.faces.size(), 0);
  for (const Part& part : parts) {
    for (const std::uint32_t f : part.faces) result.label[f] = result.parts;
    ++result.parts;
  }
  if (!result.has_core) result.note = "no core: no feature points, or nearly convex";
  return result;
}

}  // namespace rangegrasp::parts
