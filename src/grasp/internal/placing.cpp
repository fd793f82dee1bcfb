#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {
namespace {

/// A vector's part normal to an axis below this share is rounding; any normal is used then.
constexpr double kMinPart = 1e-6;
/// The limit [m] if the hand meets nothing on its way down.
constexpr double kNoLimit_m = 1e9;

Quality QualityOf(const Task& task, const View& view, const Aim& aim, const Closing& closing,
                  const Vector3d& origin_A, const Slab& slab) {
  const Vector3d& finger = closing.finger_T;
  const Vector3d& thumb = closing.thumb_T;
  const Vector3d middle = origin_A + 0.5 * (finger + thumb);
  return {.angles = Antipodal(finger, closing.finger_out_T, thumb, closing.thumb_out_T),
          .pitch_rad = aim.pitch_rad,
          .best_pitch_rad = aim.best_pitch_rad,
          .lever_m = std::abs(view.com.y() - middle.y()),
          .above_m = (middle - view.com).dot(view.up),
          .drag_m = closing.drag_m,
          .slope_m = (thumb - finger).dot(view.up),
          .finger_lean = closing.finger_out_T.z(),
          .thumb_lean = closing.thumb_out_T.z(),
          .top_margin_m = std::min(finger.z(), thumb.z()) + origin_A.z() - slab.top_m,
          .contact_m2 = closing.contact_m2,
          .room_m = task.hand.MaxGap() - closing.gap_m,
          .thumb_to_arm = view.thumb_to_arm};
}

double Square(double x) { return x * x; }

/// The extent that the hand passes; for an upper part, that of the deepest one that fits the jaws.
std::optional<Slab> PassedSlab(const Task& task, const View& view, const Band& band,
                               const Aim& aim) {
  const PlacingOptions& options = task.options.placing;
  double reach_m = task.hand.depth_m + options.swing_m;
  auto slab = SlabAt(view, band.y_m, options.hand_band_m, reach_m);
  while (aim.upper_part && slab && slab->Width() > task.MaxWidth()) {
    reach_m -= options.upper_step_m;
    if (reach_m < options.min_depth_m) return std::nullopt;
    slab = SlabAt(view, band.y_m, options.hand_band_m, reach_m);
  }
  return slab;
}

/// The descending hand: values that do not change while it is centered.
struct Descent {
  std::size_t open;
  const HandProfiles::Lower& lower;
  double reach_m;
  Vector3d pads;  ///< in T when they hold: the middle of the pads, or the tool centre
};

/// Closes the hand at the aim's depth, or as deep as it can go. Each further round places it midway
/// between the contacts that the last one found.
std::optional<Closing> CloseCentered(Task& task, const View& view, const Band& band, const Aim& aim,
                                     const Descent& descent, Vector3d& origin) {
  const PlacingOptions& options = task.options.placing;
  for (int round = 0;; ++round) {
    const double limit =
        DepthLimit(task, view, descent.lower, descent.reach_m, origin.x(), origin.y());
    origin.z() = std::min(limit, aim.depth_m - descent.pads.z()) - aim.back_off_m;
    auto closing = CloseOn(task.profiles, aim.pitch_rad, descent.open, band.points, band.normals,
                           task.samples.area_m2, origin);
    if (!task.options.centering || !closing || round == options.rounds - 1 ||
        std::abs(closing->drag_m) < options.centered_m) {
      return closing;
    }
    origin.x() -= closing->drag_m;
  }
}

/// Place with a known extent of the part that the hand passes, which is the same at every depth.
std::optional<Candidate> PlaceIn(Task& task, const View& view, const Band& band,
                                 const std::optional<Slab>& slab, const Aim& aim, GraspType type) {
  const PlacingOptions& options = task.options.placing;
  if (!slab) return std::nullopt;
  const double width_m = aim.width_m.value_or(slab->Width());
  if (width_m > task.MaxWidth()) return std::nullopt;
  const std::size_t open =
      task.options.preshape ? task.hand.IndexAtGap(width_m + options.opening_m) : 0;
  const std::size_t held = task.hand.IndexAtGap(width_m);
  const std::size_t last = std::min(held + 1, task.hand.states.size() - 1);
  const std::size_t narrow = task.options.narrow_openings
                                 ? task.hand.IndexAtGap(width_m + options.narrow_opening_m)
                                 : open;
  const bool centering = task.options.centering;
  const Descent descent{
      open, task.profiles.LowerSide(aim.pitch_rad, open),
      ReachDown(task, view, aim.pitch_rad, open, last),
      centering ? task.profiles.PadCenter_T(aim.pitch_rad, held)
                : task.profiles.ToolCenter_T(aim.pitch_rad, held, type == GraspType::kPower)};
  Vector3d origin((centering ? slab->Middle() : 0.0) - descent.pads.x(),
                  band.y_m - descent.pads.y(), 0.0);
  const auto closing = CloseCentered(task, view, band, aim, descent, origin);
  if (!closing && (centering || task.options.contact_ranking)) return std::nullopt;
  const Vector3d middle =
      centering ? Vector3d(0.5 * (closing->finger_T + closing->thumb_T)) : descent.pads;
  Candidate candidate = MakeCandidate(task, view, origin, origin + middle, aim.pitch_rad,
                                      {open, narrow, closing ? closing->state : held},
                                      closing ? closing->gap_m : width_m, type);
  candidate.depth_m = origin.z() + descent.pads.z();
  candidate.to_contact = aim.depth_m == kToContact_m;
  if (closing) {
    // The "tightest" side has the largest area of surface against the closed fingers (section 5.2
    // leaves the measure open).
    candidate.grasp.score = closing->contact_m2 / task.options.score.contact_scale_m2;
    candidate.grasp.quality = QualityOf(task, view, aim, *closing, origin, *slab);
    if (task.options.contact_ranking) {
      candidate.grasp.score =
          Score(candidate.grasp.quality, task.options.friction_cone_rad, task.options.score);
    }
  }
  return candidate;
}

std::vector<double> LiftsOf(const Task& task, const Candidate& candidate) {
  const PlacingOptions& options = task.options.placing;
  std::vector<double> lifts(options.lifts_m.begin(), options.lifts_m.end());
  if (!candidate.to_contact) return lifts;
  for (int i = 0; i < options.contact_steps; ++i) {
    lifts.push_back(lifts.back() + options.contact_step_m);
  }
  return lifts;
}

/// Whether it is free, in place or a little higher (PlacingOptions::lifts_m); sets its opening.
bool IsFree(const HandCollider& collider, const Task& task, Candidate& candidate) {
  const Vector3d approach = candidate.grasp.X_CG.linear().col(2);
  for (const double lift : LiftsOf(task, candidate)) {
    Pose X_CH = candidate.grasp.X_CH;
    X_CH.translation() -= lift * approach;
    if (HitsTableClosing(collider, task.hand, X_CH, candidate.states)) {
      if (candidate.to_contact) continue;
      return false;
    }
    if (collider.HitsObstacle(X_CH, candidate.states.held)) return false;
    const auto opening = FreeOpening(collider, X_CH, candidate.states);
    if (!opening) {
      // Down to its own object; the others are checked there (section 5.2).
      if (candidate.to_contact && !collider.HitsOwn(X_CH, candidate.states.narrow)) return false;
      continue;
    }
    candidate.grasp.opening_m = task.hand.states[*opening].gap_m;
    candidate.grasp.X_CH = X_CH;
    candidate.grasp.X_CG.translation() -= lift * approach;
    return true;
  }
  return false;
}

}  // namespace

double Score(const Quality& q, double friction_cone_rad, const ScoreWeights& w) {
  const double angle = q.angles.Larger();
  const double height_scale = q.above_m > 0.0 ? w.above_scale_m : w.below_scale_m;
  const double missing_margin = std::max(0.0, w.margin_m - q.top_margin_m) / w.margin_m;
  const double missing_room = std::clamp(1.0 - q.room_m / w.room_scale_m, 0.0, 1.0);
  const double off_pitch = (q.pitch_rad - q.best_pitch_rad) / w.pitch_scale_rad;
  return 1.0 - w.antipodal * std::min(Square(angle / friction_cone_rad), w.max_square) -
         w.pitch * std::min(Square(off_pitch), w.max_square) -
         w.lever * std::min(Square(q.lever_m / w.lever_scale_m), w.max_square) -
         w.height * std::min(Square(q.above_m / height_scale), w.max_multiple) -
         w.drag * std::min(std::abs(q.drag_m) / w.drag_scale_m, w.max_multiple) -
         w.slope * std::min(std::abs(q.slope_m) / w.slope_scale_m, w.max_multiple) -
         w.shallow * std::min(missing_margin, w.max_multiple) - w.room * Square(missing_room) +
         w.tight * std::min(q.contact_m2 / w.contact_scale_m2, 1.0) + w.arm * q.thumb_to_arm;
}

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

View MakeView(const Task& task, geometry::PointSpan coarse_C, const Vector3d& origin_C,
              const Vector3d& approach_C, const Vector3d& closing_C) {
  const Vector3d z = approach_C.normalized();
  const Vector3d x = NormalPart(closing_C, z);
  View view;
  view.X_CA = GraspFrame(origin_C, z, x);
  const Pose X_AC = view.X_CA.inverse();
  Eigen::AlignedBox3d box;
  view.coarse.reserve(coarse_C.size());
  for (const Vector3d& p_C : coarse_C) {
    view.coarse.push_back(X_AC * p_C);
    box.extend(view.coarse.back());
  }
  view.top_m = box.min().z();
  view.bottom_m = box.max().z();
  view.y_min_m = box.min().y();
  view.y_max_m = box.max().y();
  view.com = X_AC * task.com_C;
  view.up = X_AC.linear() * task.up_C;
  view.table_offset_m = task.scene.table.plane.Distance(origin_C);
  view.thumb_to_arm = x.dot(NormalPart(task.arm.base_C - origin_C, z));
  return view;
}

Band MakeBand(const Task& task, const View& view, double y0_m) {
  const PlacingOptions& options = task.options.placing;
  Band band;
  band.y_m = y0_m;
  const Pose X_AC = view.X_CA.inverse();
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
  // A level hand neither approaches the table on its way nor moves away from it.
  if (std::abs(view.up.z()) < kMinPart) return room >= 0.0 ? kNoLimit_m : -kNoLimit_m;
  return room / -view.up.z();
}

double DepthLimit(const Task& task, const View& view, const HandProfiles::Lower& lower,
                  double reach_m, double x_m, double y_m) {
  return std::min(TableLimit(view, reach_m, x_m, y_m, task.options.table_clearance_m),
                  DescentLimit(view, lower, x_m, y_m, task.options.object_clearance_m));
}

Candidate MakeCandidate(const Task& task, const View& view, const Vector3d& origin_A,
                        const Vector3d& center_A, double pitch_rad, const Openings& states,
                        double width_m, GraspType type) {
  const auto pose_at = [&](const Vector3d& p_A) {
    return base::MakePose(view.X_CA.linear(), view.X_CA * p_A);
  };
  return {.grasp = {.type = type,
                    .X_CG = pose_at(center_A),
                    .X_CH = pose_at(origin_A) * HandProfiles::X_TH(task.hand, pitch_rad),
                    .pitch_rad = pitch_rad,
                    .opening_m = task.hand.states[states.wide].gap_m,
                    .width_m = width_m},
          .states = states};
}

std::optional<Candidate> Place(Task& task, const View& view, const Band& band, const Aim& aim,
                               GraspType type) {
  return PlaceIn(task, view, band, PassedSlab(task, view, band, aim), aim, type);
}

void PlaceAtDepths(Task& task, const View& view, const Band& band, Aim aim,
                   std::span<const double> depths_m, GraspType type, int group,
                   std::vector<Candidate>& candidates) {
  const PlacingOptions& options = task.options.placing;
  const auto add = [&](const std::optional<Candidate>& candidate) {
    if (!candidate) return;
    candidates.push_back(*candidate);
    candidates.back().group = group;
  };
  const auto slab = PassedSlab(task, view, band, aim);
  double deepest = -kInfinity;
  for (const double depth : depths_m) {
    aim.depth_m = depth;
    const auto candidate = PlaceIn(task, view, band, slab, aim, type);
    // The hand stopped at the same thing as before.
    if (candidate && candidate->depth_m < deepest + options.same_depth_m) break;
    add(candidate);
    if (candidate) deepest = candidate->depth_m;
    if (!candidate || candidate->depth_m < depth - options.same_depth_m) break;
  }
  if (!task.options.depths || deepest > depths_m.front() - options.same_depth_m) return;
  aim.depth_m = depths_m.front();
  for (const double back_off : options.back_offs_m) {
    aim.back_off_m = back_off;
    if (deepest - back_off < view.top_m + options.min_depth_m) break;
    add(PlaceIn(task, view, band, slab, aim, type));
  }
}

std::optional<std::size_t> FreeOpening(const HandCollider& collider, const Pose& X_CH,
                                       const Openings& openings) {
  for (const std::size_t s : {openings.wide, openings.narrow}) {
    if (!collider.HitsObstacle(X_CH, s) && !collider.HitsOwn(X_CH, s)) return s;
    if (openings.narrow == openings.wide) break;
  }
  return std::nullopt;
}

bool HitsTableClosing(const HandCollider& collider, const HandModel& hand, const Pose& X_CH,
                      const Openings& openings) {
  const std::size_t last = std::min(openings.held + 1, hand.states.size() - 1);
  for (std::size_t s = openings.wide; s <= last; ++s) {
    if (collider.HitsTable(X_CH, s)) return true;
  }
  return false;
}

void ChooseFree(const HandCollider& collider, const Task& task, std::vector<Candidate> candidates,
                const Quota& quota, Collected& out) {
  std::ranges::stable_sort(candidates, std::ranges::greater(), ScoreOf);
  std::map<int, int> of_group;
  std::map<int, int> tried;
  const bool must_reach = task.options.reachable && task.arm.reaches;
  int taken = 0;
  int checks = 0;
  for (Candidate& candidate : candidates) {
    if (taken >= quota.max_free || checks >= quota.max_checks) break;
    if (of_group[candidate.group] >= quota.max_of_group) continue;
    ++checks;
    if (!IsFree(collider, task, candidate)) {
      candidate.grasp.collides = true;
      if (++tried[candidate.group] == 1) out.colliding.push_back(candidate.grasp);
    } else if (must_reach && !task.arm.reaches(candidate.grasp.X_CH)) {
      out.unreachable.push_back(candidate.grasp);
    } else {
      ++of_group[candidate.group];
      ++taken;
      out.free.push_back(candidate.grasp);
    }
  }
}

}  // namespace rangegrasp::grasp::internal
