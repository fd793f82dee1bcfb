#include "grasp/internal/candidates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/units.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kBand_m = 0.022;        // half; the hand's pads and a little more
constexpr double kHalfBand_m = 0.018;    // both fingers and the thumb lie within it
constexpr double kLeastDepth_m = 0.010;  // of the pads' middle below the top
constexpr double kOpen_m = 0.020;        // wider than the object, before closing
constexpr double kNarrow_m = 0.008;      // where neighbours leave no more

double MiddleOf(const Slab& slab) { return 0.5 * (slab.x_min_m + slab.x_max_m); }

Quality QualityOf(const Task& task, const View& view, const Aim& aim, const Closing& closing,
                  const Vector3d& origin_A, const Slab& slab) {
  Quality q;
  q.angles =
      Antipodal(closing.finger_T, closing.finger_out_T, closing.thumb_T, closing.thumb_out_T);
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

std::optional<Vector3d> UprightAxis(const Task& task) {
  if (!task.object.axis) return std::nullopt;
  Vector3d axis = task.object.axis->direction_C.normalized();
  if (axis.dot(task.up_C) < 0.0) axis = -axis;
  if (axis.dot(task.up_C) < std::cos(core::Deg(45.0))) return std::nullopt;
  return axis;
}

View MakeView(const Task& task, const SurfaceSamples& coarse, const Vector3d& origin_C,
              const Vector3d& approach_C, const Vector3d& closing_C) {
  const Vector3d z = approach_C.normalized();
  const Vector3d x = NormalPart(closing_C, z);
  Eigen::Matrix3d R_CA;
  R_CA << x, z.cross(x), z;
  View view;
  view.X_CA = core::MakePose(R_CA, origin_C);
  const core::Pose X_AC = view.X_CA.inverse();
  view.coarse.reserve(coarse.points.size());
  view.top_m = view.y_min_m = 1e9;
  view.bottom_m = view.y_max_m = -1e9;
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
  Band band;
  band.y_m = y0_m;
  const core::Pose X_AC = view.X_CA.inverse();
  const Eigen::RowVector3d y_row = X_AC.linear().row(1);
  const double y_shift = X_AC.translation().y() - y0_m;
  const double deepest = view.top_m + 0.15;
  for (std::size_t i = 0; i < task.samples.points.size(); ++i) {
    if (std::abs(y_row * task.samples.points[i] + y_shift) > kBand_m) continue;
    const Vector3d p = X_AC * task.samples.points[i];
    if (p.z() > deepest) continue;
    band.points.push_back(p);
    band.normals.push_back(X_AC.linear() * task.samples.normals[i]);
  }
  return band;
}

std::optional<Slab> SlabAt(const View& view, double y0_m, double half_band_m, double reach_m) {
  Slab slab;
  slab.top_m = 1e9;
  for (const Vector3d& p : view.coarse) {
    if (std::abs(p.y() - y0_m) <= half_band_m) slab.top_m = std::min(slab.top_m, p.z());
  }
  slab.x_min_m = 1e9;
  slab.x_max_m = -1e9;
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
  double limit = 1e9;
  for (const Vector3d& p : view.coarse) {
    const int cell = lower.grid.Cell(p.x() - x_m, p.y() - y_m);
    if (cell < 0) continue;
    limit = std::min(limit, p.z() - static_cast<double>(lower.z[static_cast<std::size_t>(cell)]));
  }
  return limit - clearance_m;
}

double ReachDown(Task& task, const View& view, double pitch_rad, std::size_t open,
                 std::size_t closed) {
  double reach = -1e9;
  for (std::size_t s = open; s <= std::max(open, closed); ++s) {
    reach = std::max(reach, task.profiles.Extent(pitch_rad, s, -view.up));
  }
  return reach;
}

double TableLimit(const View& view, double reach_m, double x_m, double y_m, double clearance_m) {
  const double height_at_zero = view.table_offset_m + view.up.x() * x_m + view.up.y() * y_m;
  return (height_at_zero - reach_m - clearance_m) / -view.up.z();
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

std::optional<Candidate> Place(Task& task, const View& view, const Band& band, const Aim& aim,
                               GraspType type) {
  const auto slab = SlabAt(view, band.y_m, kHalfBand_m, task.hand.depth_m + 0.02);
  if (!slab || slab->Width() > task.MaxWidth()) return std::nullopt;
  const std::size_t open = StateAtGap(task.hand, slab->Width() + kOpen_m);
  const std::size_t held = StateAtGap(task.hand, slab->Width());
  const HandProfiles::Lower& lower = task.profiles.LowerSide(aim.pitch_rad, open);
  const double reach =
      ReachDown(task, view, aim.pitch_rad, open, std::min(held + 1, task.hand.states.size() - 1));
  const Vector3d pads = task.profiles.PadCenter_T(aim.pitch_rad, held);
  Vector3d origin(MiddleOf(*slab) - pads.x(), band.y_m - pads.y(), 0.0);
  std::optional<Closing> closing;
  // Every further round stands midway between the contacts that the last one found.
  for (int round = 0; round < 3; ++round) {
    const double limit = std::min(
        TableLimit(view, reach, origin.x(), origin.y(), task.options.table_clearance_m),
        DescentLimit(view, lower, origin.x(), origin.y(), task.options.object_clearance_m));
    origin.z() = std::min(limit, aim.depth_m - pads.z()) - aim.back_off_m;
    closing = CloseOn(task.profiles, aim.pitch_rad, open, band.points, band.normals,
                      task.samples.area_m2, origin);
    if (!closing) return std::nullopt;
    if (round == 2 || std::abs(closing->drag_m) < 0.001) break;
    origin.x() -= closing->drag_m;
  }
  const Vector3d center = origin + 0.5 * (closing->finger_T + closing->thumb_T);
  Candidate candidate = MakeCandidate(task, view, origin, center, aim.pitch_rad, type);
  candidate.open_state = open;
  candidate.narrow_state = StateAtGap(task.hand, slab->Width() + kNarrow_m);
  candidate.held_state = closing->state;
  candidate.depth_m = origin.z() + pads.z();
  candidate.grasp.opening_m = task.hand.states[open].gap_m;
  candidate.grasp.width_m = closing->gap_m;
  candidate.grasp.score =
      Score(QualityOf(task, view, aim, *closing, origin, *slab), task.options.friction_cone_rad);
  return candidate;
}

void PlaceAtDepths(Task& task, const View& view, const Band& band, Aim aim,
                   const std::vector<double>& depths_m, GraspType type, int group,
                   std::vector<Candidate>& candidates) {
  const auto add = [&](const std::optional<Candidate>& candidate) {
    if (!candidate) return;
    candidates.push_back(*candidate);
    candidates.back().group = group;
  };
  double deepest = -1e9;
  for (const double depth : depths_m) {
    aim.depth_m = depth;
    const auto candidate = Place(task, view, band, aim, type);
    if (candidate && candidate->depth_m < deepest + 0.003)
      break;  // it stopped where it had stopped
    add(candidate);
    if (candidate) deepest = candidate->depth_m;
    if (!candidate || candidate->depth_m < depth - 0.003) break;
  }
  if (deepest > depths_m.front() - 0.003) return;
  aim.depth_m = depths_m.front();
  for (const double back_off : {0.006, 0.012, 0.018}) {
    aim.back_off_m = back_off;
    if (deepest - back_off < view.top_m + kLeastDepth_m) break;
    add(Place(task, view, band, aim, type));
  }
}

namespace {

/// The wide opening, then the narrow one, that clears obstacles and the object itself.
std::optional<std::size_t> FreeOpening(const HandCollider& collider, const core::Pose& X_CH,
                                       const Candidate& candidate) {
  const bool one = candidate.narrow_state == candidate.open_state;
  for (const std::size_t s : {candidate.open_state, candidate.narrow_state}) {
    if (!collider.HitsObstacle(X_CH, s) && !collider.HitsOwn(X_CH, s)) return s;
    if (one) break;
  }
  return std::nullopt;
}

bool HitsTableClosing(const HandCollider& collider, const robot::HandModel& hand,
                      const core::Pose& X_CH, const Candidate& candidate) {
  const std::size_t last = std::min(candidate.held_state + 1, hand.states.size() - 1);
  for (std::size_t s = candidate.open_state; s <= last; ++s) {
    if (collider.HitsTable(X_CH, s)) return true;
  }
  return false;
}

/// True if the grasp is free; then its opening is set. The height fields that it was placed by are
/// sampled, the trees are not: where the hand grazes the object it goes up by up to 4 mm.
bool IsFree(const HandCollider& collider, const robot::HandModel& hand, Candidate& candidate) {
  const Vector3d approach = candidate.grasp.X_CG.linear().col(2);
  for (const double lift : {0.0, 0.002, 0.004}) {
    core::Pose X_CH = candidate.grasp.X_CH;
    X_CH.translation() -= lift * approach;
    if (HitsTableClosing(collider, hand, X_CH, candidate)) return false;
    if (collider.HitsObstacle(X_CH, candidate.held_state)) return false;
    const auto opening = FreeOpening(collider, X_CH, candidate);
    if (!opening) continue;
    candidate.grasp.opening_m = hand.states[*opening].gap_m;
    candidate.grasp.X_CH = X_CH;
    candidate.grasp.X_CG.translation() -= lift * approach;
    return true;
  }
  return false;
}

}  // namespace

void Judge(const HandCollider& collider, const robot::HandModel& hand,
           std::vector<Candidate> candidates, const Quota& quota, std::vector<Grasp>& accepted,
           std::vector<Grasp>& rejected) {
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.grasp.score > b.grasp.score; });
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
