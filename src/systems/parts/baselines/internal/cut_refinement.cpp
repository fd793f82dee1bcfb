#include "parts/baselines/internal/cut_refinement.h"

#include <algorithm>
#include <cmath>

#include "geometry/shortest_path.h"
#include "parts/shape/face_frames.h"
#include "parts/shape/internal/min_cut.h"

namespace rangegrasp::parts {
namespace {

/// Eta of a convex edge (Katz and Tal 2003).
constexpr double kConvexWeight = 0.2;
constexpr double kFarFromCut = geometry::ShortestPaths::kFar;

/// The farthest that a vertex of the faces chosen is from the boundary.
template <typename Chosen>
double Depth(const Shape& mesh, const std::vector<double>& distance, Chosen chosen) {
  double depth = 0.0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen(f)) continue;
    for (const std::uint32_t v : mesh.faces[f]) {
      if (distance[v] < kFarFromCut) depth = std::max(depth, distance[v]);
    }
  }
  return depth;
}

/// Of each vertex from the edges between the segment's faces and others.
std::vector<double> DistancesFromBoundary(const VertexGraph& graph, const FaceGraph& faces,
                                          std::int32_t segment,
                                          const std::vector<std::int32_t>& label) {
  std::vector<std::uint32_t> boundary;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (label[f] != segment) continue;
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (label[faces.neighbor[k]] == segment) continue;
      boundary.insert(boundary.end(), faces.edge[k].begin(), faces.edge[k].end());
    }
  }
  return geometry::DistancesFrom(boundary, graph.Links());
}

/// A node for each face of the segment and of label 0 near the boundary; the others of the segment
/// are the source, all others the sink.
std::vector<std::uint32_t> NodesOfBand(const Shape& mesh, const std::vector<double>& distance,
                                       std::int32_t segment, double width,
                                       const std::vector<std::int32_t>& label,
                                       std::uint32_t& nodes) {
  // Both sides keep something.
  const auto reach = [&](std::int32_t side) {
    const auto on_side = [&](std::uint32_t f) { return label[f] == side; };
    return std::min(width, 0.5 * Depth(mesh, distance, on_side));
  };
  const double inside = reach(segment);
  const double outside = reach(0);
  nodes = 2;
  std::vector<std::uint32_t> node(label.size(), kSink);
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

std::vector<double> CutCosts(const Shape& mesh, const FaceGraph& faces) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  std::vector<double> costs(faces.neighbor.size());
  double sum = 0.0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      const bool concave = frames.normal[f].dot(frames.center[g] - frames.center[f]) > 0.0;
      costs[k] = (concave ? 1.0 : kConvexWeight) * (1.0 - frames.normal[f].dot(frames.normal[g]));
      sum += costs[k];
    }
  }
  const double mean = costs.empty() ? 0.0 : sum / static_cast<double>(costs.size());
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const double length = (mesh.points[faces.edge[k][0]] - mesh.points[faces.edge[k][1]]).norm();
    costs[k] = length / (1.0 + (mean > 0.0 ? costs[k] / mean : 0.0));
  }
  return costs;
}

void RefineBoundary(const Shape& mesh, const VertexGraph& graph, const FaceGraph& faces,
                    const std::vector<double>& costs, std::int32_t segment, double width,
                    std::vector<std::int32_t>& label) {
  const auto n = static_cast<std::uint32_t>(mesh.faces.size());
  std::uint32_t nodes = 0;
  const std::vector<std::uint32_t> node = NodesOfBand(
      mesh, DistancesFromBoundary(graph, faces, segment, label), segment, width, label, nodes);
  std::vector<CutLink> links;
  for (std::uint32_t f = 0; f < n; ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (f < g && node[f] != node[g]) links.push_back({node[f], node[g], costs[k]});
    }
  }
  const std::vector<bool> with_source = MinCut(nodes, links, kSource, kSink);
  for (std::uint32_t f = 0; f < n; ++f) {
    if (node[f] > kSink) label[f] = with_source[node[f]] ? segment : 0;
  }
}

}  // namespace rangegrasp::parts
