#include "perception/merge.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/units.h"
#include "geometry/kd_tree.h"
#include "perception/planar.h"
#include "perception/rotational.h"
#include "perception/top_surface.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;

constexpr double kFootprintMargin_m = 0.005;
constexpr double kHeightMargin_m = 0.003;

Indices Union(const Indices& a, const Indices& b) {
  Indices both;
  both.reserve(a.size() + b.size());
  std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

/// The points of `points` that are in the ascending `of`.
Indices Shared(const Indices& points, const Indices& of) {
  Indices shared;
  for (const auto i : points) {
    if (std::binary_search(of.begin(), of.end(), i)) shared.push_back(i);
  }
  return shared;
}

/// Cheap necessary conditions, so that few pairs are fitted.
bool MayBeOneRotationalObject(const MergeContext& context, const Part& a, const Part& b) {
  constexpr double kMostHeightDifference_m = 0.010;
  constexpr double kMostCenterDistance_m = 0.010;
  if (!a.top || !b.top) return false;
  const double height = std::abs(TopHeight(context.cloud, a.points, context.table) -
                                 TopHeight(context.cloud, b.points, context.table));
  if (height > kMostHeightDifference_m) return false;
  if ((a.top->center_C - b.top->center_C).norm() > 2.0 * context.options.most_radius_m) {
    return false;
  }
  return !a.axis || !b.axis ||
         (a.axis->center_C - b.axis->center_C).norm() <= kMostCenterDistance_m;
}

/// The union of both, if it is rotational and both parts agree with it.
std::optional<Part> RotationalUnion(const MergeContext& context, const Part& a, const Part& b,
                                    core::Rng& rng) {
  // The body share holds for the union (as printed); the part with the handle may be below it.
  constexpr double kLeastOwnBody = 0.5;
  const auto& [cloud, table, sensor, options] = context;
  Part both = DescribePart(context, Union(a.points, b.points), rng);
  if (!both.axis) return std::nullopt;
  // An axis from the body alone has no rim circle to ask the parts for.
  const bool from_rim = both.axis->rim_fraction > 0.0;
  Indices rim;
  std::optional<CircleFit> fit;
  if (from_rim) {
    rim = OuterRim(cloud, both.top->points, both.top->plane, options.bridged_rim_alpha_m);
    fit = FitCircle(geometry::Select(cloud.points, rim), options, rng);
    if (!fit) return std::nullopt;
  }
  const BodyProfile body = ProfileBody(cloud, both.points, *both.top, both.axis->center_C,
                                       both.axis->direction_C, options);
  for (const Part* part : {&a, &b}) {
    const Indices own_rim = Shared(rim, part->points);
    if (from_rim &&
        (own_rim.empty() || ShareOnCircle(cloud, own_rim, fit->circle, options.circle_distance_m) <
                                options.rim_share)) {
      return std::nullopt;
    }
    const auto agreeing = static_cast<double>(Shared(body.agreeing, part->points).size());
    const auto differing = static_cast<double>(Shared(body.differing, part->points).size());
    if (agreeing < kLeastOwnBody * (agreeing + differing)) return std::nullopt;
  }
  return both;
}

/// What the rules about fragments read of a part.
struct Footprint {
  PlanarFrame frame;
  ConvexPolygon hull;
  double fill = 0.0;  ///< share of the hull's area that has points
  double top_m = 0.0;
  double base_m = 0.0;
};

Footprint MakeFootprint(const MergeContext& context, const Part& part) {
  constexpr double kCell_m = 0.006;
  Footprint footprint;
  footprint.frame = MakePlanarFrame(context.table, context.sensor_C, Eigen::Vector3d::UnitX());
  const auto flat = Flatten(footprint.frame, geometry::Select(context.cloud.points, part.points));
  footprint.hull = ConvexPolygon::Around(flat);
  std::set<std::pair<long, long>> cells;
  for (const auto& q : flat) {
    cells.emplace(std::lround(q.x() / kCell_m), std::lround(q.y() / kCell_m));
  }
  footprint.fill = static_cast<double>(cells.size()) * kCell_m * kCell_m /
                   std::max(footprint.hull.Area(), kCell_m * kCell_m);
  footprint.top_m = TopHeight(context.cloud, part.points, context.table);
  footprint.base_m = BaseHeight(context.cloud, part.points, context.table);
  return footprint;
}

double ShareOver(const MergeContext& context, const Part& part, const Footprint& host) {
  const auto over = std::count_if(part.points.begin(), part.points.end(), [&](auto i) {
    return host.hull.Distance(host.frame.Flat(context.cloud.points[i])) <= kFootprintMargin_m;
  });
  return static_cast<double>(over) / static_cast<double>(part.points.size());
}

/// Pairs (fragment point, nearest host point) across at most the gap.
std::vector<std::pair<std::uint32_t, std::uint32_t>> Across(const MergeContext& context,
                                                            const Part& fragment, const Part& host,
                                                            double gap_m) {
  const geometry::Points host_points = geometry::Select(context.cloud.points, host.points);
  Eigen::AlignedBox3d box;
  for (const auto& p : host_points) box.extend(p);
  std::optional<geometry::KdTree> tree;
  std::vector<geometry::KdTree::Neighbor> found;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const auto i : fragment.points) {
    const Eigen::Vector3d& p = context.cloud.points[i];
    if (box.squaredExteriorDistance(p) > gap_m * gap_m) continue;
    if (!tree) tree.emplace(host_points);
    tree->Nearest(p, 1, found);
    if (!found.empty() && found[0].squared_distance <= gap_m * gap_m) {
      pairs.emplace_back(i, host.points[found[0].index]);
    }
  }
  return pairs;
}

/// The two tangent planes continue each other or fold away from the sensor, and the gap does not
/// run sideways.
bool ContinuesAcross(const MergeContext& context, std::uint32_t a, std::uint32_t b) {
  constexpr double kMostInFront_m = 0.0015;
  const auto& [cloud, table, sensor, options] = context;
  const Eigen::Vector3d gap = cloud.points[b] - cloud.points[a];
  if (cloud.normals[a].dot(gap) > kMostInFront_m || cloud.normals[b].dot(-gap) > kMostInFront_m) {
    return false;
  }
  const Eigen::Vector3d sideways = table.normal.cross(sensor - cloud.points[a]).normalized();
  return std::abs(gap.dot(sideways)) < 0.5 * gap.norm();
}

Kinship KinshipOf(const MergeContext& context, const Part& fragment, const Footprint& f,
                  const Part& host, const Footprint& h) {
  constexpr double kLeastFill = 0.5;
  constexpr std::size_t kLeastPairs = 8;
  const double gap = context.options.fragment_gap_m;
  const double over = ShareOver(context, fragment, h);
  if (over >= 0.9 && f.base_m >= h.top_m - kFootprintMargin_m && f.base_m <= h.top_m + gap &&
      f.hull.Area() <= 0.6 * h.hull.Area()) {
    return Kinship::kAbove;
  }
  const bool below = f.top_m <= h.top_m + kHeightMargin_m;
  if (below && over >= 0.7 && host.axis) return Kinship::kWithin;
  const auto pairs = Across(context, fragment, host, gap);
  if (below && over >= 0.7 && h.fill >= kLeastFill && !pairs.empty()) return Kinship::kWithin;
  if (pairs.size() < kLeastPairs) return Kinship::kNone;
  const auto continuing = std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return ContinuesAcross(context, pair.first, pair.second);
  });
  return 2 * static_cast<std::size_t>(continuing) > pairs.size() ? Kinship::kSurface
                                                                 : Kinship::kNone;
}

/// One pass over all ordered pairs, smallest fragment first; the first kinship found is joined.
bool JoinOne(const MergeContext& context, std::vector<Part>& parts,
             std::vector<Footprint>& footprints, core::Rng& rng) {
  std::vector<std::size_t> order(parts.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return parts[a].points.size() < parts[b].points.size();
  });
  for (std::size_t a = 0; a < order.size(); ++a) {
    for (std::size_t b = order.size(); b-- > a + 1;) {
      const std::size_t fragment = order[a];
      const std::size_t host = order[b];
      if (KinshipOf(context, parts[fragment], footprints[fragment], parts[host],
                    footprints[host]) == Kinship::kNone) {
        continue;
      }
      parts[host] = DescribePart(context, Union(parts[host].points, parts[fragment].points), rng);
      footprints[host] = MakeFootprint(context, parts[host]);
      parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(fragment));
      footprints.erase(footprints.begin() + static_cast<std::ptrdiff_t>(fragment));
      return true;
    }
  }
  return false;
}

}  // namespace

Part DescribePart(const MergeContext& context, Indices points, core::Rng& rng) {
  const auto& [cloud, table, sensor, options] = context;
  Part part{std::move(points), std::nullopt, std::nullopt};
  part.top = FindTopSurface(cloud, part.points, table, options, rng);
  if (part.top) {
    part.axis = FindRotationAxis(cloud, part.points, *part.top, table, options, rng);
  }
  return part;
}

void MergeRotational(const MergeContext& context, std::vector<Part>& parts, core::Rng& rng) {
  for (std::size_t a = 0; a < parts.size(); ++a) {
    for (std::size_t b = a + 1; b < parts.size();) {
      std::optional<Part> both;
      if (MayBeOneRotationalObject(context, parts[a], parts[b])) {
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

Kinship FindKinship(const MergeContext& context, const Part& fragment, const Part& host) {
  return KinshipOf(context, fragment, MakeFootprint(context, fragment), host,
                   MakeFootprint(context, host));
}

void MergeFragments(const MergeContext& context, std::vector<Part>& parts, core::Rng& rng) {
  std::vector<Footprint> footprints;
  footprints.reserve(parts.size());
  for (const Part& part : parts) footprints.push_back(MakeFootprint(context, part));
  while (JoinOne(context, parts, footprints, rng)) {
  }
}

}  // namespace rangegrasp::perception
