#include "grasp/rim.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "geometry/kd_tree.h"
#include "grasp/internal/candidates.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kNeighborhood_m = 0.008;
constexpr double kSmooth_rad = 0.175;  // 10 deg: 7 mm along the rim of a cup
constexpr double kAssumedWall_m = 0.005;
constexpr double kThickestWall_m = 0.015;

double WrappedAngle(double a) { return std::remainder(a, 2.0 * core::kPi); }

}  // namespace

std::optional<double> GaussianCurvature(geometry::PointSpan neighbors, const Vector3d& center) {
  const auto n = static_cast<Eigen::Index>(neighbors.size());
  if (n < 6) return std::nullopt;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : neighbors) mean += p / static_cast<double>(n);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : neighbors) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  if (axes.eigenvalues()[1] < 1e-12) return std::nullopt;
  Eigen::MatrixXd A(n, 6);
  Eigen::VectorXd h(n);
  // Lengths in units of the neighbourhood, so that the columns weigh alike.
  const double unit = std::sqrt(axes.eigenvalues()[2] / static_cast<double>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d q =
        axes.eigenvectors().transpose() * (neighbors[static_cast<std::size_t>(i)] - center) / unit;
    const double u = q[1];
    const double v = q[2];
    A.row(i) << u * u, u * v, v * v, u, v, 1.0;
    h[i] = q[0];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < 6) return std::nullopt;
  const Eigen::VectorXd x = qr.solve(h);
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
      const double d = WrappedAngle(angles_rad[i] - angles_rad[j]) / sigma_rad;
      const double weight = std::exp(-0.5 * d * d);
      sum += weight * values[j];
      weights += weight;
    }
    smooth[i] = sum / weights;
  }
  return smooth;
}

namespace {

/// A point in cylindrical coordinates about the rotation axis.
struct Polar {
  double angle_rad, radius_m, height_m;
};

class Cylindrical {
 public:
  Cylindrical(const perception::RotationAxis& axis, const Vector3d& axis_C, const Vector3d& zero_C)
      : center_(axis.center_C), axis_(axis_C), u_(zero_C), v_(axis_C.cross(zero_C)) {}
  Polar operator()(const Vector3d& p) const {
    const Vector3d d = p - center_;
    return {std::atan2(d.dot(v_), d.dot(u_)), (d - d.dot(axis_) * axis_).norm(), d.dot(axis_)};
  }

 private:
  Vector3d center_, axis_, u_, v_;
};

/// |K| at the rim's points, by sector: the mean of those that fall into it.
std::vector<double> RimCurvature(const perception::Scene& scene,
                                 const perception::PerceivedObject& object,
                                 const Cylindrical& polar, std::size_t sectors) {
  std::vector<double> sum(sectors, 0.0);
  std::vector<double> count(sectors, 0.0);
  if (!object.top || object.points.size() < 6) return sum;
  const geometry::Points points = geometry::Select(scene.cloud.points, object.points);
  const geometry::KdTree tree(points);
  std::vector<geometry::KdTree::Neighbor> found;
  geometry::Points neighbors;
  for (const std::uint32_t i : object.top->rim) {
    const Vector3d& p = scene.cloud.points[i];
    tree.Within(p, kNeighborhood_m, found);
    neighbors.clear();
    for (const auto& neighbor : found) neighbors.push_back(points[neighbor.index]);
    const auto curvature = GaussianCurvature(neighbors, p);
    if (!curvature) continue;
    const double turn = polar(p).angle_rad / (2.0 * core::kPi);
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
std::vector<Polar> WallPoints(geometry::PointSpan points, const Cylindrical& polar,
                              double rim_radius_m) {
  std::vector<Polar> wall;
  for (const Vector3d& p : points) {
    const Polar q = polar(p);
    if (q.height_m > 0.002 || q.height_m < -0.020) continue;
    if (std::abs(q.radius_m - rim_radius_m) <= kThickestWall_m) wall.push_back(q);
  }
  return wall;
}

/// Inner and outer radius of the wall near an angle.
void MeasureWall(const std::vector<Polar>& wall, double rim_radius_m, RimSector& sector) {
  double inner = 1e9;
  double outer = 0.0;
  for (const Polar& p : wall) {
    const double apart = std::abs(p.angle_rad - sector.angle_rad);
    if (std::min(apart, std::abs(2.0 * core::kPi - apart)) > 0.2) continue;
    inner = std::min(inner, p.radius_m);
    outer = std::max(outer, p.radius_m);
  }
  const bool seen = outer > inner + 0.002;
  sector.wall_m = seen ? outer - inner : kAssumedWall_m;
  sector.radius_m = seen ? 0.5 * (outer + inner) : rim_radius_m - 0.5 * kAssumedWall_m;
}

}  // namespace

std::vector<RimSector> DescribeRim(const perception::Scene& scene,
                                   const perception::PerceivedObject& object,
                                   const Vector3d& axis_C, const Vector3d& zero_C, int sectors) {
  const Cylindrical polar(*object.axis, axis_C, zero_C);
  const auto n = static_cast<std::size_t>(sectors);
  const auto wall = WallPoints(object.completed_C, polar, object.axis->radius_m);
  std::vector<RimSector> rim(n);
  std::vector<double> angles(n);
  for (std::size_t k = 0; k < n; ++k) {
    angles[k] = 2.0 * core::kPi * static_cast<double>(k) / static_cast<double>(sectors);
    rim[k].angle_rad = angles[k];
    MeasureWall(wall, object.axis->radius_m, rim[k]);
  }
  const std::vector<double> curvature =
      SmoothAround(angles, RimCurvature(scene, object, polar, n), kSmooth_rad);
  const double strongest = *std::max_element(curvature.begin(), curvature.end());
  if (strongest <= 0.0) return rim;
  for (std::size_t k = 0; k < n; ++k) rim[k].curvature = curvature[k] / strongest;
  return rim;
}

namespace internal {
namespace {

constexpr double kGripDepth_m = 0.014;  // pads' middle below the rim
constexpr double kTipDepth_m = 0.015;   // of a tip grasp across a closed top
constexpr double kRimOpen_m = 0.026;    // wider than the wall, before closing

/// The wall between the pads at one sector. `out`: the thumb's side, +1 outside, -1 in the cavity.
Candidate WallCandidate(Task& task, const SurfaceSamples& samples, const RimSector& sector,
                        const Vector3d& axis, const Vector3d& radial, double out, double pitch) {
  const View view = MakeView(task, samples, task.object.axis->center_C, -axis, out * radial);
  const std::size_t open = StateAtGap(task.hand, sector.wall_m + kRimOpen_m);
  const std::size_t held = StateAtGap(task.hand, sector.wall_m);
  const Vector3d pads = task.profiles.PadCenter_T(pitch, held);
  Vector3d origin(out * sector.radius_m - pads.x(), -pads.y(), 0.0);
  const double limit = std::min(TableLimit(view, ReachDown(task, view, pitch, open, held),
                                           origin.x(), origin.y(), task.options.table_clearance_m),
                                DescentLimit(view, task.profiles.LowerSide(pitch, open), origin.x(),
                                             origin.y(), task.options.object_clearance_m));
  origin.z() = std::min(limit, kGripDepth_m - pads.z());
  Candidate candidate = MakeCandidate(task, view, origin, origin + pads, pitch, GraspType::kRim);
  candidate.open_state = candidate.narrow_state = open;
  candidate.held_state = held;
  candidate.grasp.opening_m = task.hand.states[open].gap_m;
  candidate.grasp.width_m = sector.wall_m;
  const double near_arm = 0.5 * (1.0 + std::cos(sector.angle_rad));
  // Two fingers outside bear better on the convex side than on the concave one.
  candidate.grasp.score = 0.5 * sector.curvature + 0.5 * near_arm + (out < 0.0 ? 0.1 : 0.0) -
                          50.0 * std::max(0.0, kGripDepth_m - pads.z() - origin.z());
  return candidate;
}

std::vector<Candidate> OpenRim(Task& task, const Vector3d& axis, const Vector3d& zero) {
  // The points themselves: the surface may close the cavity.
  SurfaceSamples samples;
  const geometry::TriangleMesh specks = SpeckMesh(task.object.completed_C, 0.004);
  for (std::size_t i = 0; i < specks.vertices.size(); i += 3) {
    samples.points.push_back(specks.vertices[i]);
    samples.normals.push_back(axis);
  }
  std::vector<Candidate> candidates;
  const auto rim = DescribeRim(task.scene, task.object, axis, zero, task.options.yaw_steps);
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const Vector3d radial = Eigen::AngleAxisd(rim[k].angle_rad, axis) * zero;
    for (const double out : {-1.0, 1.0}) {
      candidates.push_back(WallCandidate(task, samples, rim[k], axis, radial, out, 0.0));
      candidates.back().group = static_cast<int>(k);
    }
  }
  return candidates;
}

/// A closed top has no wall to hold: the tips close on two opposite points of the rim instead.
std::vector<Candidate> ClosedRim(Task& task, const Vector3d& axis, const Vector3d& zero) {
  std::vector<Candidate> candidates;
  const auto rim = DescribeRim(task.scene, task.object, axis, zero, task.options.yaw_steps);
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const View view = MakeView(task, task.coarse, task.object.axis->center_C, -axis,
                               Eigen::AngleAxisd(rim[k].angle_rad, axis) * zero);
    const double pitch = task.options.refine ? task.options.cylinder_pitch_rad : 0.0;
    const Aim aim{pitch, pitch, view.top_m + kTipDepth_m};
    auto candidate = Place(task, view, MakeBand(task, view, 0.0), aim, GraspType::kRim);
    if (!candidate) continue;
    candidate->group = static_cast<int>(k);
    candidate->grasp.score = 0.5 * rim[k].curvature + 0.5 * view.thumb_to_arm;
    candidates.push_back(*candidate);
  }
  return candidates;
}

}  // namespace

std::vector<Candidate> RimCandidates(Task& task) {
  const auto axis = UprightAxis(task);
  if (!axis) return {};
  const Vector3d zero = NormalPart(task.arm_C - task.object.axis->center_C, *axis);
  return task.object.open ? OpenRim(task, *axis, zero) : ClosedRim(task, *axis, zero);
}

}  // namespace internal
}  // namespace rangegrasp::grasp
