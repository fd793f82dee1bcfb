#include "parts/internal/hull_side.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace rangegrasp::parts {
namespace {

constexpr double kSlack = 1e-9;
// Triangles whose planes differ by less are one facet: else the search would stand still on it.
constexpr double kSamePlane = 1e-9;

struct Side {
  std::uint32_t a, b, facet;
};

std::vector<Side> SortedSides(const geometry::TriangleMesh& hull,
                              const std::vector<std::uint32_t>& facet) {
  std::vector<Side> sides;
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(hull.triangles[t][i], hull.triangles[t][(i + 1) % 3]);
      sides.push_back({a, b, facet[t]});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::tie(p.a, p.b, p.facet) < std::tie(q.a, q.b, q.facet);
  });
  return sides;
}

}  // namespace

HullSide::HullSide(const geometry::TriangleMesh& hull, const Eigen::Vector3d& center)
    : center_(center) {
  if (hull.triangles.empty()) return;
  for (const Eigen::Vector3d& v : hull.vertices) {
    outer_squared_ = std::max(outer_squared_, (v - center).squaredNorm());
  }
  const double size = std::sqrt(outer_squared_);
  std::vector<Facet> planes;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : hull.triangles) {
    const Eigen::Vector3d a = hull.vertices[t[0]] - center;
    const Eigen::Vector3d normal =
        (hull.vertices[t[1]] - center - a).cross(hull.vertices[t[2]] - center - a).normalized();
    planes.push_back({normal, normal.dot(a)});
    nearest = std::min(nearest, planes.back().offset);
  }
  center_inside_ = nearest > kSlack * size;
  if (!center_inside_) {
    facets_ = std::move(planes);
    return;
  }
  inner_squared_ = nearest * nearest;
  // Duals: the plane n . x = d becomes the point n / d.
  std::vector<std::uint32_t> facet;
  std::vector<std::uint32_t> order(planes.size());
  std::iota(order.begin(), order.end(), 0U);
  for (Facet& plane : planes) plane.normal /= plane.offset;
  // Triangles of one facet stand side by side: those that share an edge are compared.
  facet.resize(planes.size());
  std::iota(facet.begin(), facet.end(), 0U);
  const auto triangle_sides = SortedSides(hull, facet);
  const auto root = [&facet](std::uint32_t i) {
    while (facet[i] != i) i = facet[i] = facet[facet[i]];
    return i;
  };
  for (std::size_t k = 0; k + 1 < triangle_sides.size(); ++k) {
    const Side& p = triangle_sides[k];
    const Side& q = triangle_sides[k + 1];
    if (p.a != q.a || p.b != q.b) continue;
    const Eigen::Vector3d difference = planes[p.facet].normal - planes[q.facet].normal;
    if (difference.norm() > kSamePlane * planes[p.facet].normal.norm()) continue;
    const std::uint32_t low = std::min(root(p.facet), root(q.facet));
    facet[std::max(root(p.facet), root(q.facet))] = low;
  }
  std::vector<std::uint32_t> number(planes.size(), 0);
  for (std::uint32_t t = 0; t < planes.size(); ++t) {
    if (root(t) != t) continue;
    number[t] = static_cast<std::uint32_t>(facets_.size());
    facets_.push_back(planes[t]);
  }
  std::vector<std::uint32_t> merged(planes.size());
  for (std::uint32_t t = 0; t < planes.size(); ++t) merged[t] = number[root(t)];
  const auto sides = SortedSides(hull, merged);
  std::vector<std::array<std::uint32_t, 2>> links;
  for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
    const Side& p = sides[k];
    const Side& q = sides[k + 1];
    if (p.a != q.a || p.b != q.b || p.facet == q.facet) continue;
    links.push_back({p.facet, q.facet});
    links.push_back({q.facet, p.facet});
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
  // neighbours is above of in direction d is the highest of all.
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
