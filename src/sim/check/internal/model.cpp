#include "sim/check/internal/model.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/words.h"
#include "robot/mjcf/names.h"
#include "sim/model.h"

namespace rangegrasp::check::internal {
namespace {

int Count(const mjModel& m, mjtObj type) {
  switch (type) {
    case mjOBJ_BODY:
      return static_cast<int>(m.nbody);
    case mjOBJ_JOINT:
      return static_cast<int>(m.njnt);
    case mjOBJ_GEOM:
      return static_cast<int>(m.ngeom);
    case mjOBJ_SITE:
      return static_cast<int>(m.nsite);
    case mjOBJ_CAMERA:
      return static_cast<int>(m.ncam);
    case mjOBJ_ACTUATOR:
      return static_cast<int>(m.nu);
    case mjOBJ_NUMERIC:
      return static_cast<int>(m.nnumeric);
    case mjOBJ_TUPLE:
      return static_cast<int>(m.ntuple);
    default:
      return 0;
  }
}

// Hinges from the world to a body, base to tip.
std::vector<int> HingesTo(const mjModel& m, int body) {
  std::vector<int> joints;
  for (; body > 0; body = m.body_parentid[body]) {
    for (int k = m.body_jntnum[body]; k-- > 0;) {
      const int joint = m.body_jntadr[body] + k;
      if (m.jnt_type[joint] == mjJNT_HINGE) joints.push_back(joint);
    }
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

}  // namespace

Model::Model(const std::filesystem::path& mjcf, Kind kind)
    : file_(mjcf), kind_(kind), lines_(mjcf), data_(nullptr, mj_deleteData) {
  std::vector<std::string> warnings;
  model_ = sim::CompileModel(mjcf, warnings);
  data_.reset(mj_makeData(model_.get()));
  FindArm();
  SetHome();
}

void Model::FindArm() {
  hand = Find(mjOBJ_BODY, "hand");
  if (!HasArm()) return;
  arm_joints = Tuple("arm_joints", mjOBJ_JOINT);
  guessed_joints = arm_joints.empty();
  if (guessed_joints && hand >= 0) arm_joints = HingesTo(m(), m().body_parentid[hand]);
  for (int body = 1; guessed_joints && hand < 0 && body < m().nbody; ++body) {
    const auto joints = HingesTo(m(), body);
    if (joints.size() > arm_joints.size()) arm_joints = joints;
  }
  arm_actuators = Tuple("arm_actuators", mjOBJ_ACTUATOR);
  for (std::size_t i = 0; arm_actuators.size() == i && i < arm_joints.size(); ++i) {
    for (int a = 0; a < m().nu; ++a) {
      if (m().actuator_trntype[a] != mjTRN_JOINT) continue;
      if (m().actuator_trnid[2 * a] != arm_joints[i]) continue;
      arm_actuators.push_back(a);
      break;
    }
  }
  if (arm_actuators.size() != arm_joints.size()) arm_actuators.clear();
  home = Numeric("home");
  if (home.size() != arm_joints.size()) home.clear();
}

void Model::SetHome() {
  for (std::size_t i = 0; i < arm_joints.size(); ++i) {
    const mjtNum* range = m().jnt_range + 2 * arm_joints[i];
    const double middle = m().jnt_limited[arm_joints[i]] ? 0.5 * (range[0] + range[1]) : 0.0;
    d().qpos[m().jnt_qposadr[arm_joints[i]]] = home.empty() ? middle : home[i];
  }
  mj_kinematics(&m(), &d());
  mj_comPos(&m(), &d());
}

std::string Model::Name(mjtObj type, int id) const {
  const char* name = mj_id2name(model_.get(), type, id);
  return name ? name : "";
}

std::vector<int> Model::FindAll(mjtObj type, std::string_view suffix) const {
  std::vector<int> ids;
  for (int id = 0; id < Count(m(), type); ++id) {
    const std::string name = Name(type, id);
    if (name.substr(name.find_last_of('/') + 1) == suffix) ids.push_back(id);
  }
  return ids;
}

int Model::Find(mjtObj type, std::string_view suffix) const {
  const auto ids = FindAll(type, suffix);
  return ids.empty() ? -1 : ids.front();
}

std::vector<int> Model::Tuple(std::string_view suffix, mjtObj type) const {
  const int id = Find(mjOBJ_TUPLE, suffix);
  if (id < 0) return {};
  const int* types = m().tuple_objtype + m().tuple_adr[id];
  const int* ids = m().tuple_objid + m().tuple_adr[id];
  const int size = m().tuple_size[id];
  if (!std::all_of(types, types + size, [&](int t) { return t == type; })) return {};
  return {ids, ids + size};
}

std::vector<double> Model::Numeric(std::string_view suffix) const {
  const int id = Find(mjOBJ_NUMERIC, suffix);
  if (id < 0) return {};
  const mjtNum* data = m().numeric_data + m().numeric_adr[id];
  return {data, data + m().numeric_size[id]};
}

std::string Model::Element(mjtObj type, int id) const {
  const std::string name = Name(type, id);
  if (name.empty() && type == mjOBJ_GEOM) {
    return fmt::format("a geom of body \"{}\"", BodyName(m().geom_bodyid[id]));
  }
  return fmt::format("{} \"{}\"", mju_type2Str(type), name);
}

std::string Model::Where(mjtObj type, int id) const {
  const std::string name = Name(type, id);
  if (name.empty() && type == mjOBJ_GEOM) return Where(mjOBJ_BODY, m().geom_bodyid[id]);
  return lines_.Of(mju_type2Str(type), name);
}

std::string Model::WhereMesh(int mesh) const { return lines_.Of("mesh", Name(mjOBJ_MESH, mesh)); }

std::string Model::ArmFile() const {
  if (arm_joints.empty()) return file_.string();
  return lines_.FileOf("joint", Name(mjOBJ_JOINT, arm_joints.front()));
}

std::string Model::HandFile() const {
  return hand < 0 ? file_.string() : lines_.FileOf("body", Name(mjOBJ_BODY, hand));
}

void Model::Error(const std::string& where, const std::string& element, const std::string& what,
                  const std::string& cure) {
  findings_.push_back({true, where, element, what, cure});
}

void Model::Warn(const std::string& where, const std::string& element, const std::string& what,
                 const std::string& cure) {
  findings_.push_back({false, where, element, what, cure});
}

bool Model::InSubtree(int body, int root) const { return mjcf::InSubtree(&m(), body, root); }

bool Model::Collides(int geom) const {
  return m().geom_contype[geom] != 0 || m().geom_conaffinity[geom] != 0;
}

std::string Model::BodyName(int body) const {
  const std::string name = Name(mjOBJ_BODY, body);
  return name.empty() ? fmt::format("body {}", body) : name;
}

std::string Model::NamesOf(mjtObj type, const std::vector<int>& ids) const {
  std::vector<std::string> names;
  for (const int id : ids) names.push_back(type == mjOBJ_BODY ? BodyName(id) : Name(type, id));
  return base::Join(names);
}

bool Model::IsRobot(int body) const {
  const bool arm = first_moving() > 0 && InSubtree(body, first_moving());
  return arm || (hand > 0 && InSubtree(body, hand));
}

}  // namespace rangegrasp::check::internal
