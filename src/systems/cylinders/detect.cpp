#include "cylinders/detect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/stopwatch.h"
#include "cylinders/barrel_search.h"
#include "cylinders/internal/candidate.h"
#include "geometry/kd_tree.h"
#include "geometry/normals.h"
#include "perception/find_table.h"
#include "perception/point_filter.h"

namespace rangegrasp::cylinders {
namespace {

using geometry::Indices;
using geometry::KdTree;
using geometry::Points;
using geometry::PointSpan;
using internal::Candidate;
using internal::CandidateContext;

/// Fewer points are no scan of a table.
constexpr std::size_t kMinPoints = 100;

/// What was measured, and from where.
struct Measured {
  Points points_C;
  std::vector<ScanPlace> scan;  ///< one a point
  Points places_C;
  Indices place_of;  ///< one a point: position in places_C
  bool scan_order = false;
};

Measured Gather(const geometry::Observation& observation,
                const std::optional<perception::Workspace>& workspace) {
  Measured measured;
  std::uint32_t first_line = 0;
  for (const geometry::View& view : observation.views) {
    const geometry::RangeImage& image = view.image;
    measured.scan_order = measured.scan_order || image.profiles > 1;
    const auto samples = static_cast<std::size_t>(std::max(image.samples, 1));
    for (std::size_t i = 0; i < image.points_C.size(); ++i) {
      const Eigen::Vector3d& p_C = image.points_C[i];
      if (!p_C.allFinite() || (workspace && !workspace->Contains(p_C))) continue;
      const Eigen::Vector3d& origin_C = image.OriginOf(i);
      if (measured.places_C.empty() || measured.places_C.back() != origin_C) {
        measured.places_C.push_back(origin_C);
      }
      measured.points_C.push_back(p_C);
      measured.scan.push_back({first_line + static_cast<std::uint32_t>(i / samples),
                               static_cast<std::uint32_t>(i % samples)});
      measured.place_of.push_back(static_cast<std::uint32_t>(measured.places_C.size() - 1));
    }
    first_line += static_cast<std::uint32_t>(std::max(image.profiles, 1));
  }
  return measured;
}

void CheckGiven(std::span<const GivenCylinder> given) {
  if (given.empty()) throw base::InputError("no cylinder is given to look for");
  for (const GivenCylinder& one : given) {
    if (std::isfinite(one.radius_m) && std::isfinite(one.height_m) && one.radius_m > 0.0 &&
        one.height_m > 0.0) {
      continue;
    }
    throw base::InputError(
        fmt::format("a cylinder of radius {:g} m and height {:g} m: both must be above 0",
                    one.radius_m, one.height_m));
  }
}

/// The plane that most points are near (section 4.2.1), its normal to the sensor's side.
std::optional<perception::Table> DominantPlane(PointSpan points, const Eigen::Vector3d& origin,
                                               const DetectOptions& options, base::Rng& rng) {
  auto fit = geometry::FitPlaneRansac(
      points, {options.preprocess.plane_draws, options.preprocess.plane_distance_m}, rng);
  const double enough = options.min_table_share * static_cast<double>(points.size());
  if (!fit || static_cast<double>(fit->inliers.size()) < enough) return std::nullopt;
  perception::Table table{fit->plane, {}};
  if (table.plane.Distance(origin) < 0.0) {
    table.plane = {-fit->plane.normal, -fit->plane.offset_m};
  }
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const bool near =
        std::abs(table.plane.Distance(points[i])) <= options.preprocess.plane_distance_m;
    if (near || !IsOnSensorSide(table.plane, origin, points[i])) table.points.push_back(i);
  }
  return table;
}

/// With the noise about the table, which neighborhoods do not show, the lengths grow.
void AdaptToTable(CylinderScene& scene, DetectOptions& options) {
  const auto fit = perception::FitNoisy(scene.table.plane, scene.points_C,
                                        options.preprocess.preselection_m, options.sampling);
  const double clearance_m = options.preprocess.table_clearance_m;
  scene.sampling.noise_m = std::max(scene.sampling.noise_m, fit.noise_m);
  AdaptLengths(scene.sampling, options);
  if (options.preprocess.table_clearance_m > clearance_m) {
    scene.table = perception::TableOn(fit.plane, scene.points_C, options.preprocess);
  }
}

void FindTable(const Measured& measured, DetectOptions& options, base::Rng& rng,
               CylinderScene& scene) {
  if (options.adapt_lengths) {
    scene.sampling = perception::MeasureSampling(scene.points_C, options.sampling);
    AdaptLengths(scene.sampling, options);
  }
  const Eigen::Vector3d origin = geometry::Centroid(measured.places_C);
  auto table = options.robust_table
                   ? perception::FindTable(scene.points_C, origin, options.preprocess, rng)
                   : DominantPlane(scene.points_C, origin, options, rng);
  if (!table) throw base::InputError("no table: no plane holds enough of the points");
  scene.table = std::move(*table);
  if (options.adapt_lengths && options.robust_table) AdaptToTable(scene, options);
}

Indices AboveTable(const CylinderScene& scene) {
  std::vector<bool> of_table(scene.points_C.size(), false);
  for (const auto i : scene.table.points) of_table[i] = true;
  Indices above;
  for (std::uint32_t i = 0; i < scene.points_C.size(); ++i) {
    if (!of_table[i]) above.push_back(i);
  }
  return above;
}

void Filter(const Indices& above, const DetectOptions& options, CylinderScene& scene) {
  const perception::OutlierFilterOptions as_options{
      options.preprocess.isolated_outliers, options.repeated_filter,
      options.preprocess.filter_unit_m,
      options.repeated_filter ? double{options.preprocess.filter_keep_m} : 0.0};
  const Points points = geometry::Select(scene.points_C, above);
  std::vector<bool> kept(above.size(), false);
  for (const auto k : perception::CompressionRateFilter(points, as_options)) kept[k] = true;
  for (std::size_t k = 0; k < above.size(); ++k) {
    (kept[k] ? scene.source : scene.outliers).push_back(above[k]);
  }
  scene.cloud.points = geometry::Select(scene.points_C, scene.source);
}

geometry::NeighborLists FindNormals(const Measured& measured, const KdTree& tree,
                                    const DetectOptions& options, CylinderScene& scene) {
  Indices place_of;
  place_of.reserve(scene.source.size());
  for (const auto i : scene.source) place_of.push_back(measured.place_of[i]);
  const double radius_m = options.preprocess.normal_radius_m;
  const double max_m = options.widened_normals ? options.preprocess.max_widening * radius_m : 0.0;
  geometry::NeighborLists neighbors;
  scene.cloud.normals = geometry::EstimateNormals(scene.cloud.points, tree, radius_m,
                                                  measured.places_C, place_of, max_m, &neighbors);
  return neighbors;
}

Indices PositionsOf(const std::vector<bool>& chosen) {
  Indices positions;
  for (std::uint32_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i]) positions.push_back(i);
  }
  return positions;
}

void FindCurvature(const Measured& measured, const KdTree& tree,
                   const geometry::NeighborLists& neighbors, const DetectOptions& options,
                   CylinderScene& scene) {
  scene.curved = PositionsOf(CurvedPoints(scene.cloud, tree, options.curvature, neighbors));
  scene.scan_order = measured.scan_order;
  if (!scene.scan_order) return;
  std::vector<ScanPlace> places;
  places.reserve(scene.source.size());
  for (const auto i : scene.source) places.push_back(measured.scan[i]);
  scene.edges = PositionsOf(LineEdges(scene.cloud.points, places, options.curvature));
}

bool PassesGate(const Eigen::Vector3d& normal_C, const Eigen::Vector3d& up_C,
                const DetectOptions& options) {
  const TopGate gate = options.table_gate ? options.curvature.gate : TopGate::kSensorX;
  switch (gate) {
    case TopGate::kSensorX:
      return PassesSensorGate(options.R_CS.transpose() * normal_C);
    case TopGate::kTableNormal:
      return normal_C.dot(up_C) >= std::cos(options.curvature.max_tilt_rad);
    case TopGate::kNone:
      return true;
  }
  return false;
}

void FindFragments(const DetectOptions& options, CylinderScene& scene) {
  Indices top;
  std::set_union(scene.curved.begin(), scene.curved.end(), scene.edges.begin(), scene.edges.end(),
                 std::back_inserter(top));
  std::erase_if(top, [&](std::uint32_t i) {
    return !PassesGate(scene.cloud.normals[i], scene.table.plane.normal, options);
  });
  FragmentOptions as_options = options.fragments;
  if (!options.wide_links) as_options.link = 0.0;
  scene.fragments = Fragments(geometry::Select(scene.cloud.points, top), as_options);
  for (Indices& fragment : scene.fragments) {
    for (auto& i : fragment) i = top[i];
  }
}

void FindRims(const DetectOptions& options, base::Rng& rng, CylinderScene& scene) {
  RandomCircleOptions as_options = options.circle;
  if (!options.curve_distance) as_options.distance = CircleDistance::kSphere;
  for (const Indices& fragment : scene.fragments) {
    const Points points = geometry::Select(scene.cloud.points, fragment);
    const auto fit = FitRandomCircle(points, as_options, rng);
    if (!fit) continue;
    const double share =
        ShareOn(fit->circle, points, as_options.distance, options.accept.rim_distance_m);
    if (share > options.accept.min_rim_share) scene.rims.push_back({fit->circle, share, fragment});
  }
}

double RadiusError(const Rim& rim, const GivenCylinder& given) {
  return std::abs(rim.circle_C.radius_m - given.radius_m);
}

/// Eq. 4.27: of all rims the one of the nearest radius, for each given cylinder.
void TakeNearestRims(const CandidateContext& context, std::span<const GivenCylinder> given,
                     CylinderScene& scene) {
  for (std::size_t g = 0; g < given.size(); ++g) {
    const auto nearest = std::ranges::min_element(
        scene.rims, {}, [&](const Rim& rim) { return RadiusError(rim, given[g]); });
    if (nearest == scene.rims.end() ||
        RadiusError(*nearest, given[g]) > context.options.accept.max_rim_error_m) {
      continue;
    }
    scene.cylinders.push_back(internal::PublishedPose(context, *nearest, given[g]));
    scene.cylinders.back().given = g;
  }
}

/// All places where a given cylinder may be: rims of its radius, and barrels.
std::vector<Candidate> CandidatesFor(const CylinderScene& scene, const GivenCylinder& given,
                                     const DetectOptions& options, base::Rng& rng) {
  std::vector<Candidate> candidates;
  const Eigen::Vector3d& up = scene.table.plane.normal;
  for (const Rim& rim : scene.rims) {
    if (RadiusError(rim, given) > options.accept.max_rim_error_m) continue;
    candidates.push_back({{rim.circle_C.center, up}, &rim});
  }
  if (!options.barrel_search) return candidates;
  for (const Line& axis :
       FindBarrels(scene.cloud, up, given.radius_m, given.height_m, options.search, rng)) {
    candidates.push_back({axis, nullptr});
  }
  return candidates;
}

/// How well a found cylinder explains what was seen: the points on it, less for what its radius is
/// off.
double ScoreOf(const FoundCylinder& found, const GivenCylinder& given,
               const DetectOptions& options) {
  const double error = std::abs(found.cylinder_C.radius_m - given.radius_m);
  const double on = static_cast<double>(std::max(found.view.on, found.barrel.size()));
  return on * std::exp(-error / options.accept.max_radius_error_m);
}

/// Of what shares points the better one stays. A cylinder's points are all on its surface: those
/// that its axis was fitted to may be a piece of it, and another piece would be found as another.
std::vector<FoundCylinder> WithoutOverlaps(std::vector<FoundCylinder> found,
                                           std::span<const GivenCylinder> given,
                                           const DetectOptions& options, PointSpan points) {
  std::stable_sort(found.begin(), found.end(), [&](const auto& a, const auto& b) {
    return ScoreOf(a, given[a.given], options) > ScoreOf(b, given[b.given], options);
  });
  std::vector<bool> taken(points.size(), false);
  std::vector<FoundCylinder> kept;
  for (FoundCylinder& one : found) {
    const Indices own =
        PositionsOf(PointsOn(points, one.cylinder_C, options.accept.view_tolerance_m));
    const auto shared = std::ranges::count_if(own, [&](auto i) { return taken[i]; });
    if (static_cast<double>(shared) > options.accept.max_shared * static_cast<double>(own.size())) {
      continue;
    }
    for (const auto i : own) taken[i] = true;
    kept.push_back(std::move(one));
  }
  std::stable_sort(kept.begin(), kept.end(),
                   [](const auto& a, const auto& b) { return a.given < b.given; });
  return kept;
}

void FindGiven(const CandidateContext& context, std::span<const GivenCylinder> given,
               base::Rng& rng, CylinderScene& scene) {
  std::vector<FoundCylinder> found;
  for (std::size_t g = 0; g < given.size(); ++g) {
    for (const Candidate& candidate : CandidatesFor(scene, given[g], context.options, rng)) {
      auto one = internal::Examine(context, candidate, given[g]);
      if (!one) continue;
      one->given = g;
      found.push_back(std::move(*one));
    }
  }
  scene.cylinders = WithoutOverlaps(std::move(found), given, context.options, scene.cloud.points);
}

}  // namespace

CylinderScene DetectCylinders(const geometry::Observation& observation,
                              std::span<const GivenCylinder> given, const DetectOptions& as_given,
                              base::Rng& rng,
                              const std::optional<perception::Workspace>& workspace) {
  CheckGiven(given);
  DetectOptions options = as_given;
  base::Stopwatch watch;
  Measured measured = Gather(observation, workspace);
  if (measured.points_C.size() < kMinPoints) {
    throw base::InputError(fmt::format("a scan needs at least {} points, this one has {}",
                                       kMinPoints, measured.points_C.size()));
  }
  CylinderScene scene;
  scene.points_C = std::move(measured.points_C);
  FindTable(measured, options, rng, scene);
  const Indices above = AboveTable(scene);
  scene.seconds.emplace_back("plane", watch.Restart());

  Filter(above, options, scene);
  const KdTree tree(scene.cloud.points);
  scene.seconds.emplace_back("filter", watch.Restart());

  const auto neighbors = FindNormals(measured, tree, options, scene);
  scene.seconds.emplace_back("normals", watch.Restart());

  FindCurvature(measured, tree, neighbors, options, scene);
  scene.seconds.emplace_back("curvature", watch.Restart());

  FindFragments(options, scene);
  scene.seconds.emplace_back("segmentation", watch.Restart());

  FindRims(options, rng, scene);
  const CandidateContext context{scene, measured.places_C, measured.place_of, options};
  if (options.refine_pose) {
    FindGiven(context, given, rng, scene);
  } else {
    TakeNearestRims(context, given, scene);
  }
  scene.seconds.emplace_back("cylinders", watch.Restart());
  return scene;
}

}  // namespace rangegrasp::cylinders
