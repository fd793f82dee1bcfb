#include "parts/internal/cut_refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/union_find.h"
#include "parts/internal/geodesic.h"
#include "parts/internal/min_cut.h"

namespace rangegrasp::parts {
namespace {

constexpr double kConvexWeight = 0.2;
constexpr double kFar = std::numeric_limits<double>::infinity();

struct FaceFrame {
  Eigen::Vector3d normal;
  Eigen::Vector3d center;
};

FaceFrame FrameOf(const Shape& mesh, std::uint32_t f) {
  const Eigen::Vector3d& a = mesh.points[mesh.faces[f][0]];
  const Eigen::Vector3d& b = mesh.points[mesh.faces[f][1]];
  const Eigen::Vector3d& c = mesh.points[mesh.faces[f][2]];
  return {(b - a).cross(c - a).normalized(), (a + b + c) / 3.0};
}

/// The farthest that a vertex of the faces chosen is from the boundary.
template <typename Chosen>
double Depth(const Shape& mesh, const std::vector<double>& distance, Chosen chosen) {
  double depth = 0.0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen(f)) continue;
    for (const std::uint32_t v : mesh.faces[f]) {
      if (distance[v] < kFar) depth = std::max(depth, distance[v]);
    }
  }
  return depth;
}

}  // namespace

std::vector<double> CutCosts(const Shape& mesh, const FaceGraph& faces) {
  std::vector<FaceFrame> frames;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) frames.push_back(FrameOf(mesh, f));
  std::vector<double> costs(faces.neighbor.size());
  double sum = 0.0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const FaceFrame& here = frames[f];
      const FaceFrame& there = frames[faces.neighbor[k]];
      const bool concave = here.normal.dot(there.center - here.center) > 0.0;
      costs[k] = (concave ? 1.0 : kConvexWeight) * (1.0 - here.normal.dot(there.normal));
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
  const auto in_segment = [&](std::uint32_t f) { return label[f] == segment; };
  std::vector<double> distance(mesh.points.size(), kFar);
  GeodesicFront front(graph);
  for (std::uint32_t f = 0; f < n; ++f) {
    if (!in_segment(f)) continue;
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (in_segment(faces.neighbor[k])) continue;
      for (const std::uint32_t v : faces.edge[k]) front.Lower(v, distance);
    }
  }
  // Both sides keep something.
  const double inside = 0.5 * Depth(mesh, distance, in_segment);
  const double outside =
      0.5 * Depth(mesh, distance, [&](std::uint32_t f) { return label[f] == 0; });
  constexpr std::uint32_t kSource = 0;
  constexpr std::uint32_t kSink = 1;
  std::uint32_t nodes = 2;
  std::vector<std::uint32_t> node(n, kSink);
  for (std::uint32_t f = 0; f < n; ++f) {
    double far = 0.0;
    for (const std::uint32_t v : mesh.faces[f]) far = std::max(far, distance[v]);
    if (in_segment(f)) {
      node[f] = far < std::min(width, inside) ? nodes++ : kSource;
    } else if (label[f] == 0 && far < std::min(width, outside)) {
      node[f] = nodes++;
    }
  }
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

void JoinCrumbs(const FaceGraph& faces, std::vector<std::int32_t>& label) {
  const auto n = static_cast<std::uint32_t>(label.size());
  geometry::UnionFind sets(n);
  for (std::uint32_t f = 0; f < n; ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (label[f] == label[faces.neighbor[k]]) sets.Unite(f, faces.neighbor[k]);
    }
  }
  std::vector<std::int32_t> piece;  // by size, descending
  const auto pieces =
      static_cast<std::size_t>(geometry::LabelBySize(sets, std::vector<bool>(n, true), piece));
  std::vector<std::int32_t> label_of(pieces, 0);
  std::vector<std::map<std::int32_t, std::size_t>> shared(pieces);
  for (std::uint32_t f = 0; f < n; ++f) {
    const auto p = static_cast<std::size_t>(piece[f]);
    label_of[p] = label[f];
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (piece[faces.neighbor[k]] != piece[f]) ++shared[p][piece[faces.neighbor[k]]];
    }
  }
  std::map<std::int32_t, bool> seen;
  std::vector<std::size_t> crumbs;
  for (std::size_t p = 0; p < pieces; ++p) {
    if (seen[label_of[p]]) crumbs.push_back(p);
    seen[label_of[p]] = true;
  }
  for (const std::size_t p : crumbs) {
    std::map<std::int32_t, std::size_t> votes;
    for (const auto& [other, edges] : shared[p])
      votes[label_of[static_cast<std::size_t>(other)]] += edges;
    std::size_t most = 0;
    for (const auto& [candidate, edges] : votes) {
      if (edges <= most) continue;
      most = edges;
      label_of[p] = candidate;
    }
  }
  for (std::uint32_t f = 0; f < n; ++f) label[f] = label_of[static_cast<std::size_t>(piece[f])];
}

}  // namespace rangegrasp::parts
