#include "perception/internal/container.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/quantile.h"
#include "perception/internal/planar.h"

namespace rangegrasp::perception::internal {
namespace {

using Flat = std::vector<Eigen::Vector2d>;

/// A point in a rectangle's frame, from its middle.
Eigen::Vector2d In(const Rectangle& r, const Eigen::Vector2d& q) {
  const Eigen::Vector2d d = q - r.center;
  return {d.dot(r.axis), Cross(r.axis, d)};
}

/// How far inside the rectangle's border; < 0: outside.
double Depth(const Rectangle& r, const Eigen::Vector2d& q) {
  const Eigen::Vector2d p = In(r, q).cwiseAbs();
  return std::min(0.5 * r.length_m - p.x(), 0.5 * r.width_m - p.y());
}

double ShareAtBorder(const Rectangle& r, const Flat& points, double band_m) {
  const auto at =
      std::ranges::count_if(points, [&](const auto& q) { return std::abs(Depth(r, q)) <= band_m; });
  return static_cast<double>(at) / static_cast<double>(points.size());
}

/// Share of the border that has points at it.
double Coverage(const Rectangle& r, const Flat& points, const ContainerOptions& options) {
  std::set<std::pair<int, long>> covered;  // side and position along it
  for (const auto& q : points) {
    if (std::abs(Depth(r, q)) > options.wall_m) continue;
    const Eigen::Vector2d p = In(r, q);
    const bool end = 0.5 * r.length_m - std::abs(p.x()) < 0.5 * r.width_m - std::abs(p.y());
    const double along = end ? p.y() : p.x();
    const int side = (end ? 2 : 0) + ((end ? p.x() : p.y()) > 0.0 ? 1 : 0);
    covered.emplace(side, std::lround(along / options.coverage_step_m));
  }
  return static_cast<double>(covered.size()) * options.coverage_step_m /
         (2.0 * (r.length_m + r.width_m));
}

/// The upright surfaces of a segment as seen from above.
struct Sheet {
  Flat points;
  Flat hull;
};

Rectangle Around(const std::vector<const Sheet*>& sheets) {
  Flat corners;
  for (const Sheet* sheet : sheets) {
    corners.insert(corners.end(), sheet->hull.begin(), sheet->hull.end());
  }
  return MinAreaRectangle(corners);
}

/// The sheets that stand round one rectangle with the first, which is one of them.
std::vector<const Sheet*> GroupRound(const Sheet& first, const std::vector<Sheet>& sheets,
                                     const ContainerOptions& options) {
  std::vector<const Sheet*> group{&first};
  for (const Sheet& next : sheets) {
    if (&next == &first) continue;
    group.push_back(&next);
    const Rectangle r = Around(group);
    const bool fits = std::ranges::all_of(group, [&](const Sheet* sheet) {
      return ShareAtBorder(r, sheet->points, options.wall_m) >= options.border_share;
    });
    if (!fits) group.pop_back();
  }
  return group;
}

/// The rectangle that an open box's walls stand on.
std::optional<Rectangle> FindWalls(const std::vector<Sheet>& segments, const Flat& all,
                                   const ContainerOptions& options) {
  std::vector<Sheet> sheets;
  for (const Sheet& segment : segments) {
    if (segment.hull.empty()) continue;
    const Rectangle r = MinAreaRectangle(segment.hull);
    if (r.length_m >= 0.5 * options.min_side_m &&
        ShareAtBorder(r, segment.points, options.wall_m) >= options.border_share) {
      sheets.push_back(segment);
    }
  }
  std::optional<Rectangle> best;
  double best_coverage = options.min_coverage;
  for (const Sheet& first : sheets) {
    const Rectangle r = Around(GroupRound(first, sheets, options));
    if (r.width_m < options.min_side_m) continue;
    const double coverage = Coverage(r, all, options);
    if (coverage < best_coverage) continue;
    best = r;
    best_coverage = coverage;
  }
  return best;
}

}  // namespace

geometry::Indices FindContainer(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                const ContainerOptions& options,
                                const std::vector<geometry::Indices>& segments) {
  const PlanarFrame frame = MakePlanarFrame(table, Eigen::Vector3d::Zero());
  const Flat all = Flatten(frame, cloud.points);
  const auto upright = [&](std::uint32_t i) {
    return std::abs(cloud.normals[i].dot(table.normal)) <= options.max_upward;
  };
  std::vector<Sheet> seen;
  for (const auto& segment : segments) {
    Sheet sheet;
    for (const auto i : segment) {
      if (upright(i)) sheet.points.push_back(all[i]);
    }
    if (!sheet.points.empty()) sheet.hull = ConvexPolygon::Around(sheet.points).corners;
    seen.push_back(std::move(sheet));
  }
  const auto walls = FindWalls(seen, all, options);
  if (!walls) return {};
  geometry::Indices band;
  std::vector<double> heights;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (std::abs(Depth(*walls, all[i])) > options.wall_m) continue;
    band.push_back(i);
    if (upright(i)) heights.push_back(table.Distance(cloud.points[i]));
  }
  if (heights.empty()) return {};
  const double rim_m =
      core::QuantileOf(std::move(heights), options.rim_quantile) + options.rim_margin_m;
  std::erase_if(band, [&](auto i) { return table.Distance(cloud.points[i]) > rim_m; });
  return band;
}

}  // namespace rangegrasp::perception::internal
