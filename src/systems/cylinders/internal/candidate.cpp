#include "cylinders/internal/candidate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/quantile.h"
#include "cylinders/barrel.h"

namespace rangegrasp::cylinders::internal {
namespace {

using geometry::Indices;
using geometry::Points;

/// Points about the axis that its barrel or its ends could have, with room for what the axis is
/// off.
Indices NearAxis(const geometry::Points& points, const Line& axis, double radius_m,
                 double reach_m) {
  Indices near;
  const double square = radius_m * radius_m;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d offset = points[i] - axis.point;
    const double along = offset.dot(axis.direction);
    if (std::abs(along) > reach_m) continue;
    if (offset.squaredNorm() - along * along <= square) near.push_back(i);
  }
  return near;
}

/// Part of the rays of a scan: all that meet a sphere.
struct RaysThrough {
  Eigen::Vector3d center;
  double radius_m = 0.0;
  Indices chosen;  ///< positions in all points
  Points points;
  Indices place_of;

  /// Whether a ray that meets `cylinder`, or passes it within the tolerance, is among them.
  bool AreAllOf(const Cylinder& cylinder, double tolerance_m) const {
    const double bound_m = std::hypot(cylinder.radius_m, 0.5 * cylinder.height_m) + tolerance_m;
    return (cylinder.center - center).norm() + bound_m < radius_m;
  }
};

RaysThrough ChooseRays(const CandidateContext& context, const Eigen::Vector3d& center,
                       double radius_m) {
  RaysThrough rays{center, radius_m, {}, {}, {}};
  const Points& points = context.scene.points_C;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& origin = context.places_C[context.place_of[i]];
    const Eigen::Vector3d way = points[i] - origin;
    const Eigen::Vector3d to_center = center - origin;
    if (way.cross(to_center).squaredNorm() > radius_m * radius_m * way.squaredNorm()) continue;
    rays.chosen.push_back(i);
    rays.points.push_back(points[i]);
    rays.place_of.push_back(context.place_of[i]);
  }
  return rays;
}

/// A given cylinder at an axis, with what was seen of it.
class Examination {
 public:
  Examination(const CandidateContext& context, const GivenCylinder& given)
      : context_(context), accept_(context.options.accept), given_(given) {}

  std::optional<FoundCylinder> Of(const Candidate& candidate) const {
    // From a rim the axis goes down by the height, and from a barrel's middle by half of it, or by
    // all of it where half is hidden.
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
    Orient(refined.axis);
    // Points are no further out than the ends but for noise; they may end a row before them.
    const double max_length_m = given_.height_m + accept_.max_face_error_m;
    const auto ends = FindEnds(context_.scene.cloud, near, refined, given_.radius_m, max_length_m,
                               context_.options.barrel);
    if (!ends || ends->Length() > max_length_m) return std::nullopt;
    if (ends->Length() < accept_.min_length_share * given_.height_m) return std::nullopt;
    FoundCylinder found;
    found.lies = !Stands(refined.axis.direction);
    found.length_seen_m = ends->Length();
    found.cylinder_C = {refined.axis.point, refined.axis.direction, refined.radius_m,
                        given_.height_m};
    const RaysThrough rays = RaysAbout(refined.axis, *ends);
    const Seen seen{refined, *ends, rays, OwnPoints(rays, refined.axis, *ends)};
    const bool placed = found.lies ? PlaceLying(seen, found) : PlaceStanding(seen, found);
    if (!placed) return std::nullopt;
    found.barrel = std::move(refined.points);
    AddRim(candidate, found);
    return found;
  }

  /// What was seen of the cylinder.
  struct Seen {
    const RefinedAxis& refined;
    const BarrelEnds& ends;
    const RaysThrough& rays;  ///< those that any cylinder may meet that the ends are ends of
    std::vector<bool> own;    ///< of the rays' points those on it
  };

  /// The cylinder goes on from one end of what is seen until it is as high as given.
  RaysThrough RaysAbout(const Line& axis, const BarrelEnds& ends) const {
    const double slack_m = 2.0 * accept_.max_height_error_m + accept_.view_tolerance_m;
    const double reach_m = given_.height_m - 0.5 * ends.Length();
    const double sphere_m = std::hypot(given_.radius_m, reach_m) + 2.0 * slack_m;
    return ChooseRays(context_, axis.point + 0.5 * (ends.low_m + ends.high_m) * axis.direction,
                      sphere_m);
  }

  /// The rays to these say nothing of a part of it that is not seen: they end before that as they
  /// would were there none.
  std::vector<bool> OwnPoints(const RaysThrough& rays, const Line& axis,
                              const BarrelEnds& ends) const {
    const Cylinder seen{axis.point + 0.5 * (ends.low_m + ends.high_m) * axis.direction,
                        axis.direction, given_.radius_m, ends.Length()};
    return PointsOn(rays.points, seen, accept_.view_tolerance_m);
  }

  void AddRim(const Candidate& candidate, FoundCylinder& found) const {
    if (!candidate.rim) return;
    found.from_rim = true;
    found.rim_share = candidate.rim->share;
    found.rim = candidate.rim->points;
  }

  bool IsOfTheGivenRadius(const RefinedAxis& refined) const {
    const double max_error_m = accept_.max_radius_error_m;
    const double allowed_m = max_error_m + std::min(max_error_m, 2.0 * refined.radius_sd_m);
    return std::abs(refined.radius_m - given_.radius_m) <= allowed_m &&
           refined.arc_rad >= accept_.min_arc_rad &&
           refined.normal_angle_rad <= accept_.max_normal_angle_rad;
  }

  bool Stands(const Eigen::Vector3d& axis) const {
    return std::abs(axis.dot(Table().normal)) >= std::cos(accept_.max_standing_tilt_rad);
  }

  /// Up, away from the table.
  void Orient(Line& axis) const {
    if (axis.direction.dot(Table().normal) < 0.0) axis.direction = -axis.direction;
  }

  /// Where along the axis the table is.
  double TableAlong(const Line& axis) const {
    return -Table().Distance(axis.point) / axis.direction.dot(Table().normal);
  }

  /// Its top at the given height above the table, or higher where it shows that it stands on
  /// something; lower only where the top may be hidden.
  bool PlaceStanding(const Seen& seen, FoundCylinder& found) const {
    const auto& [refined, ends, rays, own] = seen;
    const double half = 0.5 * given_.height_m;
    const double table = TableAlong(refined.axis);
    const double top = table + given_.height_m;
    const double error_m = ends.high_face ? accept_.max_face_error_m : accept_.max_height_error_m;
    if (std::abs(ends.high_m - top) <= error_m) {
      return Place(seen, (ends.high_face ? ends.high_m : top) - half, found);
    }
    if (ends.high_m < top) {
      return !ends.high_face && Place(seen, top - half, found);
    }
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
    const auto& [refined, ends, rays, own] = seen;
    const double half = 0.5 * given_.height_m;
    double middle = 0.5 * (ends.low_m + ends.high_m);
    if (IsWhole(ends)) {
      if (ends.high_face && !ends.low_face) middle = ends.high_m - half;
      if (ends.low_face && !ends.high_face) middle = ends.low_m + half;
      return Place(seen, middle, found);
    }
    // What is missing is hidden beyond the one end, the other, or both: the middle of all places
    // where it may be.
    const double missing = given_.height_m - ends.Length();
    const double low = ends.low_face ? 0.0 : HiddenLength(seen, ends.low_m, -1.0, missing);
    const double high = ends.high_face ? 0.0 : HiddenLength(seen, ends.high_m, 1.0, missing);
    if (low + high < missing - accept_.max_height_error_m) return false;
    const double most_up = ends.high_m + high - half;
    const double most_down = ends.low_m - low + half;
    middle = 0.5 * (most_up + most_down);
    return Place(seen, middle, found);
  }

  /// Puts the middle there, and says whether what was seen agrees.
  bool Place(const Seen& seen, double middle_m, FoundCylinder& found) const {
    const auto& [refined, ends, rays, own] = seen;
    found.cylinder_C.center = refined.axis.point + middle_m * refined.axis.direction;
    if (IsSunk(found.cylinder_C)) return false;
    if (!context_.options.check_shape) return true;
    const double half = 0.5 * given_.height_m;
    return MayBeHidden(seen, middle_m - half, ends.low_m) &&
           MayBeHidden(seen, ends.high_m, middle_m + half) && Agrees(found, &rays);
  }

  /// Under the table by more than its end's uncertainty.
  bool IsSunk(const Cylinder& cylinder) const {
    const double upright = std::abs(cylinder.axis.dot(Table().normal));
    const double lowest = 0.5 * given_.height_m * upright +
                          given_.radius_m * std::sqrt(std::max(0.0, 1.0 - upright * upright));
    return Table().Distance(cylinder.center) < lowest - 2.0 * accept_.max_height_error_m;
  }

  /// How far beyond an end the cylinder may go on unseen, up to so much [m]. Slices are no thinner
  /// than a row of points: a slice that no ray meets would be taken for hidden.
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

  /// Whether the part of the cylinder between two places along its axis, which showed no points,
  /// can be there.
  bool MayBeHidden(const Seen& seen, double from_m, double to_m) const {
    return to_m - from_m <= accept_.max_height_error_m || IsHidden(seen, from_m, to_m);
  }

  bool IsHidden(const Seen& seen, double from_m, double to_m) const {
    const Line& axis = seen.refined.axis;
    const Cylinder part{axis.point + 0.5 * (from_m + to_m) * axis.direction, axis.direction,
                        given_.radius_m, to_m - from_m};
    const ViewCounts counts = ViewBeside(seen, part);
    return static_cast<double>(counts.through) <=
           accept_.max_missing_seen * static_cast<double>(counts.through + counts.before);
  }

  /// @param rays  some of all rays that may do; nullptr: there are none chosen
  bool Agrees(FoundCylinder& found, const RaysThrough* rays = nullptr) const {
    Cylinder as_given = found.cylinder_C;
    as_given.radius_m = given_.radius_m;
    const double tolerance_m = accept_.view_tolerance_m;
    const bool some = rays && rays->AreAllOf(as_given, tolerance_m);
    found.view = some ? CompareWithView(rays->points, context_.places_C, rays->place_of, as_given,
                                        tolerance_m)
                      : CompareWithView(context_.scene.points_C, context_.places_C,
                                        context_.place_of, as_given, tolerance_m);
    return found.view.Agreement() >= accept_.min_agreement &&
           static_cast<double>(found.view.on) >=
               accept_.min_seen_share * static_cast<double>(found.view.All());
  }

  /// What the rays say of a part of the cylinder that is not seen, without those that end on the
  /// part that is.
  ViewCounts ViewBeside(const Seen& seen, const Cylinder& part) const {
    const double tolerance_m = accept_.view_tolerance_m;
    if (seen.rays.AreAllOf(part, tolerance_m)) {
      return CompareWithView(seen.rays.points, context_.places_C, seen.rays.place_of, part,
                             tolerance_m, seen.own);
    }
    std::vector<bool> own(context_.scene.points_C.size(), false);
    for (std::size_t k = 0; k < seen.own.size(); ++k) own[seen.rays.chosen[k]] = seen.own[k];
    return CompareWithView(context_.scene.points_C, context_.places_C, context_.place_of, part,
                           tolerance_m, own);
  }

  /// Only the rim is seen: it stands on the table, below its rim.
  std::optional<FoundCylinder> ByRim(const Rim& rim) const {
    const Eigen::Vector3d& up = Table().normal;
    std::vector<double> heights;
    for (const auto i : rim.points) {
      heights.push_back(Table().Distance(context_.scene.cloud.points[i]));
    }
    const double top_m = base::MedianOf(std::move(heights));
    if (std::abs(top_m - given_.height_m) > accept_.max_height_error_m) return std::nullopt;
    FoundCylinder found;
    const Eigen::Vector3d foot = Table().Project(rim.circle_C.center);
    found.cylinder_C = {foot + 0.5 * given_.height_m * up, up, rim.circle_C.radius_m,
                        given_.height_m};
    AddRim({{}, &rim}, found);
    if (context_.options.check_shape && !Agrees(found)) return std::nullopt;
    return found;
  }

  const CandidateContext& context_;
  const AcceptOptions& accept_;
  const GivenCylinder& given_;
};

}  // namespace

std::optional<FoundCylinder> Examine(const CandidateContext& context, const Candidate& candidate,
                                     const GivenCylinder& given) {
  return Examination(context, given).Of(candidate);
}

FoundCylinder PublishedPose(const CandidateContext& context, const Rim& rim,
                            const GivenCylinder& given) {
  const geometry::PointCloud& cloud = context.scene.cloud;
  const Eigen::Vector3d& up = context.scene.table.plane.normal;
  const Points rim_points = geometry::Select(cloud.points, rim.points);
  const double r = rim.circle_C.radius_m;
  const double distance_m = context.options.barrel.distance_m;
  FoundCylinder found;
  found.from_rim = true;
  found.rim_share = rim.share;
  found.rim = rim.points;
  found.barrel = BarrelPoints(cloud.points, {rim.circle_C.center, up}, r,
                              -given.height_m - distance_m, distance_m, distance_m);
  const auto line = FitLine(AxisPoints(geometry::Select(cloud.points, found.barrel),
                                       geometry::Select(cloud.normals, found.barrel), r));
  Line axis = line.value_or(Line{rim.circle_C.center, up});
  if (axis.direction.dot(up) < 0.0) axis.direction = -axis.direction;
  const Eigen::Vector3d c_m = CenterOnAxis(axis, rim_points, up).value_or(rim.circle_C.center);
  found.cylinder_C = {CenterOfGravity(c_m, axis.direction, given.height_m), axis.direction, r,
                      given.height_m};
  found.lies = axis.direction.dot(up) < std::cos(context.options.accept.max_standing_tilt_rad);
  return found;
}

}  // namespace rangegrasp::cylinders::internal
