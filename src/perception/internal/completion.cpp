#include "perception/internal/completion.h"

#include <algorithm>
#include <cmath>

#include "geometry/hull.h"
#include "perception/internal/symmetry.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Points;

/// The last of n cells is that of 1, too.
constexpr double kBelowOne = 1.0 - 1e-9;

Points PartPoints(const ObjectContext& context, const Part& part) {
  return geometry::Select(context.cloud.points, part.points);
}

double EndOf(std::vector<double> values, const CompletionOptions& options) {
  const auto share =
      static_cast<std::size_t>(options.end_share * static_cast<double>(values.size()));
  const auto others = std::max(static_cast<std::size_t>(options.min_end_points), share);
  return SupportedEnd(std::move(values), others, options.end_band_m);
}

/// The points without those that hang off the ends of their rectangle singly: mixed points, which
/// lie below the edge that they hang from. What the top surface has is kept.
Points WithoutStrays(const ObjectContext& context, const Part& part, const Points& points) {
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const CompletionOptions& options = context.options.completion;
  const Rectangle box = FootprintBox(frame, flat, part.top, options);
  const Eigen::Vector2d across(-box.axis.y(), box.axis.x());
  std::vector<bool> stray(points.size(), false);
  for (const Eigen::Vector2d& side :
       {box.axis, across, Eigen::Vector2d(-box.axis), Eigen::Vector2d(-across)}) {
    std::vector<double> offsets;
    offsets.reserve(flat.size());
    for (const auto& q : flat) offsets.push_back(q.dot(side));
    double end = EndOf(offsets, options);
    if (part.top) {
      for (const auto i : part.top->points) {
        end = std::max(end, frame.Flat(context.cloud.points[i]).dot(side));
      }
    }
    for (std::size_t k = 0; k < offsets.size(); ++k) stray[k] = stray[k] || offsets[k] > end;
  }
  Points kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!stray[k]) kept.push_back(points[k]);
  }
  return kept;
}

/// How high the posts along one side of an outline are: the highest points near each; the base
/// where there is none.
std::vector<double> PostTops(const ObjectContext& context, const Points& points,
                             std::span<const Eigen::Vector2d> flat, const Eigen::Vector2d& a,
                             const Eigen::Vector2d& along, double length_m, double base_m) {
  const double step_m = context.options.completion.wall_step_m;
  const auto posts = static_cast<std::size_t>(std::ceil(length_m / step_m));
  std::vector<double> tops(posts, base_m);
  for (std::size_t k = 0; k < flat.size(); ++k) {
    const double s = (flat[k] - a).dot(along);
    const double off = std::abs(Cross(along, flat[k] - a));
    if (off > context.options.completion.wall_outline_m || s < -step_m || s > length_m + step_m) {
      continue;
    }
    const auto post = static_cast<std::size_t>(std::clamp(s / length_m, 0.0, kBelowOne) *
                                               static_cast<double>(posts));
    tops[post] = std::max(tops[post], context.table.Distance(points[k]));
  }
  return tops;
}

/// Points down from the highest points of the outline to the base: the planes square to the table.
Points Walls(const ObjectContext& context, const Points& points, double base_m) {
  const double step_m = context.options.completion.wall_step_m;
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const auto hull = ConvexPolygon::Around(flat);
  Points walls;
  for (std::size_t i = 0; i < hull.corners.size(); ++i) {
    const Eigen::Vector2d& a = hull.corners[i];
    const Eigen::Vector2d& b = hull.corners[(i + 1) % hull.corners.size()];
    const double length = (b - a).norm();
    if (length == 0.0) continue;
    const Eigen::Vector2d along = (b - a) / length;
    const auto tops = PostTops(context, points, flat, a, along, length, base_m);
    for (std::size_t post = 0; post < tops.size(); ++post) {
      const double s =
          (static_cast<double>(post) + 0.5) / static_cast<double>(tops.size()) * length;
      for (double h = base_m; h < tops[post]; h += step_m) {
        walls.push_back(frame.Lift(a + s * along, h));
      }
    }
  }
  return walls;
}

/// The hull of the points and of their projections to the base. Only the corners of the footprint
/// are projected: the others' projections lie between those, in one plane with them, where the
/// hull's exact predicates are slow.
geometry::TriangleMesh HullDownTo(const PlanarFrame& frame, const Points& points, double base_m) {
  Points solid = points;
  const auto flat = Flatten(frame, points);
  for (const auto corner : HullPositions(flat)) {
    const double height_m = (points[corner] - frame.origin).dot(frame.n);
    solid.push_back(points[corner] - std::max(0.0, height_m - base_m) * frame.n);
  }
  return geometry::ConvexHull(solid);
}

/// The points in slices along the longest axis of their footprint, each with the edge of the next.
std::vector<Points> Slices(const PlanarFrame& frame, std::span<const Eigen::Vector2d> flat,
                           const Points& points, const CompletionOptions& options) {
  const Rectangle box = MinAreaRectangle(flat);
  const auto count = static_cast<std::size_t>(std::ceil(box.length_m / options.slice_m));
  std::vector<Points> slices(std::max<std::size_t>(1, count));
  const auto n = static_cast<double>(slices.size());
  for (const auto& p : points) {
    const double s = (frame.Flat(p) - box.center).dot(box.axis) / box.length_m + 0.5;
    const auto k = static_cast<std::size_t>(std::clamp(s, 0.0, kBelowOne) * n);
    slices[k].push_back(p);
    if (k > 0 && s * n - static_cast<double>(k) < options.slice_overlap) {
      slices[k - 1].push_back(p);
    }
  }
  return slices;
}

/// One hull where the outline is nearly convex, else hulls of slices along its longest axis.
geometry::TriangleMesh ConvexPieces(const ObjectContext& context, const Points& points,
                                    double base_m) {
  constexpr double kMinArea_m2 = 1e-9;  // of a line, so that nothing is divided by 0
  const CompletionOptions& options = context.options.completion;
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const double fill =
      FilledArea(flat, options.cell_m) / std::max(ConvexPolygon::Around(flat).Area(), kMinArea_m2);
  if (fill >= options.min_fill) return HullDownTo(frame, points, base_m);
  geometry::TriangleMesh mesh;
  for (const auto& slice : Slices(frame, flat, points, options)) {
    if (!slice.empty()) geometry::Append(HullDownTo(frame, slice, base_m), mesh);
  }
  return mesh;
}

/// Whether a top is a plane that leans, and no side of something.
bool Leans(const TopSurface& top, double upright, const CompletionOptions& options) {
  return !top.ridge && upright <= std::cos(options.min_lean_rad) &&
         upright >= std::cos(options.max_lean_rad);
}

/// How far below the top's plane a part was seen.
double DepthBelow(const geometry::Plane& plane, const Points& points,
                  const CompletionOptions& options) {
  std::vector<double> depths;
  depths.reserve(points.size());
  for (const auto& p : points) depths.push_back(-plane.Distance(p));
  return EndOf(std::move(depths), options);
}

/// Whether the top fills its outline, and what lies below it stands square to it: within the
/// outline, seen along the top's normal.
bool IsSquareTo(std::span<const Eigen::Vector2d> top, std::span<const Eigen::Vector2d> all,
                const CompletionOptions& options) {
  const auto outline = ConvexPolygon::Around(top);
  if (FilledArea(top, options.cell_m) < options.min_fill * outline.Area()) return false;
  const auto outside = std::count_if(all.begin(), all.end(), [&](const Eigen::Vector2d& q) {
    return outline.Distance(q) > options.lean_margin_m;
  });
  return static_cast<double>(outside) <= options.max_lean_outside * static_cast<double>(all.size());
}

/// What a leaning object's far corners and walls are, if its top leans and its points below the top
/// stand square to it: the outline in the top's plane, moved against the top's normal as far down
/// as points were seen, but not below the base.
std::optional<Completion> CompleteLeaning(const ObjectContext& context, const Part& part,
                                          const Points& points, double base_m) {
  const CompletionOptions& options = context.options.completion;
  if (!part.top) return {};
  const geometry::Plane& plane = part.top->plane;
  const double upright = plane.normal.dot(context.table.normal);
  if (!Leans(*part.top, upright, options)) return {};
  const double depth_m = DepthBelow(plane, points, options);
  if (depth_m < options.min_lean_depth_m) return {};
  const PlanarFrame frame = MakePlanarFrame(plane, part.top->center_C);
  const auto flat = Flatten(frame, points);
  const auto of_top = Flatten(frame, geometry::Select(context.cloud.points, part.top->points));
  if (!IsSquareTo(of_top, flat, options)) return {};

  Completion leaning;
  leaning.points_C = points;
  Points solid = points;
  const auto outline = ConvexPolygon::Around(flat);
  for (std::size_t i = 0; i < outline.corners.size(); ++i) {
    const Eigen::Vector2d& a = outline.corners[i];
    const Eigen::Vector2d& b = outline.corners[(i + 1) % outline.corners.size()];
    const auto posts = static_cast<int>(std::ceil((b - a).norm() / options.wall_step_m));
    for (int post = 0; post < posts; ++post) {
      const Eigen::Vector3d high = frame.Lift(a + (b - a) * post / posts);
      const double to_base_m = (context.table.Distance(high) - base_m) / upright;
      const double deep_m = std::clamp(to_base_m, 0.0, depth_m);
      for (double d = 0.0; d < deep_m; d += options.wall_step_m) {
        leaning.points_C.push_back(high - d * plane.normal);
      }
      if (post == 0) {
        solid.push_back(high);
        solid.push_back(high - deep_m * plane.normal);
      }
    }
  }
  leaning.surface_C = geometry::ConvexHull(solid);
  return leaning;
}

}  // namespace

Rectangle FootprintBox(const PlanarFrame& frame, std::span<const Eigen::Vector2d> flat,
                       const std::optional<TopSurface>& top, const CompletionOptions& options) {
  // The axis lies in the top's plane; where that stands on edge (60 deg), its shadow says nothing.
  constexpr double kMinShadow = 0.5;
  if (!top || top->major_m <= options.min_elongation * top->minor_m) return MinAreaRectangle(flat);
  const Eigen::Vector2d along(top->major_C.dot(frame.u), top->major_C.dot(frame.v));
  if (along.norm() <= kMinShadow) return MinAreaRectangle(flat);
  Rectangle box = RectangleAlong(flat, along.normalized());
  if (box.width_m > box.length_m) {
    std::swap(box.width_m, box.length_m);
    box.axis = Eigen::Vector2d(-box.axis.y(), box.axis.x());
  }
  return box;
}

Completion CompleteOther(const ObjectContext& context, const Part& part, double base_m) {
  Completion completion;
  completion.points_C = PartPoints(context, part);
  if (completion.points_C.empty()) return completion;
  const Points image = SymmetricImage(context, part);
  completion.points_C.insert(completion.points_C.end(), image.begin(), image.end());
  if (context.options.trim_strays) {
    completion.points_C = WithoutStrays(context, part, completion.points_C);
  }
  if (completion.points_C.empty()) return completion;
  if (context.options.complete_leaning) {
    auto leaning = CompleteLeaning(context, part, completion.points_C, base_m);
    if (leaning) return std::move(*leaning);
  }
  completion.surface_C = ConvexPieces(context, completion.points_C, base_m);
  const Points walls = Walls(context, completion.points_C, base_m);
  completion.points_C.insert(completion.points_C.end(), walls.begin(), walls.end());
  return completion;
}

}  // namespace rangegrasp::perception::internal
