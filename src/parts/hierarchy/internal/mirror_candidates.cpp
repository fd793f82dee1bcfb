#include "parts/hierarchy/internal/mirror_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "geometry/hull.h"
#include "geometry/shortest_path.h"
#include "parts/mirror/spherical_mirror.h"
#include "parts/shape/internal/min_cut.h"

namespace rangegrasp::parts {
namespace {

/// How deep each mirrored point lies below the hull of all.
std::vector<double> MirrorDepths(const geometry::Points& points, const Eigen::Vector3d& center) {
  const geometry::Points mirrored = MirrorOut(points, SphereRound(center, points));
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
  std::vector<double> reached(cells.size(), geometry::ShortestPaths::kFar);
  std::vector<std::uint32_t> order;
  geometry::ShortestPaths().LowerFrom(start, depth[start], reached,
                                      [&](std::uint32_t c, double, const auto& reach) {
                                        order.push_back(c);
                                        for (const Cells::Link& link : cells.links[c])
                                          reach(link.to, depth[link.to]);
                                      });
  return order;
}

/// The cheapest set of cells that holds the first of the order and none from `end` on.
std::vector<bool> CutBetween(const Cells& cells, const std::vector<std::uint32_t>& order,
                             std::size_t begin, std::size_t end) {
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
  const double growth =
      std::pow(options.max_share / options.min_share, 1.0 / std::max(1, options.levels - 1));
  double share = options.min_share;
  for (int level = 0; level < options.levels; ++level, share *= growth) {
    const std::size_t begin = std::max<std::size_t>(1, first_at(share * total));
    // Of what is outside of a large core at least half stays rest.
    const double band_end = std::min(options.reach * share, 0.5 + 0.5 * share);
    const std::size_t end = std::min(first_at(band_end * total), order.size() - 1);
    if (end <= begin) continue;
    candidates.insert(CutBetween(cells, order, begin, end));
  }
}

}  // namespace

Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c) {
  // Sine of the angle below the surface from which another cell counts: beside the cell itself its
  // neighbors, which noise lifts or lowers, would give balls of any size.
  constexpr double kMinSlope = 0.3;
  const Eigen::Vector3d& p = cells.center[c];
  const Eigen::Vector3d& n = cells.normal[c];
  double radius = std::numeric_limits<double>::infinity();
  for (std::uint32_t other = 0; other < cells.size(); ++other) {
    const Eigen::Vector3d to = p - cells.center[other];
    const double below = n.dot(to);
    if (other == c || below <= kMinSlope * to.norm()) continue;
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
