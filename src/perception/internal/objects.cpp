#include "perception/internal/objects.h"

#include <iterator>

#include "base/stopwatch.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/completion.h"
#include "perception/internal/merging.h"
#include "perception/internal/rotation_axis.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

/// Height of a part's support over the table: its lowest points if other parts are under it, or 0.
double BaseOf(const ObjectContext& context, const std::vector<Part>& parts, std::size_t which) {
  const CompletionOptions& options = context.options.completion;
  const double lowest = BaseHeight(context.cloud, parts[which].points, context.table);
  if (lowest <= options.on_table_m) return 0.0;
  const PlanarFrame frame = MakePlanarFrame(context.table, context.FirstOrigin());
  const auto footprint =
      ConvexPolygon::Around(Flatten(frame, Select(context.cloud.points, parts[which].points)));
  std::ptrdiff_t under = 0;
  for (std::size_t other = 0; other < parts.size(); ++other) {
    if (other == which) continue;
    under += std::ranges::count_if(parts[other].points, [&](auto i) {
      const auto& p = context.cloud.points[i];
      return context.table.Distance(p) <= lowest + options.on_table_m &&
             footprint.Distance(frame.Flat(p)) == 0.0;
    });
  }
  return under >= options.min_support_points ? lowest : 0.0;
}

PerceivedObject MakeObject(const ObjectContext& context, const Part& part, double base_m) {
  PerceivedObject object;
  object.points = part.points;
  object.kind = part.axis ? ObjectKind::kRotational : ObjectKind::kOther;
  object.top = part.top;
  object.axis = part.axis;
  object.height_m = TopHeight(context.cloud, part.points, context.table);
  object.base_m = std::min(base_m, object.height_m);
  const bool lies = part.axis && part.axis->Lies();
  object.open = part.top && !part.top->ridge && !lies && IsOpen(context, part.points, *part.top);
  Completion completion = part.axis ? CompleteRotational(context, part, object.base_m)
                                    : CompleteOther(context, part, object.base_m);
  object.completed_C = std::move(completion.points_C);
  object.surface_C = std::move(completion.surface_C);
  SetBox(MakePlanarFrame(context.table, context.FirstOrigin()), context.options.completion, object);
  return object;
}

}  // namespace

void SetBox(const PlanarFrame& frame, const CompletionOptions& options, PerceivedObject& object) {
  const auto flat = Flatten(frame, object.completed_C);
  const Rectangle box = FootprintBox(frame, flat, object.top, options);
  object.size_m = {box.length_m, box.width_m, object.height_m - object.base_m};
  object.center_C = frame.Lift(box.center, 0.5 * (object.height_m + object.base_m));
  object.axis_C = box.axis.x() * frame.u + box.axis.y() * frame.v;
}

Part DescribePart(const ObjectContext& context, Indices points, base::Rng& rng) {
  Part part{std::move(points), std::nullopt, std::nullopt};
  part.top = FindTopSurface(context, part.points, rng);
  if (part.top) part.axis = FindRotationAxis(context, part.points, *part.top, rng);
  if (!part.axis && context.options.lip_tops) {
    auto lip = FindLip(context, part.points);
    if (lip) part.axis = FindStandingAxis(context, part.points, *lip, rng);
    if (part.axis) part.top = std::move(lip);
  }
  if (part.axis && context.options.refine_axis) {
    RefineAxis(context, part.points, *part.top, *part.axis);
  }
  return part;
}

Part DescribeUnion(const ObjectContext& context, const Part& a, const Part& b, base::Rng& rng) {
  Indices both;
  std::ranges::merge(a.points, b.points, std::back_inserter(both));
  return DescribePart(context, std::move(both), rng);
}

std::vector<PerceivedObject> BuildObjects(const ObjectContext& context,
                                          const std::vector<Indices>& segments, base::Rng& rng,
                                          StageSeconds& seconds) {
  const FeatureOptions& options = context.options;
  base::Stopwatch watch;
  std::vector<Part> parts;
  for (const Indices& segment : segments) parts.push_back(DescribePart(context, segment, rng));
  seconds.emplace_back("top surfaces", watch.Restart());

  MergeRotational(context, parts, rng);
  if (options.merge_fragments) MergeFragments(context, parts, rng);
  if (options.lone_objects) MergeLone(context, parts, rng);
  seconds.emplace_back("merging", watch.Restart());

  std::vector<PerceivedObject> objects;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto object = MakeObject(context, parts[i], BaseOf(context, parts, i));
    const bool needle = options.drop_needles && object.size_m.x() < options.min_footprint_m;
    if (!needle) objects.push_back(std::move(object));
  }
  // Objects with the same height to the millimetre are equally high: noise must not order them.
  std::ranges::stable_sort(objects, std::ranges::greater(), [](const PerceivedObject& object) {
    return std::pair(std::lround(object.height_m * base::kMmPerM), object.points.size());
  });
  seconds.emplace_back("completion", watch.Restart());
  return objects;
}

}  // namespace rangegrasp::perception::internal
