#include "perception/internal/merge_rotational.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "perception/internal/body_profile.h"
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
  const double height = std::abs(TopHeight(context.cloud, a.points, context.table) -
                                 TopHeight(context.cloud, b.points, context.table));
  if (height > options.max_height_difference_m) return false;
  const double diameter_m = 2.0 * context.options.circle.max_radius_m;
  if ((a.top->center_C - b.top->center_C).norm() > diameter_m) return false;
  return !a.axis || !b.axis ||
         (a.axis->center_C - b.axis->center_C).norm() <= options.max_center_distance_m;
}

/// The rim of a union whose axis came from its rim, and the circle on it; an axis from the body
/// alone has no rim to ask the parts for.
struct RimCircle {
  Indices rim;
  std::optional<CircleFit> fit;
};

/// Whether a part of the union lies on the union's rim and agrees with its body.
bool Agrees(const ObjectContext& context, const Part& part, const std::optional<RimCircle>& rim,
            const BodyProfile& body) {
  const auto& options = context.options;
  if (rim) {
    const Indices own = Shared(rim->rim, part.points);
    if (own.empty() || ShareOnCircle(context.cloud, own, rim->fit->circle,
                                     options.circle.distance_m) < options.axis.rim_share) {
      return false;
    }
  }
  const auto agreeing = static_cast<double>(Shared(body.agreeing, part.points).size());
  const auto differing = static_cast<double>(Shared(body.differing, part.points).size());
  return agreeing >= options.merge.min_own_body * (agreeing + differing);
}

/// The union of both, if it is rotational and both parts agree with it.
std::optional<Part> RotationalUnion(const ObjectContext& context, const Part& a, const Part& b,
                                    core::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  Part both = DescribeUnion(context, a, b, rng);
  if (!both.axis) return std::nullopt;
  std::optional<RimCircle> rim;
  if (both.axis->rim_fraction > 0.0) {
    rim.emplace();
    rim->rim = options.bridged_rims ? OuterRim(cloud, both.top->points, both.top->plane,
                                               options.top.bridged_rim_alpha_m)
                                    : both.top->rim;
    rim->fit = FitCircle(geometry::Select(cloud.points, rim->rim), options.circle, rng);
    if (!rim->fit) return std::nullopt;
  }
  const BodyProfile body = ProfileBody(cloud, both.points, *both.top, both.axis->center_C,
                                       both.axis->direction_C, options);
  if (!Agrees(context, a, rim, body) || !Agrees(context, b, rim, body)) return std::nullopt;
  return both;
}

}  // namespace

void MergeRotational(const ObjectContext& context, std::vector<Part>& parts, core::Rng& rng) {
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
