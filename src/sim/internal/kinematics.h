#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>

#include "base/frames.h"

namespace rangegrasp::sim::internal {

/// What the engine's arrays hold, as Eigen sees it.
inline Eigen::Map<const Eigen::Vector3d> Vec3(const mjtNum* p) {
  return Eigen::Map<const Eigen::Vector3d>(p);
}
inline base::Pose PoseOf(const mjtNum* position, const mjtNum* rotation) {
  return base::MakePose(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation),
                        Vec3(position));
}

/// Poses in W as of the last kinematics.
inline base::Pose BodyPose(const mjData* data, int body) {
  return PoseOf(data->xpos + 3 * body, data->xmat + 9 * body);
}
inline base::Pose GeomPose(const mjData* data, int geom) {
  return PoseOf(data->geom_xpos + 3 * geom, data->geom_xmat + 9 * geom);
}
inline base::Pose SitePose(const mjData* data, int site) {
  return PoseOf(data->site_xpos + 3 * site, data->site_xmat + 9 * site);
}

/// Center of mass in W of a root body and all below it.
Eigen::Vector3d CenterOfMass(const mjModel* model, const mjData* data, int root);

}  // namespace rangegrasp::sim::internal
