#include "recognition/views/next_view.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <ranges>

#include "robot/ik.h"

namespace rangegrasp::views {
namespace {

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

/// Poses of the sensor that are worth a motion, with their gains, highest first.
std::vector<PlannedView> ByGain(const geometry::SeenSpace& space, const ViewRequest& request,
                                const NextViewOptions& options) {
  std::vector<PlannedView> candidates;
  for (const base::Pose& X_CS : PosesAbout(request.region_C.center(), options)) {
    const double gain_m3 = space.GainFrom(X_CS, request.field, request.region_C, options.depth_m);
    if (gain_m3 >= options.min_gain_m3) candidates.push_back({{}, X_CS, {}, gain_m3});
  }
  std::ranges::stable_sort(candidates, std::greater{}, &PlannedView::gain_m3);
  return candidates;
}

/// The candidate's turns about the line of sight and the arm's free configurations there, those
/// that move the arm least first.
std::vector<PlannedView> WaysToHold(const PlannedView& candidate, const robot::Robot& robot,
                                    const planning::Planner& planner, const ViewRequest& request,
                                    const NextViewOptions& options, base::Rng& rng) {
  robot::IkOptions ik;
  ik.max_solutions = static_cast<std::size_t>(options.ik_solutions);
  ik.starts = 2 * options.ik_solutions;
  std::vector<PlannedView> views;
  for (int roll = 0; roll < options.rolls; ++roll) {
    const Eigen::AngleAxisd turn(roll * 2.0 * base::kPi / options.rolls, Eigen::Vector3d::UnitZ());
    const base::Pose X_CS = candidate.X_CS * turn;
    for (Eigen::VectorXd& q :
         robot::SolveIk(robot, X_CS * request.X_HS.inverse(), request.q_now, ik, rng)) {
      if (planner.IsFree(q)) views.push_back({std::move(q), X_CS, {}, candidate.gain_m3});
    }
  }
  std::ranges::stable_sort(views, std::less{}, [&](const PlannedView& view) {
    return ((view.q - request.q_now).array().abs() / robot.velocity.array()).maxCoeff();
  });
  return views;
}

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
  const geometry::SeenSpace space(request.region_C, options.cell_m, so_far);
  const std::vector<PlannedView> candidates = ByGain(space, request, options);
  if (candidates.empty()) return std::nullopt;
  planning::PlanningScene obstacles;  // all that is not free
  obstacles.table_z_m = request.obstacles_C.min().z();
  obstacles.obstacles_W.push_back(
      geometry::SeenSpace(request.obstacles_C, options.obstacle_cell_m, so_far)
          .Ceiling(options.clearance_m));
  planning::Planner planner(robot, planning);
  planner.SetScene(std::move(obstacles));
  constexpr int kPlans = 3;  // per position: what blocks one motion usually blocks the others
  for (const PlannedView& candidate : candidates | std::views::take(options.max_places)) {
    auto views = WaysToHold(candidate, robot, planner, request, options, rng);
    for (PlannedView& view : views | std::views::take(kPlans)) {
      auto way = planner.PlanMotion(request.q_now, view.q, rng);
      if (!way) continue;
      view.way = std::move(*way);
      view.unseen_m3 = space.UnseenVolume();
      return std::move(view);
    }
  }
  return std::nullopt;
}

}  // namespace rangegrasp::views
