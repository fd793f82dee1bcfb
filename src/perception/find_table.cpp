#include "perception/find_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "geometry/hull.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::Plane;
using geometry::Points;
using geometry::PointSpan;
using geometry::TriangleMesh;

/// A plane of the hull, its normal to the inside.
struct Candidate {
  Plane plane;
  Eigen::Vector3d center;
  double area = 0.0;
};

Plane TowardsSensor(const Plane& plane, const Eigen::Vector3d& sensor_origin) {
  if (plane.Distance(sensor_origin) >= 0.0) return plane;
  return {-plane.normal, -plane.offset_m};
}

bool IsUp(const Plane& plane, const PreprocessOptions& options) {
  return !options.up_C ||
         plane.normal.dot(options.up_C->normalized()) >= std::cos(options.table.max_tilt_rad);
}

std::vector<Candidate> HullPlanes(const TriangleMesh& hull, const Eigen::Vector3d& sensor_origin,
                                  const PreprocessOptions& options) {
  std::vector<Candidate> faces;
  for (const auto& [a, b, c] : hull.triangles) {
    // Outward faces are counter-clockwise; turned round, the normal points inside.
    const auto plane = geometry::PlaneThrough(hull.vertices[a], hull.vertices[c], hull.vertices[b]);
    if (!plane || plane->Distance(sensor_origin) <= 0.0) continue;
    if (!IsUp(*plane, options)) continue;
    const Eigen::Vector3d u = hull.vertices[b] - hull.vertices[a];
    const Eigen::Vector3d v = hull.vertices[c] - hull.vertices[a];
    faces.push_back({*plane, (hull.vertices[a] + hull.vertices[b] + hull.vertices[c]) / 3.0,
                     0.5 * u.cross(v).norm()});
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Candidate& a, const Candidate& b) { return a.area > b.area; });
  const double same_cosine = std::cos(options.table.same_plane_rad);
  const double same_distance_m = options.table.same_plane_share * options.preselection_m;
  std::vector<Candidate> merged;
  for (const Candidate& face : faces) {
    const bool known = std::any_of(merged.begin(), merged.end(), [&](const Candidate& other) {
      return face.plane.normal.dot(other.plane.normal) > same_cosine &&
             std::abs(other.plane.Distance(face.center)) < same_distance_m;
    });
    if (!known) merged.push_back(face);
  }
  return merged;
}

std::size_t CountNear(PointSpan points, const Plane& plane, double distance_m, std::size_t step) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    count += static_cast<std::size_t>(std::abs(plane.Distance(points[i])) <= distance_m);
  }
  return count;
}

/// The candidate that the most points lie near.
std::optional<Plane> DeepestPlane(PointSpan points, const std::vector<Candidate>& candidates,
                                  const PreprocessOptions& options) {
  const double distance_m = options.preselection_m;
  const std::size_t step = std::max<std::size_t>(1, points.size() / options.table.ranking_points);
  std::vector<std::pair<std::size_t, std::size_t>> ranking;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    ranking.emplace_back(CountNear(points, candidates[i].plane, distance_m, step), i);
  }
  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::optional<Plane> best;
  std::size_t best_count = 0;
  for (std::size_t k = 0; k < std::min(options.table.finalists, ranking.size()); ++k) {
    const Plane& plane = candidates[ranking[k].second].plane;
    const std::size_t count = CountNear(points, plane, distance_m, 1);
    if (count > best_count) {
      best_count = count;
      best = plane;
    }
  }
  return best;
}

/// Every so manieth point, so that about `count` are left.
Points Thinned(PointSpan points, std::size_t count) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  Points thinned;
  for (std::size_t i = 0; i < points.size(); i += step) thinned.push_back(points[i]);
  return thinned;
}

Points Near(PointSpan points, const Plane& plane, double distance_m) {
  Points near;
  for (const Eigen::Vector3d& p : points) {
    if (std::abs(plane.Distance(p)) <= distance_m) near.push_back(p);
  }
  return near;
}

/// `other` with its normal on the side of the plane's.
Plane TurnedLike(const Plane& plane, const Plane& other) {
  const bool turned = other.normal.dot(plane.normal) < 0.0;
  return turned ? Plane{-other.normal, -other.offset_m} : other;
}

/// Preselects, draws hypotheses and refits (section 5.1.1); then refits once to the points near the
/// fit, since the hull's plane may be tilted so far that its preselection has not all of the table.
/// The normal keeps its side.
std::optional<Plane> FitNear(PointSpan points, const Plane& plane, const PreprocessOptions& options,
                             base::Rng& rng) {
  const auto fit = geometry::FitPlaneRansac(
      Near(Thinned(points, options.table.ranking_points), plane, options.preselection_m),
      {options.plane_draws, options.plane_distance_m}, rng);
  if (!fit) return std::nullopt;
  const auto refit = geometry::FitPlane(Near(points, fit->plane, options.plane_distance_m));
  return TurnedLike(plane, refit ? *refit : fit->plane);
}

struct Support {
  std::size_t on = 0;     ///< within plane_distance_m
  std::size_t below = 0;  ///< deeper than preselection_m under the plane
};

Support CountSupport(PointSpan points, const Plane& plane, const PreprocessOptions& options) {
  Support support;
  for (const Eigen::Vector3d& p : points) {
    const double distance_m = plane.Distance(p);
    support.on += static_cast<std::size_t>(std::abs(distance_m) <= options.plane_distance_m);
    support.below += static_cast<std::size_t>(distance_m < -options.preselection_m);
  }
  return support;
}

bool IsTable(const Support& support, std::size_t n, const TableSearchOptions& options) {
  return static_cast<double>(support.on) >= options.min_support * static_cast<double>(n) &&
         static_cast<double>(support.below) <= options.max_below * static_cast<double>(n);
}

/// The points that are no vertex of the hull.
Points Peel(const Points& points, const TriangleMesh& hull) {
  const auto before = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  Points vertices = hull.vertices;
  std::sort(vertices.begin(), vertices.end(), before);
  Points rest;
  rest.reserve(points.size());
  for (const Eigen::Vector3d& p : points) {
    if (!std::binary_search(vertices.begin(), vertices.end(), p, before)) rest.push_back(p);
  }
  return rest;
}

/// Section 5.1.1: the deepest plane of the hull.
std::optional<Plane> PlaneUnderAll(PointSpan points, const Eigen::Vector3d& sensor_origin,
                                   const PreprocessOptions& options, base::Rng& rng) {
  Points rest = Thinned(points, options.table.hull_points);
  const int peelings = options.robust_table ? options.table.peelings : 0;
  for (int peeling = 0; peeling <= peelings; ++peeling) {
    const TriangleMesh hull = geometry::ConvexHull(rest);
    if (hull.triangles.empty()) break;
    const auto deepest = DeepestPlane(points, HullPlanes(hull, sensor_origin, options), options);
    const auto plane = deepest ? FitNear(points, *deepest, options, rng) : std::nullopt;
    if (plane && plane->Distance(sensor_origin) > 0.0 &&
        (!options.robust_table ||
         IsTable(CountSupport(points, *plane, options), points.size(), options.table))) {
      return plane;
    }
    rest = Peel(rest, hull);
  }
  return std::nullopt;
}

/// Section 4.2.1: the plane with the most points, whatever lies beneath it.
std::optional<Plane> DominantPlane(PointSpan points, const Eigen::Vector3d& sensor_origin,
                                   const PreprocessOptions& options, base::Rng& rng) {
  Points rest(points.begin(), points.end());
  for (int i = 0; i < options.table.dominant_planes; ++i) {
    const auto fit =
        geometry::FitPlaneRansac(rest, {options.plane_draws, options.plane_distance_m}, rng);
    if (!fit || static_cast<double>(fit->inliers.size()) <
                    options.table.dominant_support * static_cast<double>(points.size())) {
      return std::nullopt;
    }
    const Plane plane = TowardsSensor(fit->plane, sensor_origin);
    if (IsUp(plane, options)) return plane;
    std::erase_if(rest, [&](const Eigen::Vector3d& p) {
      return std::abs(plane.Distance(p)) <= options.plane_distance_m;
    });
  }
  return std::nullopt;
}

void Check(const PreprocessOptions& options) {
  if (!(options.preselection_m > 0.0)) {
    throw std::invalid_argument("FindTable: preselection_m must be > 0");
  }
  if (!(options.table_clearance_m >= 0.0)) {
    throw std::invalid_argument("FindTable: table_clearance_m must be >= 0");
  }
  if (options.up_C && !(options.up_C->norm() > 0.0)) {
    throw std::invalid_argument("FindTable: up_C must not be zero");
  }
}

/// A cloud that is flat has no hull: all of it is the table.
std::optional<Plane> FlatCloud(PointSpan points, const Eigen::Vector3d& sensor_origin,
                               const PreprocessOptions& options) {
  const Points some = Thinned(points, options.table.ranking_points);
  const auto few = geometry::FitPlane(some);
  if (!few || CountSupport(some, *few, options).on < some.size()) return std::nullopt;
  const auto plane = geometry::FitPlane(points);
  if (!plane) return std::nullopt;
  const Plane up = TowardsSensor(*plane, sensor_origin);
  if (!IsUp(up, options)) return std::nullopt;
  const bool flat = CountSupport(points, up, options).on == points.size();
  return flat ? std::optional(up) : std::nullopt;
}

}  // namespace

std::optional<Table> FindTable(PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
                               const PreprocessOptions& options, base::Rng& rng) {
  Check(options);
  auto plane = FlatCloud(points_C, sensor_origin_C, options);
  if (!plane) plane = PlaneUnderAll(points_C, sensor_origin_C, options, rng);
  if (!plane && options.robust_table) {
    plane = DominantPlane(points_C, sensor_origin_C, options, rng);
  }
  if (!plane) return std::nullopt;
  return TableOn(*plane, points_C, options);
}

Table TableOn(const Plane& plane, PointSpan points_C, const PreprocessOptions& options) {
  Table table{plane, {}};
  for (std::size_t i = 0; i < points_C.size(); ++i) {
    if (plane.Distance(points_C[i]) <= options.table_clearance_m) {
      table.points.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return table;
}

}  // namespace rangegrasp::perception
