#include "sim/world.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "sim/internal/engine.h"
#include "sim/internal/scene_builder.h"
#include "sim/internal/servo.h"
#include "sim/surfaces.h"

namespace rangegrasp::sim {
using internal::ObjectEntry;
using internal::Vec3;

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Parked objects are here: out of sight and reach, weightless and asleep.
constexpr double kParking_m = 1000.0;
constexpr double kParkingSpacing_m = 5.0;
// Contacts of falling objects then yield within 8 ms; a fall of 30 mm takes 80 ms.
constexpr double kCoarseStep_s = 0.004;
// A larger change of velocity in one step is a solver failure: objects fall at 2 m/s, fingers close
// at 0.3 m/s, and 5 m/s is an impact of 250 g.
constexpr double kLeap_m_s = 5.0;
// An object that fell further below the table than this has left it.
constexpr double kLost_m = -1.0;

}  // namespace

struct SavedWorld {
  internal::DataPtr data;
  std::vector<char> parked;  // by object
};

struct World::Impl {
  internal::ModelPtr model;
  internal::DataPtr data;
  std::vector<ObjectEntry> objects;
  PhysicsOptions physics;
  mjOption scene_option;             // of steps that are not coarse
  std::vector<mjtNum> scene_solimp;  // by geom
  std::vector<double> softness;      // by geom: share of the scene's
  std::vector<FrictionPair> glove_on_object;
  FrictionPair glove_on_scene;
  GloveRange table;  // the scene's surface
  std::vector<int> arm_joints;
  std::vector<int> arm_actuators;
  std::vector<std::string> warnings;
  SolverCounts solver_counts;
  internal::ColorsOfGeoms colors{nullptr};
  // State before the present step.
  struct {
    std::vector<mjtNum> state;
    std::vector<mjtNum> velocity;
    std::array<mjWarningStat, mjNWARNING> counts;
    std::size_t warnings = 0;
  } before;

  ObjectEntry& at(int object) { return objects.at(object); }

  // A velocity of -0.0 wakes a tree and what it touches, and changes nothing else.
  void SetPose(const ObjectEntry& object, const base::Pose& X_WO) {
    const Eigen::Quaterniond q(X_WO.linear());
    Eigen::Map<Eigen::Vector<mjtNum, 7>>(data->qpos + object.qpos) << X_WO.translation(), q.w(),
        q.x(), q.y(), q.z();
    std::fill_n(data->qvel + object.dof, 6, -0.0);
    std::fill_n(data->qacc_warmstart + object.dof, 6, 0.0);
  }

  // Wakes them in the same way as SetPose. Parked objects do not move and fall asleep again.
  void WakeAll() {
    for (int dof = 0; dof < model->nv; ++dof) {
      if (data->qvel[dof] == 0.0) data->qvel[dof] = -0.0;
    }
  }

  bool IsObject(int body) const {
    return std::ranges::any_of(objects, [&](const ObjectEntry& object) {
      return object.body == model->body_rootid[body];
    });
  }

  // Reach of an object's collision geometry along a unit direction [m].
  double Reach(int object, const Vector3d& direction_W) {
    double reach = -std::numeric_limits<double>::infinity();
    for (int geom = 0; geom < model->ngeom; ++geom) {
      if (model->body_rootid[model->geom_bodyid[geom]] != at(object).body) continue;
      if (!internal::Collides(model.get(), geom)) continue;
      reach = std::max(reach, internal::ReachOfGeom(model.get(), data.get(), geom, direction_W));
    }
    return reach;
  }

  // Distance of an object's collision geometry from that of the bodies for which `of` holds.
  template <typename Predicate>
  double Distance(int object, double limit_m, const Predicate& of) {
    std::vector<int> own, others;
    for (int geom = 0; geom < model->ngeom; ++geom) {
      if (!internal::Collides(model.get(), geom)) continue;
      const int body = model->geom_bodyid[geom];
      if (model->body_rootid[body] == at(object).body) {
        own.push_back(geom);
      } else if (of(body)) {
        others.push_back(geom);
      }
    }
    double distance = limit_m;
    for (const int a : own) {
      for (const int b : others) {
        const double limit = std::max(distance, 0.0);
        distance = std::min(distance, internal::GeomDistance(model.get(), data.get(), a, b, limit));
      }
    }
    return distance;
  }

  // Opens a hand with "hand_motors" and lets its servos hold it open. Otherwise fingers with
  // another zero would swing when the first motion begins. An incomplete hand stays as in its file.
  void OpenHand() {
    if (!mjcf::HasMotors(model.get())) return;
    try {
      const auto motors = mjcf::HandMotors(model.get());
      mjcf::CloseOnNothing(model.get(), motors).Pose(model.get(), data.get(), 0.0);
      for (const mjcf::HandMotor& motor : motors) {
        const mjcf::AffineDrive drive = mjcf::AffineOf(model.get(), motor.actuator);
        if (drive.bias[1] == 0.0) continue;
        data->ctrl[model->actuator_ctrladr[motor.actuator]] =
            -(drive.bias[0] + drive.bias[1] * motor.open) / drive.gain;
      }
    } catch (const base::InputError&) {  // reported when something moves the hand
    }
  }

  // Saves everything that a step depends on.
  void KeepState() {
    mj_getState(model.get(), data.get(), before.state.data(), mjSTATE_INTEGRATION);
    before.velocity.assign(data->qvel, data->qvel + model->nv);
    std::copy_n(data->warning, mjNWARNING, before.counts.data());
    before.warnings = warnings.size();
  }
  void GoBack() {
    mj_setState(model.get(), data.get(), before.state.data(), mjSTATE_INTEGRATION);
    // The sleep state cannot be set, because the engine keeps its own lists of it.
    WakeAll();
    std::copy_n(before.counts.data(), mjNWARNING, data->warning);
    warnings.resize(before.warnings);
  }

  // The engine counts these iterations with the solver's own.
  void SetNoslip(int iterations) {
    model->opt.noslip_iterations = iterations;
    model->opt.iterations = scene_option.iterations + iterations;
  }

  // True if the solver converged in every island and no object's velocity jumped. The jump test is
  // needed because the solver also stops early when its line search fails.
  bool Solved() const {
    const auto leapt = [&](const ObjectEntry& object) {
      return (Vec3(data->qvel + object.dof) - Vec3(before.velocity.data() + object.dof)).norm() >
             kLeap_m_s;
    };
    if (std::ranges::any_of(objects, leapt)) return false;
    const int islands = std::clamp(data->nisland, 1, static_cast<int>(mjNISLAND));
    return std::all_of(data->solver_niter, data->solver_niter + islands,
                       [&](int iterations) { return iterations < model->opt.iterations; });
  }
};

World::World(const std::filesystem::path& scene_mjcf, const std::vector<ObjectModel>& objects,
             const PhysicsOptions& options)
    : impl_(std::make_unique<Impl>()) {
  internal::BuiltScene built = internal::BuildScene(scene_mjcf, objects, options);
  impl_->model = std::move(built.model);
  impl_->colors = internal::ColorsOfGeoms(model());
  impl_->objects = std::move(built.objects);
  impl_->physics = options;
  mjOption& option = impl_->model->opt;
  option.noslip_iterations = std::max(option.noslip_iterations, options.min_noslip);
  impl_->scene_option = option;
  impl_->SetNoslip(option.noslip_iterations);
  impl_->scene_solimp.assign(model()->geom_solimp, model()->geom_solimp + mjNIMP * model()->ngeom);
  impl_->softness.assign(model()->ngeom, 1.0);
  impl_->data = internal::MakeData(model());
  if (!impl_->data) throw base::RunError("MuJoCo: out of memory for the scene's data");
  impl_->before.state.resize(mj_stateSize(model(), mjSTATE_INTEGRATION));
  if (internal::TryFind(model(), mjOBJ_TUPLE, "arm_joints") >= 0) {
    try {
      const internal::ArmServo servo(model());
      impl_->arm_joints = servo.joints();
      impl_->arm_actuators = servo.actuators();
    } catch (const base::InputError& error) {
      throw base::InputError(scene_mjcf.string() + ": " + error.what());
    }
  }
  const std::vector<double> home = internal::NumericOf(model(), "home");
  if (home.size() == impl_->arm_joints.size() && !home.empty()) {
    SetArm(Eigen::Map<const VectorXd>(home.data(), std::ssize(home)));
  }
  impl_->OpenHand();
  for (int object = 0; object < this->objects(); ++object) {
    ParkObject(object);
    impl_->glove_on_object.push_back(GloveFriction(impl_->at(object).surface.glove, options));
  }
  impl_->table = FindSurface(ReadSurfaces(ShippedSurfaces()), kTableSurface).glove;
  impl_->glove_on_scene = GloveFriction(impl_->table, options);
  Refresh();
}

World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

int World::objects() const { return static_cast<int>(impl_->objects.size()); }
const std::string& World::object_name(int object) const { return impl_->at(object).name; }
const std::string& World::object_surface(int object) const {
  return impl_->at(object).surface.name;
}
int World::object_body(int object) const { return impl_->at(object).body; }

const FrictionPair& World::glove_friction(int object) const {
  return object < 0 ? impl_->glove_on_scene : impl_->glove_on_object.at(object);
}

void World::DrawFriction(base::Rng& rng) {
  impl_->glove_on_scene = GloveFriction(impl_->table, physics(), rng.Uniform());
  for (int object = 0; object < objects(); ++object) {
    impl_->glove_on_object[object] =
        GloveFriction(impl_->at(object).surface.glove, physics(), rng.Uniform());
  }
}

bool World::parked(int object) const { return impl_->at(object).parked; }

base::Pose World::ObjectPose(int object) const {
  const mjtNum* q = data()->qpos + impl_->at(object).qpos;
  return base::MakePose(Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized().toRotationMatrix(),
                        Vec3(q));
}

Vector3d World::ObjectCenterOfMass(int object) const {
  return internal::CenterOfMass(model(), data(), impl_->at(object).body);
}

void World::ScaleSoftness(int geom, double share) {
  if (share == std::exchange(impl_->softness[geom], share)) return;
  for (const int end : {0, 1}) {  // impedance d0 and d_width: the contact yields by 1 - d
    const int at = mjNIMP * geom + end;
    model()->geom_solimp[at] = 1.0 - share * (1.0 - impl_->scene_solimp[at]);
  }
}

double World::ObjectMass(int object) const {
  return model()->body_subtreemass[impl_->at(object).body];
}

double World::ObjectTop(int object) const { return impl_->Reach(object, Vector3d::UnitZ()); }

double World::ObjectBottom(int object) const { return -impl_->Reach(object, -Vector3d::UnitZ()); }

Eigen::AlignedBox3d World::ObjectBounds(int object) const {
  Eigen::AlignedBox3d bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.min()[axis] = -impl_->Reach(object, -Vector3d::Unit(axis));
    bounds.max()[axis] = impl_->Reach(object, Vector3d::Unit(axis));
  }
  return bounds;
}

double World::ObjectDistance(int object, int other, double limit_m) const {
  return impl_->Distance(
      object, limit_m, [&](int body) { return model()->body_rootid[body] == object_body(other); });
}

double World::RobotDistance(int object, double limit_m) const {
  return impl_->Distance(object, limit_m, [&](int body) {
    return model()->body_weldid[body] != 0 && !impl_->IsObject(body);
  });
}

double World::SceneDistance(int object, double limit_m) const {
  return impl_->Distance(object, limit_m,
                         [&](int body) { return model()->body_weldid[body] == 0; });
}

std::optional<Container> World::container() const {
  const int site = internal::TryFind(model(), mjOBJ_SITE, "container");
  if (site < 0) return std::nullopt;
  if (model()->site_type[site] != mjGEOM_BOX) {
    throw base::InputError(
        "the scene's site \"container\" must be of type box; it describes the interior");
  }
  return Container{internal::SitePose(data(), site), Vec3(model()->site_size + 3 * site)};
}

bool World::OverTable(const Vector3d& point_W) const {
  bool bounded = false;
  for (int geom = 0; geom < model()->ngeom; ++geom) {
    const mjtNum* size = model()->geom_size + 3 * geom;
    if (model()->geom_type[geom] != mjGEOM_PLANE || !internal::Collides(model(), geom)) continue;
    if (size[0] <= 0.0 || size[1] <= 0.0) return true;
    const Vector3d point_G = internal::GeomPose(data(), geom).inverse() * point_W;
    if (std::abs(point_G.x()) <= size[0] && std::abs(point_G.y()) <= size[1]) return true;
    bounded = true;
  }
  return !bounded;
}

double World::ObjectSpeed(int object) const {
  const ObjectEntry& entry = impl_->at(object);
  const mjtNum* v = data()->qvel + entry.dof;
  return Vec3(v).norm() + entry.radius_m * Vec3(v + 3).norm();
}

void World::PlaceObject(int object, const base::Pose& X_WO) {
  impl_->at(object).parked = false;
  model()->body_gravcomp[impl_->at(object).body] = 0.0;
  impl_->SetPose(impl_->at(object), X_WO);
  Refresh();
}

void World::ParkObject(int object) {
  ObjectEntry& entry = impl_->at(object);
  entry.parked = true;
  model()->body_gravcomp[entry.body] = 1.0;
  impl_->SetPose(entry, base::MakePose(Eigen::Matrix3d::Identity(),
                                       {kParking_m + kParkingSpacing_m * object, 0, kParking_m}));
  Refresh();
}

std::shared_ptr<const SavedWorld> World::Save() const {
  auto saved = std::make_shared<SavedWorld>();
  mjData* copy = nullptr;
  internal::CallEngine(nullptr, [&] { copy = mj_copyData(nullptr, model(), data()); });
  if (!copy) throw base::RunError("MuJoCo: out of memory for a copy of the scene's data");
  saved->data.reset(copy);
  for (const ObjectEntry& object : impl_->objects) saved->parked.push_back(object.parked);
  return saved;
}

void World::Restore(const SavedWorld& saved) {
  internal::CallEngine(nullptr, [&] { mj_copyData(data(), model(), saved.data.get()); });
  for (int object = 0; object < objects(); ++object) {
    impl_->at(object).parked = saved.parked.at(object) != 0;
    model()->body_gravcomp[object_body(object)] = parked(object) ? 1.0 : 0.0;
  }
}

void World::SetArm(const VectorXd& q) {
  const std::vector<int>& joints = impl_->arm_joints;
  if (q.size() != std::ssize(joints)) {
    throw std::invalid_argument(
        fmt::format("SetArm: {} joint positions for {} joints", q.size(), joints.size()));
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    data()->qpos[model()->jnt_qposadr[joints[i]]] = q[i];
    data()->qvel[model()->jnt_dofadr[joints[i]]] = 0.0;
    data()->ctrl[impl_->arm_actuators[i]] = q[i];
  }
  Refresh();
}

VectorXd World::ArmPositions() const {
  const std::vector<int>& joints = impl_->arm_joints;
  VectorXd q(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    q[i] = data()->qpos[model()->jnt_qposadr[joints[i]]];
  }
  return q;
}

double World::time_s() const { return data()->time; }
void World::Refresh() {
  internal::CallEngine(&impl_->warnings, [this] {
    mj_kinematics(model(), data());
    mj_comPos(model(), data());
  });
}

void World::Step() {
  internal::CallEngine(&impl_->warnings, [this] {
    impl_->KeepState();
    mj_step(model(), data());
  });
  if (impl_->Solved()) return;
  if (model()->opt.jacobian != mjJAC_DENSE) {
    ++impl_->solver_counts.repeated;
    impl_->GoBack();
    const int jacobian = std::exchange(model()->opt.jacobian, mjJAC_DENSE);
    internal::CallEngine(&impl_->warnings, [this] { mj_step(model(), data()); });
    model()->opt.jacobian = jacobian;
    if (impl_->Solved()) return;
  }
  ++impl_->solver_counts.unsolved;
}

bool World::Settle(double limit_s, double rest_speed_m_s, double rest_time_s) {
  const double end = time_s() + limit_s;
  double rest_since = time_s();
  while (time_s() < end) {
    Step();
    bool rests = true;
    bool asleep = true;
    for (int object = 0; object < objects(); ++object) {
      const ObjectEntry& entry = impl_->at(object);
      if (entry.parked) continue;
      if (data()->qpos[entry.qpos + 2] < kLost_m) return false;
      rests = rests && ObjectSpeed(object) < rest_speed_m_s;
      asleep = asleep && data()->tree_asleep[model()->body_treeid[entry.body]] >= 0;
    }
    if (asleep) return true;
    if (!rests) rest_since = time_s();
    if (time_s() - rest_since >= rest_time_s) return true;
  }
  return false;
}

void World::StepCoarsely(bool coarsely) {
  mjOption& option = model()->opt;
  option.timestep = coarsely ? kCoarseStep_s : impl_->scene_option.timestep;
  impl_->SetNoslip(coarsely ? 0 : impl_->scene_option.noslip_iterations);
  option.impratio = coarsely ? 1.0 : impl_->scene_option.impratio;
  for (int tree = 0; tree < model()->ntree; ++tree) {
    if (impl_->IsObject(model()->tree_bodyadr[tree])) continue;
    // Trees with drives never sleep otherwise.
    model()->tree_sleep_policy[tree] = coarsely ? mjSLEEP_ALLOWED : mjSLEEP_AUTO_NEVER;
  }
  if (!coarsely) impl_->WakeAll();
}

std::vector<VisualMesh> World::VisualMeshes() const {
  internal::ColorsOfGeoms& colors = impl_->colors;
  std::vector<VisualMesh> meshes;
  meshes.push_back(internal::VisualOfScene(model(), data(), colors));
  if (container()) meshes.push_back(internal::VisualOfContainer(model(), data(), colors));
  for (int object = 0; object < objects(); ++object) {
    const ObjectEntry& entry = impl_->at(object);
    if (entry.parked) continue;
    VisualMesh mesh = internal::VisualOfTree(model(), data(), entry.body, colors);
    mesh.surface = entry.optical;
    mesh.label = static_cast<std::uint32_t>(object) + 1;
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

base::Pose World::SitePose(const std::string& site) const {
  return internal::SitePose(data(), internal::Find(model(), mjOBJ_SITE, site));
}

const mjModel* World::model() const { return impl_->model.get(); }
mjModel* World::model() { return impl_->model.get(); }
mjData* World::data() { return impl_->data.get(); }
const mjData* World::data() const { return impl_->data.get(); }

std::string World::Warnings() const {
  const std::set<std::string> kinds(impl_->warnings.begin(), impl_->warnings.end());
  return base::Join({kinds.begin(), kinds.end()}, "; ");
}

int World::WarningCount() const {
  int count = 0;
  for (const mjWarningStat& warning : data()->warning) count += warning.number;
  return std::max(count, static_cast<int>(impl_->warnings.size()));
}

const SolverCounts& World::solver_counts() const { return impl_->solver_counts; }
const PhysicsOptions& World::physics() const { return impl_->physics; }
std::string EngineVersion() { return mj_versionString(); }

std::string ObjectTitle(const ObjectModel& object) {
  internal::NeedMjcf(object.mjcf);
  char error[1000] = "";
  const internal::SpecPtr spec(
      mj_parseXML(object.mjcf.c_str(), nullptr, error, static_cast<int>(sizeof(error))));
  if (!spec) throw base::InputError(mjcf::EngineMessage(object.mjcf, error));
  mjsElement* title = mjs_findElement(spec.get(), mjOBJ_TEXT, "title");
  return title ? mjs_getString(mjs_asText(title)->data) : object.name;
}

}  // namespace rangegrasp::sim
