#include "perception/internal/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

#include "geometry/kd_tree.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::KdTree;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Whether a and b lie in each other's tangent planes, within the angle of the slope.
bool Tangential(const geometry::PointCloud& cloud, std::uint32_t a, std::uint32_t b,
                double max_slope) {
  const Eigen::Vector3d d = cloud.points[b] - cloud.points[a];
  const double most = max_slope * d.norm();
  return std::abs(cloud.normals[a].dot(d)) <= most && std::abs(cloud.normals[b].dot(d)) <= most;
}

/// The direction of the line that the neighbors of a point lie on; zero if they spread across, too.
Eigen::Vector3d LineOf(const geometry::PointCloud& cloud, std::uint32_t point,
                       const std::vector<KdTree::Neighbor>& near, double on_a_line) {
  // The furthest one says which way the line goes, the others how far they are from it.
  const auto furthest = std::ranges::max_element(
      near, {}, [](const auto& n) { return std::pair(n.squared_distance, n.index); });
  const Eigen::Vector3d line = (cloud.points[furthest->index] - cloud.points[point]).normalized();
  double along = 0.0;
  double across = 0.0;
  for (const auto& n : near) {
    const Eigen::Vector3d d = cloud.points[n.index] - cloud.points[point];
    const double on = line.dot(d);
    along += on * on;
    across += n.squared_distance - on * on;
  }
  if (across > on_a_line * on_a_line * along) return Eigen::Vector3d::Zero();
  return line.isZero() ? cloud.normals[point] : line;  // alone: any direction in its plane
}

/// The seed's cell: where it is and which way it faces, so that both sides of an edge, or of a thin
/// wall, have their own.
std::array<long, 4> CellOf(const Eigen::Vector3d& p, const Eigen::Vector3d& normal, double size_m) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return {std::lround(p.x() / size_m), std::lround(p.y() / size_m), std::lround(p.z() / size_m),
          2 * axis + (normal[axis] < 0.0 ? 1 : 0)};
}

/// The point nearest to the middle of each cell's points, in the order of the cells.
geometry::Indices FindSeeds(const geometry::PointCloud& cloud, const ConvexityOptions& options) {
  std::map<std::array<long, 4>, geometry::Indices> cells;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    cells[CellOf(cloud.points[i], cloud.normals[i], options.patch_m)].push_back(i);
  }
  geometry::Indices seeds;
  for (const auto& [cell, points] : cells) {
    if (points.size() < static_cast<std::size_t>(options.min_seed_points)) continue;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto i : points) middle += cloud.points[i];
    middle /= static_cast<double>(points.size());
    seeds.push_back(*std::ranges::min_element(
        points, {}, [&](std::uint32_t i) { return (cloud.points[i] - middle).squaredNorm(); }));
  }
  return seeds;
}

class Growth {
 public:
  Growth(const geometry::PointCloud& cloud, const Links& links, const ConvexityOptions& options)
      : cloud_(cloud),
        links_(links),
        per_square_m_(1.0 / (options.patch_m * options.patch_m)),
        per_square_turn_(1.0 / (options.patch_turn * options.patch_turn)) {
    grown_.patch_of.assign(cloud.size(), kNone);
    nearest_.assign(cloud.size(), std::numeric_limits<double>::infinity());
  }

  Patches Run(const geometry::Indices& seeds) {
    for (const auto seed : seeds) Open(seed);
    Empty();
    // What no seed reached: pieces of too few points for one.
    for (std::uint32_t i = 0; i < cloud_.size(); ++i) {
      if (grown_.patch_of[i] != kNone) continue;
      Open(i);
      Empty();
    }
    for (Patch& patch : grown_.patches) {
      patch.center /= static_cast<double>(patch.points);
      patch.normal.normalize();
    }
    for (std::uint32_t i = 0; i < cloud_.size(); ++i) {
      Patch& patch = grown_.patches[grown_.patch_of[i]];
      const Eigen::Vector3d d = cloud_.points[i] - patch.center;
      patch.spread += d * d.transpose();
      patch.turning += (cloud_.normals[i] - patch.normal) * d.transpose();
    }
    return std::move(grown_);
  }

 private:
  struct Candidate {
    double distance;
    std::uint32_t point;
    std::uint32_t patch;
    bool operator<(const Candidate& other) const {
      if (distance != other.distance) return distance > other.distance;
      return std::pair(point, patch) > std::pair(other.point, other.patch);
    }
  };

  void Open(std::uint32_t seed) {
    queue_.push({0.0, seed, static_cast<std::uint32_t>(grown_.patches.size())});
    grown_.patches.emplace_back();
  }

  void Empty() {
    while (!queue_.empty()) {
      const Candidate next = queue_.top();
      queue_.pop();
      if (grown_.patch_of[next.point] != kNone) continue;
      Take(next.point, next.patch);
    }
  }

  void Take(std::uint32_t point, std::uint32_t p) {
    grown_.patch_of[point] = p;
    Patch& patch = grown_.patches[p];
    ++patch.points;
    patch.center += cloud_.points[point];
    patch.normal += cloud_.normals[point];
    const Eigen::Vector3d center = patch.center / static_cast<double>(patch.points);
    const Eigen::Vector3d normal = patch.normal.normalized();
    for (const auto other : links_.Of(point)) {
      if (grown_.patch_of[other] != kNone) continue;
      const double distance = (cloud_.points[other] - center).squaredNorm() * per_square_m_ +
                              (cloud_.normals[other] - normal).squaredNorm() * per_square_turn_;
      // A nearer patch that waits for the point will have it.
      if (distance > nearest_[other]) continue;
      nearest_[other] = distance;
      queue_.push({distance, other, p});
    }
  }

  const geometry::PointCloud& cloud_;
  const Links& links_;
  double per_square_m_;
  double per_square_turn_;
  Patches grown_;  ///< centers and normals are sums until the end
  std::priority_queue<Candidate> queue_;
  std::vector<double> nearest_;  ///< of each point, to the patches that wait for it
};

}  // namespace

Links FindLinks(const geometry::PointCloud& cloud, const ConvexityOptions& options) {
  const KdTree tree(cloud.points);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // both ways
  const auto link = [&](std::uint32_t a, std::uint32_t b) {
    pairs.emplace_back(a, b);
    pairs.emplace_back(b, a);
  };
  std::vector<KdTree::Neighbor> near;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    tree.Within(cloud.points[i], options.link_m, near);
    for (const auto& n : near) {
      if (n.index < i) link(i, n.index);
    }
    const Eigen::Vector3d line = LineOf(cloud, i, near, options.on_a_line);
    if (line.isZero()) continue;
    tree.Within(cloud.points[i], options.grazing_reach * options.link_m, near);
    std::ranges::sort(near, {},
                      [](const auto& n) { return std::pair(n.squared_distance, n.index); });
    int left = options.few_links;
    for (const auto& n : near) {
      if (left == 0) break;
      if (n.squared_distance < options.link_m * options.link_m) continue;
      const Eigen::Vector3d d = cloud.points[n.index] - cloud.points[i];
      if (std::abs(line.dot(d)) > options.max_along_line * d.norm()) continue;
      if (!Tangential(cloud, i, n.index, options.max_link_slope)) continue;
      link(i, n.index);
      --left;
    }
  }
  return geometry::Unique(geometry::MakeAdjacency(pairs, cloud.size()));
}

Patches GrowPatches(const geometry::PointCloud& cloud, const Links& links,
                    const ConvexityOptions& options) {
  return Growth(cloud, links, options).Run(FindSeeds(cloud, options));
}

}  // namespace rangegrasp::perception::internal
