#pragma once

#include <Eigen/Core>
#include <vector>

namespace rangegrasp::base {

/// Joint positions sampled at a constant period; between samples they are interpolated linearly.
struct JointTrajectory {
  double period_s = 0.01;                  ///< > 0
  std::vector<Eigen::VectorXd> positions;  ///< [rad], one vector of the arm's joints a sample

  double Duration() const {
    return positions.size() < 2 ? 0.0 : period_s * static_cast<double>(positions.size() - 1);
  }
};

}  // namespace rangegrasp::base
