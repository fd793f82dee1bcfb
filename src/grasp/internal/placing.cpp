#include "grasp/internal/placing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grasp/closing.h"
#include "grasp/score.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

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

/// The extent that the hand passes; of an upper part, the deepest one that fits between the jaws.
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

/// The area of the object's surface against the closed fingers: the "tightest" side is the one
/// where it is largest (section 5.2 leaves the measure open).
double Tightness(const std::optional<Closing>& closing) {
  return closing ? closing->contact_m2 : 0.0;
}

/// The hand as it comes down: what does not change while it is centred.
struct Descent {
  std::size_t open;
  const HandProfiles::Lower& lower;
  double reach_m;
  Vector3d pads;  ///< middle of the pads, or the tool centre, in T when they hold
};

/// Closes the hand at the aim's depth, as deep as it may go, and moves it to midway between the
/// contacts. Every further round stands midway between those that the last one found.
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

}  // namespace

Candidate MakeCandidate(const Task& task, const View& view, const Vector3d& origin_A,
                        const Vector3d& center_A, double pitch_rad, GraspType type) {
  Candidate candidate;
  Grasp& grasp = candidate.grasp;
  grasp.type = type;
  grasp.pitch_rad = pitch_rad;
  grasp.X_CG = base::MakePose(view.X_CA.linear(), view.X_CA * center_A);
  grasp.X_CH = base::MakePose(view.X_CA.linear(), view.X_CA * origin_A) *
               HandProfiles::X_TH(task.hand, pitch_rad);
  return candidate;
}

void SetStates(const Task& task, std::size_t open, std::size_t held, double width_m,
               Candidate& candidate) {
  candidate.open_state = candidate.narrow_state = open;
  candidate.held_state = held;
  candidate.grasp.opening_m = task.hand.states[open].gap_m;
  candidate.grasp.width_m = width_m;
}

namespace {

/// Place, where the extent that the hand passes is known: it is the same at every depth.
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
  const Vector3d center = centering
                              ? Vector3d(origin + 0.5 * (closing->finger_T + closing->thumb_T))
                              : Vector3d(origin + descent.pads);
  Candidate candidate = MakeCandidate(task, view, origin, center, aim.pitch_rad, type);
  SetStates(task, open, closing ? closing->state : held, closing ? closing->gap_m : width_m,
            candidate);
  if (task.options.narrow_openings) {
    candidate.narrow_state = task.hand.IndexAtGap(width_m + options.narrow_opening_m);
  }
  candidate.depth_m = origin.z() + descent.pads.z();
  candidate.to_contact = aim.depth_m == kToContact_m;
  candidate.grasp.score = Tightness(closing) / task.options.score.contact_scale_m2;
  if (closing) {
    const Quality quality = QualityOf(task, view, aim, *closing, origin, *slab);
    candidate.grasp.contact_angle_rad =
        std::max(quality.angles.finger_rad, quality.angles.thumb_rad);
    if (task.options.contact_ranking) {
      candidate.grasp.score = Score(quality, task.options.friction_cone_rad, task.options.score);
    }
  }
  return candidate;
}

}  // namespace

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
  double deepest = -std::numeric_limits<double>::infinity();
  for (const double depth : depths_m) {
    aim.depth_m = depth;
    const auto candidate = PlaceIn(task, view, band, slab, aim, type);
    // It stopped where it had stopped.
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

}  // namespace rangegrasp::grasp::internal
