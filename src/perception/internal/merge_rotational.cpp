#include "perception/internal/merge_rotational.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "perception/internal/body_profile.h"
#include "perception/internal/part_surface.h"
#include "perception/internal/rotation_axis.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;

/// The points of `points` that are in the ascending `of`.
Indices Shared(const Indices& points, const Indices& of) {
  Indices shared;
  for (const auto i : points) {
    if (std::binary_search(of.begin(), of.end(), i)) shared.push_back(i);
  }
  return shared;
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

/// A rim of a union, and the circle that most of it lies on.
struct RimCircle {
  Indices rim;
  Circle circle;
};

/// Whether a part of the union lies on the union's rim.
bool OnRim(const ObjectContext& context, const Part& part, const RimCircle& rim) {
  const Indices own = Shared(rim.rim, part.points);
  return !own.empty() &&
         ShareOnCircle(context.cloud, own, rim.circle, context.options.circle.distance_m) >=
             context.options.axis.rim_share;
}

/// Whether a part's share of the union's top lies on the lip of its wall. Where the two sides of a
/// lip are far apart, the rim goes round one of them alone.
bool OnLip(const ObjectContext& context, const Part& part, const Part& both) {
  const AxisOptions& options = context.options.axis;
  const Indices own = Shared(both.top->points, part.points);
  const auto on_lip = std::count_if(own.begin(), own.end(), [&](auto i) {
    const double inside =
        both.axis->radius_m -
        AxisDistance(context.cloud.points[i], both.axis->center_C, both.axis->direction_C);
    return inside >= -context.options.circle.distance_m && inside <= options.max_wall_m;
  });
  return !own.empty() &&
         static_cast<double>(on_lip) >= options.rim_share * static_cast<double>(own.size());
}

/// The union's rims: as the alpha shape gives it, and with its gaps bridged.
std::vector<RimCircle> RimsOf(const ObjectContext& context, const Part& both, base::Rng& rng) {
  std::vector<RimCircle> rims;
  for (const Indices* rim : {&both.top->rim, &both.top->bridged_rim}) {
    const auto fit =
        FitCircle(geometry::Select(context.cloud.points, *rim), context.options.circle, rng);
    if (fit) rims.push_back({*rim, fit->circle});
  }
  return rims;
}

/// Whether a part of the union agrees with its body.
bool Agrees(const ObjectContext& context, const Part& part, const BodyProfile& body) {
  const auto agreeing = static_cast<double>(Shared(OnCircle(body), part.points).size());
  const auto differing = static_cast<double>(Shared(body.differing, part.points).size());
  return agreeing >= context.options.merge.min_own_body * (agreeing + differing);
}

/// Whether a part lies on the union's body with all of its points but ends, lips and floors.
bool OnBody(const ObjectContext& context, const Part& part, const BodyProfile& body) {
  return static_cast<double>(Shared(body.agreeing, part.points).size()) >=
         context.options.merge.min_own_body * static_cast<double>(part.points.size());
}

/// Whether the two come this near [m] to each other.
bool AreNear(const ObjectContext& context, const Part& a, const Part& b, double gap_m) {
  PartSurface surface(geometry::Select(context.cloud.points, a.points));
  return std::ranges::any_of(b.points, [&](auto i) {
    return surface.NearestWithin(context.cloud.points[i], gap_m).has_value();
  });
}

/// The union of both, if it is rotational and both parts agree with it.
std::optional<Part> RotationalUnion(const ObjectContext& context, const Part& a, const Part& b,
                                    base::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  Part both = DescribeUnion(context, a, b, rng);
  if (!both.axis) return std::nullopt;
  const BodyProfile body = ProfileBody(cloud, both.points, EndPlane(*both.axis, *both.top),
                                       both.axis->center_C, both.axis->direction_C, options);
  if (!Agrees(context, a, body) || !Agrees(context, b, body)) return std::nullopt;
  // An axis from the body alone has no rim to ask the parts for; where things lie about, a few
  // points of one agree with the body of another.
  if (both.axis->rim_fraction == 0.0) {
    const bool one = OnBody(context, a, body) && OnBody(context, b, body) &&
                     AreNear(context, a, b, 2.0 * both.axis->radius_m);
    return one ? std::optional(std::move(both)) : std::nullopt;
  }
  const auto rims = RimsOf(context, both, rng);
  const bool on_rim = std::any_of(rims.begin(), rims.end(), [&](const RimCircle& rim) {
    return OnRim(context, a, rim) && OnRim(context, b, rim);
  });
  const bool on_lip =
      context.options.lip_tops && OnLip(context, a, both) && OnLip(context, b, both);
  if (!on_rim && !on_lip) return std::nullopt;
  return both;
}

}  // namespace

void MergeRotational(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng) {
  for (std::size_t a = 0; a < parts.size(); ++a) {
    for (std::size_t b = a + 1; b < parts.size();) {
      std::optional<Part> both;
      if (MayBeOne(context, parts[a], parts[b])) {
        both = RotationalUnion(context, parts[a], parts[b], rng);
      }
      if (!both) {
        ++b;
        continue;
      }
      parts[a] = std::move(*both);
      parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(b));
      b = a + 1;  // The union may take what the part alone did not.
    }
  }
}

}  // namespace rangegrasp::perception::internal
