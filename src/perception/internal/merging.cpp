#include "perception/internal/merging.h"

#include <map>
#include <numeric>
#include <ranges>
#include <set>

#include "geometry/graph.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/rotation_axis.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

struct Footprint {
  std::unique_ptr<PartSurface> surface;
  PlanarFrame frame;
  ConvexPolygon hull;
  double top_m = 0.0;
  double base_m = 0.0;
};

Footprint MakeFootprint(const ObjectContext& context, const Part& part) {
  const auto points = Select(context.cloud.points, part.points);
  const auto frame = MakePlanarFrame(context.table, context.FirstOrigin(), Vector3d::UnitX());
  return {std::make_unique<PartSurface>(points), frame,
          ConvexPolygon::Around(Flatten(frame, points)),
          TopHeight(context.cloud, part.points, context.table),
          BaseHeight(context.cloud, part.points, context.table)};
}

/// Share of a part's points over a hull in the frame's plane, grown by the margin.
double ShareOver(const ObjectContext& context, const Part& part, const PlanarFrame& frame,
                 const ConvexPolygon& hull) {
  const double margin_m = context.options.merge.footprint_margin_m;
  Eigen::AlignedBox2d box;  // most points of other parts are far off: no need for the polygon
  for (const auto& corner : hull.corners) box.extend(corner);
  const auto over = std::ranges::count_if(part.points, [&](auto i) {
    const Vector2d q = frame.Flat(context.cloud.points[i]);
    return box.exteriorDistance(q) <= 2.0 * margin_m && hull.Distance(q) <= margin_m;
  });
  return static_cast<double>(over) / static_cast<double>(part.points.size());
}

using PointPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Pairs (fragment point, nearest host point) across at most the gap.
PointPairs Across(const ObjectContext& context, const Part& fragment, const Part& host,
                  PartSurface& surface, double gap_m) {
  PointPairs pairs;
  for (const auto i : fragment.points) {
    const auto nearest = surface.NearestWithin(context.cloud.points[i], gap_m);
    if (nearest) pairs.emplace_back(i, host.points[*nearest]);
  }
  return pairs;
}

/// Whether the tangent planes continue each other or fold away from the sensor; no sideways gap.
bool ContinuesAcross(const ObjectContext& context, std::uint32_t a, std::uint32_t b) {
  const auto& [cloud, table, views, options] = context;
  const Vector3d gap = cloud.points[b] - cloud.points[a];
  if (cloud.normals[a].dot(gap) > options.merge.max_in_front_m ||
      cloud.normals[b].dot(-gap) > options.merge.max_in_front_m) {
    return false;
  }
  const Vector3d sideways = table.normal.cross(views.OriginOf(a) - cloud.points[a]).normalized();
  return std::abs(gap.dot(sideways)) < options.merge.max_sideways * gap.norm();
}

/// Whether most of the fragment is inside a lying host: its far side, seen through its mouth.
bool IsInside(const ObjectContext& context, const Part& fragment, const RotationAxis& host) {
  const MergeOptions& options = context.options.merge;
  const double margin_m = options.footprint_margin_m;
  return HoldsForShare(options.within_share, fragment.points, [&](auto i) {
    const Vector3d& p = context.cloud.points[i];
    const double below_end_m = host.direction_C.dot(host.center_C - p);
    return AxisDistance(p, host.center_C, host.direction_C) <= host.radius_m + margin_m &&
           below_end_m >= -margin_m && below_end_m <= host.length_m + margin_m;
  });
}

/// The extent of a part along a direction, without stray points.
struct Extent {
  double from_m;
  double to_m;
  double Length() const { return to_m - from_m; }
  double Middle() const { return 0.5 * (from_m + to_m); }
};
Extent ExtentAlong(const ObjectContext& context, const Part& part, const Vector3d& out) {
  const Plane across{out, 0.0};
  return {BaseHeight(context.cloud, part.points, across),
          TopHeight(context.cloud, part.points, across)};
}

/// Whether the fragment continues the host's end that way, short, thin and in line with it.
bool IsCapAlong(const ObjectContext& context, const Part& fragment, const Part& host,
                const Vector3d& out) {
  const auto& [cloud, table, views, all] = context;
  const MergeOptions& options = all.merge;
  const Extent f = ExtentAlong(context, fragment, out);
  const Extent h = ExtentAlong(context, host, out);
  if (f.from_m < h.to_m - options.footprint_margin_m ||
      f.Length() > options.max_cap_length * h.Length()) {
    return false;
  }
  // Across the view, as much of a thing is hidden on one side as on the other.
  const auto any = fragment.points.front();
  const Vector3d to_sensor = views.OriginOf(any) - cloud.points[any];
  const PlanarFrame frame = MakePlanarFrame({out, 0.0}, Vector3d::Zero(), out.cross(to_sensor));
  const Extent across_f = ExtentAlong(context, fragment, frame.u);
  const Extent across_h = ExtentAlong(context, host, frame.u);
  if (across_f.Length() > options.max_cap_width * across_h.Length() ||
      std::abs(across_f.Middle() - across_h.Middle()) >
          options.max_cap_offset * across_h.Length()) {
    return false;
  }
  const auto section = ConvexPolygon::Around(Flatten(frame, Select(cloud.points, host.points)));
  return ShareOver(context, fragment, frame, section) >= options.cap_share;
}

/// Whether the fragment is the cap or the neck of a host that stands, lies or leans.
bool IsCap(const ObjectContext& context, const Part& fragment, const Part& host) {
  if (IsCapAlong(context, fragment, host, context.table.normal)) return true;
  return host.top && (IsCapAlong(context, fragment, host, host.top->major_C) ||
                      IsCapAlong(context, fragment, host, -host.top->major_C));
}

/// Whether the segmentation saw the two surfaces meet and cut between them.
bool AreCutApart(const ObjectContext& context, const PointPairs& pairs) {
  const MergeOptions& options = context.options.merge;
  const auto& points = context.cloud.points;
  const auto touching = std::ranges::count_if(pairs, [&](const auto& pair) {
    return (points[pair.first] - points[pair.second]).norm() < options.cut_m;
  });
  return touching >= options.min_pairs;
}

/// Whether only the host can hold the fragment: see kHanging.
bool Hangs(const ObjectContext& context, const Part& fragment, const Footprint& f, const Part& host,
           double min_free_below) {
  const CompletionOptions& completion = context.options.completion;
  if (f.base_m <= completion.on_table_m) return false;
  if (static_cast<double>(fragment.points.size()) >
      context.options.merge.max_hanging_share * static_cast<double>(host.points.size())) {
    return false;
  }
  const auto& points = context.cloud.points;
  const auto is_free_below = [&](auto i) {
    const double down_m = context.table.Distance(points[i]) - 0.5 * f.base_m;
    return context.views.IsFree(points[i] - down_m * context.table.normal,
                                completion.free_margin_m);
  };
  if (!HoldsForShare(min_free_below, fragment.points, is_free_below)) return false;
  const auto under = std::ranges::count_if(host.points, [&](auto i) {
    return context.table.Distance(points[i]) < f.base_m &&
           f.hull.Distance(f.frame.Flat(points[i])) == 0.0;
  });
  return under < completion.min_support_points;
}

/// Whether most of the fragment is over the host's footprint and none above its top.
bool IsUnderTop(const ObjectContext& context, const Part& fragment, const Footprint& f,
                const Footprint& h) {
  const MergeOptions& options = context.options.merge;
  return f.top_m <= h.top_m + options.height_margin_m &&
         ShareOver(context, fragment, h.frame, h.hull) >= options.within_share;
}

/// Whether the fragment lies in a rotational host. A thing under a lying one is over its footprint.
bool IsWithin(const ObjectContext& context, const Part& fragment, const Footprint& f,
              const Part& host, const Footprint& h) {
  if (!host.axis) return false;
  return host.axis->Lies() ? IsInside(context, fragment, *host.axis)
                           : IsUnderTop(context, fragment, f, h);
}

/// Whether a point of the part is within the gap from the surface of another one.
bool ComesWithin(const ObjectContext& context, const Part& part, PartSurface& surface,
                 double gap_m) {
  return std::ranges::any_of(part.points, [&](auto i) {
    return surface.NearestWithin(context.cloud.points[i], gap_m).has_value();
  });
}

Kinship KinshipOf(const ObjectContext& context, const Part& fragment, const Footprint& f,
                  const Part& host, const Footprint& h) {
  const MergeOptions& options = context.options.merge;
  if (IsWithin(context, fragment, f, host, h)) return Kinship::kWithin;
  const auto pairs = Across(context, fragment, host, *h.surface, options.fragment_gap_m);
  const bool cuts = options.cut_m > 0.0;
  const bool close = pairs.size() >= static_cast<std::size_t>(options.min_pairs);
  // The unseen part between them may be a round host's shoulder or the root of its handle.
  if (close || (host.axis && ComesWithin(context, fragment, *h.surface, options.hidden_gap_m))) {
    if (IsCap(context, fragment, host)) return Kinship::kCap;
    const double free = close ? options.min_free_below : options.min_free_below_apart;
    if (cuts && Hangs(context, fragment, f, host, free)) return Kinship::kHanging;
  }
  if (cuts && AreCutApart(context, pairs)) return Kinship::kNone;
  // A piece this small compared with the host more likely belongs to it than to a thing under it.
  const bool crumb = static_cast<double>(fragment.points.size()) <=
                     options.max_crumb_share * static_cast<double>(host.points.size());
  if (!pairs.empty() && crumb && IsUnderTop(context, fragment, f, h)) return Kinship::kWithin;
  // A large thing meets its neighbor at a corner; a surface continues over about its whole width.
  const double wide = std::sqrt(static_cast<double>(fragment.points.size()));
  if (!close || static_cast<double>(pairs.size()) < wide) return Kinship::kNone;
  const auto continuing = std::ranges::count_if(
      pairs, [&](const auto& pair) { return ContinuesAcross(context, pair.first, pair.second); });
  const double enough = options.min_continuing * static_cast<double>(pairs.size());
  return static_cast<double>(continuing) > enough ? Kinship::kSurface : Kinship::kNone;
}

/// Remembers pairs of parts that are no union, until one of them changes. O(log n).
class Tried {
 public:
  explicit Tried(std::size_t parts) : names_(parts), next_name_(parts) {
    std::iota(names_.begin(), names_.end(), std::size_t{0});
  }
  bool Contains(std::size_t a, std::size_t b) const {
    return pairs_.contains({names_[a], names_[b]});
  }
  void Add(std::size_t a, std::size_t b) { pairs_.emplace(names_[a], names_[b]); }
  /// The part `kept` has become the union of both, and `gone` is erased.
  void Unite(std::size_t kept, std::size_t gone) {
    names_[kept] = next_name_++;
    names_.erase(names_.begin() + static_cast<std::ptrdiff_t>(gone));
  }

 private:
  std::vector<std::size_t> names_;  ///< of the parts; a union has a new one
  std::size_t next_name_;
  std::set<std::pair<std::size_t, std::size_t>> pairs_;  ///< by name
};

/// Positions of the parts, those with fewer points first.
std::vector<std::size_t> SmallestFirst(const std::vector<Part>& parts) {
  std::vector<std::size_t> order(parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t a) { return parts[a].points.size(); });
  return order;
}

/// Two parts, and the pairs of points across the gap between them.
struct Touch {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  PointPairs pairs;
};

/// The mean angle [rad] of the edge along which two parts meet, > 0 if it is concave: between the
/// mean normals of each part's points within the gap of the edge.
double CreaseAt(const ObjectContext& context, const Touch& touch, const std::vector<Part>& parts,
                const std::vector<Footprint>& footprints) {
  const PointCloud& cloud = context.cloud;
  struct Side {
    Vector3d center = Vector3d::Zero();
    Vector3d normal = Vector3d::Zero();
  };
  const auto side_at = [&](std::uint32_t part, std::uint32_t point) {
    Side side;
    const auto near =
        footprints[part].surface->Within(cloud.points[point], context.options.merge.fragment_gap_m);
    for (const auto& n : near) {
      const auto i = parts[part].points[n.index];
      side.center += cloud.points[i] / static_cast<double>(near.size());
      side.normal += cloud.normals[i];
    }
    side.normal.normalize();
    return side;
  };
  double sum_rad = 0.0;
  for (const auto& [i, k] : touch.pairs) {
    const Side a = side_at(touch.a, i);
    const Side b = side_at(touch.b, k);
    const double angle = std::acos(std::clamp(a.normal.dot(b.normal), -1.0, 1.0));
    const bool concave = (b.normal - a.normal).dot(b.center - a.center) < 0.0;
    sum_rad += concave ? angle : -angle;
  }
  return sum_rad / static_cast<double>(touch.pairs.size());
}

bool FitsAHand(const Footprint& footprint, double max_width_m, const MergeOptions& options) {
  const Rectangle around = MinAreaRectangle(footprint.hull.corners);
  return footprint.top_m <= options.max_lone_height_m && around.width_m <= max_width_m &&
         around.length_m <= options.max_lone_length_m;
}

/// Whether a part is no larger than a limb of a body: an ear or a leg of a toy.
bool MayBeLimb(const Footprint& footprint, const MergeOptions& options) {
  return MinAreaRectangle(footprint.hull.corners).length_m <= options.max_limb_m &&
         footprint.top_m - footprint.base_m <= options.max_limb_m;
}

Indices Shared(const Indices& points, const Indices& of) {
  return Where(points, [&](auto i) { return std::ranges::binary_search(of, i); });
}

/// Cheap necessary conditions, so that few pairs are fitted.
bool MayBeOne(const ObjectContext& context, const Part& a, const Part& b) {
  const MergeOptions& options = context.options.merge;
  if (!a.top || !b.top) return false;
  const double diameter_m = 2.0 * context.options.circle.max_radius_m;
  if ((a.top->center_C - b.top->center_C).norm() > diameter_m) return false;
  if (a.axis && b.axis &&
      (a.axis->center_C - b.axis->center_C).norm() > options.max_center_distance_m) {
    return false;
  }
  const double height = std::abs(TopHeight(context.cloud, a.points, context.table) -
                                 TopHeight(context.cloud, b.points, context.table));
  return height <= options.max_height_difference_m;
}

/// Whether both parts lie on the union's rim, with or without bridged gaps.
bool OnRim(const ObjectContext& context, const Part& a, const Part& b, const Part& both,
           base::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  bool on_rim = false;
  for (const Indices* rim : {&both.top->rim, &both.top->bridged_rim}) {
    const auto fit = FitCircle(Select(cloud.points, *rim), options.circle, rng);
    on_rim = on_rim || (fit && std::ranges::all_of(std::array{&a, &b}, [&](const Part* part) {
                          return ShareOnCircle(cloud, Shared(*rim, part->points), fit->circle,
                                               options.circle.distance_m) >= options.axis.rim_share;
                        }));
  }
  return on_rim;
}

/// Whether a part's share of the union's top is on its lip: a wide lip's rim is only one side.
bool OnLip(const ObjectContext& context, const Part& part, const Part& both) {
  const Indices own = Shared(both.top->points, part.points);
  return !own.empty() && IsOnLip(context, own, *both.axis);
}

bool Agrees(const ObjectContext& context, const Part& part, const BodyProfile& body) {
  const auto agreeing = static_cast<double>(Shared(OnCircle(body), part.points).size());
  const auto differing = static_cast<double>(Shared(body.differing, part.points).size());
  return agreeing >= context.options.merge.min_own_body * (agreeing + differing);
}

/// Whether a part lies on the union's body with the least share of its points. The others may be
/// ends, lips and floors.
bool OnBody(const ObjectContext& context, const Part& part, const BodyProfile& body) {
  return HoldsForShare(context.options.merge.min_own_body, part.points,
                       [&](auto i) { return std::ranges::binary_search(body.agreeing, i); });
}

/// The union of both, if it is rotational and both parts agree with it.
std::optional<Part> RotationalUnion(const ObjectContext& context, const Part& a, const Part& b,
                                    base::Rng& rng) {
  if (!MayBeOne(context, a, b)) return std::nullopt;
  Part both = DescribeUnion(context, a, b, rng);
  if (!both.axis) return std::nullopt;
  const auto body = ProfileBody(context, both.points, EndPlane(*both.axis, *both.top), *both.axis);
  if (!Agrees(context, a, body) || !Agrees(context, b, body)) return std::nullopt;
  // An axis from the body alone has no rim to test the parts with. Where things lie about, a few
  // points of one agree with the body of another.
  if (both.axis->rim_fraction == 0.0) {
    PartSurface surface(Select(context.cloud.points, a.points));
    const bool one = OnBody(context, a, body) && OnBody(context, b, body) &&
                     ComesWithin(context, b, surface, 2.0 * both.axis->radius_m);
    return one ? std::optional(std::move(both)) : std::nullopt;
  }
  const bool on_rim = OnRim(context, a, b, both, rng);
  const bool on_lip =
      context.options.lip_tops && OnLip(context, a, both) && OnLip(context, b, both);
  if (!on_rim && !on_lip) return std::nullopt;
  return both;
}

}  // namespace

PartSurface::PartSurface(Points points_C)
    : points_C_(std::move(points_C)), box_(geometry::BoundsOf(points_C_)) {}

std::optional<std::uint32_t> PartSurface::NearestWithin(const Vector3d& p_C, double gap_m) {
  if (points_C_.empty() || box_.squaredExteriorDistance(p_C) > gap_m * gap_m) return std::nullopt;
  if (!tree_) tree_.emplace(points_C_);
  tree_->Nearest(p_C, 1, nearest_);
  if (nearest_.front().squared_distance > gap_m * gap_m) return std::nullopt;
  return nearest_.front().index;
}

std::span<const geometry::KdTree::Neighbor> PartSurface::Within(const Vector3d& p_C, double gap_m) {
  if (points_C_.empty()) return {};
  if (!tree_) tree_.emplace(points_C_);
  tree_->Within(p_C, gap_m, nearest_);
  return nearest_;
}

Kinship FindKinship(const ObjectContext& context, const Part& fragment, const Part& host) {
  return KinshipOf(context, fragment, MakeFootprint(context, fragment), host,
                   MakeFootprint(context, host));
}

void MergeFragments(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng) {
  std::vector<Footprint> footprints;
  for (const Part& part : parts) footprints.push_back(MakeFootprint(context, part));
  Tried strangers(parts.size());
  const auto join = [&](std::size_t fragment, std::size_t host) {
    parts[host] = DescribeUnion(context, parts[host], parts[fragment], rng);
    footprints[host] = MakeFootprint(context, parts[host]);
    strangers.Unite(host, fragment);
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(fragment));
    footprints.erase(footprints.begin() + static_cast<std::ptrdiff_t>(fragment));
  };
  const auto join_one = [&] {
    const std::vector<std::size_t> order = SmallestFirst(parts);
    for (std::size_t a = 0; a < order.size(); ++a) {
      for (const std::size_t host : order | std::views::drop(a + 1) | std::views::reverse) {
        const std::size_t fragment = order[a];
        if (strangers.Contains(fragment, host)) continue;
        if (KinshipOf(context, parts[fragment], footprints[fragment], parts[host],
                      footprints[host]) == Kinship::kNone) {
          strangers.Add(fragment, host);
          continue;
        }
        join(fragment, host);
        return true;
      }
    }
    return false;
  };
  while (join_one()) {
  }
}

void MergeLone(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng) {
  const MergeOptions& options = context.options.merge;
  geometry::UnionFind groups(parts.size());
  std::vector<Footprint> footprints;
  std::vector<Touch> touches;
  // A limb of any part is one of the largest part of its group, too.
  const auto is_limb_of = [&](std::uint32_t limb, std::uint32_t body) {
    return static_cast<double>(parts[limb].points.size()) <
               options.max_limb_share * static_cast<double>(parts[body].points.size()) &&
           MayBeLimb(footprints[limb], options);
  };
  for (std::uint32_t b = 0; b < parts.size(); ++b) {
    footprints.push_back(MakeFootprint(context, parts[b]));
    for (std::uint32_t a = 0; a < b; ++a) {
      const bool limb = is_limb_of(a, b) || is_limb_of(b, a);
      auto pairs = Across(context, parts[a], parts[b], *footprints[b].surface,
                          limb ? options.limb_gap_m : options.fragment_gap_m);
      if (pairs.empty()) continue;
      groups.Unite(a, b);
      touches.push_back({a, b, std::move(pairs)});
    }
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> members;  // by root, in their order
  for (std::uint32_t i = 0; i < parts.size(); ++i) members[groups.Find(i)].push_back(i);
  std::vector<bool> joined(parts.size(), false);
  for (const auto& [root, group] : members) {
    if (group.size() < 2) continue;
    Part whole;
    for (const auto i : group) {
      whole.points.insert(whole.points.end(), parts[i].points.begin(), parts[i].points.end());
    }
    std::ranges::sort(whole.points);
    const auto body =
        *std::ranges::max_element(group, {}, [&](auto i) { return parts[i].points.size(); });
    const bool has_limbs_only =
        std::ranges::all_of(group, [&](auto i) { return i == body || is_limb_of(i, body); });
    const double max_width_m =
        has_limbs_only ? options.max_limbed_width_m : options.max_lone_width_m;
    if (!FitsAHand(MakeFootprint(context, whole), max_width_m, options)) continue;
    const bool sharp = std::ranges::any_of(touches, [&, root = root](const Touch& touch) {
      return groups.Find(touch.a) == root && !is_limb_of(touch.a, body) &&
             !is_limb_of(touch.b, body) &&
             CreaseAt(context, touch, parts, footprints) > options.max_lone_crease_rad;
    });
    if (sharp) continue;
    parts[group.front()] = DescribePart(context, std::move(whole.points), rng);
    for (const auto i : group | std::views::drop(1)) joined[i] = true;
  }
  std::size_t i = 0;
  std::erase_if(parts, [&](const Part&) { return joined[i++]; });
}

void MergeRotational(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng) {
  Tried apart(parts.size());
  const auto merge_one = [&] {
    for (std::size_t a = 0; a < parts.size(); ++a) {
      for (std::size_t b = a + 1; b < parts.size(); ++b) {
        if (apart.Contains(a, b)) continue;
        auto both = RotationalUnion(context, parts[a], parts[b], rng);
        if (!both) {
          apart.Add(a, b);
          continue;
        }
        parts[a] = std::move(*both);
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(b));
        apart.Unite(a, b);
        return true;
      }
    }
    return false;
  };
  while (merge_one()) {  // the union may match a part that neither matched alone
  }
}

}  // namespace rangegrasp::perception::internal
