#include "sim/internal/kinematics.h"

namespace rangegrasp::sim::internal {

Eigen::Vector3d CenterOfMass(const mjModel* model, const mjData* data, int root) {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int body = root; body < model->nbody && model->body_rootid[body] == root; ++body) {
    moment += model->body_mass[body] * Vec3(data->xipos + 3 * body);
  }
  return moment / model->body_subtreemass[root];
}

}  // namespace rangegrasp::sim::internal
