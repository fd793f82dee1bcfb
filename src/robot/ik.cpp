#include "robot/ik.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "robot/internal/ik_solver.h"

namespace rangegrasp::robot {
namespace {

/// Of the angles that differ by whole turns the one nearest to the seed's, within the limits: of a
/// joint with more than one turn.
void Unwind(const Eigen::VectorXd& seed, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
            Eigen::VectorXd& q) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double turned = q[i] + 2.0 * base::kPi * std::round((seed[i] - q[i]) / (2.0 * base::kPi));
    if (turned >= lower[i] && turned <= upper[i]) q[i] = turned;
  }
}

}  // namespace

std::vector<Eigen::VectorXd> SolveIk(const Robot& robot, const base::Pose& X_WH,
                                     const Eigen::VectorXd& seed, const IkOptions& options,
                                     base::Rng& rng) {
  const Eigen::VectorXd lower = robot.lower.array() + options.limit_margin_rad;
  const Eigen::VectorXd upper = robot.upper.array() - options.limit_margin_rad;
  const internal::IkTolerance tolerance{options.position_tolerance_m,
                                        options.rotation_tolerance_rad, options.iterations};
  std::vector<Eigen::VectorXd> solutions;
  for (int start = 0; start <= options.starts && solutions.size() < options.max_solutions;
       ++start) {
    Eigen::VectorXd q = seed.cwiseMax(lower).cwiseMin(upper);
    for (Eigen::Index i = 0; start > 0 && i < q.size(); ++i) q[i] = rng.Uniform(lower[i], upper[i]);
    if (!internal::RefineIk(robot, X_WH, lower, upper, tolerance, q)) continue;
    Unwind(seed, lower, upper, q);
    const bool known = std::any_of(solutions.begin(), solutions.end(), [&](const auto& other) {
      return (other - q).cwiseAbs().maxCoeff() < options.distinct_rad;
    });
    if (!known) solutions.push_back(q);
  }
  std::stable_sort(solutions.begin(), solutions.end(), [&](const auto& a, const auto& b) {
    return (a - seed).squaredNorm() < (b - seed).squaredNorm();
  });
  return solutions;
}

}  // namespace rangegrasp::robot
