#include "grasp/internal/object_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Less than this share of a vector normal to an axis is rounding: any normal does then.
constexpr double kMinPart = 1e-6;
/// Where the hand meets nothing on its way down, the limit is this far away [m].
constexpr double kNoLimit_m = 1e9;

}  // namespace

Vector3d NormalPart(const Vector3d& v, const Vector3d& axis) {
  const Vector3d part = v - v.dot(axis) * axis;
  if (part.norm() > kMinPart * std::max(1.0, v.norm())) return part.normalized();
  return axis.unitOrthogonal();
}

std::optional<Vector3d> UprightAxis(const Task& task) {
  if (!task.object.axis) return std::nullopt;
  Vector3d axis = task.object.axis->direction_C.normalized();
  if (axis.dot(task.up_C) < 0.0) axis = -axis;
  if (axis.dot(task.up_C) < std::cos(task.options.cylindrical.max_tilt_rad)) return std::nullopt;
  return axis;
}

View MakeView(const Task& task, const SurfaceSamples& coarse, const Vector3d& origin_C,
              const Vector3d& approach_C, const Vector3d& closing_C) {
  const Vector3d z = approach_C.normalized();
  const Vector3d x = NormalPart(closing_C, z);
  Eigen::Matrix3d R_CA;
  R_CA << x, z.cross(x), z;
  View view;
  view.X_CA = base::MakePose(R_CA, origin_C);
  const base::Pose X_AC = view.X_CA.inverse();
  view.coarse.reserve(coarse.points.size());
  view.top_m = view.y_min_m = kInfinity;
  view.bottom_m = view.y_max_m = -kInfinity;
  for (const Vector3d& p_C : coarse.points) {
    const Vector3d p = X_AC * p_C;
    view.coarse.push_back(p);
    view.top_m = std::min(view.top_m, p.z());
    view.bottom_m = std::max(view.bottom_m, p.z());
    view.y_min_m = std::min(view.y_min_m, p.y());
    view.y_max_m = std::max(view.y_max_m, p.y());
  }
  view.com = X_AC * task.com_C;
  view.up = X_AC.linear() * task.up_C;
  view.table_offset_m = task.scene.table.plane.Distance(origin_C);
  view.thumb_to_arm = x.dot(NormalPart(task.arm_C - origin_C, z));
  return view;
}

Band MakeBand(const Task& task, const View& view, double y0_m) {
  const PlacingOptions& options = task.options.placing;
  Band band;
  band.y_m = y0_m;
  const base::Pose X_AC = view.X_CA.inverse();
  const Eigen::RowVector3d y_row = X_AC.linear().row(1);
  const double y_shift = X_AC.translation().y() - y0_m;
  const double deepest = view.top_m + options.max_reach_m;
  for (std::size_t i = 0; i < task.samples.points.size(); ++i) {
    if (std::abs(y_row * task.samples.points[i] + y_shift) > options.contact_band_m) continue;
    const Vector3d p = X_AC * task.samples.points[i];
    if (p.z() > deepest) continue;
    band.points.push_back(p);
    band.normals.push_back(X_AC.linear() * task.samples.normals[i]);
  }
  return band;
}

std::optional<Slab> SlabAt(const View& view, double y0_m, double half_band_m, double reach_m) {
  Slab slab;
  slab.top_m = kInfinity;
  for (const Vector3d& p : view.coarse) {
    if (std::abs(p.y() - y0_m) <= half_band_m) slab.top_m = std::min(slab.top_m, p.z());
  }
  slab.x_min_m = kInfinity;
  slab.x_max_m = -kInfinity;
  for (const Vector3d& p : view.coarse) {
    if (std::abs(p.y() - y0_m) > half_band_m || p.z() > slab.top_m + reach_m) continue;
    slab.x_min_m = std::min(slab.x_min_m, p.x());
    slab.x_max_m = std::max(slab.x_max_m, p.x());
  }
  if (slab.x_max_m <= slab.x_min_m) return std::nullopt;
  return slab;
}

double DescentLimit(const View& view, const HandProfiles::Lower& lower, double x_m, double y_m,
                    double clearance_m) {
  double limit = kNoLimit_m;
  for (const Vector3d& p : view.coarse) {
    const int cell = lower.grid.Cell(p.x() - x_m, p.y() - y_m);
    if (cell < 0) continue;
    limit = std::min(limit, p.z() - static_cast<double>(lower.z[static_cast<std::size_t>(cell)]));
  }
  return limit - clearance_m;
}

double ReachDown(Task& task, const View& view, double pitch_rad, std::size_t open,
                 std::size_t closed) {
  double reach = -kInfinity;
  for (std::size_t s = open; s <= std::max(open, closed); ++s) {
    reach = std::max(reach, task.profiles.Extent(pitch_rad, s, -view.up));
  }
  return reach;
}

double TableLimit(const View& view, double reach_m, double x_m, double y_m, double clearance_m) {
  const double height_at_zero = view.table_offset_m + view.up.x() * x_m + view.up.y() * y_m;
  const double room = height_at_zero - reach_m - clearance_m;
  // A level hand neither nears the table on its way nor leaves it.
  if (std::abs(view.up.z()) < kMinPart) return room >= 0.0 ? kNoLimit_m : -kNoLimit_m;
  return room / -view.up.z();
}

double DepthLimit(const Task& task, const View& view, const HandProfiles::Lower& lower,
                  double reach_m, double x_m, double y_m) {
  return std::min(TableLimit(view, reach_m, x_m, y_m, task.options.table_clearance_m),
                  DescentLimit(view, lower, x_m, y_m, task.options.object_clearance_m));
}

}  // namespace rangegrasp::grasp::internal
