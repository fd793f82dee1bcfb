#include "parts/mirror/internal/spherical_mirror.h"

#include <CGAL/Min_sphere_of_points_d_traits_3.h>
#include <CGAL/Min_sphere_of_spheres_d.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

// Tolerance for rounding, relative to the hull's size (to its distance from the center).
constexpr double kSlack = 1e-9;
// Triangles whose planes differ by less are one facet; otherwise the search would get stuck on it.
constexpr double kSamePlane = 1e-9;

// The lowest 21 bits, with two zero bits before each.
std::uint64_t Spread(std::uint64_t x) {
  x = (x | x << 32U) & 0x001F00000000FFFFU;
  x = (x | x << 16U) & 0x001F0000FF0000FFU;
  x = (x | x << 8U) & 0x100F00F00F00F00FU;
  x = (x | x << 4U) & 0x10C30C30C30C30C3U;
  x = (x | x << 2U) & 0x1249249249249249U;
  return x;
}

}  // namespace

Sphere SmallestEnclosingSphere(geometry::PointSpan points) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Traits = CGAL::Min_sphere_of_points_d_traits_3<Kernel, double>;
  std::vector<Kernel::Point_3> input;
  input.reserve(points.size());
  for (const Eigen::Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  CGAL::Min_sphere_of_spheres_d<Traits> sphere(input.begin(), input.end());
  const double* center = sphere.center_cartesian_begin();
  return {{center[0], center[1], center[2]}, sphere.radius()};
}

Sphere SphereRound(const Eigen::Vector3d& center, geometry::PointSpan points) {
  double square = 0.0;
  for (const Eigen::Vector3d& p : points) square = std::max(square, (p - center).squaredNorm());
  return {center, std::sqrt(square)};
}

Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere) {
  const Eigen::Vector3d d = p - sphere.center;
  const double radius = d.norm();
  if (!(radius > 0.0)) return sphere.center + Eigen::Vector3d(2.0 * sphere.radius, 0.0, 0.0);
  return p + 2.0 * (sphere.radius - radius) * d / radius;
}

Points MirrorOut(geometry::PointSpan points, const Sphere& sphere) {
  Points images;
  images.reserve(points.size());
  for (const Eigen::Vector3d& p : points) images.push_back(MirrorOut(p, sphere));
  return images;
}

Eigen::Vector3d MirrorIn(const Eigen::Vector3d& mirrored, const Sphere& sphere, double offset) {
  const Eigen::Vector3d d = mirrored - sphere.center;
  const double radius = d.norm();
  return mirrored + 2.0 * (sphere.radius + offset - radius) * d / radius;
}

double Offset(const Eigen::Vector3d& p, std::span<const Eigen::Vector3d> neighbors,
              const Eigen::Vector3d& center) {
  if (neighbors.empty()) return 0.0;
  const double radius = (p - center).norm();
  double sum = 0.0;
  for (const Eigen::Vector3d& n : neighbors) sum += std::abs((n - center).norm() - radius);
  return sum / static_cast<double>(neighbors.size());
}

std::size_t CubeCell(const Eigen::Vector3d& direction, int side) {
  Eigen::Index axis = 0;
  const double largest = direction.cwiseAbs().maxCoeff(&axis);
  if (!(largest > 0.0)) return 0;
  const auto cell = [&](Eigen::Index i) {
    const double u = 0.5 * (1.0 + direction[(axis + i) % 3] / largest);
    return std::min(side - 1, static_cast<int>(u * side));
  };
  const int face = 2 * static_cast<int>(axis) + (direction[axis] > 0.0 ? 1 : 0);
  return static_cast<std::size_t>((face * side + cell(1)) * side + cell(2));
}

Indices SpatialOrder(geometry::PointSpan points) {
  if (points.empty()) return {};
  const Eigen::AlignedBox3d box = geometry::BoundsOf(points);
  const double extent = box.sizes().maxCoeff();
  const double scale = extent > 0.0 ? 2097151.0 / extent : 0.0;  // 21 bits
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d u = (points[i] - box.min()) * scale;
    const auto bits = [&u](int axis) { return Spread(static_cast<std::uint64_t>(u[axis])); };
    keys.emplace_back(bits(0) | bits(1) << 1U | bits(2) << 2U, i);
  }
  std::sort(keys.begin(), keys.end());
  Indices order;
  for (const auto& [key, i] : keys) order.push_back(i);
  return order;
}

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

// The plane n . x = d becomes the corner n / d of the dual body; coplanar triangles share one.
void HullSide::LinkFacets(const geometry::TriangleMesh& hull) {
  const std::vector<Facet> planes = std::move(facets_);
  const auto dual = [&planes](std::uint32_t t) {
    return Eigen::Vector3d(planes[t].normal / planes[t].offset);
  };
  const FaceGraph triangles = BuildFaceGraph({hull.vertices, hull.triangles, {}});
  const Pieces pieces = ConnectedPieces(triangles, [&](std::uint32_t t, std::uint32_t u) {
    return t < u && (dual(t) - dual(u)).norm() <= kSamePlane * dual(t).norm();
  });
  const Labels& facet = pieces.label;
  facets_.assign(pieces.count, {});
  for (std::uint32_t t = 0; t < planes.size(); ++t) facets_[facet[t]] = {dual(t), 1.0};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
  ForEachLink(triangles, [&](std::uint32_t t, std::uint32_t u, std::uint32_t) {
    if (facet[u] != facet[t]) links.emplace_back(facet[t], facet[u]);
  });
  neighbors_ = geometry::MakeAdjacency(links, facets_.size());
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
  // The duals of a convex hull's facets are the corners of a convex body. A corner that has no
  // higher neighbor in direction d is therefore the highest of all.
  for (bool climbs = true; climbs;) {
    climbs = false;
    std::uint32_t best = facet;
    for (const std::uint32_t neighbor : neighbors_.Of(facet)) {
      const double next = facets_[neighbor].normal.dot(d);
      if (next <= value) continue;
      value = next;
      best = neighbor;
      climbs = true;
    }
    facet = best;
  }
  hint.facet = facet;
  return value;
}

}  // namespace rangegrasp::parts
