#include "perception/segment.h"

#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <stdexcept>

#include "geometry/alpha_shape.h"
#include "geometry/graph.h"

namespace rangegrasp::perception {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::Indices;
using geometry::KdTree;
using geometry::PointCloud;
using geometry::PointSpan;

/// The neighbors of each point on a surface, ascending. Symmetric.
using Links = geometry::Adjacency;

/// A small, nearly flat piece of surface.
struct Patch {
  std::uint32_t points = 0;
  Vector3d center = Vector3d::Zero();
  Vector3d normal = Vector3d::Zero();   ///< unit, as the points' normals
  Matrix3d spread = Matrix3d::Zero();   ///< sum of d d^T, d from the center [m^2]
  Matrix3d turning = Matrix3d::Zero();  ///< sum of (n - normal) d^T [m]

  /// How fast its normals turn along a direction [rad/m], by least squares; > 0: convex along it.
  double TurningAlong(const Vector3d& direction) const {
    const double length = direction.dot(spread * direction);
    return length > 0.0 ? direction.dot(turning * direction) / length : 0.0;
  }
};
struct Patches {
  std::vector<Patch> patches;
  std::vector<std::uint32_t> patch_of;  ///< one per point
};

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Whether a and b lie in each other's tangent planes, within the angle of the slope.
bool Tangential(const PointCloud& cloud, std::uint32_t a, std::uint32_t b, double max_slope) {
  const Vector3d d = cloud.points[b] - cloud.points[a];
  const double most = max_slope * d.norm();
  return std::abs(cloud.normals[a].dot(d)) <= most && std::abs(cloud.normals[b].dot(d)) <= most;
}

/// The direction of the line that a point's neighbors lie on; zero if they spread across it, too.
Vector3d LineOf(const PointCloud& cloud, std::uint32_t point,
                const std::vector<KdTree::Neighbor>& near, double on_a_line) {
  // The furthest neighbor gives the line's direction, the others their distance from the line.
  const auto furthest = std::ranges::max_element(
      near, {}, [](const auto& n) { return std::pair(n.squared_distance, n.index); });
  const Vector3d line = (cloud.points[furthest->index] - cloud.points[point]).normalized();
  double along = 0.0;
  double across = 0.0;
  for (const auto& n : near) {
    const Vector3d d = cloud.points[n.index] - cloud.points[point];
    const double on = line.dot(d);
    along += on * on;
    across += n.squared_distance - on * on;
  }
  if (across > on_a_line * on_a_line * along) return Vector3d::Zero();
  return line.isZero() ? cloud.normals[point] : line;  // alone: any direction in its plane
}

/// The place and the facing of a seed: both sides of an edge or a thin wall have their own.
std::array<long, 4> CellOf(const Vector3d& p, const Vector3d& normal, double size_m) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return {std::lround(p.x() / size_m), std::lround(p.y() / size_m), std::lround(p.z() / size_m),
          2 * axis + (normal[axis] < 0.0 ? 1 : 0)};
}

/// The point nearest to the middle of each cell's points, in the order of the cells.
Indices FindSeeds(const PointCloud& cloud, const ConvexityOptions& options) {
  std::map<std::array<long, 4>, Indices> cells;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    cells[CellOf(cloud.points[i], cloud.normals[i], options.patch_m)].push_back(i);
  }
  Indices seeds;
  for (const auto& [cell, points] : cells) {
    if (points.size() < static_cast<std::size_t>(options.min_seed_points)) continue;
    const Vector3d middle = geometry::Centroid(geometry::Select(cloud.points, points));
    seeds.push_back(*std::ranges::min_element(
        points, {}, [&](std::uint32_t i) { return (cloud.points[i] - middle).squaredNorm(); }));
  }
  return seeds;
}

/// Splits a surface into connected patches of about patch_m that do not bend. They grow along the
/// links from seeds spread evenly over places and directions, nearest first, by distance and normal
/// (simple non-iterative clustering: Achanta and Suesstrunk 2017). O(m log m), m links.
class PatchGrowth {
 public:
  PatchGrowth(const PointCloud& cloud, const Links& links, const ConvexityOptions& options)
      : cloud_(cloud),
        links_(links),
        per_square_m_(1.0 / (options.patch_m * options.patch_m)),
        per_square_turn_(1.0 / (options.patch_turn * options.patch_turn)) {
    grown_.patch_of.assign(cloud.size(), kNone);
    nearest_.assign(cloud.size(), std::numeric_limits<double>::infinity());
  }

  Patches Run(const Indices& seeds) {
    for (const auto seed : seeds) Open(seed);
    Empty();
    // Points that no seed reached: pieces with too few points for one.
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
      const Vector3d d = cloud_.points[i] - patch.center;
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
    auto operator<=>(const Candidate&) const = default;
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
    const Vector3d center = patch.center / static_cast<double>(patch.points);
    const Vector3d normal = patch.normal.normalized();
    for (const auto other : links_.Of(point)) {
      if (grown_.patch_of[other] != kNone) continue;
      const double distance = (cloud_.points[other] - center).squaredNorm() * per_square_m_ +
                              (cloud_.normals[other] - normal).squaredNorm() * per_square_turn_;
      // A nearer patch that waits for the point will get it.
      if (distance > nearest_[other]) continue;
      nearest_[other] = distance;
      queue_.push({distance, other, p});
    }
  }

  const PointCloud& cloud_;
  const Links& links_;
  double per_square_m_;
  double per_square_turn_;
  Patches grown_;  ///< centers and normals are sums until the end
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
  std::vector<double> nearest_;  ///< distance of each point to the patches that wait for it
};

/// Links points within link_m and, on a surface seen at a grazing angle, further ones in its plane.
Links FindLinks(const PointCloud& cloud, const ConvexityOptions& options) {
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
    const Vector3d line = LineOf(cloud, i, near, options.on_a_line);
    if (line.isZero()) continue;
    tree.Within(cloud.points[i], options.grazing_reach * options.link_m, near);
    std::ranges::sort(near, {},
                      [](const auto& n) { return std::pair(n.squared_distance, n.index); });
    int left = options.few_links;
    for (const auto& n : near) {
      if (left == 0) break;
      if (n.squared_distance < options.link_m * options.link_m) continue;
      const Vector3d d = cloud.points[n.index] - cloud.points[i];
      if (std::abs(line.dot(d)) > options.max_along_line * d.norm()) continue;
      if (!Tangential(cloud, i, n.index, options.max_link_slope)) continue;
      link(i, n.index);
      --left;
    }
  }
  return geometry::MakeAdjacency(pairs, cloud.size());
}

/// The border of two patches a < b.
struct Border {
  std::uint32_t links = 0;             ///< number of links across it: its length
  Vector3d across = Vector3d::Zero();  ///< mean of the links from a to b [m]
};
using Borders = std::map<std::pair<std::uint32_t, std::uint32_t>, Border>;

/// Specks and slivers join the neighbor with the longest common border, the smallest first.
class Specks {
 public:
  Specks(const Links& links, const Patches& patches, const ConvexityOptions& options,
         geometry::UnionFind& bodies)
      : bodies_(bodies), options_(options), of_(patches.patches.size()) {
    std::vector<bool> near_border(patches.patch_of.size(), false);
    for (std::uint32_t i = 0; i < patches.patch_of.size(); ++i) {
      const std::uint32_t own = bodies_.Find(patches.patch_of[i]);
      ++of_[own].points;
      for (const auto k : links.Of(i)) {
        const std::uint32_t other = bodies_.Find(patches.patch_of[k]);
        if (other == own) continue;
        ++of_[own].border[other];
        near_border[i] = true;
      }
    }
    const auto hops = std::lround(options.sliver_depth * options.patch_m / options.link_m);
    for (long hop = 1; hop < hops; ++hop) Widen(links, patches, near_border);
    for (std::uint32_t i = 0; i < patches.patch_of.size(); ++i) {
      of_[bodies_.Find(patches.patch_of[i])].at_border += near_border[i] ? 1 : 0;
    }
    speck_ = options.speck_patches * static_cast<double>(patches.patch_of.size()) /
             std::max(1.0, static_cast<double>(patches.patches.size()));
  }

  void Join() {
    for (std::uint32_t root = 0; root < of_.size(); ++root) Consider(root);
    while (!small_.empty()) {
      const std::uint32_t root = small_.begin()->second;
      const std::uint32_t into = std::ranges::max_element(of_[root].border, {}, [](const auto& s) {
                                   return s.second;
                                 })->first;
      small_.erase({of_[root].points, root});
      small_.erase({of_[into].points, into});
      bodies_.Unite(root, into);
      const std::uint32_t kept = bodies_.Find(into);
      Absorb(kept == into ? root : into, kept);
      Consider(kept);
    }
  }

 private:
  struct Body {
    std::uint32_t points = 0;
    std::uint32_t at_border = 0;                    ///< points with a link to another body
    std::map<std::uint32_t, std::uint32_t> border;  ///< links to each other body
  };

  /// Marks the points of the same body that have a link to a marked one.
  void Widen(const Links& links, const Patches& patches, std::vector<bool>& marked) {
    std::vector<bool> wider = marked;
    for (std::uint32_t i = 0; i < marked.size(); ++i) {
      if (!marked[i]) continue;
      for (const auto k : links.Of(i)) {
        if (bodies_.Find(patches.patch_of[k]) == bodies_.Find(patches.patch_of[i])) wider[k] = true;
      }
    }
    marked = std::move(wider);
  }

  void Consider(std::uint32_t root) {
    const Body& body = of_[root];
    if (body.points == 0 || body.border.empty()) return;
    const bool speck = body.points < speck_;
    const bool sliver = body.at_border > options_.sliver_share * body.points;
    if (speck || sliver) small_.emplace(body.points, root);
  }

  void Absorb(std::uint32_t gone, std::uint32_t kept) {
    of_[kept].points += of_[gone].points;
    // Points at the border of the two are now inside. How many of them also lie at another border
    // is not known; none is assumed.
    of_[kept].at_border -= std::min(of_[kept].at_border, of_[gone].at_border);
    for (const auto& [other, links] : of_[gone].border) {
      of_[other].border.erase(gone);
      if (other == kept) continue;
      of_[kept].border[other] += links;
      of_[other].border[kept] += links;
    }
    of_[gone] = {};
  }

  geometry::UnionFind& bodies_;
  const ConvexityOptions& options_;
  std::vector<Body> of_;  ///< by root
  double speck_ = 0.0;
  std::set<std::pair<std::uint32_t, std::uint32_t>> small_;  ///< points and root
};

Borders FindBorders(const PointCloud& cloud, const Links& links, const Patches& patches) {
  Borders found;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    for (const auto k : links.Of(i)) {
      const std::uint32_t a = patches.patch_of[i];
      const std::uint32_t b = patches.patch_of[k];
      if (a >= b) continue;
      Border& border = found[{a, b}];
      ++border.links;
      border.across += cloud.points[k] - cloud.points[i];
    }
  }
  for (auto& [pair, border] : found) border.across /= static_cast<double>(border.links);
  return found;
}

/// How much a border counts for its patches being one body, at most 1: see SegmentByConvexity.
double Togetherness(const Patch& a, const Patch& b, const Border& border,
                    const ConvexityOptions& options) {
  const double angle = std::acos(std::clamp(a.normal.dot(b.normal), -1.0, 1.0));
  const Vector3d between = (b.center - a.center).normalized();
  const double bend = (b.normal - a.normal).dot(between);
  if (angle < options.concavity_rad) {
    const Vector3d normal = (a.normal + b.normal).normalized();
    return std::abs(normal.dot(border.across)) > options.step_m ? -1.0 : 1.0;
  }
  if (bend > 0.0) return 1.0;
  // Bending of both patches by themselves is the inside of something round, or noise.
  const double own =
      std::max(a.TurningAlong(between), b.TurningAlong(between)) * (b.center - a.center).norm();
  const double crease_rad = angle * std::clamp(1.0 - std::min(0.0, own) / bend, 0.0, 1.0);
  if (crease_rad < options.concavity_rad) return 1.0;
  return -options.concave_weight * std::min(1.0, (crease_rad - options.concavity_rad) /
                                                     (options.concave_rad - options.concavity_rad));
}

/// The segments with enough points, largest first, ties by first point.
std::vector<Indices> LargestFirst(std::vector<Indices> segments, const SegmentOptions& options) {
  const int min_points = options.drop_small_segments ? std::max(options.min_points, 1) : 1;
  std::erase_if(segments, [&](const Indices& one) { return std::ssize(one) < min_points; });
  std::ranges::sort(segments, {},
                    [](const Indices& one) { return std::pair(-std::ssize(one), one.front()); });
  return segments;
}

}  // namespace

double MeshAlpha(double d_max_m, const SegmentOptions& options) {
  if (!options.bounded_alpha) return d_max_m;
  return std::clamp<double>(d_max_m, options.min_alpha_m, options.max_alpha_m);
}

std::vector<Indices> SegmentByMesh(PointSpan points, const SegmentOptions& options) {
  if (points.size() < 3) return {};
  const double d_max_m = geometry::NearestNeighborDistances(points, KdTree(points)).max_m;
  geometry::UnionFind sets(points.size());
  std::vector<bool> used(points.size(), false);
  for (const auto& [a, b, c] : geometry::AlphaTriangles(points, MeshAlpha(d_max_m, options))) {
    used[a] = used[b] = used[c] = true;
    sets.Unite(a, b);
    sets.Unite(a, c);
  }
  const Indices twin = geometry::FirstTwin(points, geometry::CanonicalOrder(points));
  std::vector<Indices> segments(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (used[twin[i]]) segments[sets.Find(twin[i])].push_back(i);
  }
  return LargestFirst(std::move(segments), options);
}

double NormalWeight(const Vector3d& a, const Vector3d& b) {
  return 1.0 - std::abs(a.dot(b) / (a.norm() * b.norm()));
}

std::vector<Indices> SegmentByRegionGrowing(PointSpan points, PointSpan normals,
                                            const SegmentOptions& options) {
  if (normals.size() != points.size()) {
    throw std::invalid_argument("SegmentByRegionGrowing: needs one normal a point");
  }
  if (points.size() < 2) return {};
  const KdTree tree(points);
  const double d_a_m = geometry::NearestNeighborDistances(points, tree).mean_m;
  geometry::UnionFind regions(points.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], options.neighborhood * d_a_m, neighbors);
    for (const KdTree::Neighbor& n : neighbors) {
      if (n.index <= i || regions.Find(i) == regions.Find(n.index)) continue;
      const double distance_m = std::sqrt(n.squared_distance);
      if (distance_m * NormalWeight(normals[i], normals[n.index]) < d_a_m) {
        regions.Unite(i, n.index);
      }
    }
  }
  std::vector<Indices> segments(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) segments[regions.Find(i)].push_back(i);
  return LargestFirst(std::move(segments), options);
}

std::vector<Indices> SegmentByConvexity(const PointCloud& cloud, const SegmentOptions& options) {
  if (cloud.normals.size() != cloud.size()) {
    throw std::invalid_argument("SegmentByConvexity: needs one normal a point");
  }
  const Links links = FindLinks(cloud, options.convexity);
  const Patches grown =
      PatchGrowth(cloud, links, options.convexity).Run(FindSeeds(cloud, options.convexity));
  std::vector<geometry::SignedEdge> edges;
  for (const auto& [pair, border] : FindBorders(cloud, links, grown)) {
    const auto [a, b] = pair;
    const double together =
        Togetherness(grown.patches[a], grown.patches[b], border, options.convexity);
    edges.push_back({a, b, together * border.links});
  }
  geometry::UnionFind bodies = geometry::ContractGreedily(grown.patches.size(), edges);
  Specks(links, grown, options.convexity, bodies).Join();
  std::vector<Indices> segments(grown.patches.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    segments[bodies.Find(grown.patch_of[i])].push_back(i);
  }
  return LargestFirst(std::move(segments), options);
}

std::vector<Indices> Segment(const PointCloud& cloud, const SegmentOptions& options) {
  if (options.method == SegmentMethod::kRegionGrowing) {
    return SegmentByRegionGrowing(cloud.points, cloud.normals, options);
  }
  if (options.method == SegmentMethod::kConvexity) return SegmentByConvexity(cloud, options);
  return SegmentByMesh(cloud.points, options);
}

}  // namespace rangegrasp::perception
