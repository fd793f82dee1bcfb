#include "recognition/views/next_view.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <ranges>

#include "robot/ik.h"

namespace rangegrasp::views {
namespace {

/// A sensor pose and the gain expected from it.
struct Candidate {
  base::Pose X_CS;
  double gain_m3 = 0.0;
};

base::Pose LookingAt(const Eigen::Vector3d& center_C, const Eigen::Vector3d& away_C,
                     double distance_m) {
  const Eigen::Vector3d z = -away_C;
  // The right axis is horizontal; when looking straight down, it is arbitrary.
  Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ());
  x = x.norm() < 1e-6 ? Eigen::Vector3d::UnitX() : x.normalized().eval();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return base::MakePose(R, center_C + distance_m * away_C);
}

std::vector<Candidate> ByGain(const geometry::SeenSpace& space, const ViewRequest& request,
                              const NextViewOptions& options) {
  std::vector<Candidate> candidates;
  for (const base::Pose& X_CS : PosesAbout(request.region_C.center(), options)) {
    const double gain_m3 = space.GainFrom(X_CS, request.field, request.region_C, options.depth_m);
    if (gain_m3 >= options.min_gain_m3) candidates.push_back({X_CS, gain_m3});
  }
  std::ranges::stable_sort(candidates, std::greater{}, &Candidate::gain_m3);
  return candidates;
}

geometry::SeenSpace SpaceOf(const geometry::Observation& so_far, const Eigen::AlignedBox3d& box_C,
                            double cell_m) {
  geometry::SeenSpace space(box_C, cell_m);
  for (const geometry::View& view : so_far.views) space.Add(view);
  return space;
}

/// Plans motions of the arm to poses of the sensor.
class Reach {
 public:
  /// @param space  motions avoid what is not free in it
  Reach(const robot::Robot& robot, const geometry::SeenSpace& space, const ViewRequest& request,
        const NextViewOptions& options, const planning::PlanOptions& planning, base::Rng& rng)
      : robot_(robot), request_(request), options_(options), planner_(robot, planning), rng_(rng) {
    planning::PlanningScene scene;
    scene.table_z_m = request.obstacles_C.min().z();
    scene.obstacles_W.push_back(space.Ceiling(options.clearance_m));
    planner_.SetScene(std::move(scene));
  }

  /// Tries turns about the line of sight and configurations, those that move the arm least first.
  std::optional<PlannedView> To(const Candidate& candidate) {
    std::vector<PlannedView> views;
    for (int roll = 0; roll < options_.rolls; ++roll) {
      const Eigen::AngleAxisd turn(roll * 2.0 * base::kPi / options_.rolls,
                                   Eigen::Vector3d::UnitZ());
      const base::Pose X_CS = candidate.X_CS * turn;
      for (Eigen::VectorXd& q : Configurations(X_CS)) {
        views.push_back({std::move(q), X_CS, {}, candidate.gain_m3, 0.0});
      }
    }
    std::ranges::stable_sort(views, std::less{},
                             [this](const PlannedView& view) { return Travel(view.q); });
    constexpr int kPlans = 3;  // per position: what blocks one motion usually blocks the others
    for (PlannedView& view : views | std::views::take(kPlans)) {
      auto way = planner_.PlanMotion(request_.q_now, view.q, rng_);
      if (!way) continue;
      view.way = std::move(*way);
      return std::move(view);
    }
    return std::nullopt;
  }

 private:
  std::vector<Eigen::VectorXd> Configurations(const base::Pose& X_CS) {
    robot::IkOptions ik;
    ik.max_solutions = static_cast<std::size_t>(options_.ik_solutions);
    ik.starts = 2 * options_.ik_solutions;
    auto found = robot::SolveIk(robot_, X_CS * request_.X_HS.inverse(), request_.q_now, ik, rng_);
    std::erase_if(found, [this](const Eigen::VectorXd& q) { return !planner_.IsFree(q); });
    return found;
  }

  double Travel(const Eigen::VectorXd& q) const {
    return ((q - request_.q_now).array().abs() / robot_.velocity.array()).maxCoeff();
  }

  const robot::Robot& robot_;
  const ViewRequest& request_;
  const NextViewOptions& options_;
  planning::Planner planner_;
  base::Rng& rng_;
};

}  // namespace

std::vector<base::Pose> PosesAbout(const Eigen::Vector3d& center_C,
                                   const NextViewOptions& options) {
  std::vector<base::Pose> poses;
  for (const double distance_m : options.distances_m) {
    for (const double elevation : options.elevations_rad) {
      for (int i = 0; i < options.azimuths; ++i) {
        const double azimuth = i * 2.0 * base::kPi / options.azimuths;
        const Eigen::Vector3d away_C(std::cos(elevation) * std::cos(azimuth),
                                     std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        poses.push_back(LookingAt(center_C, away_C, distance_m));
      }
    }
  }
  return poses;
}

std::optional<PlannedView> NextBestView(const robot::Robot& robot,
                                        const geometry::Observation& so_far,
                                        const ViewRequest& request, const NextViewOptions& options,
                                        const planning::PlanOptions& planning, base::Rng& rng) {
  const geometry::SeenSpace space = SpaceOf(so_far, request.region_C, options.cell_m);
  const std::vector<Candidate> candidates = ByGain(space, request, options);
  if (candidates.empty()) return std::nullopt;
  Reach reach(robot, SpaceOf(so_far, request.obstacles_C, options.obstacle_cell_m), request,
              options, planning, rng);
  for (const Candidate& candidate : candidates | std::views::take(options.max_places)) {
    std::optional<PlannedView> view = reach.To(candidate);
    if (!view) continue;
    view->unseen_m3 = space.UnseenVolume();
    return view;
  }
  return std::nullopt;
}

}  // namespace rangegrasp::views
