#include "grasp/internal/power_candidates.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "grasp/closing.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Cosine between approaches that are one: 2.6 deg.
constexpr double kSameApproach = 0.999;

/// An approach and a closing direction from above.
struct Direction {
  Vector3d approach;
  Vector3d closing;
};

/// The area of the object's surface against the closed fingers: the "tightest" side is the one
/// where it is largest (section 5.2 leaves the measure open).
double Tightness(const std::optional<Closing>& closing) {
  return closing ? closing->contact_m2 : 0.0;
}

/// As published: tool centre in the top surface's centre, the hand against the surface's normal,
/// closing across the principal axis, moved down to contact.
Candidate Published(Task& task, const Direction& direction) {
  const perception::TopSurface& top = *task.object.top;
  const View view =
      MakeView(task, task.coarse, top.center_C, direction.approach, direction.closing);
  const core::Pose X_TG = HandProfiles::X_TH(task.hand, 0.0) * task.hand.X_HG_power;
  Vector3d origin = -X_TG.translation();
  const std::size_t last = task.hand.states.size() - 1;
  const std::size_t held = std::min(last, task.hand.IndexAtGap(top.minor_m) + 1);
  origin.z() = DepthLimit(task, view, task.profiles.LowerSide(0.0, 0),
                          ReachDown(task, view, 0.0, 0, held), origin.x(), origin.y());
  Candidate candidate =
      MakeCandidate(task, view, origin, origin + X_TG.translation(), 0.0, GraspType::kPower);
  const Band band = MakeBand(task, view, origin.y());
  const auto closing =
      CloseOn(task.profiles, 0.0, 0, band.points, band.normals, task.samples.area_m2, origin);
  SetStates(task, 0, closing ? closing->state : held, closing ? closing->gap_m : top.minor_m,
            candidate);
  candidate.grasp.score = Tightness(closing) / task.options.score.contact_scale_m2;
  return candidate;
}

std::vector<Candidate> PublishedCandidates(Task& task) {
  std::vector<Candidate> candidates;
  if (!task.object.top) return candidates;
  const perception::TopSurface& top = *task.object.top;
  Vector3d normal = top.plane.normal;
  if (normal.dot(task.up_C) < 0.0) normal = -normal;
  for (const double side : {1.0, -1.0}) {
    candidates.push_back(Published(task, {-normal, side * top.minor_C}));
    candidates.back().group = side > 0.0 ? 0 : 1;
  }
  return candidates;
}

/// The direction normal to the approach along which the object is narrowest, from `first` in equal
/// steps of half a turn.
Vector3d Narrowest(const Task& task, const Vector3d& approach, const Vector3d& first) {
  const PowerOptions& options = task.options.power;
  Vector3d best = first;
  double min_width = kInfinity;
  for (int k = 0; k < options.narrow_steps; ++k) {
    const double turn = core::Deg(180.0 * k / options.narrow_steps);
    const Vector3d x = Eigen::AngleAxisd(turn, approach) * first;
    double low = kInfinity;
    double high = -kInfinity;
    for (const Vector3d& p : task.coarse.points) {
      const double at = x.dot(p);
      low = std::min(low, at);
      high = std::max(high, at);
    }
    // Ties, as between all directions of a cylinder, go to the first.
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
  for (const Vector3d& p : task.coarse.points) {
    const Eigen::Vector2d q(u.dot(p - task.com_C), v.dot(p - task.com_C));
    covariance += q * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
  return axes.eigenvectors()(0, 0) * u + axes.eigenvectors()(1, 0) * v;
}

/// Adds a closing direction and its neighbors on both sides, both ways round, where no direction is
/// near yet.
void AddClosing(const PowerOptions& options, const Vector3d& approach, const Vector3d& closing,
                std::vector<Direction>& list) {
  for (const double turn : options.turns_rad) {
    const Vector3d x = Eigen::AngleAxisd(turn, approach) * closing;
    const bool known = std::any_of(list.begin(), list.end(), [&](const Direction& d) {
      return d.approach.dot(approach) > kSameApproach &&
             std::abs(d.closing.dot(x)) > std::cos(options.distinct_rad);
    });
    if (known) continue;
    list.push_back({approach, x});
    list.push_back({approach, -x});
  }
}

/// Straight down, and against the top surface where that is tilted; closing across the narrowest
/// side, the principal axis and the axis normal to it.
std::vector<Direction> Directions(const Task& task) {
  const PowerOptions& options = task.options.power;
  std::vector<Vector3d> approaches{-task.up_C};
  if (task.object.top) {
    Vector3d normal = task.object.top->plane.normal;
    if (normal.dot(task.up_C) < 0.0) normal = -normal;
    const double tilt = std::acos(std::min(1.0, normal.dot(task.up_C)));
    if (tilt > options.min_tilt_rad && tilt < options.max_tilt_rad) approaches.push_back(-normal);
  }
  std::vector<Direction> directions;
  for (const Vector3d& approach : approaches) {
    const Vector3d across = task.object.top ? NormalPart(task.object.top->minor_C, approach)
                                            : MinSpread(task, approach);
    AddClosing(options, approach, Narrowest(task, approach, across), directions);
    AddClosing(options, approach, across, directions);
    AddClosing(options, approach, approach.cross(across), directions);
  }
  return directions;
}

/// Pads at the centre of mass, below it, and as deep as it goes.
std::array<double, 3> Depths(const View& view, const PowerOptions& options) {
  return {view.com.z(), view.com.z() + options.below_center_m,
          0.5 * (view.com.z() + view.bottom_m)};
}

/// The best candidate's pitch, or the measured best one where there is none.
double BestPitch(const std::vector<Candidate>& candidates, const PowerOptions& options) {
  const auto best = std::max_element(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.grasp.score < b.grasp.score; });
  return best == candidates.end() ? options.pitch_rad : best->grasp.pitch_rad;
}

/// One direction searched finely: pitches through the centre of mass, then offsets along the object
/// at the best of them.
void Search(Task& task, const View& view, int group, std::vector<Candidate>& candidates) {
  const PowerOptions& options = task.options.power;
  std::vector<Candidate> found;
  const Band middle = MakeBand(task, view, view.com.y());
  for (const double pitch : options.pitches_rad) {
    PlaceAtDepths(task, view, middle, {pitch, options.pitch_rad}, Depths(view, options),
                  GraspType::kPower, group, found);
  }
  candidates.insert(candidates.end(), found.begin(), found.end());
  for (const Candidate& c : candidates) {
    if (c.group == group) found.push_back(c);
  }
  const double pitch = BestPitch(found, options);
  for (const double offset : options.offsets_m) {
    const double y = view.com.y() + offset;
    if (y < view.y_min_m + options.end_m || y > view.y_max_m - options.end_m) continue;
    PlaceAtDepths(task, view, MakeBand(task, view, y), {pitch, options.pitch_rad},
                  Depths(view, options), GraspType::kPower, group, candidates);
  }
}

std::vector<Candidate> RefinedCandidates(Task& task) {
  const PowerOptions& options = task.options.power;
  const std::vector<Direction> directions = Directions(task);
  std::vector<View> views;
  std::vector<std::pair<double, int>> order;
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < directions.size(); ++k) {
    views.push_back(
        MakeView(task, task.coarse, task.com_C, directions[k].approach, directions[k].closing));
    const View& view = views.back();
    const std::size_t before = candidates.size();
    PlaceAtDepths(task, view, MakeBand(task, view, view.com.y()),
                  {options.pitch_rad, options.pitch_rad}, Depths(view, options), GraspType::kPower,
                  static_cast<int>(k), candidates);
    double best = -kInfinity;
    for (std::size_t i = before; i < candidates.size(); ++i) {
      best = std::max(best, candidates[i].grasp.score);
    }
    order.emplace_back(-best, static_cast<int>(k));
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < std::min(order.size(), options.max_fine_directions); ++i) {
    const int k = order[i].second;
    Search(task, views[static_cast<std::size_t>(k)], k, candidates);
  }
  return candidates;
}

}  // namespace

std::vector<Candidate> PowerCandidates(Task& task) {
  if (!task.options.refine) return PublishedCandidates(task);
  std::vector<Candidate> candidates = RefinedCandidates(task);
  // Nothing fits the hand: the published pose is returned with its verdict.
  return candidates.empty() ? PublishedCandidates(task) : candidates;
}

}  // namespace rangegrasp::grasp::internal
