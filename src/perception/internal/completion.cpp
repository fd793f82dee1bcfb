#include "perception/internal/completion.h"

#include <functional>

#include "base/statistics.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

using Image = std::function<Vector3d(const Vector3d&)>;

Image Mirror(const Vector3d& through, const Vector3d& normal) {
  return
      [=](const Vector3d& p) -> Vector3d { return p - 2.0 * ((p - through).dot(normal) * normal); };
}

Image HalfTurn(const Vector3d& through, const Vector3d& axis) {
  return [=](const Vector3d& p) -> Vector3d {
    const Vector3d d = p - through;
    return p - 2.0 * (d - d.dot(axis) * axis);
  };
}

/// Empty if the part is not symmetric.
Image FindSymmetry(const ObjectContext& context, const Part& part) {
  const CompletionOptions& options = context.options.completion;
  const Vector3d& up = context.table.normal;
  const TopSurface& top = *part.top;
  const Vector3d level = top.plane.normal.cross(up);
  const bool inclined = level.norm() > std::sin(options.min_inclination_rad);
  if (top.ridge || inclined) {
    const PlanarFrame frame =
        MakePlanarFrame(context.table, top.center_C, top.ridge ? top.major_C : level);
    if (top.ridge) return Mirror(top.center_C, frame.v);
    const double edge = HighestLine(frame, context.table, Select(context.cloud.points, top.points));
    return Mirror(top.center_C + edge * frame.v, frame.v);
  }
  const PlanarFrame frame = MakePlanarFrame(context.table, top.center_C);
  const Rectangle body =
      MinAreaRectangle(Flatten(frame, Select(context.cloud.points, part.points)));
  const bool small =
      top.major_m * top.minor_m < options.max_top_share * body.length_m * body.width_m;
  return small ? HalfTurn(top.center_C, up) : Image();
}

/// A point of a profile: depth below the rim along the axis, distance from the axis.
struct ProfilePoint {
  double depth_m;
  double radius_m;
};

/// A profile's point, rotated about the normal of the frame at the rim.
Vector3d Rotated(const PlanarFrame& rim, const ProfilePoint& p, double angle) {
  return rim.origin - p.depth_m * rim.n +
         p.radius_m * (std::cos(angle) * rim.u + std::sin(angle) * rim.v);
}

/// The outer wall from the rim to the base.
std::vector<ProfilePoint> OuterProfile(const BodyProfile& body, double radius_m, double length_m,
                                       const CompletionOptions& options) {
  const auto min_points = static_cast<std::size_t>(options.min_section_points);
  std::vector<ProfilePoint> profile{{0.0, radius_m}};
  for (const Section& s : body.sections) {
    if (s.outer_points >= min_points && s.depth_m > 0.0 && s.depth_m < length_m) {
      profile.push_back({s.depth_m, s.outer_m});
    }
  }
  profile.push_back({length_m, profile.back().radius_m});
  return profile;
}

/// The depth under the rim at which the floor of a cavity was seen; 0 if it was not.
double FloorDepth(const ObjectContext& context, const Part& part, double inner_m) {
  const CompletionOptions& options = context.options.completion;
  const Vector3d& center = part.axis->center_C;
  const Vector3d& direction = part.axis->direction_C;
  std::vector<double> depths;
  for (const auto i : part.points) {
    const Vector3d& p = context.cloud.points[i];
    const double depth = -(p - center).dot(direction);
    if (depth > options.min_floor_depth_m &&
        context.cloud.normals[i].dot(direction) > options.min_floor_cosine &&
        AxisDistance(p, center, direction) < inner_m - options.wall_m) {
      depths.push_back(depth);
    }
  }
  if (depths.size() < static_cast<std::size_t>(options.min_floor_points)) return 0.0;
  return base::UpperMedianOf(std::move(depths));
}

/// The cavity from its floor up to the rim. If the floor was not seen, the deepest seen part of the
/// wall replaces it: a finger goes no further than is known to be empty.
std::vector<ProfilePoint> InnerProfile(const ObjectContext& context, const Part& part,
                                       const BodyProfile& body, double length_m) {
  const CompletionOptions& options = context.options.completion;
  const auto min_points = static_cast<std::size_t>(options.min_section_points);
  std::vector<ProfilePoint> wall;
  for (const Section& s : body.sections) {
    if (s.inner_points >= min_points && s.depth_m > 0.0 && s.inner_m < part.axis->radius_m) {
      wall.push_back({s.depth_m, s.inner_m});
    }
  }
  const double rim = wall.empty() ? part.axis->radius_m - options.wall_m : wall.front().radius_m;
  double floor = FloorDepth(context, part, rim);
  if (floor == 0.0) floor = wall.empty() ? part.axis->radius_m : wall.back().depth_m;
  floor = std::min(floor, length_m - options.wall_m);
  std::erase_if(wall, [&](const ProfilePoint& p) { return p.depth_m >= floor; });
  std::vector<ProfilePoint> profile{{floor, 0.0},
                                    {floor, wall.empty() ? rim : wall.back().radius_m}};
  profile.insert(profile.end(), wall.rbegin(), wall.rend());
  profile.push_back({0.0, rim});
  return profile;
}

/// Counter-clockwise from outside for profiles that run from the top's middle outward and down.
TriangleMesh Revolve(const PlanarFrame& rim, const std::vector<ProfilePoint>& profile,
                     const Plane& table, int sides) {
  TriangleMesh mesh;
  for (const ProfilePoint& p : profile) {
    for (int k = 0; k < sides; ++k) {
      Vector3d vertex = Rotated(rim, p, 2.0 * base::kPi * k / sides);
      if (table.Distance(vertex) < 0.0) vertex = table.Project(vertex);
      mesh.vertices.push_back(vertex);
    }
  }
  const auto n = static_cast<std::uint32_t>(sides);
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t a = ring * n + k;
      const std::uint32_t b = ring * n + (k + 1) % n;
      const std::uint32_t c = a + n;
      const std::uint32_t d = b + n;
      if (profile[ring].radius_m > 0.0) mesh.triangles.push_back({a, d, b});
      if (profile[ring + 1].radius_m > 0.0) mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

/// Groups of points further out than the body's circles, each with enough points.
std::vector<Points> Attachments(const ObjectContext& context, const Part& part,
                                const BodyProfile& body) {
  const CompletionOptions& options = context.options.completion;
  const double attached_m = options.attached_m;
  double widest = part.axis->radius_m;
  for (const Section& s : body.sections) widest = std::max(widest, s.outer_m);
  const Indices outside = Where(part.points, [&](auto i) {
    const auto& p = context.cloud.points[i];
    return AxisDistance(p, part.axis->center_C, part.axis->direction_C) > widest + attached_m ||
           (p - part.axis->center_C).dot(part.axis->direction_C) > attached_m;
  });
  auto groups = geometry::GroupsWithin(Select(context.cloud.points, outside), options.link_m);
  std::erase_if(
      groups, [&](const Points& group) { return std::ssize(group) < options.min_attached_points; });
  return groups;
}

void AddRing(const ObjectContext& context, const PlanarFrame& rim, const ProfilePoint& p,
             Points& points) {
  const double step_rad = context.options.completion.step_rad;
  const auto steps = static_cast<int>(std::lround(2.0 * base::kPi / step_rad));
  for (int k = 0; k < steps; ++k) {
    const Vector3d q = Rotated(rim, p, k * step_rad);
    if (context.table.Distance(q) >= 0.0) points.push_back(q);
  }
}

/// Keeps a gap of exactly one step from being cut in two.
constexpr double kRounding = 1e-9;

/// The profile with points added so that they are at most one section apart.
std::vector<ProfilePoint> Filled(const std::vector<ProfilePoint>& profile, double step_m) {
  std::vector<ProfilePoint> filled{profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const ProfilePoint from = profile[i - 1];
    const double gap = profile[i].depth_m - from.depth_m;
    const auto pieces = std::max(1, static_cast<int>(std::ceil(gap / step_m - kRounding)));
    for (int k = 1; k <= pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      filled.push_back(
          {from.depth_m + t * gap, from.radius_m + t * (profile[i].radius_m - from.radius_m)});
    }
  }
  return filled;
}

/// From the end of the axis to the other end of a lying body, or to the base of a standing one.
double LengthOf(const ObjectContext& context, const RotationAxis& axis, double base_m) {
  if (axis.Lies()) return axis.length_m;
  const CompletionOptions& options = context.options.completion;
  const double upright =
      std::max(options.min_axis_cosine, axis.direction_C.dot(context.table.normal));
  return std::max(options.wall_m, (context.table.Distance(axis.center_C) - base_m) / upright);
}

/// Puts 1 into the last of n cells, too.
constexpr double kBelowOne = 1.0 - 1e-9;

double EndOf(std::vector<double> values, const CompletionOptions& options) {
  const int share = static_cast<int>(options.end_share * static_cast<double>(values.size()));
  const auto others = static_cast<std::size_t>(std::max(options.min_end_points, share));
  return SupportedEnd(std::move(values), others, options.end_band_m);
}

/// The points without mixed ones, which hang singly off the rectangle's ends. The top's are kept.
Points WithoutStrays(const ObjectContext& context, const Part& part, const Points& points) {
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const CompletionOptions& options = context.options.completion;
  const Rectangle box = FootprintBox(frame, flat, part.top, options);
  const Vector2d across(-box.axis.y(), box.axis.x());
  std::vector<bool> kept(points.size(), true);
  for (const Vector2d& side : {box.axis, across, Vector2d(-box.axis), Vector2d(-across)}) {
    std::vector<double> offsets;
    offsets.reserve(flat.size());
    for (const auto& q : flat) offsets.push_back(q.dot(side));
    double end = EndOf(offsets, options);
    if (part.top) {
      for (const auto i : part.top->points) {
        end = std::max(end, frame.Flat(context.cloud.points[i]).dot(side));
      }
    }
    for (std::size_t k = 0; k < offsets.size(); ++k) kept[k] = kept[k] && !(offsets[k] > end);
  }
  return Select(points, geometry::PositionsOf(kept));
}

/// Heights of the posts along one side of an outline: the highest points near each, or the base.
std::vector<double> PostTops(const ObjectContext& context, const Points& points,
                             std::span<const Vector2d> flat, const Vector2d& a,
                             const Vector2d& along, double length_m, double base_m) {
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

/// Points from the outline's highest points down to the base: the planes normal to the table.
Points Walls(const ObjectContext& context, const Points& points, double base_m) {
  const double step_m = context.options.completion.wall_step_m;
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const auto hull = ConvexPolygon::Around(flat);
  Points walls;
  for (std::size_t i = 0; i < hull.corners.size(); ++i) {
    const Vector2d& a = hull.corners[i];
    const Vector2d& b = hull.corners[(i + 1) % hull.corners.size()];
    const double length = (b - a).norm();
    if (length == 0.0) continue;
    const Vector2d along = (b - a) / length;
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

/// The hull of the points and of their projections to the base. Only the footprint's corners are
/// projected: the others lie in one plane with them, where the hull's exact predicates are slow.
TriangleMesh HullDownTo(const PlanarFrame& frame, const Points& points, double base_m) {
  Points solid = points;
  const auto flat = Flatten(frame, points);
  for (const auto corner : HullPositions(flat)) {
    const double above_m = frame.Height(points[corner]) - base_m;
    solid.push_back(points[corner] - std::max(0.0, above_m) * frame.n);
  }
  return geometry::ConvexHull(solid);
}

/// The points in slices along the longest axis of their footprint, each with the edge of the next.
std::vector<Points> Slices(const PlanarFrame& frame, std::span<const Vector2d> flat,
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

/// One hull if the outline is nearly convex, else hulls of slices along its longest axis.
TriangleMesh ConvexPieces(const ObjectContext& context, const Points& points, double base_m) {
  constexpr double kMinArea_m2 = 1e-9;  // of a line, to avoid a division by 0
  const CompletionOptions& options = context.options.completion;
  const PlanarFrame frame = MakePlanarFrame(context.table, points.front());
  const auto flat = Flatten(frame, points);
  const double fill =
      FilledArea(flat, options.cell_m) / std::max(ConvexPolygon::Around(flat).Area(), kMinArea_m2);
  if (fill >= options.min_fill) return HullDownTo(frame, points, base_m);
  TriangleMesh mesh;
  for (const auto& slice : Slices(frame, flat, points, options)) {
    if (!slice.empty()) geometry::Append(HullDownTo(frame, slice, base_m), mesh);
  }
  return mesh;
}

/// Whether the top fills its outline and the rest is within it, seen along the top's normal.
bool IsSquareTo(std::span<const Vector2d> top, std::span<const Vector2d> all,
                const CompletionOptions& options) {
  const auto outline = ConvexPolygon::Around(top);
  if (FilledArea(top, options.cell_m) < options.min_fill * outline.Area()) return false;
  const auto outside = std::ranges::count_if(
      all, [&](const Vector2d& q) { return outline.Distance(q) > options.lean_margin_m; });
  return static_cast<double>(outside) <= options.max_lean_outside * static_cast<double>(all.size());
}

/// If the top leans and the points below form faces normal to it: the outline in the top's plane,
/// moved against the top's normal as far down as points were seen, but not below the base.
std::optional<Completion> CompleteLeaning(const ObjectContext& context, const Part& part,
                                          const Points& points, double base_m) {
  const CompletionOptions& options = context.options.completion;
  if (!part.top) return {};
  const Plane& plane = part.top->plane;
  const double upright = plane.normal.dot(context.table.normal);
  const bool leans = upright <= std::cos(options.min_lean_rad) &&
                     upright >= std::cos(options.max_lean_rad);  // else it is a side
  if (part.top->ridge || !leans) return {};
  std::vector<double> depths;
  for (const auto& p : points) depths.push_back(-plane.Distance(p));
  const double depth_m = EndOf(std::move(depths), options);
  if (depth_m < options.min_lean_depth_m) return {};
  const PlanarFrame frame = MakePlanarFrame(plane, part.top->center_C);
  const auto flat = Flatten(frame, points);
  const auto of_top = Flatten(frame, Select(context.cloud.points, part.top->points));
  if (!IsSquareTo(of_top, flat, options)) return {};

  Completion leaning;
  leaning.points_C = points;
  Points solid = points;
  const auto outline = ConvexPolygon::Around(flat);
  for (std::size_t i = 0; i < outline.corners.size(); ++i) {
    const Vector2d& a = outline.corners[i];
    const Vector2d& b = outline.corners[(i + 1) % outline.corners.size()];
    const auto posts = static_cast<int>(std::ceil((b - a).norm() / options.wall_step_m));
    for (int post = 0; post < posts; ++post) {
      const Vector3d high = frame.Lift(a + (b - a) * post / posts);
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

Points SymmetricImage(const ObjectContext& context, const Part& part) {
  if (!context.options.complete_by_symmetry || !part.top) return {};
  const Image image_of = FindSymmetry(context, part);
  if (!image_of) return {};
  Points image = Select(context.cloud.points, part.points);
  std::ranges::transform(image, image.begin(), image_of);
  std::erase_if(image, [&](const Vector3d& p) {
    return context.views.IsFree(p, context.options.completion.free_margin_m) ||
           !(context.table.Distance(p) >= 0.0);
  });
  const double share = static_cast<double>(image.size()) / static_cast<double>(part.points.size());
  if (share < context.options.completion.mirror_share) image.clear();
  return image;
}

Completion CompleteRotational(const ObjectContext& context, const Part& part, double base_m) {
  const RotationAxis& axis = *part.axis;
  const auto body = ProfileBody(context, part.points, EndPlane(axis, *part.top), axis);
  const Vector3d u = axis.direction_C.unitOrthogonal();
  const PlanarFrame rim{axis.center_C, u, axis.direction_C.cross(u), axis.direction_C};
  const CompletionOptions& options = context.options.completion;
  const double length = LengthOf(context, axis, base_m);
  const auto outer = OuterProfile(body, axis.radius_m, length, options);

  Completion completion;
  completion.points_C = Select(context.cloud.points, part.points);
  for (const ProfilePoint& p : Filled(outer, context.options.axis.section_m)) {
    AddRing(context, rim, p, completion.points_C);
  }
  std::vector<ProfilePoint> profile{{0.0, 0.0}};
  if (!axis.Lies() && IsOpen(context, part.points, *part.top)) {
    profile = InnerProfile(context, part, body, length);
    for (const ProfilePoint& p : profile) {
      if (p.radius_m > 0.0) AddRing(context, rim, p, completion.points_C);
    }
  }
  profile.insert(profile.end(), outer.begin(), outer.end());
  profile.push_back({length, 0.0});
  completion.surface_C = Revolve(rim, profile, context.table, options.sides);
  for (const Points& attachment : Attachments(context, part, body)) {
    geometry::Append(geometry::ConvexHull(attachment), completion.surface_C);
  }
  return completion;
}

Rectangle FootprintBox(const PlanarFrame& frame, std::span<const Vector2d> flat,
                       const std::optional<TopSurface>& top, const CompletionOptions& options) {
  // The axis lies in the top's plane; if that stands on edge (60 deg), its projection says nothing.
  constexpr double kMinShadow = 0.5;
  if (!top || top->major_m <= options.min_elongation * top->minor_m) return MinAreaRectangle(flat);
  const Vector2d along(top->major_C.dot(frame.u), top->major_C.dot(frame.v));
  if (along.norm() <= kMinShadow) return MinAreaRectangle(flat);
  return RectangleAlong(flat, along.normalized()).LongerSideFirst();
}

Completion CompleteOther(const ObjectContext& context, const Part& part, double base_m) {
  Completion completion;
  completion.points_C = Select(context.cloud.points, part.points);
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
