#include "grasp/internal/candidates.h"

#include <Eigen/Geometry>
#include <ranges>

#include "base/linear_algebra.h"

namespace rangegrasp::grasp::internal {
namespace {

using geometry::KdTree;
using geometry::Points;
using geometry::PointSpan;

constexpr Eigen::Index kMinNeighbors = 6;
/// [m^2] Points on a line have no second principal axis; a smaller spread along it is rounding.
constexpr double kMinSpread_m2 = 1e-12;

/// A point in cylindrical coordinates about the rotation axis.
struct Polar {
  double angle_rad, radius_m, height_m;
};
struct Cylindrical {
  Vector3d center, axis, zero;

  Polar operator()(const Vector3d& p) const {
    const Vector3d d = p - center;
    return {std::atan2(d.dot(axis.cross(zero)), d.dot(zero)), (d - d.dot(axis) * axis).norm(),
            d.dot(axis)};
  }
};

/// |K| at the rim's points by sector: the mean over the points in it.
std::vector<double> RimCurvature(const Scene& scene, const PerceivedObject& object,
                                 const Cylindrical& polar, std::size_t sectors,
                                 double neighborhood_m) {
  std::vector<double> sum(sectors, 0.0);
  std::vector<double> count(sectors, 0.0);
  if (!object.top || object.points.size() < kMinNeighbors) return sum;
  const Points points = geometry::Select(scene.cloud.points, object.points);
  const KdTree tree(points);
  std::vector<KdTree::Neighbor> found;
  Points neighbors;
  for (const std::uint32_t i : object.top->rim) {
    const Vector3d& p = scene.cloud.points[i];
    tree.Within(p, neighborhood_m, found);
    neighbors.clear();
    for (const auto& neighbor : found) neighbors.push_back(points[neighbor.index]);
    const auto curvature = GaussianCurvature(neighbors, p);
    if (!curvature) continue;
    const double turn = polar(p).angle_rad / (2.0 * base::kPi);
    const auto k = static_cast<std::size_t>(
                       std::lround((turn - std::floor(turn)) * static_cast<double>(sectors))) %
                   sectors;
    sum[k] += std::abs(*curvature);
    count[k] += 1.0;
  }
  for (std::size_t k = 0; k < sectors; ++k) sum[k] /= std::max(1.0, count[k]);
  return sum;
}

/// The points of the wall a little below the rim.
std::vector<Polar> WallPoints(PointSpan points, const Cylindrical& polar, double rim_radius_m,
                              const RimOptions& options) {
  std::vector<Polar> wall;
  for (const Vector3d& p : points) {
    const Polar q = polar(p);
    if (q.height_m > options.above_rim_m || q.height_m < -options.below_rim_m) continue;
    if (std::abs(q.radius_m - rim_radius_m) <= options.max_wall_m) wall.push_back(q);
  }
  return wall;
}

/// Inner and outer radius of the wall near an angle.
void MeasureWall(const std::vector<Polar>& wall, double rim_radius_m, const RimOptions& options,
                 RimSector& sector) {
  double inner = kInfinity;
  double outer = 0.0;
  for (const Polar& p : wall) {
    const double apart = std::abs(p.angle_rad - sector.angle_rad);
    if (std::min(apart, std::abs(2.0 * base::kPi - apart)) > options.sector_rad) continue;
    inner = std::min(inner, p.radius_m);
    outer = std::max(outer, p.radius_m);
  }
  const bool seen = outer > inner + options.min_wall_m;
  sector.wall_m = seen ? outer - inner : options.assumed_wall_m;
  sector.radius_m = seen ? 0.5 * (outer + inner) : rim_radius_m - 0.5 * options.assumed_wall_m;
}

/// A grasp of the wall at one sector. `out`: the thumb's side, +1 outside, -1 in the cavity.
Candidate WallCandidate(Task& task, PointSpan wall_C, const RimSector& sector, const Vector3d& axis,
                        const Vector3d& radial, double out) {
  const RimOptions& options = task.options.rim;
  const View view = MakeView(task, wall_C, task.object.axis->center_C, -axis, out * radial);
  const std::size_t open = task.hand.IndexAtGap(sector.wall_m + options.opening_m);
  const std::size_t held = task.hand.IndexAtGap(sector.wall_m);
  const Vector3d pads = task.profiles.PadCenter_T(0.0, held);
  Vector3d origin(out * sector.radius_m - pads.x(), -pads.y(), 0.0);
  const double limit = DepthLimit(task, view, task.profiles.LowerSide(0.0, open),
                                  ReachDown(task, view, 0.0, open, held), origin.x(), origin.y());
  const double wanted = options.grip_depth_m - pads.z();
  origin.z() = std::min(limit, wanted);
  Candidate candidate = MakeCandidate(task, view, origin, origin + pads, 0.0, {open, open, held},
                                      sector.wall_m, GraspType::kRim);
  const double near_arm = 0.5 * (1.0 + std::cos(sector.angle_rad));
  candidate.grasp.score =
      options.curvature_weight * sector.curvature + options.arm_weight * near_arm +
      (task.options.contact_ranking && out < 0.0 ? options.outside_bonus : 0.0) -
      options.shallow_per_m * std::max(0.0, wanted - origin.z());
  return candidate;
}

std::vector<Candidate> OpenRim(Task& task, const Vector3d& axis, const Vector3d& zero,
                               const std::vector<RimSector>& rim) {
  // The points themselves are used, because the surface may close the cavity.
  Points wall_C;
  const TriangleMesh specks = SpeckMesh(task.object.completed_C, task.options.rim.speck_cell_m);
  for (std::size_t i = 0; i < specks.vertices.size(); i += 3) wall_C.push_back(specks.vertices[i]);
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const Vector3d radial = Eigen::AngleAxisd(rim[k].angle_rad, axis) * zero;
    for (const double out : {-1.0, 1.0}) {
      candidates.push_back(WallCandidate(task, wall_C, rim[k], axis, radial, out));
      candidates.back().group = static_cast<int>(k);
    }
  }
  return candidates;
}

/// A closed top has no wall to hold: the tips close on two opposite points of the rim instead.
std::vector<Candidate> ClosedRim(Task& task, const Vector3d& axis, const Vector3d& zero,
                                 const std::vector<RimSector>& rim) {
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const View view = MakeView(task, task.coarse, task.object.axis->center_C, -axis,
                               Eigen::AngleAxisd(rim[k].angle_rad, axis) * zero);
    const double pitch = task.options.pitches ? task.options.cylindrical.pitch_rad : 0.0;
    const Aim aim{pitch, pitch, view.top_m + task.options.rim.tip_depth_m};
    auto candidate = Place(task, view, MakeBand(task, view, 0.0), aim, GraspType::kRim);
    if (!candidate) continue;
    candidate->group = static_cast<int>(k);
    candidate->grasp.score = task.options.rim.curvature_weight * rim[k].curvature +
                             task.options.rim.arm_weight * view.thumb_to_arm;
    candidates.push_back(*candidate);
  }
  return candidates;
}

/// Cosine above which two approaches count as one: 2.6 deg.
constexpr double kSameApproach = 0.999;

struct Direction {
  Vector3d approach;
  Vector3d closing;
};

Vector3d UpNormal(const Task& task) {
  const Vector3d& normal = task.object.top->plane.normal;
  return normal.dot(task.up_C) < 0.0 ? Vector3d(-normal) : normal;
}

/// Grasps with the hand wide open over the top surface's centre, against its normal, in both
/// orientations, down to contact: if nothing else is left. With contact_ranking none if the surface
/// is wider than the hand, whose pads then cannot touch its sides; the dissertation does not check
/// that.
std::vector<Candidate> OverTheTop(Task& task) {
  std::vector<Candidate> candidates;
  if (!task.object.top) return candidates;
  const perception::TopSurface& top = *task.object.top;
  if (task.options.contact_ranking && top.minor_m > task.hand.MaxGap()) return candidates;
  for (const double side : {1.0, -1.0}) {
    const View view =
        MakeView(task, task.coarse, top.center_C, -UpNormal(task), side * top.minor_C);
    const Vector3d tool = task.profiles.ToolCenter_T(0.0, 0, true);
    Vector3d origin = -tool;
    const std::size_t last = task.hand.states.size() - 1;
    const std::size_t held = std::min(last, task.hand.IndexAtGap(top.minor_m) + 1);
    origin.z() = DepthLimit(task, view, task.profiles.LowerSide(0.0, 0),
                            ReachDown(task, view, 0.0, 0, held), origin.x(), origin.y());
    Candidate candidate = MakeCandidate(task, view, origin, origin + tool, 0.0, {0, 0, held},
                                        top.minor_m, GraspType::kPower);
    candidate.group = side > 0.0 ? 0 : 1;
    candidate.to_contact = true;
    candidates.push_back(candidate);
  }
  return candidates;
}

/// The direction across the approach in which the object is narrowest, in equal steps from `first`.
Vector3d Narrowest(const Task& task, const Vector3d& approach, const Vector3d& first) {
  const PowerOptions& options = task.options.power;
  Vector3d best = first;
  double min_width = kInfinity;
  for (int k = 0; k < options.narrow_steps; ++k) {
    const double turn = base::Deg(180.0 * k / options.narrow_steps);
    const Vector3d x = Eigen::AngleAxisd(turn, approach) * first;
    const auto [low, high] = std::ranges::minmax(
        task.coarse | std::views::transform([&](const Vector3d& p) { return x.dot(p); }));
    // Ties, e.g. between all directions of a cylinder, go to the first direction.
    if (high - low < min_width - options.same_width_m) {
      min_width = high - low;
      best = x;
    }
  }
  return best;
}

/// The direction normal to the approach in which the samples spread least.
Vector3d MinSpread(const Task& task, const Vector3d& approach) {
  const Vector3d u = approach.unitOrthogonal();
  const Vector3d v = approach.cross(u);
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Vector3d& p : task.coarse) {
    const Eigen::Vector2d q(u.dot(p - task.com_C), v.dot(p - task.com_C));
    covariance += q * q.transpose();
  }
  const Eigen::Vector2d least = base::SymmetricEigen(covariance).vectors.col(0);
  return least[0] * u + least[1] * v;
}

/// Adds a closing direction and its neighbors, in both orientations, unless one is near already.
void AddClosing(const PowerOptions& options, const Vector3d& approach, const Vector3d& closing,
                std::vector<Direction>& list) {
  for (const double turn : options.turns_rad) {
    const Vector3d x = Eigen::AngleAxisd(turn, approach) * closing;
    const bool known = std::ranges::any_of(list, [&](const Direction& d) {
      return d.approach.dot(approach) > kSameApproach &&
             std::abs(d.closing.dot(x)) > std::cos(options.distinct_rad);
    });
    if (known) continue;
    list.push_back({approach, x});
    list.push_back({approach, -x});
  }
}

/// Straight down, and against the top surface if it is tilted.
std::vector<Vector3d> Approaches(const Task& task) {
  const PowerOptions& options = task.options.power;
  std::vector<Vector3d> approaches{-task.up_C};
  if (task.object.top) {
    const Vector3d normal = UpNormal(task);
    const double tilt = std::acos(std::min(1.0, normal.dot(task.up_C)));
    if (tilt > options.min_tilt_rad && tilt < options.max_tilt_rad) approaches.push_back(-normal);
  }
  return approaches;
}

std::vector<Vector3d> LeaningApproaches(const Task& task, double lean_rad) {
  const int sides = task.options.power.crowded_sides;
  const Vector3d to_arm = NormalPart(task.arm.base_C - task.com_C, task.up_C);
  std::vector<Vector3d> approaches;
  for (int k = 0; k < sides; ++k) {
    const Vector3d from = Eigen::AngleAxisd(base::Deg(360.0 * k / sides), task.up_C) * to_arm;
    approaches.push_back(-std::cos(lean_rad) * task.up_C - std::sin(lean_rad) * from);
  }
  return approaches;
}

/// The direction across the object: the top surface's shorter axis.
Vector3d Across(const Task& task, const Vector3d& approach) {
  return task.object.top ? NormalPart(task.object.top->minor_C, approach)
                         : MinSpread(task, approach);
}

/// All approaches, closing across the narrowest side, the principal axis and the axis normal to it.
/// As published: against the top surface, closing across its principal axis, both ways round.
std::vector<Direction> Directions(const Task& task) {
  const PowerOptions& options = task.options.power;
  std::vector<Direction> directions;
  if (!task.options.directions) {
    if (!task.object.top) return directions;
    const Vector3d& across = task.object.top->minor_C;
    return {{-UpNormal(task), across}, {-UpNormal(task), -across}};
  }
  for (const Vector3d& approach : Approaches(task)) {
    const Vector3d across = Across(task, approach);
    AddClosing(options, approach, Narrowest(task, approach, across), directions);
    AddClosing(options, approach, across, directions);
    AddClosing(options, approach, approach.cross(across), directions);
  }
  return directions;
}

/// Pad depths: at the centre of mass, below it, and halfway to the bottom; or only down to contact.
std::vector<double> Depths(const Task& task, const View& view) {
  if (!task.options.depths) return {kToContact_m};
  return {view.com.z(), view.com.z() + task.options.power.below_center_m,
          0.5 * (view.com.z() + view.bottom_m)};
}

/// Pad depths from the shallowest that holds to the centre of mass.
std::vector<double> ShallowDepths(const Task& task, const View& view) {
  const int count = std::max(2, task.options.power.crowded_depths);
  const double shallow = view.top_m + task.options.placing.min_depth_m;
  const double step = std::max(0.0, view.com.z() - shallow) / (count - 1);
  std::vector<double> depths;
  for (int k = 0; k < count; ++k) depths.push_back(shallow + k * step);
  return depths;
}

/// The measured best pitch, or 0 (level fingers) without pitches.
double MainPitch(const Task& task) {
  return task.options.pitches ? task.options.power.pitch_rad : 0.0;
}

/// Position along the fingers' row: the centre of mass, or the top's (then the view's origin).
double MiddleOf(const Task& task, const View& view) {
  return task.options.centering || !task.object.top ? view.com.y() : 0.0;
}

/// Pitches through the centre of mass, then offsets along the object at the best of them.
void Search(Task& task, const View& view, int group, std::vector<Candidate>& candidates) {
  const PowerOptions& options = task.options.power;
  const double main = MainPitch(task);
  const double y0 = MiddleOf(task, view);
  const std::size_t before = candidates.size();
  if (task.options.pitches) {
    const Band middle = MakeBand(task, view, y0);
    for (const double pitch : options.pitches_rad) {
      PlaceAtDepths(task, view, middle, {pitch, main}, Depths(task, view), GraspType::kPower, group,
                    candidates);
    }
  }
  if (!task.options.offsets) return;
  // New candidates come first, so that they win ties of the score.
  std::vector<Candidate> found(candidates.begin() + static_cast<std::ptrdiff_t>(before),
                               candidates.end());
  std::ranges::copy_if(candidates, std::back_inserter(found),
                       [&](const Candidate& c) { return c.group == group; });
  const auto best = std::ranges::max_element(found, {}, ScoreOf);
  const double pitch = best == found.end() ? main : best->grasp.pitch_rad;
  for (const double offset : options.offsets_m) {
    const double y = y0 + offset;
    if (y < view.y_min_m + options.end_m || y > view.y_max_m - options.end_m) continue;
    PlaceAtDepths(task, view, MakeBand(task, view, y), {pitch, main}, Depths(task, view),
                  GraspType::kPower, group, candidates);
  }
}

struct SideApproach {
  Vector3d approach;
  double ahead;  ///< cosine between it, seen from above, and the arm's direction to the object
};

/// Directions away from the arm, level or a little downwards, and turned to both sides.
std::vector<SideApproach> SideApproaches(const Task& task) {
  const LateralOptions& options = task.options.lateral;
  const Vector3d away = NormalPart(task.com_C - task.arm.base_C, task.up_C);
  std::vector<SideApproach> approaches;
  for (const double down : options.downwards_rad) {
    for (int k = -options.turns_each_way; k <= options.turns_each_way; ++k) {
      const double turn = k * options.turn_rad;
      const Vector3d level = Eigen::AngleAxisd(turn, task.up_C) * away;
      approaches.push_back({std::cos(down) * level - std::sin(down) * task.up_C, std::cos(turn)});
    }
  }
  return approaches;
}

/// Along y (nearly upright if the closing direction is level), from the centre of mass up.
std::vector<double> Heights(const Task& task, const View& view) {
  const LateralOptions& options = task.options.lateral;
  const double sign = view.up.y() > 0.0 ? 1.0 : -1.0;
  const double top = sign > 0.0 ? view.y_max_m : -view.y_min_m;
  std::vector<double> heights;
  for (int k = 0; k < options.heights; ++k) {
    const double up = sign * view.com.y() + k * options.height_step_m;
    if (up <= top - task.options.power.end_m) heights.push_back(sign * up);
  }
  return heights;
}

}  // namespace

std::optional<double> GaussianCurvature(PointSpan neighbors, const Vector3d& center) {
  const auto n = static_cast<Eigen::Index>(neighbors.size());
  if (n < kMinNeighbors) return std::nullopt;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : neighbors) mean += p / static_cast<double>(n);
  const auto axes = base::SymmetricEigen(geometry::Scatter(neighbors, mean));
  if (axes.values[1] < kMinSpread_m2) return std::nullopt;
  Eigen::MatrixXd A(n, 6);
  Eigen::VectorXd h(n);
  // Lengths are in units of the neighbourhood, so that the columns have similar weights.
  const double unit = std::sqrt(axes.values[2] / static_cast<double>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d q =
        axes.vectors.transpose() * (neighbors[static_cast<std::size_t>(i)] - center) / unit;
    const double u = q[1];
    const double v = q[2];
    A.row(i) << u * u, u * v, v * v, u, v, 1.0;
    h[i] = q[0];
  }
  const auto solved = base::UniqueLeastSquares(A, h);
  if (!solved) return std::nullopt;
  const Eigen::VectorXd& x = *solved;
  const double slope = 1.0 + x[3] * x[3] + x[4] * x[4];
  return (4.0 * x[0] * x[2] - x[1] * x[1]) / (slope * slope) / (unit * unit);
}

std::vector<double> SmoothAround(std::span<const double> angles_rad, std::span<const double> values,
                                 double sigma_rad) {
  std::vector<double> smooth(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    double sum = 0.0;
    double weights = 0.0;
    for (std::size_t j = 0; j < values.size(); ++j) {
      const double d = std::remainder(angles_rad[i] - angles_rad[j], 2.0 * base::kPi) / sigma_rad;
      const double weight = std::exp(-0.5 * d * d);
      sum += weight * values[j];
      weights += weight;
    }
    smooth[i] = sum / weights;
  }
  return smooth;
}

std::vector<RimSector> DescribeRim(const Scene& scene, const PerceivedObject& object,
                                   const Vector3d& axis_C, const Vector3d& zero_C, int sectors,
                                   const RimOptions& options) {
  const Cylindrical polar{object.axis->center_C, axis_C, zero_C};
  const auto n = static_cast<std::size_t>(sectors);
  const auto wall = WallPoints(object.completed_C, polar, object.axis->radius_m, options);
  std::vector<RimSector> rim(n);
  std::vector<double> angles(n);
  for (std::size_t k = 0; k < n; ++k) {
    angles[k] = 2.0 * base::kPi * static_cast<double>(k) / static_cast<double>(sectors);
    rim[k].angle_rad = angles[k];
    MeasureWall(wall, object.axis->radius_m, options, rim[k]);
  }
  const std::vector<double> curvature = SmoothAround(
      angles, RimCurvature(scene, object, polar, n, options.neighborhood_m), options.smooth_rad);
  const double max = *std::ranges::max_element(curvature);
  if (max <= 0.0) return rim;
  for (std::size_t k = 0; k < n; ++k) rim[k].curvature = curvature[k] / max;
  return rim;
}

std::vector<Candidate> CylindricalCandidates(Task& task) {
  const CylindricalOptions& options = task.options.cylindrical;
  std::vector<Candidate> candidates;
  const auto axis = UprightAxis(task);
  if (!axis || 2.0 * task.object.axis->radius_m > task.MaxWidth()) return candidates;
  const Vector3d& center = task.object.axis->center_C;
  const Vector3d towards_arm = NormalPart(task.arm.base_C - center, *axis);
  const double diameter_m = 2.0 * task.object.axis->radius_m;
  const double best = task.options.pitches ? options.pitch_rad : 0.0;
  std::vector<double> pitches{best};
  if (task.options.pitches) pitches.push_back(best - options.second_pitch_rad);
  for (int k = 0; k < options.yaw_steps; ++k) {
    const double yaw = 2.0 * base::kPi * k / options.yaw_steps;
    const View view =
        MakeView(task, task.coarse, center, -*axis, Eigen::AngleAxisd(yaw, *axis) * towards_arm);
    const Band band = MakeBand(task, view, 0.0);
    const std::array middle{0.5 * (view.top_m + view.bottom_m)};
    for (const double pitch : pitches) {
      Aim aim{pitch, best};
      // The tool centre is on the axis at half the height; the width is the diameter.
      if (!task.options.centering) aim.width_m = diameter_m;
      const std::size_t before = candidates.size();
      PlaceAtDepths(task, view, band, aim, middle, GraspType::kCylindrical, k, candidates);
      if (task.options.contact_ranking) continue;
      for (Candidate& candidate : std::span(candidates).subspan(before)) {
        candidate.grasp.score = view.thumb_to_arm;  // next to the arm (section 5.2)
      }
    }
  }
  return candidates;
}

std::vector<Candidate> RimCandidates(Task& task) {
  const auto axis = UprightAxis(task);
  if (!axis) return {};
  const Vector3d zero = NormalPart(task.arm.base_C - task.object.axis->center_C, *axis);
  const auto rim = DescribeRim(task.scene, task.object, *axis, zero,
                               task.options.cylindrical.yaw_steps, task.options.rim);
  return task.object.open ? OpenRim(task, *axis, zero, rim) : ClosedRim(task, *axis, zero, rim);
}

std::vector<Candidate> PowerCandidates(Task& task) {
  const PowerOptions& options = task.options.power;
  const bool at_top = !task.options.centering && task.object.top;
  const Vector3d& middle_C = at_top ? task.object.top->center_C : task.com_C;
  const std::vector<Direction> directions = Directions(task);
  std::vector<View> views;
  std::vector<std::pair<double, int>> order;
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < directions.size(); ++k) {
    views.push_back(
        MakeView(task, task.coarse, middle_C, directions[k].approach, directions[k].closing));
    const View& view = views.back();
    const std::size_t before = candidates.size();
    PlaceAtDepths(task, view, MakeBand(task, view, MiddleOf(task, view)),
                  {MainPitch(task), MainPitch(task)}, Depths(task, view), GraspType::kPower,
                  static_cast<int>(k), candidates);
    double best = -kInfinity;
    for (const Candidate& c : std::span(candidates).subspan(before)) {
      best = std::max(best, c.grasp.score);
    }
    order.emplace_back(-best, static_cast<int>(k));
  }
  std::ranges::sort(order);
  for (std::size_t i = 0; i < std::min(order.size(), options.max_fine_directions); ++i) {
    const int k = order[i].second;
    Search(task, views[static_cast<std::size_t>(k)], k, candidates);
  }
  return candidates.empty() ? OverTheTop(task) : candidates;
}

std::vector<Candidate> CrowdedCandidates(Task& task, std::size_t round) {
  const PowerOptions& options = task.options.power;
  const std::vector<Vector3d> approaches =
      round == 0 ? Approaches(task)
                 : LeaningApproaches(task, options.crowded_leans_rad.at(round - 1));
  std::vector<Candidate> candidates;
  int group = 0;
  for (const Vector3d& approach : approaches) {
    const Vector3d across = Across(task, approach);
    for (int turn = 0; turn < options.crowded_turns; ++turn) {
      const double angle = base::Deg(360.0 * turn / options.crowded_turns);
      const View view = MakeView(task, task.coarse, task.com_C, approach,
                                 Eigen::AngleAxisd(angle, approach) * across);
      for (const double offset : options.crowded_offsets_m) {
        const double y = view.com.y() + offset;
        if (y < view.y_min_m + options.end_m || y > view.y_max_m - options.end_m) continue;
        Aim aim{MainPitch(task), MainPitch(task)};
        aim.upper_part = true;
        PlaceAtDepths(task, view, MakeBand(task, view, y), aim, ShallowDepths(task, view),
                      GraspType::kPower, group, candidates);
      }
      ++group;
    }
  }
  // Some direction always finds a surface to close on, so grasps that certainly slip are removed.
  std::erase_if(candidates, [&](const Candidate& candidate) {
    return candidate.grasp.quality.angles.Larger() > task.options.friction_cone_rad;
  });
  return candidates;
}

std::vector<Candidate> LateralCandidates(Task& task) {
  const double pitch = MainPitch(task);
  std::vector<Candidate> candidates;
  int group = 0;
  for (const auto& [approach, ahead] : SideApproaches(task)) {
    for (const double side : {1.0, -1.0}) {
      View view =
          MakeView(task, task.coarse, task.com_C, approach, side * task.up_C.cross(approach));
      // Here, the side that the hand comes from counts as next to the arm, not the thumb's side.
      view.thumb_to_arm = ahead;
      const std::array depths{view.com.z(), 0.5 * (view.com.z() + view.bottom_m)};
      for (const double y : Heights(task, view)) {
        PlaceAtDepths(task, view, MakeBand(task, view, y), {pitch, pitch}, depths,
                      GraspType::kPower, group, candidates);
      }
      ++group;
    }
  }
  std::erase_if(candidates, [&](const Candidate& candidate) {
    const Vector3d off = candidate.grasp.X_CG.translation() - task.com_C;
    const double lever_m = (off - off.dot(task.up_C) * task.up_C).norm();
    return lever_m > task.options.lateral.max_lever_m ||
           candidate.grasp.quality.angles.Larger() > task.options.friction_cone_rad;
  });
  return candidates;
}

}  // namespace rangegrasp::grasp::internal
