#include <algorithm>
#include <cmath>

#include "core/stopwatch.h"
#include "perception/completion.h"
#include "perception/features.h"
#include "perception/merge.h"
#include "perception/planar.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;

/// What a part stands on, as a height above the table: the table, unless points of other parts lie
/// under its footprint: then its own lowest points.
double BaseOf(const MergeContext& context, const std::vector<Part>& parts, std::size_t which) {
  // Points this low stand on the table: those of the table's clearance are not in the cloud.
  constexpr double kOnTable_m = 0.012;
  constexpr std::size_t kLeastSupport = 15;
  const double lowest = BaseHeight(context.cloud, parts[which].points, context.table);
  if (lowest <= kOnTable_m) return 0.0;
  const PlanarFrame frame = MakePlanarFrame(context.table, context.sensor_C);
  const auto footprint = ConvexPolygon::Around(
      Flatten(frame, geometry::Select(context.cloud.points, parts[which].points)));
  std::size_t under = 0;
  for (std::size_t other = 0; other < parts.size(); ++other) {
    if (other == which) continue;
    for (const auto i : parts[other].points) {
      const auto& p = context.cloud.points[i];
      if (context.table.Distance(p) <= lowest + kOnTable_m &&
          footprint.Distance(frame.Flat(p)) == 0.0) {
        ++under;
      }
    }
  }
  return under >= kLeastSupport ? lowest : 0.0;
}

void SortTopmostFirst(std::vector<PerceivedObject>& objects) {
  const auto millimetres = [](double metres) { return std::lround(metres * 1e3); };
  std::stable_sort(objects.begin(), objects.end(),
                   [&](const PerceivedObject& a, const PerceivedObject& b) {
                     const long height_a = millimetres(a.height_m);
                     const long height_b = millimetres(b.height_m);
                     if (height_a != height_b) return height_a > height_b;
                     return a.points.size() > b.points.size();
                   });
}

}  // namespace

double OpenSphereRadius(const geometry::PointCloud& cloud, const TopSurface& top,
                        const FeatureOptions& options) {
  if (top.rim.empty()) return 0.0;
  double nearest = (cloud.points[top.rim.front()] - top.center_C).norm();
  for (const auto i : top.rim) nearest = std::min(nearest, (cloud.points[i] - top.center_C).norm());
  return options.open_sphere_factor * nearest;
}

bool IsOpen(const geometry::PointCloud& cloud, const Indices& object, const TopSurface& top,
            const FeatureOptions& options) {
  const double radius = OpenSphereRadius(cloud, top, options);
  if (radius <= 0.0) return false;
  const auto inside = std::count_if(object.begin(), object.end(), [&](auto i) {
    return (cloud.points[i] - top.center_C).norm() < radius;
  });
  return static_cast<double>(inside) <=
         options.open_stray_share * static_cast<double>(top.points.size());
}

std::vector<PerceivedObject> BuildObjects(const geometry::PointCloud& cloud,
                                          const std::vector<Indices>& segments,
                                          const geometry::Plane& table, const SensorView& view,
                                          const FeatureOptions& options, core::Rng& rng,
                                          StageSeconds& seconds) {
  core::Stopwatch watch;
  const MergeContext context{cloud, table, view.origin_C(), options};
  std::vector<Part> parts;
  parts.reserve(segments.size());
  for (const Indices& segment : segments) {
    if (segment.empty()) continue;
    Indices sorted = segment;
    std::sort(sorted.begin(), sorted.end());
    parts.push_back(DescribePart(context, std::move(sorted), rng));
  }
  seconds.emplace_back("top surfaces", watch.Restart());

  MergeRotational(context, parts, rng);
  if (options.merge_fragments) MergeFragments(context, parts, rng);
  seconds.emplace_back("merging", watch.Restart());

  const CompletionContext completion{cloud, table, view, options};
  std::vector<PerceivedObject> objects;
  objects.reserve(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto object = MakeObject(completion, parts[i], BaseOf(context, parts, i));
    if (object.size_m.x() >= options.least_footprint_m) objects.push_back(std::move(object));
  }
  SortTopmostFirst(objects);
  seconds.emplace_back("completion", watch.Restart());
  return objects;
}

}  // namespace rangegrasp::perception
