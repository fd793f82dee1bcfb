#include "perception/completion.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/hull.h"
#include "perception/features.h"
#include "perception/planar.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::Points;

// Image points are free only if what was measured lies this far behind them: cells of directions
// are 4 mm wide and surfaces slope.
constexpr double kFreeMargin_m = 0.006;

Points PartPoints(const CompletionContext& context, const Part& part) {
  return geometry::Select(context.cloud.points, part.points);
}

/// The rectangle along the top surface's principal axis where it has one, else the smallest.
Rectangle FootprintBox(const PlanarFrame& frame, std::span<const Eigen::Vector2d> flat,
                       const std::optional<TopSurface>& top) {
  constexpr double kLeastElongation = 1.2;
  if (!top || top->major_m <= kLeastElongation * top->minor_m) return SmallestRectangle(flat);
  const Eigen::Vector2d along(top->major_C.dot(frame.u), top->major_C.dot(frame.v));
  if (along.norm() <= 0.5) return SmallestRectangle(flat);
  Rectangle box = RectangleAlong(flat, along.normalized());
  if (box.width_m > box.length_m) {
    std::swap(box.width_m, box.length_m);
    box.axis = Eigen::Vector2d(-box.axis.y(), box.axis.x());
  }
  return box;
}

/// The largest value that has enough others close below it.
double SupportedEnd(std::vector<double> values) {
  constexpr double kBand_m = 0.002;
  constexpr double kLeastShare = 0.002;
  std::sort(values.begin(), values.end());
  const std::size_t least = std::max<std::size_t>(
      4, static_cast<std::size_t>(kLeastShare * static_cast<double>(values.size())));
  for (std::size_t k = values.size(); k-- > least;) {
    if (values[k - least] >= values[k] - kBand_m) return values[k];
  }
  return values.back();
}

/// The points without those that hang off the ends of their rectangle singly: mixed points, which
/// lie below the edge that they hang from. What the top surface has is kept.
Points WithoutStrays(const CompletionContext& context, const Part& part, const Points& points) {
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const Rectangle box = FootprintBox(frame, flat, part.top);
  const Eigen::Vector2d across(-box.axis.y(), box.axis.x());
  std::vector<bool> stray(points.size(), false);
  for (const Eigen::Vector2d& side :
       {box.axis, across, Eigen::Vector2d(-box.axis), Eigen::Vector2d(-across)}) {
    std::vector<double> offsets;
    offsets.reserve(flat.size());
    for (const auto& q : flat) offsets.push_back(q.dot(side));
    double end = SupportedEnd(offsets);
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

struct Symmetry {
  enum class Kind { kNone, kMirror, kHalfTurn } kind = Kind::kNone;
  Eigen::Vector3d through;  ///< a point of the mirror plane, or of the axis
  Eigen::Vector3d normal;   ///< of the mirror plane; unit
};

Symmetry FindSymmetry(const CompletionContext& context, const Part& part) {
  constexpr double kLeastInclination_rad = 0.21;
  constexpr double kMostTopShare = 0.6;
  const Eigen::Vector3d& up = context.table.normal;
  const TopSurface& top = *part.top;
  const Points points = PartPoints(context, part);
  const Eigen::Vector3d level = top.plane.normal.cross(up);
  const bool inclined = level.norm() > std::sin(kLeastInclination_rad);
  if (top.ridge || inclined) {
    const Eigen::Vector3d along = top.ridge ? top.major_C : level;
    const PlanarFrame frame = MakePlanarFrame(context.table, top.center_C, along);
    Eigen::Vector3d through = top.center_C;
    if (!top.ridge) {
      through +=
          HighestLine(frame, context.table, geometry::Select(context.cloud.points, top.points)) *
          frame.v;
    }
    return {Symmetry::Kind::kMirror, through, frame.v};
  }
  const PlanarFrame frame = MakePlanarFrame(context.table, top.center_C);
  const Rectangle body = SmallestRectangle(Flatten(frame, points));
  if (top.major_m * top.minor_m < kMostTopShare * body.length_m * body.width_m) {
    return {Symmetry::Kind::kHalfTurn, top.center_C, up};
  }
  return {};
}

Eigen::Vector3d Image(const Symmetry& symmetry, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - symmetry.through;
  const Eigen::Vector3d along = d.dot(symmetry.normal) * symmetry.normal;
  return symmetry.kind == Symmetry::Kind::kMirror ? Eigen::Vector3d(p - 2.0 * along)
                                                  : Eigen::Vector3d(p - 2.0 * (d - along));
}

/// Points down from the highest points of the outline to the base: the planes square to the table.
Points Walls(const CompletionContext& context, const Points& points, double base_m) {
  constexpr double kStep_m = 0.005;
  constexpr double kOutline_m = 0.003;
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
    const auto posts = static_cast<std::size_t>(std::ceil(length / kStep_m));
    std::vector<double> tops(posts, base_m);
    for (std::size_t k = 0; k < flat.size(); ++k) {
      const double s = (flat[k] - a).dot(along);
      const double off = std::abs(along.x() * (flat[k] - a).y() - along.y() * (flat[k] - a).x());
      if (off > kOutline_m || s < -kStep_m || s > length + kStep_m) continue;
      const auto post = static_cast<std::size_t>(std::clamp(s / length, 0.0, 1.0 - 1e-9) *
                                                 static_cast<double>(posts));
      tops[post] = std::max(tops[post], context.table.Distance(points[k]));
    }
    for (std::size_t post = 0; post < posts; ++post) {
      const double s = (static_cast<double>(post) + 0.5) / static_cast<double>(posts) * length;
      for (double h = base_m; h < tops[post]; h += kStep_m) {
        walls.push_back(frame.Lift(a + s * along, h));
      }
    }
  }
  return walls;
}

/// Every point, and its projection to the base.
Points WithShadow(const geometry::Plane& table, const Points& points, double base_m) {
  Points all = points;
  all.reserve(2 * points.size());
  for (const auto& p : points) {
    all.push_back(p - std::max(0.0, table.Distance(p) - base_m) * table.normal);
  }
  return all;
}

/// One hull where the outline is nearly convex, else hulls of slices along its longest axis.
geometry::TriangleMesh ConvexPieces(const CompletionContext& context, const Points& points,
                                    double base_m) {
  constexpr double kCell_m = 0.006;
  constexpr double kLeastFill = 0.75;
  constexpr double kSlice_m = 0.020;
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  std::map<std::pair<long, long>, int> cells;
  for (const auto& q : flat) ++cells[{std::lround(q.x() / kCell_m), std::lround(q.y() / kCell_m)}];
  const double fill = static_cast<double>(cells.size()) * kCell_m * kCell_m /
                      std::max(ConvexPolygon::Around(flat).Area(), 1e-9);
  const Points solid = WithShadow(context.table, points, base_m);
  if (fill >= kLeastFill) return geometry::ConvexHull(solid);
  const Rectangle box = SmallestRectangle(flat);
  const auto slices = static_cast<std::size_t>(std::ceil(box.length_m / kSlice_m));
  std::vector<Points> pieces(std::max<std::size_t>(1, slices));
  for (const auto& p : solid) {
    const double s = (frame.Flat(p) - box.center).dot(box.axis) / box.length_m + 0.5;
    const auto k = static_cast<std::size_t>(std::clamp(s, 0.0, 1.0 - 1e-9) *
                                            static_cast<double>(pieces.size()));
    pieces[k].push_back(p);
    if (k > 0 && s * static_cast<double>(pieces.size()) - static_cast<double>(k) < 0.15) {
      pieces[k - 1].push_back(p);  // Neighbours overlap, so that no gap is left between them.
    }
  }
  geometry::TriangleMesh mesh;
  for (const auto& piece : pieces) {
    if (piece.size() >= 4) geometry::Append(geometry::ConvexHull(piece), mesh);
  }
  return mesh;
}

void SetBox(const CompletionContext& context, PerceivedObject& object) {
  const PlanarFrame frame = MakePlanarFrame(context.table, context.view.origin_C());
  const auto flat = Flatten(frame, object.completed_C);
  const Rectangle box = FootprintBox(frame, flat, object.top);
  object.size_m = {box.length_m, box.width_m, object.height_m - object.base_m};
  object.center_C = frame.Lift(box.center, 0.5 * (object.height_m + object.base_m));
  object.axis_C = box.axis.x() * frame.u + box.axis.y() * frame.v;
}

}  // namespace

Points SymmetricImage(const CompletionContext& context, const Part& part) {
  if (!context.options.complete_by_symmetry || !part.top) return {};
  const Symmetry symmetry = FindSymmetry(context, part);
  if (symmetry.kind == Symmetry::Kind::kNone) return {};
  Points image;
  image.reserve(part.points.size());
  for (const auto i : part.points) {
    const Eigen::Vector3d p = Image(symmetry, context.cloud.points[i]);
    if (!context.view.IsFree(p, kFreeMargin_m) && context.table.Distance(p) >= 0.0) {
      image.push_back(p);
    }
  }
  const double share = static_cast<double>(image.size()) / static_cast<double>(part.points.size());
  if (share < context.options.mirror_share) image.clear();
  return image;
}

Completion CompleteOther(const CompletionContext& context, const Part& part, double base_m) {
  Completion completion;
  completion.points_C = PartPoints(context, part);
  if (completion.points_C.empty()) return completion;
  const Points image = SymmetricImage(context, part);
  completion.points_C.insert(completion.points_C.end(), image.begin(), image.end());
  completion.points_C = WithoutStrays(context, part, completion.points_C);
  if (completion.points_C.empty()) return completion;
  completion.surface_C = ConvexPieces(context, completion.points_C, base_m);
  const Points walls = Walls(context, completion.points_C, base_m);
  completion.points_C.insert(completion.points_C.end(), walls.begin(), walls.end());
  return completion;
}

PerceivedObject MakeObject(const CompletionContext& context, const Part& part, double base_m) {
  PerceivedObject object;
  object.points = part.points;
  object.kind = part.axis ? ObjectKind::kRotational : ObjectKind::kOther;
  object.top = part.top;
  object.axis = part.axis;
  object.height_m = TopHeight(context.cloud, part.points, context.table);
  object.base_m = std::min(base_m, object.height_m);
  object.open = part.top && !part.top->ridge &&
                IsOpen(context.cloud, part.points, *part.top, context.options);
  Completion completion = part.axis ? CompleteRotational(context, part, object.base_m)
                                    : CompleteOther(context, part, object.base_m);
  object.completed_C = std::move(completion.points_C);
  object.surface_C = std::move(completion.surface_C);
  SetBox(context, object);
  return object;
}

}  // namespace rangegrasp::perception
