#include "perception/internal/part.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "perception/internal/rotation_axis.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {

Part DescribePart(const ObjectContext& context, geometry::Indices points, base::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  Part part{std::move(points), std::nullopt, std::nullopt};
  part.top = FindTopSurface(cloud, part.points, table, options, rng);
  if (part.top) {
    part.axis = FindRotationAxis(cloud, part.points, *part.top, table, options, rng);
  }
  if (part.axis || !options.lip_tops) return part;
  auto lip = FindLip(cloud, part.points, table, options);
  if (!lip) return part;
  part.axis = FindStandingAxis(cloud, part.points, *lip, table, options, rng);
  if (part.axis) part.top = std::move(lip);
  return part;
}

Part DescribeUnion(const ObjectContext& context, const Part& a, const Part& b, base::Rng& rng) {
  geometry::Indices both;
  both.reserve(a.points.size() + b.points.size());
  std::merge(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
             std::back_inserter(both));
  return DescribePart(context, std::move(both), rng);
}

}  // namespace rangegrasp::perception::internal
