#include "parts/hierarchy/internal/mirror_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "base/units.h"
#include "geometry/shortest_path.h"
#include "parts/mirror/spherical_mirror.h"
#include "parts/shape/internal/min_cut.h"

namespace rangegrasp::parts {
namespace {

/// So many of some points, each as far from those before as can be; the first is the farthest from
/// the middle.
std::vector<std::uint32_t> FarApart(const geometry::Points& points, std::size_t count) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  std::vector<double> distance(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) distance[i] = (points[i] - mean).squaredNorm();
  std::vector<std::uint32_t> chosen;
  while (chosen.size() < std::min(count, points.size())) {
    const auto next = std::max_element(distance.begin(), distance.end()) - distance.begin();
    if (chosen.empty()) std::fill(distance.begin(), distance.end(), geometry::ShortestPaths::kFar);
    chosen.push_back(static_cast<std::uint32_t>(next));
    for (std::size_t i = 0; i < points.size(); ++i) {
      distance[i] =
          std::min(distance[i], (points[i] - points[static_cast<std::size_t>(next)]).squaredNorm());
    }
  }
  return chosen;
}

/// Evenly spread over the sphere: a spiral of the golden angle.
Eigen::Matrix<double, Eigen::Dynamic, 3> Directions(int count) {
  const double golden = base::kPi * (3.0 - std::sqrt(5.0));
  Eigen::Matrix<double, Eigen::Dynamic, 3> directions(count, 3);
  for (int k = 0; k < count; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / count;
    const double r = std::sqrt(1.0 - z * z);
    directions.row(k) << r * std::cos(golden * k), r * std::sin(golden * k), z;
  }
  return directions;
}

/// How deep each mirrored point lies below the hull of all: the least distance to the planes that
/// touch the hull in many directions.
std::vector<double> MirrorDepths(const geometry::Points& points, const Eigen::Vector3d& center) {
  // 10 degrees apart: finer ones change no order that matters.
  static const Eigen::Matrix<double, Eigen::Dynamic, 3> directions = Directions(400);
  const geometry::Points mirrored = MirrorOut(points, SphereRound(center, points));
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>> all(
      mirrored.front().data(), 3, static_cast<Eigen::Index>(mirrored.size()));
  const Eigen::MatrixXd heights = directions * all;
  const Eigen::VectorXd levels = heights.rowwise().maxCoeff();
  std::vector<double> depth(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    depth[i] = (levels - heights.col(static_cast<Eigen::Index>(i))).minCoeff();
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
  std::vector<double> radius(cells.size());
  geometry::Points center(cells.size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    center[c] = InnerCenter(cells, c);
    radius[c] = (center[c] - cells.center[c]).norm();
  }
  const auto grow = [&](const std::vector<double>& key, std::uint32_t start) {
    const std::vector<std::uint32_t> order = GrowthOrder(cells, key, start);
    if (order.size() > 1) AddCores(cells, order, options, candidates);
  };
  const auto starts = FarApart(cells.center, static_cast<std::size_t>(options.centers));
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const std::uint32_t c = starts[k];
    grow(MirrorDepths(cells.center, center[c]), c);
    grow(radius, c);
  }
  return {candidates.begin(), candidates.end()};
}

}  // namespace rangegrasp::parts
