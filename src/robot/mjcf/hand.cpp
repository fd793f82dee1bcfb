#include "robot/mjcf/hand.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/linear_algebra.h"
#include "base/pattern.h"
#include "base/words.h"

namespace rangegrasp::mjcf {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

geometry::TriangleMesh MeshWithFaces(const mjModel* model, int mesh, const int* faces, int count) {
  geometry::TriangleMesh result;
  const float* vertices = model->mesh_vert + 3 * model->mesh_vertadr[mesh];
  for (int v = 0; v < model->mesh_vertnum[mesh]; ++v, vertices += 3) {
    result.vertices.emplace_back(vertices[0], vertices[1], vertices[2]);
  }
  for (int f = 0; f < count; ++f, faces += 3) {
    result.triangles.push_back(
        {std::uint32_t(faces[0]), std::uint32_t(faces[1]), std::uint32_t(faces[2])});
  }
  return result;
}

/// The MJCF files that a text's attributes name.
std::vector<std::string> FilesIn(const std::string& text) {
  constexpr std::string_view kFile = "file=";
  std::vector<std::string> names;
  for (std::size_t at = text.find(kFile); at != std::string::npos; at = text.find(kFile, at)) {
    at += kFile.size() + 1;
    if (at >= text.size()) break;
    const std::string name = text.substr(at, text.find(text[at - 1], at) - at);
    if (name.ends_with(".xml")) names.push_back(name);
  }
  return names;
}

/// Adds an MJCF file and those that it includes or attaches.
void AddFilesOf(const std::filesystem::path& file, std::vector<std::filesystem::path>& files) {
  if (!std::filesystem::is_regular_file(file) || std::ranges::find(files, file) != files.end()) {
    return;
  }
  files.push_back(file);
  for (const std::string& name : FilesIn(base::ReadFile(file))) {
    AddFilesOf((file.parent_path() / name).lexically_normal(), files);
  }
}

std::string LineOf(const std::filesystem::path& file, std::size_t line) {
  const auto lines = base::Split(base::ReadFile(file), '\n');
  return line >= 1 && line <= lines.size() ? lines[line - 1] : "";
}

std::string MatchIn(const std::string& text, const char* pattern) {
  const auto match = base::FindMatch(text, pattern);
  return match ? match->groups[1] : "";
}

std::vector<double> OneADrive(const mjModel* model, const char* name, std::size_t drives) {
  std::vector<double> values = NumericOf(model, name);
  if (values.size() != drives) {
    throw base::InputError(
        fmt::format("numeric \"{}\" must have one value for each of the {} drives of tuple "
                    "\"hand_motors\"; it has {}",
                    name, drives, values.size()));
  }
  return values;
}

void RequireAffine(const mjModel* model, int actuator) {
  const bool gain = model->actuator_gaintype[actuator] == mjGAIN_FIXED;
  const bool bias = model->actuator_biastype[actuator] == mjBIAS_NONE ||
                    model->actuator_biastype[actuator] == mjBIAS_AFFINE;
  const bool at_once = model->actuator_dyntype[actuator] == mjDYN_NONE;
  if (gain && bias && at_once && model->actuator_gainprm[actuator * mjNGAIN] != 0.0) return;
  throw base::InputError(fmt::format(
      "actuator \"{}\" of tuple \"hand_motors\" is neither a <position> servo nor a <motor> nor a "
      "<general> whose force is linear in its command, its length and its speed",
      mj_id2name(model, mjOBJ_ACTUATOR, actuator)));
}

template <class OfJoint>
double Along(const mjModel* model, int actuator, double otherwise, const OfJoint& of_joint) {
  const double gear = model->actuator_gear[6 * model->actuator_outadr[actuator]];
  const int id = model->actuator_trnid[2 * actuator];
  if (model->actuator_trntype[actuator] == mjTRN_JOINT) return gear * of_joint(id);
  if (model->actuator_trntype[actuator] != mjTRN_TENDON) return otherwise;
  double sum = 0.0;
  for (int i = model->tendon_adr[id]; i < model->tendon_adr[id] + model->tendon_num[id]; ++i) {
    if (model->wrap_type[i] != mjWRAP_JOINT) return otherwise;
    sum += model->wrap_prm[i] * of_joint(model->wrap_objid[i]);
  }
  return gear * sum;
}

/// The joints of the hand, including those that nothing drives.
std::vector<int> HandJoints(const mjModel* model, int hand) {
  std::vector<int> joints;
  for (int j = 0; j < model->njnt; ++j) {
    if (!InSubtree(model, model->jnt_bodyid[j], hand)) continue;
    if (model->jnt_type[j] != mjJNT_HINGE && model->jnt_type[j] != mjJNT_SLIDE) {
      throw base::InputError("a joint of the hand is neither a hinge nor a slide");
    }
    joints.push_back(j);
  }
  return joints;
}

constexpr int kPoints = 97;           // 1 mm of gap each for a hand that opens 100 mm
constexpr int kFirstSteps = 600;      // 1.2 s: from the model's initial pose to the open hand
constexpr int kStepsAPoint = 15;      // 30 ms: servos come within a hundredth of the step
constexpr double kStep_s = 0.002;     // as in scenes
constexpr double kServo_1_s = 300.0;  // frequency of drives: a third of what the step allows
constexpr double kDrag = 0.95;        // share of speed kept per step: springs swing out
constexpr double kArmature = 1000.0;  // of everything except the hand, to keep it still

/// Effect of one unit of an actuator's force on each degree of freedom.
VectorXd MomentOf(const mjModel* model, const mjData* data, int actuator) {
  VectorXd moment(model->nv);
  const int out = model->actuator_outadr[actuator];
  mju_sparse2dense(moment.data(), data->actuator_moment, 1, static_cast<int>(model->nv),
                   data->moment_rownnz + out, data->moment_rowadr + out, data->moment_colind);
  return moment;
}

// The copy of the hand that is closed, with drives that follow their commands.
class Rehearsal {
 public:
  Rehearsal(const mjModel* model, const std::vector<HandMotor>& motors, const LastSegments& tips,
            int hand)
      : motors_(motors),
        tips_(tips),
        joints_(HandJoints(model, hand)),
        model_(mj_copyModel(nullptr, model)),
        data_(mj_makeData(model)) {
    mjModel* m = model_.get();
    m->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_GRAVITY | mjDSBL_SENSOR;
    m->opt.enableflags &= ~mjENBL_SLEEP;
    m->opt.integrator = mjINT_IMPLICITFAST;
    m->opt.timestep = kStep_s;
    for (int dof = 0; dof < m->nv; ++dof) {
      const bool of_hand = std::ranges::find(joints_, m->dof_jntid[dof]) != joints_.end();
      if (!of_hand) m->dof_armature[dof] += kArmature;
    }
    data_.reset(mj_makeData(m));
    MakeServos();
  }

  HandClosing Close() {
    HandClosing closing;
    closing.joints = joints_;
    for (int i = 0; i < kPoints; ++i) {
      const double share = static_cast<double>(i) / (kPoints - 1);
      for (const HandMotor& motor : motors_) {
        data_->ctrl[model_->actuator_ctrladr[motor.actuator]] = motor.open + share * motor.Travel();
      }
      Step(i == 0 ? kFirstSteps : kStepsAPoint);
      auto& point = closing.points.emplace_back();
      point = {share, GapOf(model_.get(), data_.get(), tips_), {}};
      for (const int j : joints_) point.positions.push_back(data_->qpos[model_->jnt_qposadr[j]]);
      NoteEqualities(closing);
    }
    NoteDrives(closing);
    return closing;
  }

 private:
  // Gives every drive a servo of the same frequency, from the inertia that it moves, stiffer if the
  // joints are damped more than the servo itself. All other actuators are idle.
  void MakeServos() {
    mjModel* m = model_.get();
    mj_forward(m, data_.get());
    for (int a = 0; a < m->nactuator; ++a) {
      m->actuator_biastype[a] = mjBIAS_NONE;
      m->actuator_gaintype[a] = mjGAIN_FIXED;
      m->actuator_gainprm[a * mjNGAIN] = 0.0;
    }
    for (const HandMotor& motor : motors_) {
      const int a = motor.actuator;
      const double inertia = InertiaAt(a);
      const double damping = 2.0 * inertia * kServo_1_s;
      const double more_damping = std::max(0.0, DampingAt(a) - damping);
      const double stiffness = (inertia * kServo_1_s + more_damping) * kServo_1_s;
      m->actuator_biastype[a] = mjBIAS_AFFINE;
      m->actuator_gainprm[a * mjNGAIN] = stiffness;
      m->actuator_biasprm[a * mjNBIAS] = 0.0;
      m->actuator_biasprm[a * mjNBIAS + 1] = -stiffness;
      m->actuator_biasprm[a * mjNBIAS + 2] = -damping;
      m->actuator_forcelimited[a] = 0;
      m->actuator_ctrllimited[m->actuator_ctrladr[a]] = 0;
    }
  }

  double InertiaAt(int actuator) const {
    const mjModel* m = model_.get();
    const VectorXd arm = MomentOf(m, data_.get(), actuator);
    VectorXd response(m->nv);
    mj_solveM(m, data_.get(), response.data(), arm.data(), 1);
    const double mobility = mju_dot(arm.data(), response.data(), static_cast<int>(m->nv));
    if (mobility <= 0.0) {
      throw base::InputError(fmt::format("actuator \"{}\" of tuple \"hand_motors\" moves no joint",
                                         mj_id2name(m, mjOBJ_ACTUATOR, actuator)));
    }
    return 1.0 / mobility;
  }

  // Damping of the joints on which a drive acts, at the drive.
  double DampingAt(int actuator) const {
    const VectorXd arm = MomentOf(model_.get(), data_.get(), actuator);
    return arm.cwiseAbs2().dot(Eigen::Map<const VectorXd>(model_->dof_damping, model_->nv));
  }

  void Step(int steps) {
    for (int i = 0; i < steps; ++i) {
      mj_step(model_.get(), data_.get());
      mju_scl(data_->qvel, data_->qvel, kDrag, static_cast<int>(model_->nv));
    }
    mj_forward(model_.get(), data_.get());
    if (data_->warning[mjWARN_BADQACC].number > 0 || data_->warning[mjWARN_BADQPOS].number > 0) {
      throw base::InputError(
          "the simulation of the empty closing hand diverges: its equalities, masses or "
          "\"hand_open\" and \"hand_closed\" contradict each other");
    }
  }

  void NoteEqualities(HandClosing& closing) const {
    for (int row = 0; row < data_->ne; ++row) {
      const double error = std::abs(data_->efc_pos[row]);
      if (error <= closing.equality_m) continue;
      closing.equality_m = error;
      closing.equality = data_->efc_id[row];
    }
  }

  void NoteDrives(HandClosing& closing) const {
    for (const HandMotor& motor : motors_) {
      if (!motor.Moves()) continue;
      const double at = DriveLength(model_.get(), data_.get(), motor.actuator);
      const double behind = std::abs((motor.closed - at) / motor.Travel());
      if (behind <= closing.behind) continue;
      closing.behind = behind;
      closing.behind_actuator = motor.actuator;
    }
  }

  std::vector<HandMotor> motors_;
  LastSegments tips_;
  std::vector<int> joints_;
  ModelPtr model_;
  DataPtr data_;
};

// Position of a share: the point below it, and the fraction of the way to the next.
std::pair<std::size_t, double> Place(const std::vector<HandClosing::Point>& points, double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(points.size() - 1);
  const auto from = std::min(static_cast<std::size_t>(at), points.size() - 2);
  return {from, at - static_cast<double>(from)};
}

/// Column k: effect of one unit of force of the k-th drive, then equality, on the joints.
MatrixXd Columns(const mjModel* model, const mjData* data, const std::vector<HandMotor>& motors) {
  MatrixXd all(model->nv, std::ssize(motors) + data->ne);
  for (Eigen::Index k = 0; k < std::ssize(motors); ++k) {
    all.col(k) = MomentOf(model, data, motors[k].actuator);
  }
  MatrixXd equalities(model->nv, data->ne);  // in the engine's arrays, an equality is a row
  if (mj_isSparse(model)) {
    mju_sparse2dense(equalities.data(), data->efc_J, data->ne, static_cast<int>(model->nv),
                     data->efc_J_rownnz, data->efc_J_rowadr, data->efc_J_colind);
  } else {
    std::copy_n(data->efc_J, equalities.size(), equalities.data());
  }
  all.rightCols(data->ne) = equalities;
  return all;
}

/// Joint forces that the pressing of the last segments requires.
VectorXd Wanted(const mjModel* model, const mjData* data, const Vector3d& x_W) {
  const LastSegments tips = LastSegmentsOf(model);
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, model->nv);
  VectorXd wanted = VectorXd::Zero(model->nv);
  const auto press = [&](const std::vector<int>& geoms, const Vector3d& direction_W) {
    for (const int geom : geoms) {
      mj_jacGeom(model, data, J.data(), nullptr, geom);
      wanted += J.transpose() * direction_W / static_cast<double>(geoms.size());
    }
  };
  press(tips.thumb, -x_W);
  press(tips.fingers, x_W);
  return wanted;
}

bool BeginsAsXml(const std::filesystem::path& file) {
  const std::string text = base::ReadFile(file);
  const std::size_t begin = text.find_first_not_of("\xef\xbb\xbf \t\r\n");  // byte order mark
  return begin != std::string::npos && text[begin] == '<';
}

}  // namespace

std::string_view Suffix(std::string_view name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

int CountOf(const mjModel* model, mjtObj type) {
  const std::pair<mjtObj, std::int64_t> counts[] = {
      {mjOBJ_BODY, model->nbody},       {mjOBJ_JOINT, model->njnt},   {mjOBJ_GEOM, model->ngeom},
      {mjOBJ_SITE, model->nsite},       {mjOBJ_CAMERA, model->ncam},  {mjOBJ_ACTUATOR, model->nu},
      {mjOBJ_NUMERIC, model->nnumeric}, {mjOBJ_TUPLE, model->ntuple}, {mjOBJ_LIGHT, model->nlight}};
  for (const auto& [counted, count] : counts) {
    if (counted == type) return static_cast<int>(count);
  }
  return 0;
}

std::string EngineMessage(const std::filesystem::path& file, const std::string& message) {
  std::vector<std::string> parts;
  for (const std::string& part : base::Split(message, '\n')) {
    if (!part.empty()) parts.push_back(part);
  }
  const std::string text = base::Join(parts, "; ");
  if (text.starts_with("XML parse error") && !BeginsAsXml(file)) {
    return file.string() +
           ": is not XML; an MJCF file (.xml) is needed, e.g. the scene that an experiment names";
  }
  // "Element 'geom', line 4", "Element name 'arm/link1', id 3, line 4", or, if it is no XML, "Line
  // number=4". Then follow, from the inside, the elements that attach the file of the one before.
  const auto lines = base::AllMatches(text, "(?:line |Line number=)([0-9]+)");
  const auto line =
      lines.empty() ? std::nullopt : base::NumberFrom<std::size_t>(lines.front().groups[1]);
  if (!line) return file.string() + ": " + text;
  const std::string tag = MatchIn(text.substr(0, lines.front().end()), "Element '([^']{1,80})'");
  const std::string name = MatchIn(text, "Element name '([^']{1,80})'");
  std::filesystem::path attached = file.lexically_normal();
  for (const auto& outer : lines | std::views::drop(1) | std::views::reverse) {
    const auto number = base::NumberFrom<std::size_t>(outer.groups[1]);
    const auto children = FilesIn(LineOf(attached, number.value_or(0)));
    if (!children.empty()) attached = (attached.parent_path() / children[0]).lexically_normal();
  }
  std::vector<std::filesystem::path> files;
  AddFilesOf(attached, files);
  if (tag.empty() && name.empty()) files = {attached};
  if (files.size() > 1) {
    std::erase_if(files, [&](const std::filesystem::path& one) {
      const std::string there = LineOf(one, *line);
      return there.find("<" + tag) == std::string::npos ||
             there.find(Suffix(name)) == std::string::npos;
    });
  }
  if (files.size() == 1) return fmt::format("{}:{}: {}", files.front().string(), *line, text);
  return fmt::format("{}: {} (in this file, or in one that it includes or attaches)",
                     attached.string(), text);
}

std::string FarAway(const mjModel& model) {
  constexpr double kMax_m = 1e4;
  const std::pair<mjtObj, const mjtNum*> kinds[] = {
      {mjOBJ_BODY, model.body_pos},  {mjOBJ_BODY, model.body_ipos}, {mjOBJ_GEOM, model.geom_pos},
      {mjOBJ_SITE, model.site_pos},  {mjOBJ_JOINT, model.jnt_pos},  {mjOBJ_CAMERA, model.cam_pos},
      {mjOBJ_LIGHT, model.light_pos}};
  const auto title = [&](mjtObj type, int i) {
    return fmt::format("{} \"{}\"", mju_type2Str(type), NameOf(&model, type, i));
  };
  for (const auto& [type, at] : kinds) {
    for (int i = 0; i < CountOf(&model, type); ++i) {
      const Eigen::Vector3d p(at + 3 * std::ptrdiff_t{i});
      if (p.cwiseAbs().maxCoeff() <= kMax_m) continue;
      return fmt::format("{} at {:g} {:g} {:g}", title(type, i), p.x(), p.y(), p.z());
    }
  }
  for (int i = 0; i < CountOf(&model, mjOBJ_GEOM); ++i) {
    if (model.geom_rbound[i] <= kMax_m) continue;
    return fmt::format("{} with a radius of {:g}", title(mjOBJ_GEOM, i), model.geom_rbound[i]);
  }
  return "";
}

int TryFind(const mjModel* model, mjtObj type, std::string_view suffix) {
  for (int id = 0; id < CountOf(model, type); ++id) {
    if (Suffix(NameOf(model, type, id)) == suffix) return id;
  }
  return -1;
}

int Find(const mjModel* model, mjtObj type, std::string_view suffix) {
  const int id = TryFind(model, type, suffix);
  if (id >= 0) return id;
  std::vector<std::string> known;
  for (int i = 0; i < CountOf(model, type); ++i) {
    const std::string_view name = Suffix(NameOf(model, type, i));
    if (!name.empty()) known.emplace_back(name);
  }
  throw base::InputError(fmt::format("the scene has no {} \"{}\"; it has: {}", mju_type2Str(type),
                                     suffix, known.empty() ? "none" : base::Join(known)));
}

std::vector<int> TupleOf(const mjModel* model, mjtObj type, std::string_view suffix) {
  const int tuple = Find(model, mjOBJ_TUPLE, suffix);
  std::vector<int> ids;
  for (int i = 0; i < model->tuple_size[tuple]; ++i) {
    const int element = model->tuple_adr[tuple] + i;
    if (model->tuple_objtype[element] != type) {
      throw base::InputError(
          fmt::format("tuple \"{}\" of the scene must have elements of type {} only", suffix,
                      mju_type2Str(type)));
    }
    ids.push_back(model->tuple_objid[element]);
  }
  return ids;
}

std::vector<double> NumericOf(const mjModel* model, std::string_view suffix) {
  const int id = TryFind(model, mjOBJ_NUMERIC, suffix);
  if (id < 0) return {};
  const mjtNum* data = model->numeric_data + model->numeric_adr[id];
  return {data, data + model->numeric_size[id]};
}

std::string_view NameOf(const mjModel* model, mjtObj type, int id) {
  const char* name = mj_id2name(model, type, id);
  return name ? name : "";
}

bool Collides(const mjModel* model, int geom) {
  return model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0;
}

std::optional<geometry::Shape::Kind> KindOf(int geom_type) {
  using Kind = geometry::Shape::Kind;
  switch (geom_type) {
    case mjGEOM_SPHERE:
      return Kind::kSphere;
    case mjGEOM_CAPSULE:
      return Kind::kCapsule;
    case mjGEOM_CYLINDER:
      return Kind::kCylinder;
    case mjGEOM_BOX:
      return Kind::kBox;
    case mjGEOM_ELLIPSOID:
      return Kind::kEllipsoid;
    default:
      return std::nullopt;
  }
}

geometry::TriangleMesh MeshOf(const mjModel* model, int mesh) {
  return MeshWithFaces(model, mesh, model->mesh_face + 3 * model->mesh_faceadr[mesh],
                       model->mesh_facenum[mesh]);
}

geometry::TriangleMesh HullOf(const mjModel* model, int mesh) {
  if (model->mesh_graphadr[mesh] < 0) return MeshOf(model, mesh);
  // Layout of mesh_graph: numvert, numface, vert_edgeadr[numvert], vert_globalid[numvert],
  // edge_localid[numvert + 3 numface], face_globalid[3 numface].
  const int* graph = model->mesh_graph + model->mesh_graphadr[mesh];
  return MeshWithFaces(model, mesh, graph + 2 + 3 * graph[0] + 3 * graph[1], graph[1]);
}

bool InSubtree(const mjModel* model, int body, int root) {
  while (body > root) body = model->body_parentid[body];  // parents have lower ids
  return body == root;
}

bool HasMotors(const mjModel* model) { return TryFind(model, mjOBJ_TUPLE, "hand_motors") >= 0; }

std::vector<HandMotor> HandMotors(const mjModel* model) {
  const std::vector<int> actuators = TupleOf(model, mjOBJ_ACTUATOR, "hand_motors");
  const std::vector<double> open = OneADrive(model, "hand_open", actuators.size());
  const std::vector<double> closed = OneADrive(model, "hand_closed", actuators.size());
  std::vector<HandMotor> motors;
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    RequireAffine(model, actuators[i]);
    motors.push_back({actuators[i], open[i], closed[i]});
  }
  if (std::ranges::none_of(motors, [](const HandMotor& m) { return m.Moves(); })) {
    throw base::InputError(
        "numerics \"hand_open\" and \"hand_closed\" are the same: the hand does not close");
  }
  return motors;
}

int HandBranch(const mjModel* model, int body, int hand) {
  int branch = body;
  for (int b = body; b > hand; b = model->body_parentid[b]) {
    if (model->body_jntnum[b] > 0) branch = b;
  }
  return branch;
}

int ThumbRoot(const mjModel* model) {
  if (!HasMotors(model)) return model->jnt_bodyid[TupleOf(model, mjOBJ_JOINT, "hand_joints").at(0)];
  const int tip = TupleOf(model, mjOBJ_GEOM, "fingertips").at(0);
  return HandBranch(model, model->geom_bodyid[tip], Find(model, mjOBJ_BODY, "hand"));
}

LastSegments LastSegmentsOf(const mjModel* model) {
  return LastSegmentsOf(model, TupleOf(model, mjOBJ_GEOM, "fingertips"), ThumbRoot(model));
}

LastSegments LastSegmentsOf(const mjModel* model, const std::vector<int>& tips, int thumb) {
  LastSegments last;
  for (const int geom : tips) {
    const int body = model->geom_bodyid[geom];
    const bool inner = std::ranges::any_of(tips, [&](int other) {
      const int further = model->geom_bodyid[other];
      return further != body && InSubtree(model, further, body);
    });
    if (!inner) (InSubtree(model, body, thumb) ? last.thumb : last.fingers).push_back(geom);
  }
  return last;
}

double GapOf(const mjModel* model, mjData* data, const LastSegments& tips) {
  double gap_m = kFarApart_m;
  for (const int a : tips.thumb) {
    for (const int b : tips.fingers) {
      gap_m = std::min(gap_m, mj_geomDistance(model, data, a, b, kFarApart_m, nullptr));
    }
  }
  return gap_m;
}

double DriveLength(const mjModel* model, const mjData* data, int actuator) {
  return Along(model, actuator, data->actuator_length[model->actuator_outadr[actuator]],
               [&](int joint) { return data->qpos[model->jnt_qposadr[joint]]; });
}

double DriveSpeed(const mjModel* model, const mjData* data, int actuator) {
  return Along(model, actuator, data->actuator_velocity[model->actuator_outadr[actuator]],
               [&](int joint) { return data->qvel[model->jnt_dofadr[joint]]; });
}

AffineDrive AffineOf(const mjModel* model, int actuator) {
  AffineDrive drive;
  drive.gain = model->actuator_gainprm[actuator * mjNGAIN];
  if (model->actuator_biastype[actuator] == mjBIAS_AFFINE) {
    std::copy_n(model->actuator_biasprm + actuator * mjNBIAS, 3, drive.bias);
  }
  drive.weakest = -std::numeric_limits<double>::infinity();
  drive.strongest = std::numeric_limits<double>::infinity();
  if (model->actuator_forcelimited[actuator]) {
    drive.weakest = model->actuator_forcerange[2 * actuator];
    drive.strongest = model->actuator_forcerange[2 * actuator + 1];
  }
  const int control = model->actuator_ctrladr[actuator];
  if (drive.bias[1] == 0.0 && model->actuator_ctrllimited[control]) {
    // For a motor, the command's range limits the force.
    const double a = drive.bias[0] + drive.gain * model->actuator_ctrlrange[2 * control];
    const double b = drive.bias[0] + drive.gain * model->actuator_ctrlrange[2 * control + 1];
    drive.weakest = std::max(drive.weakest, std::min(a, b));
    drive.strongest = std::min(drive.strongest, std::max(a, b));
  }
  return drive;
}

double HandClosing::NarrowingAt(double share) const {
  const auto [i, u] = Place(points, share);
  return (points[i].gap_m - points[i + 1].gap_m) * static_cast<double>(points.size() - 1);
}

double HandClosing::ShareAtGap(double gap_m) const {
  std::size_t i = 0;
  while (i < points.size() && points[i].gap_m >= gap_m) ++i;
  if (i == 0) return 0.0;
  if (i == points.size()) return 1.0;
  const double u = (points[i - 1].gap_m - gap_m) / (points[i - 1].gap_m - points[i].gap_m);
  return points[i - 1].share + u * (points[i].share - points[i - 1].share);
}

void HandClosing::Pose(const mjModel* model, mjData* data, double share) const {
  const auto [i, u] = Place(points, share);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    data->qpos[model->jnt_qposadr[joints[k]]] =
        (1.0 - u) * points[i].positions[k] + u * points[i + 1].positions[k];
  }
}

HandClosing CloseOnNothing(const mjModel* model, const std::vector<HandMotor>& motors) {
  return CloseOnNothing(model, motors, LastSegmentsOf(model), Find(model, mjOBJ_BODY, "hand"));
}

HandClosing CloseOnNothing(const mjModel* model, const std::vector<HandMotor>& motors,
                           const LastSegments& tips, int hand) {
  return Rehearsal(model, motors, tips, hand).Close();
}

std::vector<double> GripForces(const mjModel* model, const mjData* data,
                               const std::vector<HandMotor>& motors, const HandClosing& closing,
                               double share, const Vector3d& x_W) {
  if (motors.size() == 1) return {closing.NarrowingAt(share) / motors.front().Travel()};
  const MatrixXd all = Columns(model, data, motors);
  const VectorXd wanted = Wanted(model, data, x_W);
  std::vector<int> dofs;
  for (const int joint : closing.joints) dofs.push_back(model->jnt_dofadr[joint]);
  const MatrixXd of_hand = all(dofs, Eigen::all);
  const VectorXd of_tips = wanted(dofs);
  const VectorXd forces = base::LeastSquares(of_hand, of_tips).head(std::ssize(motors));
  return {forces.data(), forces.data() + forces.size()};
}

}  // namespace rangegrasp::mjcf
