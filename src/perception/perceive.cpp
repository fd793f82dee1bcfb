#include "perception/perceive.h"

#include "core/error.h"
#include "core/stopwatch.h"
#include "geometry/kd_tree.h"
#include "geometry/normals.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;

constexpr std::size_t kLeastPoints = 100;

Indices AboveTable(geometry::PointSpan points, const geometry::Plane& table, double clearance_m) {
  Indices above;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (table.Distance(points[i]) > clearance_m) above.push_back(static_cast<std::uint32_t>(i));
  }
  return above;
}

/// Fills the scene's source and outliers from the points above the table.
void FilterPoints(geometry::PointSpan points, const Indices& above, bool filter, Scene& scene) {
  if (!filter || above.size() < 2) {
    scene.source = above;
    return;
  }
  std::vector<bool> kept(above.size(), false);
  for (const auto k : CompressionRateFilter(geometry::Select(points, above))) kept[k] = true;
  for (std::size_t k = 0; k < above.size(); ++k) {
    (kept[k] ? scene.source : scene.outliers).push_back(above[k]);
  }
}

}  // namespace

Scene Perceive(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
               const PerceptionOptions& options, core::Rng& rng) {
  if (points_C.size() < kLeastPoints) {
    throw core::InputError("a scan needs at least " + std::to_string(kLeastPoints) +
                           " points, this one has " + std::to_string(points_C.size()));
  }
  Scene scene;
  core::Stopwatch watch;
  auto table = FindTable(points_C, sensor_origin_C, options.preprocess, rng);
  if (!table) throw core::InputError("no table plane was found in the scan");
  scene.table = std::move(*table);
  const Indices above =
      AboveTable(points_C, scene.table.plane, options.preprocess.table_clearance_m);
  scene.seconds.emplace_back("table", watch.Restart());

  FilterPoints(points_C, above, options.preprocess.filter, scene);
  scene.cloud.points = geometry::Select(points_C, scene.source);
  scene.seconds.emplace_back("filter", watch.Restart());

  if (options.preprocess.smooth && !scene.source.empty()) {
    scene.cloud.points = Smooth(scene.cloud.points, options.preprocess.smooth_radius_m);
  }
  scene.seconds.emplace_back("smooth", watch.Restart());

  if (!scene.source.empty()) {
    const geometry::KdTree tree(scene.cloud.points);
    scene.cloud.normals = geometry::EstimateNormals(
        scene.cloud.points, tree, options.preprocess.normal_radius_m, sensor_origin_C);
  }
  scene.seconds.emplace_back("normals", watch.Restart());

  if (!scene.source.empty()) scene.segments = Segment(scene.cloud, options.segment);
  scene.seconds.emplace_back("segments", watch.Restart());

  const SensorView view(points_C, sensor_origin_C);
  scene.objects = BuildObjects(scene.cloud, scene.segments, scene.table.plane, view,
                               options.features, rng, scene.seconds);
  return scene;
}

}  // namespace rangegrasp::perception
