#include "sim/check/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/linear_algebra.h"
#include "base/units.h"
#include "geometry/mesh.h"
#include "sim/check/internal/arm.h"
#include "sim/check/internal/cell.h"
#include "sim/check/internal/hand.h"
#include "sim/internal/engine.h"
#include "sim/internal/scene_builder.h"
#include "sim/resting_poses.h"
#include "sim/surfaces.h"

namespace rangegrasp::check {
namespace {

using base::Finding;
using Eigen::Vector3d;
using internal::Cure;
using internal::Model;

// Names, tuples and numerics that the program looks for.

struct Wanted {
  mjtObj type;
  std::string name, what_for;
  Cure cure;
  bool needed = true;
};

// Whether the element exists exactly once; reports a finding if not.
bool CheckOne(Model& model, const Wanted& wanted, const std::string& file) {
  const auto found = model.FindAll(wanted.type, wanted.name);
  const std::string element = fmt::format("{} \"{}\"", mju_type2Str(wanted.type), wanted.name);
  if (found.size() > 1) {
    model.Error(model.Where(wanted.type, found[1]), element,
                fmt::format("exists twice: {}", model.NamesOf(wanted.type, found)),
                "rename or remove one of them");
    return false;
  }
  if (!found.empty()) return true;
  model.Report(wanted.needed, file, element, fmt::format("is missing: {}", wanted.what_for),
               wanted.cure);
  return false;
}

// Sites and cameras as in scenes/tabletop.xml. Without a free joint, an object's file counts as a
// scene.
void CheckSceneNames(Model& model) {
  const std::string file = model.file().string();
  if (model.Find(mjOBJ_SITE, "workspace") < 0 && model.arm_joints.empty()) {
    model.Error(file, "scene", "has neither a workspace nor an arm",
                "if this is an object, it lacks a <freejoint/>; use --as object");
  }
  const auto in_world = [&](const char* block, const char* said = "") {
    return Cure::Insert(file, "/*/worldbody", block) + said;
  };
  for (const Wanted& wanted :
       {Wanted{mjOBJ_SITE, "workspace", "objects are placed and perceived there",
               in_world("<site name=\"workspace\" type=\"cylinder\" size=\"0.13 0.0005\" "
                        "group=\"4\"/>",
                        " on the table's top (z = 0); its first size is the radius")},
        Wanted{mjOBJ_SITE, "delivery", "objects are delivered there",
               in_world("<site name=\"delivery\" type=\"cylinder\" pos=\"-0.08 -0.42 0\" "
                        "size=\"0.15 0.0005\" group=\"4\"/>",
                        " on the table's top")},
        Wanted{mjOBJ_SITE, "scanner", "it is the pose of the sensor",
               in_world("<site name=\"scanner\" pos=\"0.8 0 0.62\" xyaxes=\"0 1 0 0.6018 0 "
                        "-0.7986\" group=\"4\"/>",
                        " where your sensor is: x to the right, y down, z to the workspace")},
        Wanted{mjOBJ_CAMERA, "overview", "`snapshot` uses it",
               in_world("<camera name=\"overview\" pos=\"1.3 -1.62 1.15\" xyaxes=\"0.8107 0.5855 "
                        "0 -0.236 0.3267 0.9152\" fovy=\"42\"/>"),
               false},
        Wanted{mjOBJ_CAMERA, "close", "`trial --snapshots` uses it",
               in_world("<camera name=\"close\" pos=\"0.46 -0.52 0.4\" xyaxes=\"0.7282 0.6854 0 "
                        "-0.2699 0.2867 0.9192\" fovy=\"40\"/>"),
               false}}) {
    CheckOne(model, wanted, file);
  }
}

void CheckTuple(Model& model, const std::string& file, const char* name, mjtObj type,
                const char* what_for, const std::vector<int>& likely) {
  const Cure cure = model.SetTuple(name, type, likely, file);
  if (!CheckOne(model, {mjOBJ_TUPLE, name, what_for, cure}, file)) return;
  if (!model.Tuple(name, type).empty()) return;
  model.Error(mjOBJ_TUPLE, name,
              fmt::format("must have only elements of type {}", mju_type2Str(type)), cure);
}

// Checks that a numeric has this many values, all above 0 if `positive`.
void CheckNumeric(Model& model, const std::string& file, const Wanted& wanted, std::size_t size,
                  bool positive) {
  if (!CheckOne(model, wanted, file)) return;
  const auto values = model.Numeric(wanted.name);
  const auto above_0 = [](double v) { return v > 0.0; };
  if (values.size() == size && (!positive || std::ranges::all_of(values, above_0))) return;
  model.Error(mjOBJ_NUMERIC, wanted.name,
              fmt::format("must have {} {}, it has {}", size,
                          positive ? "numbers above 0" : "numbers", values.size()),
              wanted.cure);
}

// A value repeated `count` times.
std::string Values(std::size_t count, const char* value) {
  return fmt::format("{}", fmt::join(std::vector(count, value), " "));
}

void CheckArmNames(Model& model) {
  const std::string file = model.ArmFile();
  CheckTuple(model, file, "arm_joints", mjOBJ_JOINT, "the arm's joints, base to tip",
             model.arm_joints);
  CheckTuple(model, file, "arm_actuators", mjOBJ_ACTUATOR,
             "the position servos of these joints, in the same order", model.arm_actuators);
  const std::size_t n = model.arm_joints.size();
  for (const auto& [name, unit, value] :
       {std::array{"joint_velocity", "limits in rad/s", "1"},
        std::array{"joint_acceleration", "limits in rad/s^2", "2"}}) {
    CheckNumeric(model, file,
                 {mjOBJ_NUMERIC, name, unit,
                  model.SetNumeric(name, Values(n, value), file) +
                      ", or the values of the data sheet, one per joint"},
                 n, true);
  }
  Cure home = SuggestHome(model);
  if (home.empty()) {
    home = fmt::format(
        "<numeric name=\"home\" data=\"{}\"/> in the arm's file or the scene's: the check of the "
        "scene proposes one",
        Values(n, "0"));
  }
  CheckNumeric(model, file,
               {mjOBJ_NUMERIC, "home", "joint positions of the arm at rest [rad]", home,
                model.kind() == Kind::kScene},
               n, false);
}

// Whether the hand is meant to have one geared motor on hinges instead of drives ("hand_motors").
bool IsGeared(const Model& model) {
  return model.Find(mjOBJ_TUPLE, "hand_motors") < 0 &&
         (model.Find(mjOBJ_TUPLE, "hand_motor") >= 0 ||
          model.Find(mjOBJ_TUPLE, "hand_joints") >= 0);
}

void CheckMotorNames(Model& model, const std::string& file) {
  const internal::HandGuess guess = GuessHand(model);
  CheckTuple(model, file, "hand_motors", mjOBJ_ACTUATOR, "the drives that close the hand",
             guess.motors);
  CheckTuple(model, file, "fingertips", mjOBJ_GEOM,
             "the geoms that may touch a grasped object, the thumb's first (geoms need names)",
             guess.fingertips);
  const auto ends = [&](const char* name, const char* what, const std::string& values) {
    const std::size_t drives = model.Tuple("hand_motors", mjOBJ_ACTUATOR).size();
    CheckNumeric(
        model, file,
        {mjOBJ_NUMERIC, name, what,
         values.empty() ? Cure("one value per drive") : model.SetNumeric(name, values, file)},
        drives > 0 ? drives : guess.motors.size(), false);
  };
  ends("hand_open", "position of each drive's joint or tendon in the open hand [rad or m]",
       guess.open);
  ends("hand_closed", "position of each drive's joint or tendon in the closed hand [rad or m]",
       guess.closed);
  CheckNumeric(model, file,
               {mjOBJ_NUMERIC, "grip_force",
                "the first and the maximum grip force between the two sides [N]",
                model.SetNumeric("grip_force", "20 40", file)},
               2, true);
}

void CheckToolSite(Model& model, const std::string& file) {
  const Cure cure = IsGeared(model) ? Cure(
                                          "a <site> of this name in the body \"hand\", between "
                                          "the tips of the open hand")
                                    : SuggestTool(model);
  CheckOne(model,
           {mjOBJ_SITE, "tcp",
            "the tool center: z is the approach direction, x points from the fingers' pads to the "
            "thumb's",
            cure},
           file);
}

void CheckHandNames(Model& model) {
  const std::string file = model.HandFile();
  const char* attach =
      "attach a hand to the last link, e.g. in <asset> <model name=\"hand\" "
      "file=\"PATH/models/hand/sensorhand.xml\"/> and in the last body\n<frame pos=\"FLANGE\" "
      "xyaxes=\"0 1 0 0 0 1\">\n  <frame pos=\"-0.010 0.075 -0.020\">\n    <attach model=\"hand\" "
      "body=\"hand\" prefix=\"hand/\"/>\n  </frame>\n</frame>\nwhere FLANGE is the position of the "
      "flange, whose axis is z";
  const Cure rename =
      model.kind() == Kind::kHand && model.m().nbody > 1 ? model.Rename(1, "hand") : Cure(attach);
  if (!CheckOne(model, {mjOBJ_BODY, "hand", "the hand's root", rename},
                model.HasArm() ? model.ArmFile() : file)) {
    if (model.kind() != Kind::kHand || model.m().nbody < 2) return;
    model.hand = 1;  // reports what else is missing at once
  }
  if (IsGeared(model)) {
    CheckTuple(model, file, "hand_joints", mjOBJ_JOINT, "the driven joints, the thumb's first", {});
    CheckTuple(model, file, "hand_motor", mjOBJ_ACTUATOR, "the drives of these joints", {});
    CheckTuple(model, file, "fingertips", mjOBJ_GEOM, "the geoms that may touch a grasped object",
               {});
  } else {
    CheckMotorNames(model, file);
  }
  CheckToolSite(model, file);
  CheckOne(
      model,
      {mjOBJ_TUPLE, "grip_sensors", "the hand measures neither pressure nor slip",
       "if it has sensors: <touch> sensors on the last segments, named in a tuple of this name",
       false},
      file);
}

constexpr int kFewestOfAnArm = 5;  // joints in a chain, if the file says nothing else

// A message of the engine or a loader as a finding; its leading file and line are split off.
Finding FindingOf(const std::filesystem::path& mjcf, const base::InputError& error,
                  const std::string& element = "", const std::string& cure = "") {
  const std::string what = error.what();
  const std::size_t end = what.find(": ");
  const std::string where = what.substr(0, end);
  if (end == std::string::npos || where.find(".xml") == std::string::npos) {
    return {true, mjcf.string(), element, what, cure};
  }
  return {true, where, element, what.substr(end + 2), cure};
}

// The engine names the element that a tuple lists and that does not exist.
std::string CureOfTuple(const std::string& what) {
  if (what.find("unrecognized object") == std::string::npos ||
      what.find("in tuple") == std::string::npos) {
    return "";
  }
  return "list names that elements of this file have (name=\"...\"); or remove the tuple: this "
         "check then prints one that fits, with names for elements that have none";
}

// Objects.

constexpr int kSegments = 32;  // for round primitives
// Principal moments relative to those of its homogeneous hull of the same mass: a hammer has 0.3 to
// 2.5, a shell up to 1.7.
constexpr double kMinInertia = 0.1;
constexpr double kMaxInertia = 4.0;
// Visible and collision geometry may differ in size by this share.
constexpr double kMaxMismatch = 0.25;
// A colliding mesh with less than this share of its hull's volume has a hollow that gets closed.
constexpr double kMinConvexity = 0.85;

std::string Mm(double length_m) { return fmt::format("{:.4g} mm", length_m * base::kMmPerM); }

double LongestEdge(const geometry::Points& points) {
  return points.empty() ? 0.0 : geometry::BoundsOf(points).sizes().maxCoeff();
}

// A compiled object at its zero pose, and its findings.
class Checked {
 public:
  Checked(const sim::ObjectModel& object, double min_tipping_rad)
      : object_(object),
        min_tipping_rad_(min_tipping_rad),
        built_(sim::internal::BuildObject(object)) {
    data_ = sim::internal::DataAtZero(model());
    sim::internal::ColorsOfGeoms colors(model());
    seen_ = sim::internal::VisualOfTree(model(), data_.get(), root(), colors).mesh_W.vertices;
    solid_ = sim::internal::CollisionVertices(model(), data_.get(), kSegments);
  }

  std::vector<Finding> Findings() {
    CheckSize();
    if (found_.empty()) {
      CheckSeen();
      CheckMass();
      CheckResting();
    }
    CheckConvex();
    CheckSurface();
    std::ranges::stable_partition(found_, &Finding::error);
    return std::move(found_);
  }

 private:
  const mjModel* model() const { return built_.model.get(); }
  int root() const { return built_.objects[0].body; }

  void Say(bool error, const std::string& element, const std::string& what,
           const std::string& cure) {
    found_.push_back({error, object_.mjcf.string(), element, what, cure});
  }
  std::string Body() const {
    return fmt::format("body \"{}\"", mj_id2name(model(), mjOBJ_BODY, root()));
  }

  void Error(const std::string& what, const std::string& cure) { Say(true, Body(), what, cure); }

  void CheckSize() {
    const double size = LongestEdge(solid_);
    if (size > kMaxSize_m) {
      Error(
          fmt::format("the collision geometry is {:.4g} m long: is the mesh in millimetres?", size),
          "write scale=\"0.001 0.001 0.001\" in each <mesh>, and correct mass and inertia; "
          "`rangegrasp add-object` does both");
    } else if (size < kMinSize_m) {
      Error(fmt::format("the collision geometry is {} long: too small for a hand", Mm(size)),
            "write a scale in each <mesh>, e.g. scale=\"1000 1000 1000\"");
    }
  }

  void CheckSeen() {
    if (seen_.empty()) {
      Error("no visible geom: sensors see the groups 0 to 2",
            "add <geom group=\"2\" contype=\"0\" conaffinity=\"0\" mass=\"0\" .../> of its shape");
      return;
    }
    const double seen = LongestEdge(seen_), solid = LongestEdge(solid_);
    if (std::abs(seen - solid) <= kMaxMismatch * std::max(seen, solid)) return;
    Error(fmt::format("the visible geometry is {} long, the collision geometry {}", Mm(seen),
                      Mm(solid)),
          "give both the same shape and, in <mesh>, the same scale");
  }

  void CheckMass() {
    const geometry::TriangleMesh hull = geometry::ConvexHull(solid_);
    const geometry::MassProperties filled = geometry::MassPropertiesOf(hull);
    if (!(filled.volume_m3 > 0.0)) {
      Error("the collision geometry has no volume", "give it a solid shape");
      return;
    }
    const double mass = model()->body_subtreemass[root()];
    const double density = mass / filled.volume_m3;
    if (density < sim::kMinDensity_kg_m3 || density > sim::kMaxDensity_kg_m3) {
      Error(
          fmt::format("its mass of {:.4g} kg is implausible: {:.3g} kg/m3 in its hull, {:g} to "
                      "{:g} are possible",
                      mass, density, sim::kMinDensity_kg_m3, sim::kMaxDensity_kg_m3),
          "state the mass in kg in <inertial> or in a geom's mass=\"...\"; `rangegrasp add-object "
          "--mass` is in grams");
      return;
    }
    CheckInertia(density * filled.inertia_M, hull);
  }

  // Only for one rigid body: with joints, the inertia changes.
  void CheckInertia(const Eigen::Matrix3d& filled, const geometry::TriangleMesh& hull) {
    if (model()->nbody != root() + 1) return;
    Vector3d own = sim::internal::Vec3(model()->body_inertia + 3 * root());
    std::sort(own.begin(), own.end());
    const Vector3d even = base::SymmetricEigen(filled).values;
    for (int axis = 0; axis < 3; ++axis) {
      const double share = own[axis] / even[axis];
      if (share >= kMinInertia && share <= kMaxInertia) continue;
      Error(fmt::format(
                "its inertia is implausible: a principal moment of {:.3g} kg m2, {:.3g} times that "
                "of a homogeneous hull of the same mass ({:g} to {:g} are possible)",
                own[axis], share, kMinInertia, kMaxInertia),
            fmt::format("diaginertia=\"{:.3g} {:.3g} {:.3g}\" of its hull; or omit <inertial> and "
                        "set the mass of the collision geoms",
                        even[0], even[1], even[2]));
      return;
    }
    geometry::Points with_center = hull.vertices;
    with_center.push_back(sim::internal::CenterOfMass(model(), data_.get(), root()));
    const double inside = geometry::Volume(hull);
    if (geometry::Volume(geometry::ConvexHull(with_center)) <= inside * (1.0 + 1e-6)) return;
    Error("its center of mass is outside the collision geometry",
          "correct pos=\"...\" of <inertial>");
  }

  void CheckResting() {
    if (!sim::StableRestingPoses(object_, min_tipping_rad_).empty()) return;
    Error(fmt::format("it has no stable resting pose: every pose tips over at less than {:.0f} deg",
                      base::ToDeg(min_tipping_rad_)),
          "give it a flat side, or lower min_tipping_deg in the experiment");
  }

  void CheckConvex() {
    for (int geom = 0; geom < model()->ngeom; ++geom) {
      if (!sim::internal::Collides(model(), geom) || model()->geom_type[geom] != mjGEOM_MESH)
        continue;
      const auto mesh = sim::internal::GeomSurface(model(), geom, kSegments);
      const double hull = geometry::Volume(geometry::ConvexHull(mesh.vertices));
      const double share = std::abs(geometry::Volume(mesh)) / hull;
      if (!(share < kMinConvexity)) continue;
      Say(false,
          fmt::format("mesh \"{}\"", mjcf::NameOf(model(), mjOBJ_MESH, model()->geom_dataid[geom])),
          fmt::format(
              "is not convex: its convex hull is used for collisions, of which it fills {:.0f} %",
              100.0 * share),
          "cut it into convex parts, e.g. with `rangegrasp add-object`");
    }
  }

  void CheckSurface() {
    if (mj_name2id(model(), mjOBJ_TEXT, "surface") >= 0) return;
    Say(false, Body(), "has no surface: friction and reflection of cardboard are used",
        "write <text name=\"surface\" data=\"cardboard\"/> in <custom>, or another of "
        "models/surfaces.yaml");
  }

  const sim::ObjectModel& object_;
  double min_tipping_rad_;
  sim::internal::BuiltScene built_;
  sim::internal::DataPtr data_;
  geometry::Points seen_, solid_;
  std::vector<Finding> found_;
};

}  // namespace

Kind KindOf(const std::filesystem::path& mjcf) {
  const internal::SourceLines lines(mjcf);
  const auto has = [&](const char* what) { return lines.seen().contains(what); };
  if (has("site workspace")) return Kind::kScene;
  if (has("tuple arm_joints")) return Kind::kArm;
  if (has("freejoint")) return Kind::kObject;
  if (has("tuple hand_joints") || has("tuple hand_motors")) return Kind::kHand;
  if (lines.longest_chain() >= kFewestOfAnArm) return Kind::kArm;
  return lines.longest_chain() > 0 ? Kind::kHand : Kind::kScene;
}

std::vector<Finding> CheckModel(const std::filesystem::path& mjcf, Kind kind) {
  std::vector<Finding> findings;
  try {
    Model model(mjcf, kind);
    if (kind == Kind::kScene) CheckSceneNames(model);
    if (model.HasArm()) CheckArmNames(model);
    CheckHandNames(model);
    CheckArm(model);
    CheckHand(model);
    CheckBodies(model);
    CheckContacts(model);
    CheckCell(model);
    try {
      CheckMotion(model);
      findings = model.findings();
    } catch (const base::InputError&) {
      findings = model.findings();
      throw;
    }
  } catch (const base::InputError& error) {
    findings.push_back(FindingOf(mjcf, error, "", CureOfTuple(error.what())));
  }
  std::ranges::stable_partition(findings, &Finding::error);
  return findings;
}

bool IsObjectFile(const std::filesystem::path& mjcf) { return sim::internal::IsObject(mjcf); }

std::vector<Finding> CheckObject(const sim::ObjectModel& object, double min_tipping_rad) {
  try {
    return Checked(object, min_tipping_rad).Findings();
  } catch (const base::InputError& error) {
    return {FindingOf(object.mjcf, error, "object",
                      "correct what is named above; docs/bring-your-own.md shows the content of "
                      "an object's file")};
  }
}

}  // namespace rangegrasp::check
