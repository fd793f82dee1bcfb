#include "cylinders/detect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "base/error.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "geometry/kd_tree.h"
#include "geometry/plane.h"
#include "perception/preprocess.h"

namespace rangegrasp::cylinders {
namespace {

using geometry::Indices;
using geometry::KdTree;
using geometry::Points;
using geometry::PointSpan;

/// Everything that candidates are compared with.
struct CandidateContext {
  const CylinderScene& scene;
  Rays rays;  ///< of scene.points_C
  const DetectOptions& options;
};

/// A possible pose of a given cylinder.
struct Candidate {
  Line axis_C;
  const Rim* rim = nullptr;  ///< nullptr: found by its barrel
};

/// Points near the axis that could belong to the barrel or its ends.
Indices NearAxis(const Points& points, const Line& axis, double radius_m, double reach_m) {
  return geometry::PositionsWhere(points, [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d offset = p - axis.point;
    const double along = offset.dot(axis.direction);
    return std::abs(along) <= reach_m &&
           offset.squaredNorm() - along * along <= radius_m * radius_m;
  });
}

/// Median height of a rim's points above the table [m].
double HeightOf(const Rim& rim, const CylinderScene& scene) {
  std::vector<double> heights;
  for (const auto i : rim.points) {
    heights.push_back(scene.table.plane.Distance(scene.cloud.points[i]));
  }
  return base::MedianOf(std::move(heights));
}

/// Turns the axis up, away from the table.
void TurnUp(const Eigen::Vector3d& up, Line& axis) {
  if (axis.direction.dot(up) < 0.0) axis.direction = -axis.direction;
}

/// Fits and checks a given cylinder at a candidate axis.
class Examination {
 public:
  Examination(const CandidateContext& context, const GivenCylinder& given)
      : context_(context), accept_(context.options.accept), given_(given) {}

  /// Returns nullopt if the cylinder is not there.
  std::optional<FoundCylinder> Of(const Candidate& candidate) const {
    // It may extend by its height below a rim, or from a barrel's middle if half is hidden.
    const double reach_m = 1.5 * given_.height_m + accept_.max_height_error_m;
    const double round_m = given_.radius_m + context_.options.barrel.first_distance_m;
    const Indices near = NearAxis(context_.scene.cloud.points, candidate.axis_C, round_m, reach_m);
    auto refined = RefineAxis(context_.scene.cloud, near, candidate.axis_C, given_.radius_m,
                              context_.options.barrel);
    if (refined) return ByBarrel(candidate, near, std::move(*refined));
    return candidate.rim ? ByRim(*candidate.rim) : std::nullopt;
  }

 private:
  const geometry::Plane& Table() const { return context_.scene.table.plane; }

  std::optional<FoundCylinder> ByBarrel(const Candidate& candidate, const Indices& near,
                                        RefinedAxis refined) const {
    if (!IsOfTheGivenRadius(refined)) return std::nullopt;
    TurnUp(Table().normal, refined.axis);
    // Points lie beyond the ends only by noise; they may stop up to a row before the ends.
    const double max_length_m = given_.height_m + accept_.max_face_error_m;
    const auto ends = FindEnds(context_.scene.cloud, near, refined, given_.radius_m, max_length_m,
                               context_.options.barrel);
    if (!ends || ends->Length() > max_length_m) return std::nullopt;
    if (ends->Length() < accept_.min_length_share * given_.height_m) return std::nullopt;
    FoundCylinder found;
    const double upright = std::abs(refined.axis.direction.dot(Table().normal));
    found.lies = upright < std::cos(accept_.max_standing_tilt_rad);
    found.length_seen_m = ends->Length();
    found.cylinder_C = {refined.axis.point, refined.axis.direction, refined.radius_m,
                        given_.height_m};
    const RaysThrough rays = RaysAbout(refined.axis, *ends);
    const Seen seen{refined, *ends, rays, Part(refined.axis, ends->low_m, ends->high_m)};
    const bool placed = found.lies ? PlaceLying(seen, found) : PlaceStanding(seen, found);
    if (!placed) return std::nullopt;
    found.barrel = std::move(refined.points);
    if (candidate.rim) found.rim_share = candidate.rim->share;
    return found;
  }

  /// The visible part of the cylinder.
  struct Seen {
    const RefinedAxis& refined;
    const BarrelEnds& ends;
    const RaysThrough& rays;  ///< all rays that may meet any cylinder with these ends
    Cylinder shown;           ///< rays that end on it are ignored for the unseen parts
  };

  /// The part of the cylinder between two positions along its axis.
  Cylinder Part(const Line& axis, double from_m, double to_m) const {
    return {axis.point + 0.5 * (from_m + to_m) * axis.direction, axis.direction, given_.radius_m,
            to_m - from_m};
  }

  /// The cylinder may extend from either end of its visible part up to the given height.
  RaysThrough RaysAbout(const Line& axis, const BarrelEnds& ends) const {
    const double slack_m = 2.0 * accept_.max_height_error_m + accept_.view_tolerance_m;
    const double reach_m = given_.height_m - 0.5 * ends.Length();
    const double sphere_m = std::hypot(given_.radius_m, reach_m) + 2.0 * slack_m;
    return {context_.rays, Part(axis, ends.low_m, ends.high_m).center, sphere_m};
  }

  bool IsOfTheGivenRadius(const RefinedAxis& refined) const {
    const double max_error_m = accept_.max_radius_error_m;
    const double allowed_m = max_error_m + std::min(max_error_m, 2.0 * refined.radius_sd_m);
    return std::abs(refined.radius_m - given_.radius_m) <= allowed_m &&
           refined.arc_rad >= accept_.min_arc_rad &&
           refined.normal_angle_rad <= accept_.max_normal_angle_rad;
  }

  /// Places the top at the given height above the table, or higher if it visibly stands on an
  /// object. The visible end may be lower only if the top may be hidden.
  bool PlaceStanding(const Seen& seen, FoundCylinder& found) const {
    const auto& [refined, ends, rays, shown] = seen;
    const double half = 0.5 * given_.height_m;
    const Line& axis = refined.axis;
    const double table = -Table().Distance(axis.point) / axis.direction.dot(Table().normal);
    const double top = table + given_.height_m;
    const double error_m = ends.high_face ? accept_.max_face_error_m : accept_.max_height_error_m;
    if (std::abs(ends.high_m - top) <= error_m) {
      return Place(seen, (ends.high_face ? ends.high_m : top) - half, found);
    }
    if (ends.high_m < top) return !ends.high_face && Place(seen, top - half, found);
    const double foot =
        table + context_.options.preprocess.table_clearance_m + accept_.max_height_error_m;
    return ends.low_m > foot && IsWhole(ends) && Place(seen, ends.high_m - half, found);
  }

  bool IsWhole(const BarrelEnds& ends) const {
    const double error_m =
        ends.low_face && ends.high_face ? accept_.max_face_error_m : accept_.max_height_error_m;
    return std::abs(ends.Length() - given_.height_m) <= error_m;
  }

  bool PlaceLying(const Seen& seen, FoundCylinder& found) const {
    const BarrelEnds& ends = seen.ends;
    const double half = 0.5 * given_.height_m;
    double middle = 0.5 * (ends.low_m + ends.high_m);
    if (IsWhole(ends)) {
      if (ends.high_face && !ends.low_face) middle = ends.high_m - half;
      if (ends.low_face && !ends.high_face) middle = ends.low_m + half;
      return Place(seen, middle, found);
    }
    // The missing part is hidden beyond one or both ends: take the middle of the possible places.
    const double missing = given_.height_m - ends.Length();
    const double low = ends.low_face ? 0.0 : HiddenLength(seen, ends.low_m, -1.0, missing);
    const double high = ends.high_face ? 0.0 : HiddenLength(seen, ends.high_m, 1.0, missing);
    if (low + high < missing - accept_.max_height_error_m) return false;
    const double most_up = ends.high_m + high - half;
    const double most_down = ends.low_m - low + half;
    return Place(seen, 0.5 * (most_up + most_down), found);
  }

  /// Sets the center; true if the scan agrees with it.
  bool Place(const Seen& seen, double middle_m, FoundCylinder& found) const {
    const auto& [refined, ends, rays, shown] = seen;
    found.cylinder_C.center = refined.axis.point + middle_m * refined.axis.direction;
    if (IsSunk(found.cylinder_C)) return false;
    const double half = 0.5 * given_.height_m;
    return MayBeHidden(seen, middle_m - half, ends.low_m) &&
           MayBeHidden(seen, ends.high_m, middle_m + half) && Agrees(found, &rays);
  }

  /// True if it is below the table by more than the uncertainty of its end.
  bool IsSunk(const Cylinder& cylinder) const {
    const double upright = std::abs(cylinder.axis.dot(Table().normal));
    const double lowest = 0.5 * given_.height_m * upright +
                          given_.radius_m * std::sqrt(std::max(0.0, 1.0 - upright * upright));
    return Table().Distance(cylinder.center) < lowest - 2.0 * accept_.max_height_error_m;
  }

  /// Length by which the cylinder may extend unseen beyond an end, at most `up_to_m` [m]. Slices
  /// are at least one row of points long: a slice that no ray meets would count as hidden.
  double HiddenLength(const Seen& seen, double end_m, double sign, double up_to_m) const {
    const int steps =
        std::clamp(static_cast<int>(up_to_m / accept_.max_height_error_m), 1, accept_.hidden_steps);
    const double step_m = up_to_m / steps;
    for (int i = 0; i < steps; ++i) {
      const double near_m = end_m + sign * i * step_m;
      const double far_m = near_m + sign * step_m;
      if (!IsHidden(seen, std::min(near_m, far_m), std::max(near_m, far_m))) return i * step_m;
    }
    return up_to_m;
  }

  /// True if a part of the cylinder along its axis can exist although it has no points.
  bool MayBeHidden(const Seen& seen, double from_m, double to_m) const {
    return to_m - from_m <= accept_.max_height_error_m || IsHidden(seen, from_m, to_m);
  }

  bool IsHidden(const Seen& seen, double from_m, double to_m) const {
    const ViewCounts counts =
        ViewOf(Part(seen.refined.axis, from_m, to_m), &seen.rays, &seen.shown);
    return static_cast<double>(counts.through) <=
           accept_.max_missing_seen * static_cast<double>(counts.through + counts.before);
  }

  /// @param rays  preselected rays, used if they suffice; nullptr: no preselection
  bool Agrees(FoundCylinder& found, const RaysThrough* rays = nullptr) const {
    Cylinder as_given = found.cylinder_C;
    as_given.radius_m = given_.radius_m;
    found.view = ViewOf(as_given, rays);
    return found.view.Agreement() >= accept_.min_agreement &&
           static_cast<double>(found.view.on) >=
               accept_.min_seen_share * static_cast<double>(found.view.All());
  }

  /// @param rays  preselected rays, used only if they include all rays relevant to the cylinder
  ViewCounts ViewOf(const Cylinder& cylinder, const RaysThrough* rays,
                    const Cylinder* left_out = nullptr) const {
    const double tolerance_m = accept_.view_tolerance_m;
    const bool enough = rays && rays->AreAllOf(cylinder, tolerance_m);
    return CompareWithView(enough ? rays->Chosen() : context_.rays, cylinder, tolerance_m,
                           left_out);
  }

  /// If only the rim is seen, the cylinder stands on the table below its rim.
  std::optional<FoundCylinder> ByRim(const Rim& rim) const {
    const Eigen::Vector3d& up = Table().normal;
    const double error_m = HeightOf(rim, context_.scene) - given_.height_m;
    if (std::abs(error_m) > accept_.max_height_error_m) return std::nullopt;
    FoundCylinder found;
    const Eigen::Vector3d foot = Table().Project(rim.circle_C.center);
    found.cylinder_C = {foot + 0.5 * given_.height_m * up, up, rim.circle_C.radius_m,
                        given_.height_m};
    found.rim_share = rim.share;
    return Agrees(found) ? std::optional(found) : std::nullopt;
  }

  const CandidateContext& context_;
  const AcceptOptions& accept_;
  const GivenCylinder& given_;
};

/// The pose as published (algorithm 1, eq. 4.28): barrel points along the circle's axis (the
/// visible end is within the distance near its rim), the line through their axis points, and the
/// center recomputed on it.
FoundCylinder PublishedPose(const CandidateContext& context, const Rim& rim,
                            const GivenCylinder& given) {
  const geometry::PointCloud& cloud = context.scene.cloud;
  const Eigen::Vector3d& up = context.scene.table.plane.normal;
  const Points rim_points = geometry::Select(cloud.points, rim.points);
  const double r = rim.circle_C.radius_m;
  const double distance_m = context.options.barrel.distance_m;
  Line circle_axis{rim.circle_C.center, rim.circle_C.normal};
  TurnUp(up, circle_axis);
  FoundCylinder found;
  found.rim_share = rim.share;
  found.barrel = BarrelPoints(cloud.points, circle_axis, r, -given.height_m - distance_m,
                              distance_m, distance_m);
  std::erase_if(found.barrel, [&](std::uint32_t i) {
    return !IsRadial(cloud.normals[i], circle_axis.direction);
  });
  Line axis = FitLine(AxisPoints(geometry::Select(cloud.points, found.barrel),
                                 geometry::Select(cloud.normals, found.barrel), r))
                  .value_or(circle_axis);
  TurnUp(up, axis);
  const Eigen::Vector3d c_m = CenterOnAxis(axis, rim_points, up).value_or(rim.circle_C.center);
  found.cylinder_C = {CenterOfGravity(c_m, axis.direction, given.height_m), axis.direction, r,
                      given.height_m};
  found.lies = axis.direction.dot(up) < std::cos(context.options.accept.max_standing_tilt_rad);
  return found;
}

/// With fewer points it is not a scan of a table.
constexpr std::size_t kMinPoints = 100;

/// The measured points and the sensor's positions.
struct Measured {
  Points points_C;
  Indices lines;  ///< for each point, the number of its scan line
  Points places_C;
  Indices place_of;  ///< for each point, its position in places_C
  bool scan_order = false;
};

Measured Gather(const geometry::Observation& observation,
                const std::optional<perception::Workspace>& workspace) {
  Measured measured;
  std::uint32_t first_line = 0;
  for (const geometry::View& view : observation.views) {
    const geometry::RangeImage& image = view.image;
    measured.scan_order = measured.scan_order || image.HasScanOrder();
    const auto samples = static_cast<std::size_t>(std::max(image.samples, 1));
    for (std::size_t i = 0; i < image.points_C.size(); ++i) {
      const Eigen::Vector3d& p_C = image.points_C[i];
      if (!p_C.allFinite() || (workspace && !workspace->Contains(p_C))) continue;
      const Eigen::Vector3d& origin_C = image.OriginOf(i);
      if (measured.places_C.empty() || measured.places_C.back() != origin_C) {
        measured.places_C.push_back(origin_C);
      }
      measured.points_C.push_back(p_C);
      measured.lines.push_back(first_line + static_cast<std::uint32_t>(i / samples));
      measured.place_of.push_back(static_cast<std::uint32_t>(measured.places_C.size() - 1));
    }
    first_line += static_cast<std::uint32_t>(std::max(image.profiles, 1));
  }
  return measured;
}

/// The plane with the most points near it (section 4.2.1); its normal points to the sensor's side.
std::optional<perception::Table> DominantPlane(PointSpan points, const Eigen::Vector3d& origin,
                                               const DetectOptions& options, base::Rng& rng) {
  auto fit = geometry::FitPlaneRansac(
      points, {options.preprocess.plane_draws, options.preprocess.plane_distance_m}, rng);
  const double enough = options.min_table_share * static_cast<double>(points.size());
  if (!fit || static_cast<double>(fit->inliers.size()) < enough) return std::nullopt;
  perception::Table table{fit->plane, {}};
  if (table.plane.Distance(origin) < 0.0) table.plane = table.plane.Flipped();
  table.points = geometry::PositionsWhere(points, [&](const Eigen::Vector3d& p) {
    return std::abs(table.plane.Distance(p)) <= options.preprocess.plane_distance_m ||
           !IsOnSensorSide(table.plane, origin, p);
  });
  return table;
}

/// Adapts all lengths that were not set explicitly to the sampling.
void AdaptLengths(const perception::Sampling& sampling, DetectOptions& options) {
  perception::PerceptionOptions perception_options;
  perception_options.preprocess = options.preprocess;
  perception::AdaptLengths(sampling, perception_options);
  options.preprocess = perception_options.preprocess;
  for (perception::AdaptiveLength* length :
       {&options.curvature.radius_m, &options.curvature.line_step_m, &options.barrel.distance_m,
        &options.barrel.first_distance_m, &options.barrel.piece_m, &options.search.min_scatter_m,
        &options.accept.rim_distance_m, &options.accept.max_rim_error_m,
        &options.accept.max_radius_error_m, &options.accept.max_height_error_m,
        &options.accept.max_face_error_m, &options.accept.view_tolerance_m}) {
    length->AdaptTo(sampling);
  }
}

/// Adapts the lengths to the noise about the table, which small neighborhoods do not show.
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
  if (!options.as_published) {
    scene.sampling = perception::MeasureSampling(scene.points_C, options.sampling);
    AdaptLengths(scene.sampling, options);
  }
  const Eigen::Vector3d origin = geometry::Centroid(measured.places_C);
  auto table = options.as_published
                   ? DominantPlane(scene.points_C, origin, options, rng)
                   : perception::FindTable(scene.points_C, origin, options.preprocess, rng);
  if (!table) throw base::InputError("no table: no plane has enough points");
  scene.table = std::move(*table);
  if (!options.as_published) AdaptToTable(scene, options);
}

void Filter(const DetectOptions& options, CylinderScene& scene) {
  std::vector<bool> is_above(scene.points_C.size(), true);
  for (const auto i : scene.table.points) is_above[i] = false;
  const Indices above = geometry::PositionsOf(is_above);
  const perception::OutlierFilterOptions as_options{
      options.preprocess.isolated_outliers, !options.as_published, options.preprocess.filter_unit_m,
      options.as_published ? 0.0 : double{options.preprocess.filter_keep_m}};
  const Points points = geometry::Select(scene.points_C, above);
  for (const auto k : perception::CompressionRateFilter(points, as_options)) {
    scene.source.push_back(above[k]);
  }
  std::ranges::set_difference(above, scene.source, std::back_inserter(scene.outliers));
  scene.cloud.points = geometry::Select(scene.points_C, scene.source);
}

geometry::NeighborLists FindNormals(const Measured& measured, const KdTree& tree,
                                    const DetectOptions& options, CylinderScene& scene) {
  Indices place_of;
  for (const auto i : scene.source) place_of.push_back(measured.place_of[i]);
  const double radius_m = options.preprocess.normal_radius_m;
  const double max_m = options.as_published ? 0.0 : options.preprocess.max_widening * radius_m;
  geometry::NeighborLists neighbors;
  scene.cloud.normals = geometry::EstimateNormals(scene.cloud.points, tree, radius_m,
                                                  measured.places_C, place_of, max_m, &neighbors);
  return neighbors;
}

void FindCurvature(const Measured& measured, const KdTree& tree,
                   const geometry::NeighborLists& neighbors, const DetectOptions& options,
                   CylinderScene& scene) {
  scene.curved =
      geometry::PositionsOf(CurvedPoints(scene.cloud, tree, options.curvature, neighbors));
  scene.scan_order = measured.scan_order;
  if (!scene.scan_order) return;
  Indices lines;
  for (const auto i : scene.source) lines.push_back(measured.lines[i]);
  scene.edges = geometry::PositionsOf(LineEdges(scene.cloud.points, lines, options.curvature));
}

/// Removes the points whose normals are not those of a top.
void KeepTops(const Measured& measured, const DetectOptions& options, const CylinderScene& scene,
              Indices& points) {
  const Eigen::Vector3d& up = scene.table.plane.normal;
  const Eigen::Matrix3d R_CS =
      SensorAxes(up, geometry::Centroid(measured.places_C) - geometry::Centroid(scene.points_C));
  const double min_cosine = std::cos(options.curvature.max_tilt_rad);
  std::erase_if(points, [&](std::uint32_t i) {
    const Eigen::Vector3d& n_C = scene.cloud.normals[i];
    return options.as_published ? !PassesSensorGate(R_CS.transpose() * n_C)
                                : n_C.dot(up) < min_cosine;
  });
}

/// As published, all curvature points are segmented (section 4.2.3), and then the top ones of each
/// fragment are used (section 4.2.4). Here only the top ones are segmented.
void FindFragments(const Measured& measured, const DetectOptions& options, CylinderScene& scene) {
  Indices curved;
  std::ranges::set_union(scene.curved, scene.edges, std::back_inserter(curved));
  if (!options.as_published) KeepTops(measured, options, scene, curved);
  scene.fragments = Fragments(geometry::Select(scene.cloud.points, curved), options.fragments);
  for (Indices& fragment : scene.fragments) {
    for (auto& i : fragment) i = curved[i];
    if (options.as_published) KeepTops(measured, options, scene, fragment);
  }
  std::erase_if(scene.fragments, [&](const Indices& fragment) {
    return fragment.size() < static_cast<std::size_t>(options.fragments.min_points);
  });
}

void FindRims(const DetectOptions& options, base::Rng& rng, CylinderScene& scene) {
  const auto distance = options.as_published ? CircleDistance::kSphere : CircleDistance::kCurve;
  for (const Indices& fragment : scene.fragments) {
    const Points points = geometry::Select(scene.cloud.points, fragment);
    const auto fit = FitRandomCircle(points, options.circle_draws, rng);
    if (!fit) continue;
    const double share = ShareOn(*fit, points, distance, options.accept.rim_distance_m);
    if (share > options.accept.min_rim_share) scene.rims.push_back({*fit, share, fragment});
  }
}

double RadiusError(const Rim& rim, const GivenCylinder& given) {
  return std::abs(rim.circle_C.radius_m - given.radius_m);
}

/// Eq. 4.27: of all rims at the given cylinder's height above the table ("the radius and the height
/// [...] are used", section 4.2.4), takes the one with the nearest radius.
void TakeNearestRims(const CandidateContext& context, std::span<const GivenCylinder> given,
                     CylinderScene& scene) {
  for (std::size_t g = 0; g < given.size(); ++g) {
    const Rim* nearest = nullptr;
    for (const Rim& rim : scene.rims) {
      const double error_m = HeightOf(rim, scene) - given[g].height_m;
      if (std::abs(error_m) > context.options.accept.rim_distance_m) continue;
      if (nearest && RadiusError(rim, given[g]) >= RadiusError(*nearest, given[g])) continue;
      nearest = &rim;
    }
    if (!nearest) continue;
    scene.cylinders.push_back(PublishedPose(context, *nearest, given[g]));
    scene.cylinders.back().given = g;
  }
}

/// All possible poses of a given cylinder: from rims of its radius, and from barrels.
std::vector<Candidate> CandidatesFor(const CandidateContext& context, const GivenCylinder& given,
                                     base::Rng& rng) {
  const auto& [scene, rays, options] = context;
  std::vector<Candidate> candidates;
  const Eigen::Vector3d& up = scene.table.plane.normal;
  for (const Rim& rim : scene.rims) {
    if (RadiusError(rim, given) > options.accept.max_rim_error_m) continue;
    candidates.push_back({{rim.circle_C.center, up}, &rim});
  }
  for (const Line& axis :
       FindBarrels(scene.cloud, up, given.radius_m, given.height_m, options.search, rng)) {
    candidates.push_back({axis, nullptr});
  }
  return candidates;
}

/// Number of points on a found cylinder, reduced by the error of its radius.
double ScoreOf(const FoundCylinder& found, const GivenCylinder& given,
               const DetectOptions& options) {
  const double error = std::abs(found.cylinder_C.radius_m - given.radius_m);
  const double on = static_cast<double>(std::max(found.view.on, found.barrel.size()));
  return on * std::exp(-error / options.accept.max_radius_error_m);
}

/// Of cylinders that share points, keeps the best. All points on a cylinder's surface count as its
/// own: its axis may be fitted to one piece, and another piece would be found as a second cylinder.
std::vector<FoundCylinder> WithoutOverlaps(std::vector<FoundCylinder> found,
                                           std::span<const GivenCylinder> given,
                                           const DetectOptions& options, PointSpan points) {
  std::ranges::stable_sort(found, std::greater{}, [&](const FoundCylinder& one) {
    return ScoreOf(one, given[one.given], options);
  });
  std::vector<bool> taken(points.size(), false);
  std::vector<FoundCylinder> kept;
  for (FoundCylinder& one : found) {
    const Indices own = PointsOn(points, one.cylinder_C, options.accept.view_tolerance_m);
    const auto shared = std::ranges::count_if(own, [&](auto i) { return taken[i]; });
    if (static_cast<double>(shared) > options.accept.max_shared * static_cast<double>(own.size())) {
      continue;
    }
    for (const auto i : own) taken[i] = true;
    kept.push_back(std::move(one));
  }
  std::ranges::stable_sort(kept, {}, &FoundCylinder::given);
  return kept;
}

void FindGiven(const CandidateContext& context, std::span<const GivenCylinder> given,
               base::Rng& rng, CylinderScene& scene) {
  std::vector<FoundCylinder> found;
  for (std::size_t g = 0; g < given.size(); ++g) {
    for (const Candidate& candidate : CandidatesFor(context, given[g], rng)) {
      auto one = Examination(context, given[g]).Of(candidate);
      if (!one) continue;
      one->given = g;
      found.push_back(std::move(*one));
    }
  }
  scene.cylinders = WithoutOverlaps(std::move(found), given, context.options, scene.cloud.points);
}

}  // namespace

DetectOptions AsPublished() {
  DetectOptions options;
  options.as_published = true;
  options.curvature.line_step_m = 0.0;  // the adjacent samples (eq. 4.14)
  options.fragments.link = 0.0;         // d_ca (eq. 4.17)
  return options;
}

CylinderScene DetectCylinders(const geometry::Observation& observation,
                              std::span<const GivenCylinder> given, const DetectOptions& as_given,
                              base::Rng& rng,
                              const std::optional<perception::Workspace>& workspace) {
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
  scene.seconds.emplace_back("plane", watch.Restart());

  Filter(options, scene);
  const KdTree tree(scene.cloud.points);
  scene.seconds.emplace_back("filter", watch.Restart());

  const auto neighbors = FindNormals(measured, tree, options, scene);
  scene.seconds.emplace_back("normals", watch.Restart());

  FindCurvature(measured, tree, neighbors, options, scene);
  scene.seconds.emplace_back("curvature", watch.Restart());

  FindFragments(measured, options, scene);
  scene.seconds.emplace_back("segmentation", watch.Restart());

  FindRims(options, rng, scene);
  const CandidateContext context{
      scene, {scene.points_C, measured.places_C, measured.place_of}, options};
  if (options.as_published) {
    TakeNearestRims(context, given, scene);
  } else {
    FindGiven(context, given, rng, scene);
  }
  scene.seconds.emplace_back("cylinders", watch.Restart());
  return scene;
}

}  // namespace rangegrasp::cylinders
