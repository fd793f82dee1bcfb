#include "robot/planning/internal/joint_planner.h"

#include <ompl/base/ScopedState.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "robot/planning/internal/motion_check.h"

namespace rangegrasp::planning::internal {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using JointSpace = ob::RealVectorStateSpace;
using Path = std::vector<Eigen::VectorXd>;

/// Longest branch of a tree. Longer: fewer of them are free; shorter: more are needed.
constexpr double kTreeStep_rad = 0.6;
/// Shortcuts tried on a path. More: paths get a little shorter, at a check of an edge each.
constexpr int kShortcuts = 80;
/// A shortcut must be shorter by a thousandth, or rounding would be cut for ever.
constexpr double kWorthwhile = 0.999;

Eigen::Map<Eigen::VectorXd> Values(ob::State* state, Eigen::Index dof) {
  return {state->as<JointSpace::StateType>()->values, dof};
}
Eigen::Map<const Eigen::VectorXd> Values(const ob::State* state, Eigen::Index dof) {
  return {state->as<JointSpace::StateType>()->values, dof};
}

/// Draws from our own stream: OMPL's generators are seeded once for the whole process.
class Sampler : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, const robot::Robot& robot, const JointQuery& query,
          base::Rng& rng)
      : ob::StateSampler(space), robot_(robot), query_(query), rng_(rng) {}

  void sampleUniform(ob::State* state) override {
    Eigen::VectorXd q(robot_.dof());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      q[i] = rng_.Uniform(robot_.lower[i], robot_.upper[i]);
    }
    if (query_.project) query_.project(q);
    Values(state, q.size()) = q.cwiseMax(robot_.lower).cwiseMin(robot_.upper);
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    Eigen::VectorXd q = Values(near, robot_.dof());
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] += rng_.Uniform(-distance, distance);
    Values(state, q.size()) = q.cwiseMax(robot_.lower).cwiseMin(robot_.upper);
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    Eigen::VectorXd q = Values(mean, robot_.dof());
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] += deviation * rng_.Normal();
    Values(state, q.size()) = q.cwiseMax(robot_.lower).cwiseMin(robot_.upper);
  }

 private:
  const robot::Robot& robot_;
  const JointQuery& query_;
  base::Rng& rng_;
};

std::shared_ptr<JointSpace> MakeSpace(const robot::Robot& robot, const JointQuery& query,
                                      base::Rng& rng) {
  const auto dof = static_cast<unsigned int>(robot.dof());
  auto space = std::make_shared<JointSpace>(dof);
  ob::RealVectorBounds bounds(dof);
  for (unsigned int i = 0; i < dof; ++i) {
    bounds.setLow(i, robot.lower[i]);
    bounds.setHigh(i, robot.upper[i]);
  }
  space->setBounds(bounds);
  space->setLongestValidSegmentFraction(query.resolution_rad / space->getMaximumExtent());
  space->setStateSamplerAllocator(
      [&](const ob::StateSpace* s) { return std::make_shared<Sampler>(s, robot, query, rng); });
  return space;
}

std::optional<Path> SolveRrtConnect(const robot::Robot& robot, const JointQuery& query,
                                    base::Rng& rng) {
  ompl::msg::noOutputHandler();
  const Eigen::Index dof = robot.dof();
  const auto space = MakeSpace(robot, query, rng);
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      [&](const ob::State* state) { return query.free(Values(state, dof)); });
  information->setup();
  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<JointSpace> start(space);
  ob::ScopedState<JointSpace> goal(space);
  Values(start.get(), dof) = query.start;
  Values(goal.get(), dof) = query.goal;
  problem->setStartAndGoalStates(start, goal);

  og::RRTConnect planner(information);
  planner.setRange(kTreeStep_rad);
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setProblemDefinition(problem);
  planner.setup();
  int iterations = 0;
  const base::Stopwatch watch;
  const ob::PlannerTerminationCondition done(
      [&] { return ++iterations > query.iterations || watch.Seconds() > query.seconds; });
  if (planner.solve(done) != ob::PlannerStatus::EXACT_SOLUTION) return {};
  Path path;
  for (const ob::State* state : problem->getSolutionPath()->as<og::PathGeometric>()->getStates()) {
    path.emplace_back(Values(state, dof));
  }
  return path;
}

/// Joins two random points of the path by a straight line where that is free and shorter.
void Shortcut(const JointQuery& query, base::Rng& rng, Path& path) {
  for (int k = 0; k < kShortcuts && path.size() > 2; ++k) {
    const double last = static_cast<double>(path.size() - 1);
    double a = rng.Uniform(0.0, last);
    double b = rng.Uniform(0.0, last);
    if (a > b) std::swap(a, b);
    const auto i = static_cast<std::size_t>(a);
    const auto j = static_cast<std::size_t>(b);
    if (i == j) continue;
    const Eigen::VectorXd from = path[i] + (a - static_cast<double>(i)) * (path[i + 1] - path[i]);
    const Eigen::VectorXd to = path[j] + (b - static_cast<double>(j)) * (path[j + 1] - path[j]);
    double length = (path[i + 1] - from).norm() + (to - path[j]).norm();
    for (std::size_t n = i + 1; n < j; ++n) length += (path[n + 1] - path[n]).norm();
    if ((to - from).norm() > kWorthwhile * length ||
        !EdgeFree(query.free, from, to, query.resolution_rad))
      continue;
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(i) + 1,
               path.begin() + static_cast<std::ptrdiff_t>(j) + 1);
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(i) + 1, {from, to});
  }
}

}  // namespace

std::optional<Path> PlanJointPath(const robot::Robot& robot, const JointQuery& query,
                                  base::Rng& rng) {
  if (!query.free(query.start) || !query.free(query.goal)) return {};
  if (EdgeFree(query.free, query.start, query.goal, query.resolution_rad))
    return Path{query.start, query.goal};
  std::optional<Path> path = SolveRrtConnect(robot, query, rng);
  if (path) Shortcut(query, rng, *path);
  return path;
}

}  // namespace rangegrasp::planning::internal
