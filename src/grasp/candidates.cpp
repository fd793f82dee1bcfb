#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "grasp/internal/candidates.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kHalfBand_m = 0.018;  // both fingers and the thumb lie within it
constexpr double kOpen_m = 0.020;      // wider than the object, before closing
constexpr double kNarrow_m = 0.008;    // where neighbours leave no more

double MiddleOf(const Slab& slab) { return 0.5 * (slab.x_min_m + slab.x_max_m); }

Quality QualityOf(const Task& task, const View& view, const Aim& aim, const Closing& closing,
                  const Vector3d& origin_A, const Slab& slab) {
  Quality q;
  q.angles = Antipodal(closing.finger_T, closing.finger_out_T, closing.thumb_T, closing.thumb_out_T);
  q.pitch_rad = aim.pitch_rad;
  q.best_pitch_rad = aim.best_pitch_rad;
  const Vector3d middle = origin_A + 0.5 * (closing.finger_T + closing.thumb_T);
  q.lever_m = std::abs(view.com.y() - middle.y());
  q.above_m = (middle - view.com).dot(view.up);
  q.drag_m = closing.drag_m;
  q.slope_m = (closing.thumb_T - closing.finger_T).dot(view.up);
  q.top_margin_m = std::min(closing.finger_T.z(), closing.thumb_T.z()) + origin_A.z() - slab.top_m;
  q.contact_m2 = closing.contact_m2;
  q.room_m = task.hand.MaxGap() - closing.gap_m;
  q.thumb_to_arm = view.thumb_to_arm;
  return q;
}

}  // namespace

Vector3d NormalPart(const Vector3d& v, const Vector3d& axis) {
  const Vector3d part = v - v.dot(axis) * axis;
  if (part.norm() > 1e-6 * std::max(1.0, v.norm())) return part.normalized();
  return axis.unitOrthogonal();
}

View MakeView(const Task& task, const Vector3d& origin_C, const Vector3d& approach_C,
              const Vector3d& closing_C) {
  const Vector3d z = approach_C.normalized();
  const Vector3d x = NormalPart(closing_C, z);
  Eigen::Matrix3d R_CA;
  R_CA << x, z.cross(x), z;
  View view;
  view.X_CA = core::MakePose(R_CA, origin_C);
  const core::Pose X_AC = view.X_CA.inverse();
  view.points.reserve(task.samples.points.size());
  view.normals.reserve(task.samples.points.size());
  view.top_m = view.y_min_m = 1e9;
  view.bottom_m = view.y_max_m = -1e9;
  for (std::size_t i = 0; i < task.samples.points.size(); ++i) {
    const Vector3d p = X_AC * task.samples.points[i];
    view.points.push_back(p);
    view.normals.push_back(X_AC.linear() * task.samples.normals[i]);
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

std::optional<Slab> SlabAt(const View& view, double y0_m, double half_band_m, double reach_m) {
  Slab slab;
  slab.top_m = 1e9;
  for (const Vector3d& p : view.points) {
    if (std::abs(p.y() - y0_m) <= half_band_m) slab.top_m = std::min(slab.top_m, p.z());
  }
  slab.x_min_m = 1e9;
  slab.x_max_m = -1e9;
  for (const Vector3d& p : view.points) {
    if (std::abs(p.y() - y0_m) > half_band_m || p.z() > slab.top_m + reach_m) continue;
    slab.x_min_m = std::min(slab.x_min_m, p.x());
    slab.x_max_m = std::max(slab.x_max_m, p.x());
  }
  if (slab.x_max_m <= slab.x_min_m) return std::nullopt;
  return slab;
}

double DescentLimit(const View& view, const HandProfiles::Lower& lower, double x_m, double y_m,
                    double clearance_m) {
  double limit = 1e9;
  for (const Vector3d& p : view.points) {
    const int cell = lower.grid.Cell(p.x() - x_m, p.y() - y_m);
    if (cell < 0) continue;
    limit = std::min(limit, p.z() - static_cast<double>(lower.z[static_cast<std::size_t>(cell)]));
  }
  return limit - clearance_m;
}

double TableLimit(Task& task, const View& view, double pitch_rad, std::size_t open,
                  std::size_t closed) {
  double extent = -1e9;
  for (std::size_t s = open; s <= std::max(open, closed); ++s) {
    extent = std::max(extent, task.profiles.Extent(pitch_rad, s, -view.up));
  }
  // Height of T's origin at z: table_offset + up . (x, y, z); x and y matter only where the approach
  // is tilted, and then by their share of up: the caller's final check is exact.
  const double fall = -view.up.z();
  return (view.table_offset_m - extent - task.options.table_clearance_m) / fall;
}

Candidate MakeCandidate(const Task& task, const View& view, const Vector3d& origin_A,
                        const Vector3d& center_A, double pitch_rad, GraspType type) {
  Candidate candidate;
  Grasp& grasp = candidate.grasp;
  grasp.type = type;
  grasp.pitch_rad = pitch_rad;
  grasp.X_CG = core::MakePose(view.X_CA.linear(), view.X_CA * center_A);
  grasp.X_CH = core::MakePose(view.X_CA.linear(), view.X_CA * origin_A) *
               HandProfiles::X_TH(task.hand, pitch_rad);
  return candidate;
}

std::optional<Candidate> Place(Task& task, const View& view, const Aim& aim, GraspType type) {
  const auto slab = SlabAt(view, aim.y_m, kHalfBand_m, task.hand.depth_m + 0.02);
  if (!slab || slab->Width() > task.MaxWidth()) return std::nullopt;
  const std::size_t open = StateAtGap(task.hand, slab->Width() + kOpen_m);
  std::size_t held = StateAtGap(task.hand, slab->Width());
  const HandProfiles::Lower& lower = task.profiles.LowerSide(aim.pitch_rad, open);
  const double table = TableLimit(task, view, aim.pitch_rad, open,
                                  std::min(held + 1, task.hand.states.size() - 1));
  Vector3d pads = task.profiles.PadCenter_T(aim.pitch_rad, held);
  Vector3d origin(MiddleOf(*slab) - pads.x(), aim.y_m - pads.y(), 0.0);
  std::optional<Closing> closing;
  // The second round stands midway between the contacts that the first one found, the third
  // confirms it.
  for (int round = 0; round < 3; ++round) {
    const double limit = std::min(
        table, DescentLimit(view, lower, origin.x(), origin.y(), task.options.object_clearance_m));
    origin.z() = std::min(limit, aim.depth_m - pads.z());
    closing = CloseOn(task.profiles, aim.pitch_rad, open, view.points, view.normals,
                      task.samples.area_m2, origin);
    if (!closing) return std::nullopt;
    if (round == 2 || std::abs(closing->drag_m) < 0.0005) break;
    origin.x() -= closing->drag_m;
  }
  const Vector3d center = origin + 0.5 * (closing->finger_T + closing->thumb_T);
  Candidate candidate = MakeCandidate(task, view, origin, center, aim.pitch_rad, type);
  candidate.open_state = open;
  candidate.narrow_state = StateAtGap(task.hand, slab->Width() + kNarrow_m);
  candidate.held_state = closing->state;
  candidate.grasp.opening_m = task.hand.states[open].gap_m;
  candidate.grasp.width_m = closing->gap_m;
  candidate.grasp.score = Score(QualityOf(task, view, aim, *closing, origin, *slab),
                                task.options.friction_cone_rad);
  return candidate;
}

namespace {

/// Tries the wide, then the narrow opening; true if one is free, and then it is the grasp's.
bool IsFree(const HandCollider& collider, const robot::HandModel& hand, Candidate& candidate) {
  const core::Pose& X_CH = candidate.grasp.X_CH;
  const std::size_t last = std::min(candidate.held_state + 1, hand.states.size() - 1);
  for (std::size_t s = candidate.open_state; s <= last; ++s) {
    if (collider.HitsTable(X_CH, s)) return false;
  }
  if (collider.HitsObstacle(X_CH, candidate.held_state)) return false;
  for (const std::size_t s : {candidate.open_state, candidate.narrow_state}) {
    if (s != candidate.open_state && candidate.narrow_state == candidate.open_state) break;
    if (collider.HitsObstacle(X_CH, s) || collider.HitsOwn(X_CH, s)) continue;
    candidate.grasp.opening_m = hand.states[s].gap_m;
    return true;
  }
  return false;
}

}  // namespace

void Judge(const HandCollider& collider, const robot::HandModel& hand,
           std::vector<Candidate> candidates, const Quota& quota, std::vector<Grasp>& accepted,
           std::vector<Grasp>& rejected) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.grasp.score > b.grasp.score;
  });
  std::map<int, int> of_group;
  std::map<int, int> tried;
  int taken = 0;
  int checks = 0;
  for (Candidate& candidate : candidates) {
    if (taken >= quota.most || checks >= quota.checks) break;
    if (of_group[candidate.group] >= quota.each) continue;
    ++checks;
    if (IsFree(collider, hand, candidate)) {
      ++of_group[candidate.group];
      ++taken;
      accepted.push_back(candidate.grasp);
    } else if (++tried[candidate.group] == 1) {
      candidate.grasp.collides = true;
      rejected.push_back(candidate.grasp);
    }
  }
}

}  // namespace rangegrasp::grasp::internal
