#include "grasp/proposals.h"

#include <Eigen/Geometry>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "geometry/plane.h"
#include "grasp/internal/placing.h"

namespace rangegrasp::grasp {
namespace {

using base::Pose;
using Eigen::Vector3d;
using geometry::Indices;
using geometry::PointSpan;
using robot::HandModel;

std::size_t OpenState(double width_m, double room_m, const HandModel& hand,
                      const GraspOptions& options) {
  return options.preshape ? hand.IndexAtGap(width_m + room_m) : 0;
}

std::vector<double> Along(PointSpan points, const Vector3d& direction) {
  std::vector<double> along(points.size());
  std::ranges::transform(points, along.begin(),
                         [&](const Vector3d& p) { return direction.dot(p); });
  return along;
}

/// Used by ProposeStraightDown: the first depth and the height of the shipped examples' grasps.
constexpr double kPadsBelowTop_m = 0.030;
constexpr double kPadsAboveTable_m = 0.010;

/// The unit direction in the plane in which the points spread most.
Vector3d MajorInPlane(PointSpan points, const geometry::Plane& plane) {
  geometry::Points flat(points.begin(), points.end());
  for (Vector3d& p : flat) p = plane.Project(p);
  const auto axes = base::SymmetricEigen(geometry::Scatter(flat, geometry::Centroid(flat)));
  const Vector3d major = axes.vectors.col(2);
  return (major - plane.normal.dot(major) * plane.normal).normalized();
}

struct Bar {
  Vector3d middle_C;
  double width_m;
};

/// The gripped part lies within this of the handle's outermost point: a bar and its bends.
constexpr double kBar_m = 0.012;
/// Smallest width: points of one side measure too little, and no handle for people is thinner.
constexpr double kMinHandle_m = 0.008;
constexpr double kHandleStep_rad = 0.2618;  ///< angle between approaches: 15 deg
constexpr double kMaxRise_rad = 0.1745;  ///< upwards: the hand comes from above or level, to 10 deg

/// The outermost part of the handle; single outlying samples do not count.
Bar OuterBar(PointSpan handle, const Vector3d& out, const Vector3d& across) {
  const double end = base::QuantileOf(Along(handle, out), 0.98);
  geometry::Points bar(handle.begin(), handle.end());
  std::erase_if(bar, [&](const Vector3d& p) { return out.dot(p) < end - kBar_m; });
  const Vector3d mean = geometry::Centroid(bar);
  const auto along = Along(bar, across);
  const double low = base::QuantileOf(along, 0.05);
  const double high = base::QuantileOf(along, 0.95);
  return {mean + (0.5 * (low + high) - across.dot(mean)) * across,
          std::max(kMinHandle_m, high - low)};
}

Proposal Way(const Bar& bar, const Vector3d& approach, const Vector3d& closing, double score) {
  return {GraspFrame(bar.middle_C, approach, closing), bar.width_m, approach, score};
}

}  // namespace

Grasp PlaceHand(const Proposal& proposal, const HandModel& hand, const GraspOptions& options) {
  const HandModel::State& held = hand.AtGap(proposal.width_m);
  const Pose X_HG =
      base::MakePose(hand.X_HG_tip.linear(), 0.5 * (held.thumb_pad_H + held.finger_pad_H));
  const std::size_t open = OpenState(proposal.width_m, options.placing.opening_m, hand, options);
  return {.X_CG = proposal.X_CG,
          .X_CH = proposal.X_CG * X_HG.inverse(),
          .opening_m = hand.states[open].gap_m,
          .width_m = proposal.width_m,
          .score = proposal.score,
          .collides = proposal.width_m > hand.MaxGap()};
}

Indices BetweenFingers(const Grasp& grasp, const HandModel& hand, PointSpan points_C) {
  const Pose X_GC = grasp.X_CG.inverse();
  const Pose X_GH = X_GC * grasp.X_CH;
  const HandModel::State& open = hand.AtGap(grasp.opening_m);
  Eigen::AlignedBox3d box_G;
  for (std::size_t i = 0; i < open.shapes.size(); ++i) {
    if (!open.is_finger[i]) continue;
    for (const auto& vertex_H : geometry::Tessellate(open.shapes[i]).vertices) {
      box_G.extend(X_GH * vertex_H);
    }
  }
  return geometry::PositionsWhere(points_C,
                                  [&](const Vector3d& p_C) { return box_G.contains(X_GC * p_C); });
}

std::vector<Proposal> ProposeStraightDown(PointSpan points_C, const geometry::Plane& table_C) {
  if (points_C.size() < 3) return {};
  const Vector3d& up = table_C.normal;
  const Vector3d major = MajorInPlane(points_C, table_C);
  const Vector3d minor = up.cross(major);
  const auto along = std::ranges::minmax(Along(points_C, major));
  const auto across = std::ranges::minmax(Along(points_C, minor));
  const double top_m = std::ranges::max(Along(points_C, up)) + table_C.offset_m;
  const double height_m =
      std::max(top_m - kPadsBelowTop_m, std::min(kPadsAboveTable_m, 0.5 * top_m));
  const Bar bar{0.5 * (along.min + along.max) * major + 0.5 * (across.min + across.max) * minor +
                    (height_m - table_C.offset_m) * up,
                across.max - across.min};
  return {Way(bar, -up, minor, 0.0), Way(bar, -up, -minor, 0.0)};
}

void CheckProposals(const perception::Scene& scene, std::size_t object, const HandModel& hand,
                    const GraspOptions& options,
                    std::span<const geometry::TriangleMesh> obstacles_C,
                    std::vector<Grasp>& grasps) {
  const collision::HandCollider collider(hand, Others(scene, object, obstacles_C),
                                         SurfaceOf(scene.objects[object]), scene.table.plane,
                                         {options.object_clearance_m, options.table_clearance_m});
  for (Grasp& grasp : grasps) {
    if (grasp.collides) continue;
    const internal::Openings openings{
        hand.IndexAtGap(grasp.opening_m),
        OpenState(grasp.width_m, options.placing.narrow_opening_m, hand, options),
        hand.IndexAtGap(grasp.width_m)};
    grasp.collides = internal::HitsTableClosing(collider, hand, grasp.X_CH, openings) ||
                     collider.HitsObstacle(grasp.X_CH, openings.held);
    if (grasp.collides) continue;
    const auto opening = internal::FreeOpening(collider, grasp.X_CH, openings);
    grasp.collides = !opening;
    if (opening) grasp.opening_m = hand.states[*opening].gap_m;
  }
}

std::vector<Proposal> ProposeHandleGrasps(PointSpan handle_C, const Vector3d& body_C,
                                          const Vector3d& up_C) {
  if (handle_C.size() < 3) return {};
  const Vector3d mean = geometry::Centroid(handle_C);
  const Vector3d across = base::SymmetricEigen(geometry::Scatter(handle_C, mean)).vectors.col(0);
  const Vector3d from_body = mean - body_C;
  const Vector3d out = (from_body - across.dot(from_body) * across).normalized();
  const Bar bar = OuterBar(handle_C, out, across);
  std::vector<Proposal> ways;
  const int steps = static_cast<int>(std::lround(base::kPi / kHandleStep_rad));
  for (int k = -steps; k < steps; ++k) {
    const Vector3d approach = Eigen::AngleAxisd(k * kHandleStep_rad, across) * -out;
    const double down = -approach.dot(up_C);
    // The hand cannot come through the body or through the table.
    if (approach.dot(out) > 0.1 || down < -std::sin(kMaxRise_rad)) continue;
    for (const double sign : {1.0, -1.0}) ways.push_back(Way(bar, approach, sign * across, down));
  }
  std::ranges::stable_sort(ways, std::ranges::greater(), &Proposal::score);
  return ways;
}

}  // namespace rangegrasp::grasp
