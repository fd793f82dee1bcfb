#include "parts/metrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <stdexcept>
#include <string>
#include <utility>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

double Pairs(std::size_t n) {
  return 0.5 * static_cast<double>(n) * (static_cast<double>(n) - 1.0);
}

/// The sum of C(n, 2) over the groups of equal values.
template <class T>
double PairsInGroups(std::vector<T> values) {
  std::sort(values.begin(), values.end());
  double sum = 0.0;
  for (auto first = values.begin(); first != values.end();) {
    const auto last = std::upper_bound(first, values.end(), *first);
    sum += Pairs(static_cast<std::size_t>(last - first));
    first = last;
  }
  return sum;
}

double MeanDistanceToCentroid(const Shape& mesh) {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  geometry::Points centers;
  std::vector<double> areas;
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.faces) {
    const Eigen::Vector3d& p = mesh.points[a];
    areas.push_back(0.5 * (mesh.points[b] - p).cross(mesh.points[c] - p).norm());
    centers.push_back((p + mesh.points[b] + mesh.points[c]) / 3.0);
    moment += areas.back() * centers.back();
    area += areas.back();
  }
  const Eigen::Vector3d centroid = moment / area;
  double sum = 0.0;
  for (std::size_t i = 0; i < areas.size(); ++i) sum += areas[i] * (centers[i] - centroid).norm();
  return sum / area;
}

constexpr double kUnreached = std::numeric_limits<double>::infinity();

/// Dijkstra from all sources at once.
std::vector<double> DistancesTo(const VertexGraph& graph,
                                const std::vector<std::uint32_t>& sources) {
  using Entry = std::pair<double, std::uint32_t>;
  std::vector<double> distance(graph.begin.size() - 1, kUnreached);
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const std::uint32_t source : sources) {
    distance[source] = 0.0;
    queue.emplace(0.0, source);
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      const std::uint32_t next = graph.neighbor[k];
      const double through = d + graph.length[k];
      if (through >= distance[next]) continue;
      distance[next] = through;
      queue.emplace(through, next);
    }
  }
  return distance;
}

}  // namespace

double RandError(std::span<const std::int32_t> a, std::span<const std::int32_t> b) {
  if (a.size() != b.size() || a.size() < 2) {
    throw std::invalid_argument("RandError: labellings of " + std::to_string(a.size()) + " and " +
                                std::to_string(b.size()) + " elements; they must be as long, >= 2");
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> both;
  both.reserve(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) both.emplace_back(a[i], b[i]);
  return (PairsInGroups(std::vector(a.begin(), a.end())) +
          PairsInGroups(std::vector(b.begin(), b.end())) - 2.0 * PairsInGroups(std::move(both))) /
         Pairs(a.size());
}

CutMeasure::CutMeasure(const Shape& mesh)
    : points_(mesh.points),
      faces_(BuildFaceGraph(mesh)),
      vertices_(BuildVertexGraph(mesh)),
      radius_(MeanDistanceToCentroid(mesh)) {}

std::vector<std::uint32_t> CutMeasure::CutVertices(std::span<const std::int32_t> label) const {
  std::vector<bool> on_cut(points_.size(), false);
  for (std::size_t f = 0; f + 1 < faces_.begin.size(); ++f) {
    for (std::uint32_t k = faces_.begin[f]; k < faces_.begin[f + 1]; ++k) {
      if (label[faces_.neighbor[k]] == label[f]) continue;
      for (const std::uint32_t v : faces_.edge[k]) on_cut[v] = true;
    }
  }
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < on_cut.size(); ++v) {
    if (on_cut[v]) vertices.push_back(v);
  }
  return vertices;
}

double CutMeasure::SumOfDistances(const std::vector<std::uint32_t>& from,
                                  const std::vector<std::uint32_t>& to) const {
  const std::vector<double> distance = DistancesTo(vertices_, to);
  geometry::Points targets;
  std::optional<geometry::KdTree> tree;
  std::vector<geometry::KdTree::Neighbor> nearest;
  double sum = 0.0;
  for (const std::uint32_t v : from) {
    if (distance[v] != kUnreached) {
      sum += distance[v];
      continue;
    }
    if (!tree) {
      targets = geometry::Select(points_, to);
      tree.emplace(targets);
    }
    tree->Nearest(points_[v], 1, nearest);
    sum += std::sqrt(nearest.front().squared_distance);
  }
  return sum;
}

std::optional<double> CutMeasure::Discrepancy(std::span<const std::int32_t> a,
                                              std::span<const std::int32_t> b) const {
  const std::size_t faces = faces_.begin.size() - 1;
  if (a.size() != faces || b.size() != faces) {
    throw std::invalid_argument("CutMeasure: labellings of " + std::to_string(a.size()) + " and " +
                                std::to_string(b.size()) + " faces; the mesh has " +
                                std::to_string(faces));
  }
  const std::vector<std::uint32_t> cut_a = CutVertices(a);
  const std::vector<std::uint32_t> cut_b = CutVertices(b);
  if (cut_a.empty() || cut_b.empty()) return std::nullopt;
  const double sum = SumOfDistances(cut_a, cut_b) + SumOfDistances(cut_b, cut_a);
  return sum / static_cast<double>(cut_a.size() + cut_b.size()) / radius_;
}

std::optional<double> CutDiscrepancy(const Shape& mesh, std::span<const std::int32_t> a,
                                     std::span<const std::int32_t> b) {
  return CutMeasure(mesh).Discrepancy(a, b);
}

}  // namespace rangegrasp::parts
