#include "parts/internal/improved_candidates.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <utility>

#include "geometry/hull.h"
#include "parts/internal/min_cut.h"
#include "parts/mirror.h"

namespace rangegrasp::parts {
namespace {

/// How deep each mirrored point lies below the hull of all.
std::vector<double> MirrorDepths(const geometry::Points& points, const Eigen::Vector3d& center) {
  const Sphere sphere{center, BoundingRadius(points, center)};
  geometry::Points mirrored;
  for (const Eigen::Vector3d& p : points) mirrored.push_back(MirrorOut(p, sphere));
  const geometry::TriangleMesh hull = geometry::ConvexHull(mirrored);
  // Of points in a plane there is no hull: all are seen alike.
  std::vector<double> depth(points.size(),
                            hull.triangles.empty() ? 0.0 : std::numeric_limits<double>::infinity());
  for (const auto& [a, b, c] : hull.triangles) {
    const Eigen::Vector3d normal = (hull.vertices[b] - hull.vertices[a])
                                       .cross(hull.vertices[c] - hull.vertices[a])
                                       .normalized();
    const double level = normal.dot(hull.vertices[a]);
    for (std::size_t i = 0; i < points.size(); ++i) {
      depth[i] = std::min(depth[i], level - normal.dot(mirrored[i]));
    }
  }
  return depth;
}

/// All cells that can be reached from `start`, best seen first.
std::vector<std::uint32_t> GrowthOrder(const Cells& cells, const std::vector<double>& depth,
                                       std::uint32_t start) {
  using Entry = std::pair<double, std::uint32_t>;
  std::vector<bool> seen(cells.size(), false);
  std::vector<Entry> heap{{depth[start], start}};
  std::vector<std::uint32_t> order;
  seen[start] = true;
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    const std::uint32_t c = heap.back().second;
    heap.pop_back();
    order.push_back(c);
    for (const Cells::Link& link : cells.links[c]) {
      if (seen[link.to]) continue;
      seen[link.to] = true;
      heap.emplace_back(depth[link.to], link.to);
      std::push_heap(heap.begin(), heap.end(), std::greater<>());
    }
  }
  return order;
}

/// The cheapest set of cells that holds the first of the order and none from `end` on.
std::vector<bool> CutBetween(const Cells& cells, const std::vector<std::uint32_t>& order,
                             std::size_t begin, std::size_t end) {
  constexpr std::uint32_t kSource = 0;
  constexpr std::uint32_t kSink = 1;
  std::vector<std::uint32_t> node(cells.size(), kSink);
  std::uint32_t nodes = 2;
  for (std::size_t k = 0; k < end; ++k) node[order[k]] = k < begin ? kSource : nodes++;
  std::vector<CutLink> links;
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    for (const Cells::Link& link : cells.links[c]) {
      if (c < link.to && node[c] != node[link.to]) {
        links.push_back({node[c], node[link.to], link.cost});
      }
    }
  }
  const std::vector<bool> with_source = MinCut(nodes, links, kSource, kSink);
  std::vector<bool> within(cells.size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) within[c] = with_source[node[c]];
  return within;
}

void AddCores(const Cells& cells, const std::vector<std::uint32_t>& order,
              const CandidateOptions& options, std::set<std::vector<bool>>& candidates) {
  double total = 0.0;
  for (const std::uint32_t c : order) total += cells.area[c];
  const auto first_at = [&](double area) {
    double sum = 0.0;
    std::size_t k = 0;
    while (k < order.size() && sum < area) sum += cells.area[order[k++]];
    return k;
  };
  const double growth = std::pow(0.7 / options.least, 1.0 / std::max(1, options.levels - 1));
  double share = options.least;
  for (int level = 0; level < options.levels; ++level, share *= growth) {
    const std::size_t begin = std::max<std::size_t>(1, first_at(share * total));
    const std::size_t end = std::min(
        first_at(std::min(options.reach * share, 0.5 + 0.5 * share) * total), order.size() - 1);
    if (end <= begin) continue;
    candidates.insert(CutBetween(cells, order, begin, end));
  }
}

}  // namespace

Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c) {
  const Eigen::Vector3d& p = cells.center[c];
  const Eigen::Vector3d& n = cells.normal[c];
  double radius = std::numeric_limits<double>::infinity();
  for (std::uint32_t other = 0; other < cells.size(); ++other) {
    const Eigen::Vector3d to = p - cells.center[other];
    const double below = n.dot(to);
    if (other == c || below <= 0.3 * to.norm()) continue;
    radius = std::min(radius, to.squaredNorm() / (2.0 * below));
  }
  return std::isfinite(radius) ? Eigen::Vector3d(p - radius * n) : p;
}

std::vector<std::vector<bool>> MirrorCandidates(const Cells& cells,
                                                const CandidateOptions& options) {
  std::set<std::vector<bool>> candidates;
  const auto mirror = [&](const Eigen::Vector3d& center, std::uint32_t start) {
    const std::vector<std::uint32_t> order =
        GrowthOrder(cells, MirrorDepths(cells.center, center), start);
    if (order.size() > 1) AddCores(cells, order, options, candidates);
  };
  const auto centers = std::min(static_cast<std::uint32_t>(options.centers), cells.size());
  for (std::uint32_t c = 0; c < centers; ++c) mirror(InnerCenter(cells, c), c);
  return {candidates.begin(), candidates.end()};
}

}  // namespace rangegrasp::parts
