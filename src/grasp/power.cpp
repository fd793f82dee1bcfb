#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "grasp/internal/candidates.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kBestPitch_rad = 0.1396;  // 8 deg: boxes hold at 0 to 15, bottles at 5 to 8
constexpr std::size_t kDirections = 6;     // the most promising ones are searched finely
constexpr double kEnd_m = 0.012;           // pads stay this far from the object's ends

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
  const std::size_t held = std::min(last, StateAtGap(task.hand, top.minor_m) + 1);
  origin.z() = std::min(TableLimit(view, ReachDown(task, view, 0.0, 0, held), origin.x(),
                                   origin.y(), task.options.table_clearance_m),
                        DescentLimit(view, task.profiles.LowerSide(0.0, 0), origin.x(), origin.y(),
                                     task.options.object_clearance_m));
  Candidate candidate =
      MakeCandidate(task, view, origin, origin + X_TG.translation(), 0.0, GraspType::kPower);
  const Band band = MakeBand(task, view, origin.y());
  const auto closing =
      CloseOn(task.profiles, 0.0, 0, band.points, band.normals, task.samples.area_m2, origin);
  candidate.held_state = closing ? closing->state : held;
  candidate.grasp.opening_m = task.hand.MaxGap();
  candidate.grasp.width_m = closing ? closing->gap_m : top.minor_m;
  candidate.grasp.score = Tightness(closing) / ScoreWeights{}.contact_scale_m2;
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

/// The direction normal to the approach along which the object is narrowest, from `first` in steps
/// of 2 deg.
Vector3d Narrowest(const Task& task, const Vector3d& approach, const Vector3d& first) {
  Vector3d best = first;
  double least = 1e9;
  for (int k = 0; k < 90; ++k) {
    const Vector3d x = Eigen::AngleAxisd(core::Deg(2.0 * k), approach) * first;
    double low = 1e9;
    double high = -1e9;
    for (const Vector3d& p : task.coarse.points) {
      const double at = x.dot(p);
      low = std::min(low, at);
      high = std::max(high, at);
    }
    // Ties, as between all directions of a cylinder, go to the first.
    if (high - low < least - 0.0005) {
      least = high - low;
      best = x;
    }
  }
  return best;
}

/// The direction of least spread of the samples normal to the approach.
Vector3d LeastSpread(const Task& task, const Vector3d& approach) {
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

/// Adds a closing direction and its neighbours at +-15 deg, both ways round, where no direction
/// within 6 deg is there yet.
void AddClosing(const Vector3d& approach, const Vector3d& closing, std::vector<Direction>& list) {
  for (const double turn : {0.0, 15.0, -15.0}) {
    const Vector3d x = Eigen::AngleAxisd(core::Deg(turn), approach) * closing;
    const bool known = std::any_of(list.begin(), list.end(), [&](const Direction& d) {
      return d.approach.dot(approach) > 0.999 &&
             std::abs(d.closing.dot(x)) > std::cos(core::Deg(6.0));
    });
    if (known) continue;
    list.push_back({approach, x});
    list.push_back({approach, -x});
  }
}

/// Straight down, and against the top surface where that is tilted; closing across the narrowest
/// side, the principal axis and the axis normal to it.
std::vector<Direction> Directions(const Task& task) {
  std::vector<Vector3d> approaches{-task.up_C};
  if (task.object.top) {
    Vector3d normal = task.object.top->plane.normal;
    if (normal.dot(task.up_C) < 0.0) normal = -normal;
    const double tilt = std::acos(std::min(1.0, normal.dot(task.up_C)));
    if (tilt > core::Deg(8.0) && tilt < core::Deg(45.0)) approaches.push_back(-normal);
  }
  std::vector<Direction> directions;
  for (const Vector3d& approach : approaches) {
    const Vector3d across = task.object.top ? NormalPart(task.object.top->minor_C, approach)
                                            : LeastSpread(task, approach);
    AddClosing(approach, Narrowest(task, approach, across), directions);
    AddClosing(approach, across, directions);
    AddClosing(approach, approach.cross(across), directions);
  }
  return directions;
}

std::vector<double> Depths(const View& view) {
  // Pads at the centre of mass, below it, and as deep as it goes.
  return {view.com.z(), view.com.z() + 0.012, 0.5 * (view.com.z() + view.bottom_m)};
}

/// The best candidate's pitch, or the measured best one where there is none.
double BestPitch(const std::vector<Candidate>& candidates) {
  const auto best = std::max_element(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.grasp.score < b.grasp.score; });
  return best == candidates.end() ? kBestPitch_rad : best->grasp.pitch_rad;
}

/// One direction searched finely: pitches through the centre of mass, then offsets along the object
/// at the best of them.
void Search(Task& task, const View& view, int group, std::vector<Candidate>& candidates) {
  std::vector<Candidate> found;
  const Band middle = MakeBand(task, view, view.com.y());
  for (const double pitch : {0.0, core::Deg(4.0), core::Deg(13.0)}) {
    PlaceAtDepths(task, view, middle, {pitch, kBestPitch_rad}, Depths(view), GraspType::kPower,
                  group, found);
  }
  candidates.insert(candidates.end(), found.begin(), found.end());
  for (const Candidate& c : candidates) {
    if (c.group == group) found.push_back(c);
  }
  const double pitch = BestPitch(found);
  for (const double offset : {0.010, -0.010, 0.025, -0.025}) {
    const double y = view.com.y() + offset;
    if (y < view.y_min_m + kEnd_m || y > view.y_max_m - kEnd_m) continue;
    PlaceAtDepths(task, view, MakeBand(task, view, y), {pitch, kBestPitch_rad}, Depths(view),
                  GraspType::kPower, group, candidates);
  }
}

std::vector<Candidate> RefinedCandidates(Task& task) {
  const std::vector<Direction> directions = Directions(task);
  std::vector<View> views;
  std::vector<std::pair<double, int>> order;
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < directions.size(); ++k) {
    views.push_back(
        MakeView(task, task.coarse, task.com_C, directions[k].approach, directions[k].closing));
    const View& view = views.back();
    const std::size_t before = candidates.size();
    PlaceAtDepths(task, view, MakeBand(task, view, view.com.y()), {kBestPitch_rad, kBestPitch_rad},
                  Depths(view), GraspType::kPower, static_cast<int>(k), candidates);
    double best = -1e9;
    for (std::size_t i = before; i < candidates.size(); ++i) {
      best = std::max(best, candidates[i].grasp.score);
    }
    order.emplace_back(-best, static_cast<int>(k));
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < std::min(order.size(), kDirections); ++i) {
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
