#include "perception/perceive.h"

#include <fmt/format.h>

#include <iterator>
#include <ranges>

#include "base/error.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "geometry/alpha_shape.h"
#include "perception/internal/container.h"
#include "perception/internal/objects.h"
#include "perception/preprocess.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::Observation;
using geometry::Points;
using geometry::PointSpan;
using geometry::Select;

/// Fewer points are not a scan of a table; the hull and the fits would only fail later.
constexpr std::size_t kMinPoints = 100;

std::string NoTable(PointSpan points, const PreprocessOptions& options, base::Rng& rng) {
  const auto best =
      geometry::FitPlaneRansac(points, {options.plane_draws, options.plane_distance_m}, rng);
  return fmt::format("no table was found (the best plane has {} points of {})",
                     best ? best->inliers.size() : 0, points.size());
}

/// Fills the scene's source and outliers from the points above the table.
void FilterPoints(const Indices& above, const PreprocessOptions& options, Scene& scene) {
  if (!options.filter) {
    scene.source = above;
    return;
  }
  for (const auto k : CompressionRateFilter(Select(scene.points_C, above),
                                            {options.isolated_outliers, options.repeated_filter,
                                             options.filter_unit_m, options.filter_keep_m})) {
    scene.source.push_back(above[k]);
  }
  std::ranges::set_difference(above, scene.source, std::back_inserter(scene.outliers));
}

/// The table shows noise that neighborhoods do not: errors that are constant over a neighborhood.
void AdaptToTable(Scene& scene, PerceptionOptions& options) {
  const double distance_m = options.preprocess.plane_distance_m;
  const double clearance_m = options.preprocess.table_clearance_m;
  const NoisyPlane fit = FitNoisy(scene.table.plane, scene.points_C,
                                  options.preprocess.preselection_m, options.sampling);
  scene.sampling.noise_m = std::max(scene.sampling.noise_m, fit.noise_m);
  AdaptLengths(scene.sampling, options);
  // The plane as found lies below a table that is thicker than the search assumed.
  const bool thicker = options.preprocess.plane_distance_m > distance_m;
  if (thicker || options.preprocess.table_clearance_m > clearance_m) {
    scene.table =
        TableOn(thicker ? fit.plane : scene.table.plane, scene.points_C, options.preprocess);
  }
}

/// Normals from each point's neighborhood, or from the faces of the segments' mesh (section 5.1.3).
Points NormalsOf(PointSpan points, const PerceptionOptions& options, PointSpan places_C,
                 const Indices& place_of) {
  const geometry::KdTree tree(points);
  if (options.preprocess.neighborhood_normals) {
    const double radius_m = options.preprocess.normal_radius_m;
    const double max_m =
        options.preprocess.widened_normals ? options.preprocess.max_widening * radius_m : 0.0;
    return geometry::EstimateNormals(points, tree, radius_m, places_C, place_of, max_m);
  }
  const double d_max_m = geometry::NearestNeighborDistances(points, tree).max_m;
  const auto triangles = geometry::AlphaTriangles(points, MeshAlpha(d_max_m, options.segment));
  return geometry::FaceNormals(points, triangles, places_C, place_of);
}

/// Fills the scene's segments and the box that they lie in, whose walls would join touching things.
void FindSegments(const PerceptionOptions& options, Scene& scene) {
  const ContainerOptions& as_options = options.features.container;
  std::optional<internal::Container> container;
  if (options.features.containers) {
    container = internal::FindContainer(scene.cloud, scene.table.plane, as_options);
  }
  if (!container) {
    scene.segments = Segment(scene.cloud, options.segment);
    return;
  }
  scene.container = internal::PointsOfWalls(scene.cloud, *container, as_options);
  Indices rest;
  std::ranges::set_difference(std::views::iota(0U, static_cast<std::uint32_t>(scene.cloud.size())),
                              scene.container, std::back_inserter(rest));
  const geometry::PointCloud inside{Select(scene.cloud.points, rest),
                                    Select(scene.cloud.normals, rest)};
  for (Indices& segment : Segment(inside, options.segment)) {
    for (auto& i : segment) i = rest[i];
    if (internal::IsPieceOfWall(scene.cloud, *container, as_options, segment)) {
      scene.container.insert(scene.container.end(), segment.begin(), segment.end());
    } else {
      scene.segments.push_back(std::move(segment));
    }
  }
  std::ranges::sort(scene.container);
}

/// The median of the noise that views state for samples; nullopt if none states any.
std::optional<double> StatedNoise(const Observation& observation,
                                  const std::vector<SampleId>& samples) {
  std::vector<double> noises_m;
  for (const SampleId& id : samples) {
    const auto& of_view = observation.views[id.view].noise_m;
    if (id.sample < of_view.size() && of_view[id.sample] > 0.0F) {
      noises_m.push_back(of_view[id.sample]);
    }
  }
  if (noises_m.empty()) return std::nullopt;
  return base::MedianOf(std::move(noises_m));
}

/// One view per place, of all points measured from it.
std::vector<internal::SensorView> ViewsFrom(PointSpan places_C, const Indices& place_of,
                                            PointSpan points_C) {
  std::vector<Points> seen_from(places_C.size());
  for (std::size_t i = 0; i < points_C.size(); ++i) seen_from[place_of[i]].push_back(points_C[i]);
  std::vector<internal::SensorView> views;
  for (std::size_t place = 0; place < seen_from.size(); ++place) {
    views.emplace_back(seen_from[place], places_C[place]);
  }
  return views;
}

/// The common input of all later steps.
struct Begun {
  Scene scene;                ///< with its points, sampling and table
  PerceptionOptions options;  ///< with lengths that suit the sampling
  Points places_C;            ///< places of the sensors
  Indices place_of;           ///< one per point of the scene
  Indices above;              ///< what is above the table; positions in the scene's points
};

Begun Begin(const Observation& observation, const PerceptionOptions& given, base::Rng& rng,
            const std::optional<Workspace>& workspace) {
  base::Stopwatch watch;
  internal::MeasuredPoints measured = internal::Gather(observation, workspace);
  if (measured.points_C.size() < kMinPoints) {
    throw base::InputError(fmt::format("a scan needs at least {} points, this one has {}",
                                       kMinPoints, measured.points_C.size()));
  }
  Begun begun{{}, given, std::move(measured.places_C), std::move(measured.place_of), {}};
  Scene& scene = begun.scene;
  PerceptionOptions& options = begun.options;
  scene.points_C = std::move(measured.points_C);
  scene.samples = std::move(measured.samples);
  if (options.stated_noise) options.noise_m = StatedNoise(observation, scene.samples);
  if (options.preprocess.adapt_lengths) {
    scene.sampling = MeasureSampling(scene.points_C, options.sampling);
    if (options.noise_m) scene.sampling.noise_m = *options.noise_m;
    AdaptLengths(scene.sampling, options);
  }
  scene.seconds.emplace_back("sampling", watch.Restart());
  // All sensors are on one side of the table, and so is their centroid.
  auto table =
      FindTable(scene.points_C, geometry::Centroid(begun.places_C), options.preprocess, rng);
  if (!table) throw base::InputError(NoTable(scene.points_C, options.preprocess, rng));
  scene.table = std::move(*table);
  if (options.preprocess.adapt_lengths && !options.noise_m) AdaptToTable(scene, options);
  begun.above = geometry::PositionsWhere(scene.points_C, [&](const Eigen::Vector3d& p) {
    return scene.table.plane.Distance(p) > options.preprocess.table_clearance_m;
  });
  scene.seconds.emplace_back("table", watch.Restart());
  return begun;
}

}  // namespace

Scene PerceiveTable(const Observation& observation, const PerceptionOptions& options,
                    base::Rng& rng, const std::optional<Workspace>& workspace) {
  Begun begun = Begin(observation, options, rng, workspace);
  begun.scene.source = std::move(begun.above);
  begun.scene.cloud.points = Select(begun.scene.points_C, begun.scene.source);
  return std::move(begun.scene);
}

Scene Perceive(const Observation& observation, const PerceptionOptions& given, base::Rng& rng,
               const std::optional<Workspace>& workspace) {
  Begun begun = Begin(observation, given, rng, workspace);
  Scene scene = std::move(begun.scene);
  PerceptionOptions& options = begun.options;
  base::Stopwatch watch;

  FilterPoints(begun.above, options.preprocess, scene);
  scene.cloud.points = Select(scene.points_C, scene.source);
  scene.seconds.emplace_back("filter", watch.Restart());

  if (options.preprocess.smooth && !scene.source.empty()) {
    scene.cloud.points = Smooth(scene.cloud.points, options.preprocess.smooth_radius_m);
  }
  scene.seconds.emplace_back("smooth", watch.Restart());

  Indices place_of;
  for (const auto i : scene.source) place_of.push_back(begun.place_of[i]);
  if (!scene.source.empty()) {
    scene.cloud.normals = NormalsOf(scene.cloud.points, options, begun.places_C, place_of);
  }
  scene.seconds.emplace_back("normals", watch.Restart());

  if (!scene.source.empty()) FindSegments(options, scene);
  scene.seconds.emplace_back("segments", watch.Restart());

  if (options.segment.method == SegmentMethod::kConvexity) {
    options.features.merge.cut_m = options.segment.convexity.link_m;
  }
  const internal::SensorViews views{ViewsFrom(begun.places_C, begun.place_of, scene.points_C),
                                    std::move(place_of)};
  scene.objects = internal::BuildObjects({scene.cloud, scene.table.plane, views, options.features},
                                         scene.segments, rng, scene.seconds);
  return scene;
}

Scene Perceive(PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
               const PerceptionOptions& options, base::Rng& rng) {
  const geometry::RangeImage image{.profiles = 1,
                                   .samples = static_cast<int>(points_C.size()),
                                   .points_C = {points_C.begin(), points_C.end()},
                                   .origins_C = {sensor_origin_C}};
  return Perceive(geometry::ObservationOf(image), options, rng);
}

void SetBox(const geometry::Plane& table, PerceivedObject& object) {
  if (object.completed_C.empty()) return;
  for (const auto& p : object.completed_C) {
    object.height_m = std::max(object.height_m, table.Distance(p));
  }
  const auto frame = internal::MakePlanarFrame(table, object.completed_C.front());
  internal::SetBox(frame, CompletionOptions{}, object);
}

}  // namespace rangegrasp::perception
