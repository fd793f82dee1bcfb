#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <tuple>

#include "core/error.h"
#include "geometry/hull.h"
#include "geometry/union_find.h"
#include "parts/baselines.h"
#include "parts/embedding.h"
#include "parts/internal/cut_refinement.h"
#include "parts/internal/geodesic.h"
#include "parts/mirror.h"

namespace rangegrasp::parts {
namespace {

using Faces = std::vector<std::uint32_t>;

/// A part below this many landmarks is not looked at.
constexpr int kFewest = 16;
/// Reach of the boundary's refinement, in landmark spacings.
constexpr double kReach = 6.0;

/// Some faces of a mesh as a shape of its own.
struct Piece {
  Shape shape;
  std::vector<bool> cut;  ///< a vertex: on an edge where it was cut from the rest
};

Piece Extract(const Shape& mesh, const FaceGraph& graph, const Faces& faces) {
  Piece piece;
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
  std::vector<std::uint32_t> number(mesh.points.size(), 0);
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

struct CoordinateLess {
  bool operator()(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
  }
};

std::vector<bool> OnHull(const geometry::Points& points, const geometry::TriangleMesh& hull) {
  const std::set<Eigen::Vector3d, CoordinateLess> corners(hull.vertices.begin(),
                                                          hull.vertices.end());
  std::vector<bool> on_hull(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) on_hull[i] = corners.contains(points[i]);
  return on_hull;
}

/// How far each point is inside of a hull of which it is one or which holds it.
std::vector<double> DepthInHull(const geometry::Points& points,
                                const geometry::TriangleMesh& hull) {
  std::vector<double> depth(points.size(), std::numeric_limits<double>::infinity());
  for (const auto& [a, b, c] : hull.triangles) {
    const Eigen::Vector3d normal = (hull.vertices[b] - hull.vertices[a])
                                       .cross(hull.vertices[c] - hull.vertices[a])
                                       .normalized();
    for (std::size_t i = 0; i < points.size(); ++i) {
      depth[i] = std::min(depth[i], normal.dot(hull.vertices[a] - points[i]));
    }
  }
  return depth;
}

/// The coarse form in which a piece is looked at: landmarks, joined where their cells touch.
struct Coarse {
  LandmarkDistances spread;
  Eigen::MatrixXd distance;  ///< between landmarks
  geometry::Points embedded;
  std::vector<std::set<std::uint32_t>> neighbors;
  std::vector<bool> near_cut;

  std::uint32_t size() const { return static_cast<std::uint32_t>(spread.landmark.size()); }
};

Coarse MakeCoarse(const Piece& piece, const VertexGraph& graph, int landmarks) {
  Coarse coarse;
  coarse.spread = SpreadLandmarks(graph, landmarks);
  const auto n = coarse.spread.landmark.size();
  coarse.distance = BetweenLandmarks(coarse.spread);
  coarse.neighbors.resize(n);
  coarse.near_cut.assign(n, false);
  const std::vector<std::uint32_t>& nearest = coarse.spread.nearest;
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    if (piece.cut[v]) coarse.near_cut[nearest[v]] = true;
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      const std::uint32_t other = nearest[graph.neighbor[k]];
      if (other != nearest[v]) coarse.neighbors[nearest[v]].insert(other);
    }
  }
  const Embedding embedding = Smacof(coarse.distance, {});
  for (std::size_t i = 0; i < n; ++i) {
    coarse.embedded.push_back(embedding.positions.row(static_cast<Eigen::Index>(i)));
  }
  return coarse;
}

/// Landmarks farther from all others, in the mean, than their neighbours are, on the embedding's
/// hull.
std::vector<bool> FeaturePoints(const Coarse& coarse, const std::vector<bool>& on_hull) {
  const Eigen::VectorXd far = coarse.distance.rowwise().sum();
  std::vector<bool> feature(coarse.size(), false);
  for (std::uint32_t i = 0; i < coarse.size(); ++i) {
    feature[i] = on_hull[i] && !coarse.near_cut[i];
    for (const std::uint32_t j : coarse.neighbors[i]) {
      if (far[j] >= far[i]) feature[i] = false;
    }
  }
  return feature;
}

/// Landmarks from the core's middle outwards: by how deep the mirrored ones lie in their hull.
struct Outward {
  std::vector<std::uint32_t> order;
  std::vector<double> depth;  ///< a landmark
  std::size_t on_hull = 0;    ///< the first so many
};

Outward FromCoreOutwards(const Coarse& coarse) {
  const Eigen::Vector3d center = geometry::Centroid(coarse.embedded);
  const Sphere sphere{center, BoundingRadius(coarse.embedded, center)};
  geometry::Points mirrored;
  for (const Eigen::Vector3d& p : coarse.embedded) mirrored.push_back(MirrorOut(p, sphere));
  const geometry::TriangleMesh hull = geometry::ConvexHull(mirrored);
  Outward outward{{}, DepthInHull(mirrored, hull), hull.vertices.size()};
  outward.order.resize(coarse.size());
  std::iota(outward.order.begin(), outward.order.end(), 0u);
  std::stable_sort(
      outward.order.begin(), outward.order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return outward.depth[a] < outward.depth[b]; });
  return outward;
}

/// Components of the landmarks that are left when the first `core` of the order are gone, numbered
/// from 1 where they hold a feature point, else 0. Returns how many do.
std::int32_t Components(const Coarse& coarse, const std::vector<bool>& feature,
                        const std::vector<std::uint32_t>& order, std::size_t core,
                        std::vector<std::int32_t>& label) {
  std::vector<bool> rest(coarse.size(), true);
  for (std::size_t k = 0; k < core; ++k) rest[order[k]] = false;
  label.assign(coarse.size(), 0);
  std::int32_t count = 0;
  std::vector<std::uint32_t> front;
  for (std::uint32_t i = 0; i < coarse.size(); ++i) {
    if (!feature[i] || !rest[i] || label[i] != 0) continue;
    label[i] = ++count;
    front.push_back(i);
    while (!front.empty()) {
      const std::uint32_t at = front.back();
      front.pop_back();
      for (const std::uint32_t j : coarse.neighbors[at]) {
        if (!rest[j] || label[j] != 0) continue;
        label[j] = count;
        front.push_back(j);
      }
    }
  }
  return count;
}

/// Grows the core from the hull of the mirrored landmarks outwards and stops where the number of
/// separate components with feature points then stays the same for longest: growing on until every
/// last feature point is on its own (ears, horns) would leave stumps of the limbs.
std::int32_t Separate(const Coarse& coarse, const std::vector<bool>& feature,
                      std::vector<std::int32_t>& label) {
  const Outward outward = FromCoreOutwards(coarse);
  double longest = -1.0;
  std::int32_t best = 0;
  std::int32_t count = 0;
  double since = 0.0;
  std::vector<std::int32_t> first, candidate;
  for (std::size_t core = outward.on_hull; core < outward.order.size(); ++core) {
    const double depth = outward.depth[outward.order[core]];
    const std::int32_t now = Components(coarse, feature, outward.order, core, candidate);
    if (now != count) {
      count = now;
      since = depth;
      first = candidate;
    }
    if (count > 0 && (count - 1) * (depth - since) > longest) {
      longest = (count - 1) * (depth - since);
      best = count;
      label = first;
    }
  }
  return best;
}

/// Feature points and core of the coarse form: a label a landmark, 0 the core, and how many others.
std::int32_t LabelLandmarks(const Coarse& coarse, double hull_fraction,
                            std::vector<std::int32_t>& label) {
  const std::vector<bool> on_hull = OnHull(coarse.embedded, geometry::ConvexHull(coarse.embedded));
  const auto convex = static_cast<double>(std::count(on_hull.begin(), on_hull.end(), true));
  if (convex > hull_fraction * coarse.size()) return 0;
  return Separate(coarse, FeaturePoints(coarse, on_hull), label);
}

/// The faces of a part as its core and segments; empty if it stays whole.
std::vector<Faces> Split(const Shape& shape, const FaceGraph& shape_graph, const Faces& part,
                         const CoreExtractionOptions& options) {
  const double share = static_cast<double>(part.size()) / static_cast<double>(shape.faces.size());
  const int landmarks = static_cast<int>(options.landmarks * std::sqrt(share));
  if (landmarks < kFewest) return {};
  const Piece piece = Extract(shape, shape_graph, part);
  const VertexGraph graph = GeodesicGraph(piece.shape);
  const Coarse coarse = MakeCoarse(piece, graph, landmarks);
  if (coarse.size() < std::uint32_t{kFewest}) return {};
  std::vector<std::int32_t> of_landmark;
  const std::int32_t segments = LabelLandmarks(coarse, options.hull_fraction, of_landmark);
  if (segments == 0) return {};

  std::vector<std::int32_t> label;
  for (const auto& [a, b, c] : piece.shape.faces) {
    const std::int32_t la = of_landmark[coarse.spread.nearest[a]];
    const std::int32_t lb = of_landmark[coarse.spread.nearest[b]];
    const std::int32_t lc = of_landmark[coarse.spread.nearest[c]];
    label.push_back(la == lb || la == lc ? la : lb == lc ? lb : 0);
  }
  const FaceGraph faces = BuildFaceGraph(piece.shape);
  JoinCrumbs(faces, label);
  const std::vector<double> costs = CutCosts(piece.shape, faces);
  for (std::int32_t s = 1; s <= segments; ++s) {
    RefineBoundary(piece.shape, graph, faces, costs, s, kReach * coarse.spread.spacing, label);
  }
  JoinCrumbs(faces, label);
  std::map<std::int32_t, Faces> by_label;
  for (std::size_t i = 0; i < label.size(); ++i) by_label[label[i]].push_back(part[i]);
  std::vector<Faces> split;
  for (auto& [unused, some] : by_label) split.push_back(std::move(some));
  return split;
}

std::vector<Faces> ConnectedPieces(const Shape& mesh, const FaceGraph& graph) {
  geometry::UnionFind sets(mesh.faces.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
      sets.Unite(f, graph.neighbor[k]);
    }
  }
  std::vector<std::int32_t> piece;
  const std::int32_t pieces =
      geometry::LabelBySize(sets, std::vector<bool>(mesh.faces.size(), true), piece);
  std::vector<Faces> result(static_cast<std::size_t>(pieces));
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    result[static_cast<std::size_t>(piece[f])].push_back(f);
  }
  return result;
}

struct Part {
  Faces faces;
  bool whole;  ///< was looked at and cannot be split
};

}  // namespace

// The paper looks for feature points and the core in a coarsened mesh; here that is the landmarks
// and the contacts of their cells, so that there is nothing to simplify and to map back.
Segmentation SegmentByCoreExtraction(const Shape& shape, const CoreExtractionOptions& options) {
  if (!shape.IsMesh()) {
    throw core::InputError("core extraction needs a mesh; the input is a point cloud");
  }
  if (options.levels < 1 || options.landmarks < 1) {
    throw std::invalid_argument("core extraction: levels and landmarks must be >= 1");
  }
  const FaceGraph graph = BuildFaceGraph(shape);
  std::vector<Part> parts;
  for (Faces& faces : ConnectedPieces(shape, graph)) parts.push_back({std::move(faces), false});
  Segmentation result;
  for (int level = 0; level < options.levels; ++level) {
    std::vector<Part> finer;
    for (Part& part : parts) {
      const std::vector<Faces> split =
          part.whole ? std::vector<Faces>{} : Split(shape, graph, part.faces, options);
      if (split.size() < 2) {
        finer.push_back({std::move(part.faces), true});
        continue;
      }
      result.has_core = result.has_core || finer.empty();
      for (const Faces& faces : split) finer.push_back({faces, false});
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
