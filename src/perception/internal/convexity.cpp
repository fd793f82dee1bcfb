#include "perception/internal/convexity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace rangegrasp::perception::internal {
namespace {

/// Bodies while the small ones join their neighbors.
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
    // Points at the border of the two are inside now; which of them lie at another, too, is not
    // known: taken as none.
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

}  // namespace

std::vector<Border> FindBorders(const geometry::PointCloud& cloud, const Links& links,
                                const Patches& patches) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Border> found;
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
  std::vector<Border> borders;
  for (auto& [pair, border] : found) {
    border.a = pair.first;
    border.b = pair.second;
    border.across /= static_cast<double>(border.links);
    borders.push_back(border);
  }
  return borders;
}

double Togetherness(const Patch& a, const Patch& b, const Border& border,
                    const ConvexityOptions& options) {
  const double angle = std::acos(std::clamp(a.normal.dot(b.normal), -1.0, 1.0));
  const Eigen::Vector3d between = (b.center - a.center).normalized();
  const double bend = (b.normal - a.normal).dot(between);
  if (angle < options.concavity_rad) {
    const Eigen::Vector3d normal = (a.normal + b.normal).normalized();
    return std::abs(normal.dot(border.across)) > options.step_m ? -1.0 : 1.0;
  }
  if (bend > 0.0) return 1.0;
  // What both patches bend by themselves is the inside of something round, or noise.
  const double own =
      std::max(a.TurningAlong(between), b.TurningAlong(between)) * (b.center - a.center).norm();
  const double crease_rad = angle * std::clamp(1.0 - std::min(0.0, own) / bend, 0.0, 1.0);
  if (crease_rad < options.concavity_rad) return 1.0;
  return -options.concave_weight * std::min(1.0, (crease_rad - options.concavity_rad) /
                                                     (options.concave_rad - options.concavity_rad));
}

void JoinSpecks(const Links& links, const Patches& patches, const ConvexityOptions& options,
                geometry::UnionFind& bodies) {
  Specks(links, patches, options, bodies).Join();
}

}  // namespace rangegrasp::perception::internal
