#include "parts/mirror/internal/hull_side.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "geometry/union_find.h"

namespace rangegrasp::parts {
namespace {

// Share of the hull's size (of its distance from the center) by which rounding may be off.
constexpr double kSlack = 1e-9;
// Triangles whose planes differ by less are one facet: else the search would stand still on it.
constexpr double kSamePlane = 1e-9;

using TrianglePair = std::array<std::uint32_t, 2>;

// Triangles that share an edge.
std::vector<TrianglePair> Neighbors(const geometry::TriangleMesh& hull) {
  struct Side {
    std::uint32_t a, b, triangle;
  };
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < hull.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(hull.triangles[t][i], hull.triangles[t][(i + 1) % 3]);
      sides.push_back({a, b, t});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::tie(p.a, p.b, p.triangle) < std::tie(q.a, q.b, q.triangle);
  });
  std::vector<TrianglePair> pairs;
  for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
    if (sides[k].a == sides[k + 1].a && sides[k].b == sides[k + 1].b) {
      pairs.push_back({sides[k].triangle, sides[k + 1].triangle});
    }
  }
  return pairs;
}

}  // namespace

HullSide::HullSide(const geometry::TriangleMesh& hull, const Eigen::Vector3d& center)
    : center_(center) {
  if (hull.triangles.empty()) return;
  for (const Eigen::Vector3d& v : hull.vertices) {
    outer_squared_ = std::max(outer_squared_, (v - center).squaredNorm());
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : hull.triangles) {
    const Eigen::Vector3d a = hull.vertices[t[0]] - center;
    const Eigen::Vector3d normal =
        (hull.vertices[t[1]] - center - a).cross(hull.vertices[t[2]] - center - a).normalized();
    facets_.push_back({normal, normal.dot(a)});
    nearest = std::min(nearest, facets_.back().offset);
  }
  center_inside_ = nearest > kSlack * std::sqrt(outer_squared_);
  if (!center_inside_) return;
  inner_squared_ = nearest * nearest;
  LinkFacets(hull);
}

// The plane n . x = d becomes n / d, a corner of the dual body; triangles of one plane one corner.
void HullSide::LinkFacets(const geometry::TriangleMesh& hull) {
  const std::vector<Facet> planes = std::move(facets_);
  facets_.clear();
  const auto dual = [&planes](std::uint32_t t) {
    return Eigen::Vector3d(planes[t].normal / planes[t].offset);
  };
  const auto pairs = Neighbors(hull);
  geometry::UnionFind sets(planes.size());
  for (const auto& [t, u] : pairs) {
    if ((dual(t) - dual(u)).norm() <= kSamePlane * dual(t).norm()) sets.Unite(t, u);
  }
  std::vector<std::int32_t> facet;
  const auto count = geometry::LabelBySize(sets, std::vector<bool>(planes.size(), true), facet);
  facets_.resize(static_cast<std::size_t>(count));
  for (std::uint32_t t = 0; t < planes.size(); ++t) {
    facets_[static_cast<std::size_t>(facet[t])] = {dual(t), 1.0};
  }
  std::vector<TrianglePair> links;
  for (const auto& [t, u] : pairs) {
    if (facet[t] == facet[u]) continue;
    const auto from = static_cast<std::uint32_t>(facet[t]);
    const auto to = static_cast<std::uint32_t>(facet[u]);
    links.push_back({from, to});
    links.push_back({to, from});
  }
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  begin_.assign(facets_.size() + 1, 0);
  for (const auto& [from, to] : links) {
    ++begin_[from + 1];
    neighbor_.push_back(to);
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
}

bool HullSide::Contains(const Eigen::Vector3d& p, Hint& hint) const {
  if (facets_.empty()) return false;
  const Eigen::Vector3d d = p - center_;
  const double squared = d.squaredNorm();
  if (squared > outer_squared_ * (1.0 + 2.0 * kSlack)) return false;
  if (!center_inside_) {
    const double slack = kSlack * std::sqrt(outer_squared_);
    return std::ranges::all_of(
        facets_, [&](const Facet& facet) { return facet.normal.dot(d) <= facet.offset + slack; });
  }
  if (squared < inner_squared_) return true;
  return Highest(d, hint) <= 1.0 + kSlack;
}

bool HullSide::ContainsWell(const Eigen::Vector3d& p, Hint& hint) const {
  if (!center_inside_) return false;
  const Eigen::Vector3d d = p - center_;
  const double squared = d.squaredNorm();
  if (squared >= outer_squared_) return false;
  return squared < inner_squared_ * (1.0 - 2.0 * kSlack) || Highest(d, hint) < 1.0 - kSlack;
}

// The largest of n . d over all facets.
double HullSide::Highest(const Eigen::Vector3d& d, Hint& hint) const {
  std::uint32_t facet = std::min(hint.facet, static_cast<std::uint32_t>(facets_.size() - 1));
  double value = facets_[facet].normal.dot(d);
  // The duals of a convex hull's facets are the corners of a convex body: a corner that none of its
  // neighbors is above of in direction d is the highest of all.
  for (bool climbs = true; climbs;) {
    climbs = false;
    std::uint32_t best = facet;
    for (std::uint32_t k = begin_[facet]; k < begin_[facet + 1]; ++k) {
      const double next = facets_[neighbor_[k]].normal.dot(d);
      if (next <= value) continue;
      value = next;
      best = neighbor_[k];
      climbs = true;
    }
    facet = best;
  }
  hint.facet = facet;
  return value;
}

}  // namespace rangegrasp::parts
