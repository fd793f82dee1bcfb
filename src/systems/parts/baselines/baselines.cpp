#include "parts/baselines/baselines.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/mesh_segmentation.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "geometry/graph.h"
#include "geometry/mesh.h"
#include "parts/mirror/internal/spherical_mirror.h"

namespace rangegrasp::parts {
namespace {

// ---- k-means ----

/// The dual graph: faces with their centroids, and the cost of a step from one face to the next.
struct DualGraph {
  FaceGraph faces;
  std::vector<double> cost;  ///< parallel to faces.neighbor
  FaceFrames frames;
};

DualGraph MakeDualGraph(const Shape& mesh, double dihedral_weight) {
  DualGraph graph;
  graph.faces = BuildFaceGraph(mesh);
  graph.frames = BuildFaceFrames(mesh);
  const FaceFrames& frames = graph.frames;
  graph.cost.resize(graph.faces.neighbor.size());
  ForEachLink(graph.faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const Eigen::Vector3d to_next = frames.center[g] - frames.center[f];
    const bool convex = frames.normal[f].dot(to_next) - frames.normal[g].dot(to_next) <= 0.0;
    // 1 - cos of the angle between the normals (Funkhouser et al. 2004): cuts follow concave edges.
    const double fold = convex ? 0.0 : 1.0 - frames.normal[f].dot(frames.normal[g]);
    graph.cost[k] = to_next.norm() * (1.0 + dihedral_weight * fold);
  });
  return graph;
}

/// The nearest seed of each face: along the graph or, in pieces without a seed, in a straight line.
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

/// Picks the face farthest from the center of the surface, then repeatedly the face farthest along
/// the graph from all faces before. Pieces that no seed reaches come first, by index.
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

/// Duplicates vertices and edges that the half-edge structure cannot represent (more than two faces
/// at an edge, faces that meet only in a point, neighbors of opposite orientation). Faces keep
/// their numbers.
Mesh ToMesh(const Shape& shape) {
  std::vector<Kernel::Point_3> points;
  for (const Eigen::Vector3d& p : shape.points) points.emplace_back(p.x(), p.y(), p.z());
  // The diameter is measured against the normals, so a mesh that is inside out is flipped.
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

/// Number of values of 0 .. 1 that are farther apart than rounding. With more clusters than that
/// the mixture would have nothing to draw from.
std::size_t DifferentValues(const Mesh& mesh, const Diameters& diameter) {
  std::vector<double> values;
  for (const SdfFace face : mesh.faces()) values.push_back(diameter[face]);
  std::sort(values.begin(), values.end());
  constexpr double kApart = 1e-9;  // values are 0 to 1: far above rounding, far below noise
  std::size_t different = 1;
  for (std::size_t i = 1; i < values.size(); ++i) {
    different += values[i] > values[i - 1] + kApart ? 1 : 0;
  }
  return different;
}

}  // namespace

Segmentation SegmentByKMeans(const Shape& shape, const KMeansOptions& options) {
  const DualGraph graph = MakeDualGraph(shape, options.dihedral_weight);
  Indices seeds = FarApart(graph, options.clusters);
  Segmentation result;
  result.label = Assign(graph, seeds);
  for (int i = 1; i < options.iterations; ++i) {
    const Points centers = GroupFrames(graph.frames, result.label, seeds.size()).center;
    seeds = MiddleFaces(graph.frames, result.label, centers);
    Labels label = Assign(graph, seeds);
    if (label == result.label) break;
    result.label = std::move(label);
  }
  result.parts = static_cast<int>(seeds.size());
  return result;
}

Segmentation SegmentBySdf(const Shape& shape, int clusters) {
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
  // CGAL accesses the first edge between two faces even if there is none.
  const auto edges = mesh.edges();
  if (std::all_of(edges.begin(), edges.end(), [&](const auto e) { return mesh.is_border(e); })) {
    std::iota(result.label.begin(), result.label.end(), 0);
    result.parts = static_cast<int>(faces);
    result.note = "no two faces share an edge: each is a part";
    return result;
  }
  auto segment = mesh.add_property_map<SdfFace, std::size_t>("f:segment").first;
  CGAL::segmentation_from_sdf_values(mesh, diameter, segment,
                                     std::min(static_cast<std::size_t>(clusters), different));
  for (const SdfFace face : mesh.faces()) {
    result.label[face.idx()] = static_cast<std::int32_t>(segment[face]);
    result.parts = std::max(result.parts, result.label[face.idx()] + 1);
  }
  return result;
}

namespace {

// ---- landmarks ----

/// For the whole; a part has this times the square root of its share of faces. More landmarks find
/// smaller feature points at quadratic cost.
constexpr int kLandmarks = 300;
/// A part with fewer landmarks is not examined: its few cells show no limbs.
constexpr std::uint32_t kMinLandmarks = 16;
/// A part stays whole if a larger fraction of its landmarks lies on their convex hull.
constexpr double kHullFraction = 0.7;

std::vector<bool> OnHull(const Points& points) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(points);
  std::vector<bool> on_hull;
  for (const Eigen::Vector3d& p : points) {
    on_hull.push_back(
        std::ranges::binary_search(hull.vertices, CoordinatesOf(p), {}, CoordinatesOf));
  }
  return on_hull;
}

/// Connected components of the landmarks without the first `core` ones of the order. Those with a
/// feature point are numbered from 1, all others are 0. Returns the number of the former.
std::int32_t Components(const LandmarkForm& form, const std::vector<bool>& feature,
                        const Indices& order, std::size_t core, Labels& label) {
  std::vector<bool> rest(form.size(), true);
  for (std::size_t k = 0; k < core; ++k) rest[order[k]] = false;
  label.assign(form.size(), 0);
  std::int32_t count = 0;
  Indices front;
  for (std::uint32_t i = 0; i < form.size(); ++i) {
    if (!feature[i] || !rest[i] || label[i] != 0) continue;
    label[i] = ++count;
    front.push_back(i);
    while (!front.empty()) {
      const std::uint32_t at = front.back();
      front.pop_back();
      for (const std::uint32_t j : form.neighbors[at]) {
        if (!rest[j] || label[j] != 0) continue;
        label[j] = count;
        front.push_back(j);
      }
    }
  }
  return count;
}

/// Grows the core from the hull of the mirrored landmarks, by increasing depth of the landmarks in
/// it. It stops where the number of separate components with feature points then stays the same for
/// longest. Growing until every last feature point is separate (ears, horns) would leave only
/// stumps of the limbs.
/// @return a label per landmark, 0 for the core, and the number of other labels
Pieces Separate(const LandmarkForm& form, const std::vector<bool>& feature) {
  const Points mirrored =
      MirrorOut(form.embedded, SphereRound(geometry::Centroid(form.embedded), form.embedded));
  const geometry::TriangleMesh hull = geometry::ConvexHull(mirrored);
  const std::vector<double> height = HeightsAbove(hull, mirrored);
  Indices order(form.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return -height[i]; });
  double longest = -1.0, since = 0.0;
  Pieces best, first, candidate;
  for (std::size_t core = hull.vertices.size(); core < order.size(); ++core) {
    const double depth = -height[order[core]];
    candidate.count = Components(form, feature, order, core, candidate.label);
    if (candidate.count != first.count) {
      since = depth;
      first = candidate;
    }
    const double lasts = (first.count - 1) * (depth - since);
    if (first.count > 0 && lasts > longest) {
      longest = lasts;
      best = first;
    }
  }
  return best;
}

// ---- minimum cuts ----

/// Eta of a convex edge (Katz and Tal 2003).
constexpr double kConvexWeight = 0.2;
/// How far a boundary may move to its cheapest place, in distances between landmarks. A smaller
/// value leaves it near the border between two cells; a larger one may find a crease of another
/// part.
constexpr double kBoundaryReach = 6.0;

/// Distance of each vertex from the edges between the segment's faces and others.
std::vector<double> DistancesFromBoundary(const VertexGraph& graph, const FaceGraph& faces,
                                          std::int32_t segment, const Labels& label) {
  Indices boundary;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (label[f] != segment || label[g] == segment) return;
    boundary.insert(boundary.end(), faces.edge[k].begin(), faces.edge[k].end());
  });
  return geometry::DistancesFrom(boundary, graph.Links());
}

/// How far the boundary may move into one side: at most half the distance to the farthest vertex of
/// that side, so that both sides keep some faces.
double ReachOf(const Shape& mesh, const std::vector<double>& distance, const Labels& label,
               std::int32_t side, double width) {
  double depth = 0.0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (label[f] != side) continue;
    for (const std::uint32_t v : mesh.faces[f]) {
      if (distance[v] < geometry::kFar) depth = std::max(depth, distance[v]);
    }
  }
  return std::min(width, 0.5 * depth);
}

// ---- the hierarchy ----

/// Some faces of a mesh as a separate shape.
struct CorePiece {
  Shape shape;
  std::vector<bool> cut;  ///< per vertex: it lies on an edge where it was cut from the rest
};

CorePiece Extract(const Shape& mesh, const FaceGraph& graph, const Indices& faces) {
  CorePiece piece;
  std::vector<bool> within(mesh.faces.size(), false), cut(mesh.points.size(), false);
  for (const std::uint32_t f : faces) within[f] = true;
  for (const std::uint32_t f : faces) {
    piece.shape.faces.push_back(mesh.faces[f]);
    for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
      if (within[graph.neighbor[k]]) continue;
      for (const std::uint32_t v : graph.edge[k]) cut[v] = true;
    }
  }
  const Indices kept = UseOnly(mesh.points.size(), piece.shape.faces);
  piece.shape.points = geometry::Select(mesh.points, kept);
  piece.cut = ValuesAt(cut, kept);
  return piece;
}

/// A face gets the label shared by the landmarks of two of its vertices, else that of the core.
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

/// Splits the faces of a part into its core and segments; empty if it stays whole.
std::vector<Indices> SplitPart(const Shape& shape, const FaceGraph& shape_graph,
                               const Indices& part) {
  const double share = static_cast<double>(part.size()) / static_cast<double>(shape.faces.size());
  const auto landmarks = static_cast<std::uint32_t>(kLandmarks * std::sqrt(share));
  if (landmarks < kMinLandmarks) return {};
  const CorePiece piece = Extract(shape, shape_graph, part);
  const VertexGraph graph = GeodesicGraph(piece.shape);
  const LandmarkForm form = MakeLandmarkForm(graph, piece.cut, static_cast<int>(landmarks));
  if (form.size() < kMinLandmarks) return {};
  const std::vector<bool> on_hull = OnHull(form.embedded);
  const auto convex = static_cast<double>(std::ranges::count(on_hull, true));
  if (convex > kHullFraction * form.size()) return {};
  const Pieces segments = Separate(form, FeaturePoints(form, on_hull));
  if (segments.count == 0) return {};

  Labels label = LabelFaces(piece.shape, form.spread.nearest, segments.label);
  const FaceGraph faces = BuildFaceGraph(piece.shape);
  JoinCrumbs(faces, label);
  const std::vector<double> costs = CutCosts(piece.shape, faces);
  for (std::int32_t s = 1; s <= segments.count; ++s) {
    RefineBoundary(piece.shape, graph, faces, costs, s, kBoundaryReach * form.spread.spacing,
                   label);
  }
  JoinCrumbs(faces, label);
  std::vector<Indices> split(segments.count + 1);
  for (std::size_t i = 0; i < label.size(); ++i) split[label[i]].push_back(part[i]);
  std::erase_if(split, [](const Indices& some) { return some.empty(); });
  return split;
}

struct Part {
  Indices faces;
  bool whole = false;  ///< was examined and cannot be split
};

}  // namespace

LandmarkForm MakeLandmarkForm(const VertexGraph& graph, const std::vector<bool>& cut,
                              int landmarks) {
  LandmarkForm form;
  form.spread = SpreadLandmarks(graph, landmarks);
  const auto n = form.spread.landmark.size();
  form.distance = BetweenLandmarks(form.spread);
  form.neighbors.resize(n);
  form.near_cut.assign(n, false);
  const Indices& nearest = form.spread.nearest;
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    if (cut[v]) form.near_cut[nearest[v]] = true;
  }
  ForEachLink(graph, [&](std::uint32_t v, std::uint32_t w, std::uint32_t) {
    if (nearest[w] != nearest[v]) form.neighbors[nearest[v]].insert(nearest[w]);
  });
  const Embedding embedding = Smacof(form.distance, {});
  for (std::size_t i = 0; i < n; ++i) form.embedded.push_back(embedding.positions.row(i));
  return form;
}

std::vector<bool> FeaturePoints(const LandmarkForm& form, const std::vector<bool>& on_hull) {
  const Eigen::VectorXd far = form.distance.rowwise().sum();
  std::vector<bool> feature(form.size(), false);
  for (std::uint32_t i = 0; i < form.size(); ++i) {
    feature[i] = on_hull[i] && !form.near_cut[i];
    for (const std::uint32_t j : form.neighbors[i]) {
      if (far[j] >= far[i]) feature[i] = false;
    }
  }
  return feature;
}

std::vector<double> CutCosts(const Shape& mesh, const FaceGraph& faces) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  std::vector<double> costs(faces.neighbor.size());
  double sum = 0.0;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const bool concave = frames.normal[f].dot(frames.center[g] - frames.center[f]) > 0.0;
    costs[k] = (concave ? 1.0 : kConvexWeight) * (1.0 - frames.normal[f].dot(frames.normal[g]));
    sum += costs[k];
  });
  const double mean = costs.empty() ? 0.0 : sum / static_cast<double>(costs.size());
  for (std::size_t k = 0; k < costs.size(); ++k) {
    costs[k] = LengthOf(mesh.points, faces.edge[k]) / (1.0 + (mean > 0.0 ? costs[k] / mean : 0.0));
  }
  return costs;
}

void RefineBoundary(const Shape& mesh, const VertexGraph& graph, const FaceGraph& faces,
                    const std::vector<double>& costs, std::int32_t segment, double width,
                    Labels& label) {
  const auto distance = DistancesFromBoundary(graph, faces, segment, label);
  const double inside = ReachOf(mesh, distance, label, segment, width);
  const double outside = ReachOf(mesh, distance, label, 0, width);
  std::uint32_t nodes = 2;
  Indices node(label.size(), kSink);
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    double far = 0.0;
    for (const std::uint32_t v : mesh.faces[f]) far = std::max(far, distance[v]);
    if (label[f] == segment) {
      node[f] = far < inside ? nodes++ : kSource;
    } else if (label[f] == 0 && far < outside) {
      node[f] = nodes++;
    }
  }
  CutFaces(faces, costs, nodes, node, segment, 0, label);
}

// The paper searches for feature points and the core in a coarsened mesh. Here the landmarks and
// the contacts of their cells replace it, so that nothing has to be simplified and mapped back.
Segmentation SegmentByCoreExtraction(const Shape& shape, int levels) {
  const FaceGraph graph = BuildFaceGraph(shape);
  const Pieces pieces = ConnectedPieces(graph, AnyNeighbors);
  std::vector<Part> parts(pieces.count);
  for (std::uint32_t f = 0; f < shape.faces.size(); ++f) parts[pieces.label[f]].faces.push_back(f);
  Segmentation result;
  for (int level = 0; level < levels; ++level) {
    std::vector<Part> finer;
    for (Part& part : parts) {
      std::vector<Indices> split;
      if (!part.whole) split = SplitPart(shape, graph, part.faces);
      if (split.size() < 2) {
        finer.push_back({std::move(part.faces), true});
        continue;
      }
      result.has_core = result.has_core || finer.empty();
      for (Indices& faces : split) finer.push_back({std::move(faces)});
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
