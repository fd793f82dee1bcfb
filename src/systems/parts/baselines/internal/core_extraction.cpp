#include "parts/baselines/internal/core_extraction.h"

#include <algorithm>
#include <numeric>

#include "geometry/graph.h"
#include "geometry/mesh.h"
#include "parts/mirror/internal/spherical_mirror.h"

namespace rangegrasp::parts {
namespace {

// ---- landmarks ----

std::vector<bool> OnHull(const Points& points) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(points);
  std::vector<bool> on_hull;
  for (const Eigen::Vector3d& p : points) {
    on_hull.push_back(
        std::ranges::binary_search(hull.vertices, CoordinatesOf(p), {}, CoordinatesOf));
  }
  return on_hull;
}

/// Landmarks from the core's middle outwards: by how deep the mirrored ones lie in their hull.
struct Outward {
  Indices order;
  std::vector<double> depth;  ///< a landmark
  std::size_t on_hull = 0;    ///< the first so many
};

Outward FromCoreOutwards(const LandmarkForm& form) {
  const Sphere sphere = SphereRound(geometry::Centroid(form.embedded), form.embedded);
  const Points mirrored = MirrorOut(form.embedded, sphere);
  const geometry::TriangleMesh hull = geometry::ConvexHull(mirrored);
  Outward outward{Indices(form.size()), HeightsAbove(hull, mirrored), hull.vertices.size()};
  for (double& depth : outward.depth) depth = -depth;
  std::iota(outward.order.begin(), outward.order.end(), 0u);
  std::ranges::stable_sort(outward.order, {}, [&](std::uint32_t i) { return outward.depth[i]; });
  return outward;
}

/// Components of the landmarks that are left when the first `core` of the order are gone, numbered
/// from 1 where they hold a feature point, else 0. Returns how many do.
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

/// Grows the core from the hull of the mirrored landmarks outwards and stops where the number of
/// separate components with feature points then stays the same for longest: growing on until every
/// last feature point is on its own (ears, horns) would leave stumps of the limbs.
std::int32_t Separate(const LandmarkForm& form, const std::vector<bool>& feature, Labels& label) {
  const Outward outward = FromCoreOutwards(form);
  double longest = -1.0;
  std::int32_t best = 0;
  std::int32_t count = 0;
  double since = 0.0;
  Labels first, candidate;
  for (std::size_t core = outward.on_hull; core < outward.order.size(); ++core) {
    const double depth = outward.depth[outward.order[core]];
    const std::int32_t now = Components(form, feature, outward.order, core, candidate);
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

// ---- minimum cuts ----

/// Eta of a convex edge (Katz and Tal 2003).
constexpr double kConvexWeight = 0.2;

/// Of each vertex from the edges between the segment's faces and others.
std::vector<double> DistancesFromBoundary(const VertexGraph& graph, const FaceGraph& faces,
                                          std::int32_t segment, const Labels& label) {
  Indices boundary;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (label[f] != segment || label[g] == segment) return;
    boundary.insert(boundary.end(), faces.edge[k].begin(), faces.edge[k].end());
  });
  return geometry::DistancesFrom(boundary, graph.Links());
}

/// A node for each face of the segment and of label 0 near the boundary; the others of the segment
/// are the source, all others the sink.
Indices NodesOfBand(const Shape& mesh, const std::vector<double>& distance, std::int32_t segment,
                    double width, const Labels& label, std::uint32_t& nodes) {
  // Both sides keep something: not more than half of the way to a side's farthest vertex is moved.
  const auto reach = [&](std::int32_t side) {
    double depth = 0.0;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
      if (label[f] != side) continue;
      for (const std::uint32_t v : mesh.faces[f]) {
        if (distance[v] < geometry::ShortestPaths::kFar) depth = std::max(depth, distance[v]);
      }
    }
    return std::min(width, 0.5 * depth);
  };
  const double inside = reach(segment);
  const double outside = reach(0);
  nodes = 2;
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
  return node;
}

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

std::int32_t LabelLandmarks(const LandmarkForm& form, double hull_fraction, Labels& label) {
  const std::vector<bool> on_hull = OnHull(form.embedded);
  const auto convex = static_cast<double>(std::count(on_hull.begin(), on_hull.end(), true));
  if (convex > hull_fraction * form.size()) return 0;
  return Separate(form, FeaturePoints(form, on_hull), label);
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
    const double length = (mesh.points[faces.edge[k][0]] - mesh.points[faces.edge[k][1]]).norm();
    costs[k] = length / (1.0 + (mean > 0.0 ? costs[k] / mean : 0.0));
  }
  return costs;
}

void RefineBoundary(const Shape& mesh, const VertexGraph& graph, const FaceGraph& faces,
                    const std::vector<double>& costs, std::int32_t segment, double width,
                    Labels& label) {
  std::uint32_t nodes = 0;
  const Indices node = NodesOfBand(mesh, DistancesFromBoundary(graph, faces, segment, label),
                                   segment, width, label, nodes);
  std::vector<CutLink> links;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (f < g && node[f] != node[g]) links.push_back({node[f], node[g], costs[k]});
  });
  const std::vector<bool> with_source = MinCut(nodes, links, kSource, kSink);
  for (std::size_t f = 0; f < node.size(); ++f) {
    if (node[f] > kSink) label[f] = with_source[node[f]] ? segment : 0;
  }
}

}  // namespace rangegrasp::parts
