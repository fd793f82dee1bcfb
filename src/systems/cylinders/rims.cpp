#include "cylinders/rims.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace rangegrasp::cylinders {
namespace {

/// Ratio of twice a triangle's area, squared, to the product of its two longer sides, squared.
/// Below it the corners are collinear within double precision for coordinates of about a metre.
constexpr double kCollinear = 1e-12;

/// The first point at least step_m from point i along its scan line, forward or backward. With a
/// step of 0, the next or previous stored point, on any line.
std::optional<std::size_t> Along(geometry::PointSpan points, std::span<const std::uint32_t> lines,
                                 std::size_t i, bool forward, double step_m) {
  std::size_t at = i;
  for (;;) {
    if (forward ? at + 1 == points.size() : at == 0) return std::nullopt;
    at = forward ? at + 1 : at - 1;
    if (!(step_m > 0.0)) return at;
    if (lines[at] != lines[i]) return std::nullopt;
    if ((points[at] - points[i]).squaredNorm() >= step_m * step_m) return at;
  }
}

}  // namespace

double EdgeCosine(const Eigen::Vector3d& before, const Eigen::Vector3d& p,
                  const Eigen::Vector3d& after) {
  const Eigen::Vector3d back = p - before;
  const Eigen::Vector3d ahead = p - after;
  const double lengths = back.norm() * ahead.norm();
  return lengths > 0.0 ? back.dot(ahead) / lengths : -1.0;
}

Eigen::Matrix3d SensorAxes(const Eigen::Vector3d& up, const Eigen::Vector3d& to_sensor) {
  const Eigen::Vector3d y = to_sensor.cross(up).stableNormalized();
  Eigen::Matrix3d axes;
  axes << up, y, up.cross(y);
  return axes;
}

std::vector<bool> CurvedPoints(const geometry::PointCloud& cloud, const geometry::KdTree& tree,
                               const CurvatureOptions& options,
                               const geometry::NeighborLists& known) {
  const double max_cosine = std::cos(options.min_angle_rad);
  const bool usable = known.radius_m == options.radius_m;
  std::vector<bool> curved(cloud.size(), false);
  std::vector<geometry::KdTree::Neighbor> near;
  geometry::Indices searched;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    std::span<const std::uint32_t> neighbors;
    if (usable && known.Has(i)) {
      neighbors = known.Of(i);
    } else {
      tree.Within(cloud.points[i], options.radius_m, near);
      searched.clear();
      for (const auto& neighbor : near) searched.push_back(neighbor.index);
      neighbors = searched;
    }
    // Mean cosine of unit normals, from their sum. The neighbors include the point itself.
    Eigen::Vector3d sum = -cloud.normals[i];
    for (const auto k : neighbors) sum += cloud.normals[k];
    const auto others = static_cast<double>(neighbors.size()) - 1.0;
    curved[i] = others > 0.0 && cloud.normals[i].dot(sum) < max_cosine * others;
  }
  return curved;
}

std::vector<bool> LineEdges(geometry::PointSpan points, std::span<const std::uint32_t> lines,
                            const CurvatureOptions& options) {
  const double min_cosine = std::cos(options.max_edge_angle_rad);
  std::vector<bool> edges(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto before = Along(points, lines, i, false, options.line_step_m);
    const auto after = Along(points, lines, i, true, options.line_step_m);
    if (!before || !after) continue;
    edges[i] = EdgeCosine(points[*before], points[i], points[*after]) > min_cosine;
  }
  return edges;
}

double MeanNeighborDistance(geometry::PointSpan points, const geometry::KdTree& tree,
                            double radius_m) {
  double sum_m = 0.0;
  std::size_t count = 0;
  std::vector<geometry::KdTree::Neighbor> near;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], radius_m, near);
    double of_one = 0.0;
    for (const auto& neighbor : near) of_one += std::sqrt(neighbor.squared_distance);
    if (near.size() < 2) continue;  // only the point itself
    sum_m += of_one / static_cast<double>(near.size() - 1);
    ++count;
  }
  return count == 0 ? 0.0 : sum_m / static_cast<double>(count);
}

std::vector<geometry::Indices> Fragments(geometry::PointSpan points,
                                         const FragmentOptions& options) {
  if (points.empty()) return {};
  const geometry::KdTree tree(points);
  double link_m = 0.0;
  if (!(options.link > 0.0)) {
    link_m = MeanNeighborDistance(points, tree, options.neighborhood_m);
  } else if (points.size() > 1) {
    link_m = options.link * geometry::NearestNeighborDistances(points, tree).mean_m;
  }
  auto groups = geometry::GroupsWithin(points, tree, link_m);
  std::erase_if(groups, [&](const geometry::Indices& group) {
    return group.size() < static_cast<std::size_t>(options.min_points);
  });
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

TriangleProducts ProductsOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c) {
  const double d_ca = (c - a).dot(b - a);
  const double d_ba = (c - b).dot(a - b);
  const double d_cb = (a - c).dot(b - c);
  return {d_ca, d_ba, d_cb, d_ba * d_cb, d_cb * d_ca, d_ca * d_ba};
}

double CircumradiusOf(const TriangleProducts& p) {
  return 0.5 * std::sqrt((p.d_ca + p.d_ba) * (p.d_ba + p.d_cb) * (p.d_cb + p.d_ca) / p.Sum());
}

std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) {
  const TriangleProducts p = ProductsOf(a, b, c);
  const double sum = p.Sum();
  const double sides = p.d_ca + p.d_ba + p.d_cb;  // half the sum of the squared sides
  if (!(sum > kCollinear * sides * sides)) return std::nullopt;
  return Circle{((p.n_2 + p.n_3) * a + (p.n_3 + p.n_1) * b + (p.n_1 + p.n_2) * c) / (2.0 * sum),
                (b - a).cross(c - a).normalized(), CircumradiusOf(p)};
}

double DistanceTo(const Circle& circle, const Eigen::Vector3d& p, CircleDistance distance) {
  const Eigen::Vector3d from_center = p - circle.center;
  if (distance == CircleDistance::kSphere) return std::abs(from_center.norm() - circle.radius_m);
  const double off_plane = from_center.dot(circle.normal);
  const double in_plane = (from_center - off_plane * circle.normal).norm();
  return std::hypot(in_plane - circle.radius_m, off_plane);
}

double SumOfDistances(const Circle& circle, geometry::PointSpan rim, double enough_m) {
  double sum_m = 0.0;
  for (const Eigen::Vector3d& p : rim) {
    sum_m += DistanceTo(circle, p, CircleDistance::kCurve);
    if (sum_m > enough_m) break;
  }
  return sum_m;
}

double ShareOn(const Circle& circle, geometry::PointSpan rim, CircleDistance distance,
               double tolerance_m) {
  if (rim.empty()) return 0.0;
  std::size_t on = 0;
  for (const Eigen::Vector3d& p : rim) on += DistanceTo(circle, p, distance) <= tolerance_m;
  return static_cast<double>(on) / static_cast<double>(rim.size());
}

std::optional<Circle> FitRandomCircle(geometry::PointSpan rim, int draws, base::Rng& rng) {
  if (rim.size() < 3) return std::nullopt;
  std::optional<Circle> best;
  double least_m = std::numeric_limits<double>::infinity();
  for (int draw = 0; draw < draws; ++draw) {
    const std::size_t a = rng.Index(rim.size());
    const std::size_t b = rng.Index(rim.size());
    const std::size_t c = rng.Index(rim.size());
    const auto circle = CircleThrough(rim[a], rim[b], rim[c]);  // none if a point is drawn twice
    if (!circle) continue;
    const double sum_m = SumOfDistances(*circle, rim, least_m);
    if (best && !(sum_m < least_m)) continue;
    best = circle;
    least_m = sum_m;
  }
  return best;
}

}  // namespace rangegrasp::cylinders
