#include "grasp/internal/power_candidates.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "grasp/closing.h"

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// Cosine between approaches that are one: 2.6 deg.
constexpr double kSameApproach = 0.999;

/// An approach and a closing direction from above.
struct Direction {
  Vector3d approach;
  Vector3d closing;
};

/// The top surface's normal, away from the table.
Vector3d UpNormal(const Task& task) {
  const Vector3d& normal = task.object.top->plane.normal;
  return normal.dot(task.up_C) < 0.0 ? Vector3d(-normal) : normal;
}

/// The hand wide open over the top surface's centre, against its normal, both ways round, moved
/// down to contact: where nothing else is left, e.g. for what is wider than the hand.
std::vector<Candidate> OverTheTop(Task& task) {
  std::vector<Candidate> candidates;
  if (!task.object.top) return candidates;
  const perception::TopSurface& top = *task.object.top;
  for (const double side : {1.0, -1.0}) {
    const View view =
        MakeView(task, task.coarse, top.center_C, -UpNormal(task), side * top.minor_C);
    const Vector3d tool = task.profiles.ToolCenter_T(0.0, 0, true);
    Vector3d origin = -tool;
    const std::size_t last = task.hand.states.size() - 1;
    const std::size_t held = std::min(last, task.hand.IndexAtGap(top.minor_m) + 1);
    origin.z() = DepthLimit(task, view, task.profiles.LowerSide(0.0, 0),
                            ReachDown(task, view, 0.0, 0, held), origin.x(), origin.y());
    Candidate candidate = MakeCandidate(task, view, origin, origin + tool, 0.0, GraspType::kPower);
    SetStates(task, 0, held, top.minor_m, candidate);
    candidate.group = side > 0.0 ? 0 : 1;
    candidate.to_contact = true;
    candidates.push_back(candidate);
  }
  return candidates;
}

/// The direction normal to the approach along which the object is narrowest, from `first` in equal
/// steps of half a turn.
Vector3d Narrowest(const Task& task, const Vector3d& approach, const Vector3d& first) {
  const PowerOptions& options = task.options.power;
  Vector3d best = first;
  double min_width = kUnbounded;
  for (int k = 0; k < options.narrow_steps; ++k) {
    const double turn = base::Deg(180.0 * k / options.narrow_steps);
    const Vector3d x = Eigen::AngleAxisd(turn, approach) * first;
    double low = kUnbounded;
    double high = -kUnbounded;
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

/// Against the top surface, closing across its principal axis, from the left and the right.
std::vector<Direction> PublishedDirections(const Task& task) {
  if (!task.object.top) return {};
  const Vector3d approach = -UpNormal(task);
  return {{approach, task.object.top->minor_C}, {approach, -task.object.top->minor_C}};
}

/// Straight down, and against the top surface where that is tilted.
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

/// Leaning by an angle, from all round.
std::vector<Vector3d> LeaningApproaches(const Task& task, double lean_rad) {
  const int sides = task.options.power.crowded_sides;
  const Vector3d to_arm = NormalPart(task.arm_C - task.com_C, task.up_C);
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

/// The approaches; closing across the narrowest
/// side, the principal axis and the axis normal to it.
std::vector<Direction> Directions(const Task& task) {
  const PowerOptions& options = task.options.power;
  if (!task.options.directions) return PublishedDirections(task);
  std::vector<Direction> directions;
  for (const Vector3d& approach : Approaches(task)) {
    const Vector3d across = Across(task, approach);
    AddClosing(options, approach, Narrowest(task, approach, across), directions);
    AddClosing(options, approach, across, directions);
    AddClosing(options, approach, approach.cross(across), directions);
  }
  return directions;
}

/// Pads at the centre of mass, below it, and as deep as it goes; or down to contact alone.
std::vector<double> Depths(const Task& task, const View& view) {
  if (!task.options.depths) return {kToContact_m};
  return {view.com.z(), view.com.z() + task.options.power.below_center_m,
          0.5 * (view.com.z() + view.bottom_m)};
}

/// The pads from as little below the top as holds to the centre of mass.
std::vector<double> ShallowDepths(const Task& task, const View& view) {
  const int count = std::max(2, task.options.power.crowded_depths);
  const double shallow = view.top_m + task.options.placing.min_depth_m;
  const double step = std::max(0.0, view.com.z() - shallow) / (count - 1);
  std::vector<double> depths;
  for (int k = 0; k < count; ++k) depths.push_back(shallow + k * step);
  return depths;
}

/// The measured best pitch; level fingers without pitches.
double MainPitch(const Task& task) {
  return task.options.pitches ? task.options.power.pitch_rad : 0.0;
}

/// The best candidate's pitch, or the measured best one where there is none.
double BestPitch(const std::vector<Candidate>& candidates, double main_pitch_rad) {
  const auto best = std::max_element(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.grasp.score < b.grasp.score; });
  return best == candidates.end() ? main_pitch_rad : best->grasp.pitch_rad;
}

/// Where the hand stands along the closed fingers' row: at the centre of mass, or, without
/// centering, at the top surface's centre, which the view then has as its origin.
double MiddleOf(const Task& task, const View& view) {
  return task.options.centering || !task.object.top ? view.com.y() : 0.0;
}

/// One direction searched finely: pitches through the centre of mass, then offsets along the object
/// at the best of them.
void Search(Task& task, const View& view, int group, std::vector<Candidate>& candidates) {
  const PowerOptions& options = task.options.power;
  std::vector<Candidate> found;
  const double main = MainPitch(task);
  const double y0 = MiddleOf(task, view);
  if (task.options.pitches) {
    const Band middle = MakeBand(task, view, y0);
    for (const double pitch : options.pitches_rad) {
      PlaceAtDepths(task, view, middle, {pitch, main}, Depths(task, view), GraspType::kPower, group,
                    found);
    }
  }
  candidates.insert(candidates.end(), found.begin(), found.end());
  for (const Candidate& c : candidates) {
    if (c.group == group) found.push_back(c);
  }
  if (!task.options.offsets) return;
  const double pitch = BestPitch(found, main);
  for (const double offset : options.offsets_m) {
    const double y = y0 + offset;
    if (y < view.y_min_m + options.end_m || y > view.y_max_m - options.end_m) continue;
    PlaceAtDepths(task, view, MakeBand(task, view, y), {pitch, main}, Depths(task, view),
                  GraspType::kPower, group, candidates);
  }
}

std::vector<Candidate> SearchedCandidates(Task& task) {
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
    double best = -kUnbounded;
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
  std::vector<Candidate> candidates = SearchedCandidates(task);
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
  // From all round there is always something to close on; what slips for sure is no grasp.
  std::erase_if(candidates, [&](const Candidate& candidate) {
    return candidate.grasp.contact_angle_rad > task.options.friction_cone_rad;
  });
  return candidates;
}

}  // namespace rangegrasp::grasp::internal
