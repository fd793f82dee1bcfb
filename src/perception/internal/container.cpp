#include "perception/internal/container.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "perception/internal/planar.h"
#include "perception/internal/top_surface.h"

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

/// A segment as seen from above.
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

geometry::Indices TakeContainer(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                const FeatureOptions& options,
                                std::vector<geometry::Indices>& segments) {
  const ContainerOptions& box = options.container;
  const PlanarFrame frame = MakePlanarFrame(table, Eigen::Vector3d::Zero());
  std::vector<Sheet> seen;
  for (const auto& segment : segments) {
    Sheet sheet{Flatten(frame, geometry::Select(cloud.points, segment)), {}};
    sheet.hull = ConvexPolygon::Around(sheet.points).corners;
    seen.push_back(std::move(sheet));
  }
  const auto walls = FindWalls(seen, Flatten(frame, cloud.points), box);
  if (!walls) return {};
  geometry::Indices taken;
  std::vector<geometry::Indices> left;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool wall = ShareAtBorder(*walls, seen[i].points, box.wall_m) >= box.border_share;
    const bool floor = TopHeight(cloud, segments[i], table) <= options.completion.on_table_m;
    if (wall || floor) {
      taken.insert(taken.end(), segments[i].begin(), segments[i].end());
    } else {
      left.push_back(std::move(segments[i]));
    }
  }
  segments = std::move(left);
  std::ranges::sort(taken);
  return taken;
}

}  // namespace rangegrasp::perception::internal
