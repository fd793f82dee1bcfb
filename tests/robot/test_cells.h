#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"
#include "robot/robot.h"

namespace rangegrasp {

inline std::filesystem::path SmallCell() {
  return std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "tests/data/small_cell.xml";
}
inline std::filesystem::path Tabletop() {
  return std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "scenes/tabletop.xml";
}
/// The small test cell and the shipped cell.
inline std::vector<std::filesystem::path> Cells() { return {SmallCell(), Tabletop()}; }

/// Cells with other arms: six joints with offsets, or seven with continuous joints, on a pedestal,
/// a wall or a ceiling.
inline std::filesystem::path OwnArm(const std::string& name) {
  return std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "tests/data/arms" / (name + ".xml");
}
inline std::vector<std::filesystem::path> AllCells() {
  return {SmallCell(), Tabletop(), OwnArm("six_on_wall"), OwnArm("seven_on_ceiling")};
}

inline std::string CellName(const std::filesystem::path& file) { return file.stem().string(); }

inline Eigen::VectorXd RandomJoints(const robot::Robot& robot, base::Rng& rng,
                                    double margin_rad = 0.02) {
  Eigen::VectorXd q(robot.dof());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q[i] = rng.Uniform(robot.lower[i] + margin_rad, robot.upper[i] - margin_rad);
  }
  return q;
}

/// The same scene loaded in MuJoCo, as the reference.
struct Reference {
  explicit Reference(const std::filesystem::path& file)
      : m(mj_loadXML(file.string().c_str(), nullptr, nullptr, 0), mj_deleteModel),
        d(m ? mj_makeData(m.get()) : nullptr, mj_deleteData) {}

  /// The id of the element whose name, after any prefix, is the given one.
  int Find(mjtObj type, const std::string& name) const {
    for (int id = 0;; ++id) {
      const char* full = mj_id2name(m.get(), type, id);
      if (full == nullptr) {
        if (id > 1000) return -1;
        continue;
      }
      const std::string s = full;
      if (s == name || s.ends_with("/" + name)) return id;
    }
  }
  std::vector<int> ArmJoints() const {
    const int tuple = Find(mjOBJ_TUPLE, "arm_joints");
    const int* ids = m->tuple_objid + m->tuple_adr[tuple];
    return {ids, ids + m->tuple_size[tuple]};
  }
  void SetArm(const Eigen::VectorXd& q) {
    const std::vector<int> joints = ArmJoints();
    for (std::size_t i = 0; i < joints.size(); ++i) d->qpos[m->jnt_qposadr[joints[i]]] = q[i];
  }
  base::Pose BodyPose(int body) const {
    base::Pose X = base::Pose::Identity();
    X.translation() = Eigen::Map<const Eigen::Vector3d>(d->xpos + 3 * body);
    X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d->xmat + 9 * body);
    return X;
  }

  std::unique_ptr<mjModel, void (*)(mjModel*)> m;
  std::unique_ptr<mjData, void (*)(mjData*)> d;
};

}  // namespace rangegrasp
