#include "sim/check/internal/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "sim/internal/scene_builder.h"

namespace rangegrasp::check::internal {
namespace {

// Hinges from the world to a body, base to tip.
std::vector<int> HingesTo(const mjModel& m, int body) {
  std::vector<int> joints;
  for (; body > 0; body = m.body_parentid[body]) {
    for (int k = m.body_jntnum[body]; k-- > 0;) {
      const int joint = m.body_jntadr[body] + k;
      if (m.jnt_type[joint] == mjJNT_HINGE) joints.push_back(joint);
    }
  }
  std::ranges::reverse(joints);
  return joints;
}

bool InWorld(const pugi::xml_node& node) {
  pugi::xml_node above = node.parent();
  while (above && above.name() != std::string_view("worldbody")) above = above.parent();
  return above;
}

// The kind of an element that has a name of its own, or is a drive; empty for all others.
std::string KindOf(const pugi::xml_node& node) {
  const std::string tag = node.name();
  const std::string parent = node.parent().name();
  const bool has_name = *node.attribute("name").value() != '\0';  // name="" is none
  if (parent == "actuator" && !has_name) return kUnnamedDrive;
  if (parent == "actuator" || parent == "sensor") return parent;
  if (tag == "tuple" || tag == "numeric" || tag == "mesh") return tag;
  if (!InWorld(node)) return "";
  if (tag == "freejoint") return "joint";
  static const std::set<std::string> named = {"body", "joint", "geom", "site", "camera"};
  return named.contains(tag) ? tag : "";
}

std::string NameOf(const pugi::xml_node& node) {
  const std::string name = node.attribute("name").value();
  const std::string file = node.attribute("file").value();
  if (KindOf(node) == kUnnamedDrive) return node.attribute("joint").value();
  if (!name.empty() || std::string(node.name()) != "mesh") return name;
  return std::filesystem::path(file).stem().string();
}

// XPath of an element that has a name, or a file or joint in place of a name.
std::string XPathOf(const pugi::xml_node& node, const std::string& kind) {
  const bool moves = kind != node.parent().name() && InWorld(node);
  const bool unnamed_drive = kind == kUnnamedDrive;
  const char* key = unnamed_drive ? "joint" : node.attribute("name") ? "name" : "file";
  if (std::string_view(node.attribute(key).value()).find('\'') != std::string::npos) return "";
  const std::string has = fmt::format("[@{}='{}']", key, node.attribute(key).value());
  // Another drive on the same joint could be edited in its place.
  if (unnamed_drive && node.root().select_nodes(("//actuator/*" + has).c_str()).size() > 1) {
    return "";
  }
  return (moves ? "//worldbody//" : "//") + std::string(node.name()) + has;
}

// Number of joints on a joint's body and on all bodies above it.
int JointsAbove(const pugi::xml_node& joint) {
  return static_cast<int>(joint.select_nodes("ancestor::body/joint").size());
}

}  // namespace

std::string TextOf(const Attributes& attributes) {
  std::string text;
  for (const auto& [name, value] : attributes) {
    if (value.empty()) continue;
    text += fmt::format("{}{}=\"{}\"", text.empty() ? "" : " ", name, value);
  }
  return text;
}

Model::Model(const std::filesystem::path& mjcf, Kind kind)
    : file_(mjcf), kind_(kind), lines_(mjcf) {
  model_ = sim::internal::BuildScene(mjcf, {}, {}).model;
  data_.reset(mj_makeData(model_.get()));
  FindArm();
  SetHome();
}

void Model::FindArm() {
  hand = Find(mjOBJ_BODY, "hand");
  if (!HasArm()) return;
  arm_joints = Tuple("arm_joints", mjOBJ_JOINT);
  const bool guessed_joints = arm_joints.empty();
  if (guessed_joints && hand >= 0) arm_joints = HingesTo(m(), m().body_parentid[hand]);
  for (int body = 1; guessed_joints && hand < 0 && body < m().nbody; ++body) {
    const auto joints = HingesTo(m(), body);
    if (joints.size() > arm_joints.size()) arm_joints = joints;
  }
  arm_actuators = Tuple("arm_actuators", mjOBJ_ACTUATOR);
  if (arm_actuators.empty()) arm_actuators = DrivesOfArm();
  if (arm_actuators.size() != arm_joints.size()) arm_actuators.clear();
  home = Numeric("home");
  if (home.size() != arm_joints.size()) home.clear();
}

int Model::DriveOf(int joint) const {
  for (int a = 0; a < m().nu; ++a) {
    if (m().actuator_trntype[a] == mjTRN_JOINT && m().actuator_trnid[2 * a] == joint) return a;
  }
  return -1;
}

std::vector<int> Model::DrivesOfArm() const {
  std::vector<int> drives;
  for (const int joint : arm_joints) drives.push_back(DriveOf(joint));
  if (std::ranges::find(drives, -1) != drives.end()) drives.clear();
  return drives;
}

void Model::SetArm(const double* q) {
  sim::internal::SetJoints(&m(), &d(), arm_joints, q);
  mj_kinematics(&m(), &d());
}

void Model::SetHome() {
  std::vector<double> q = home;
  for (std::size_t i = q.size(); i < arm_joints.size(); ++i) {
    const auto [low, high] = RangeOf(arm_joints[i], mjPI);
    q.push_back(0.5 * (low + high));
  }
  SetArm(q.data());
  mj_comPos(&m(), &d());
}

std::vector<int> Model::FindAll(mjtObj type, std::string_view suffix) const {
  std::vector<int> ids;
  for (int id = 0; id < mjcf::CountOf(&m(), type); ++id) {
    if (mjcf::Suffix(Name(type, id)) == suffix) ids.push_back(id);
  }
  return ids;
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

std::pair<std::string, std::string> Model::KeyOf(mjtObj type, int id) const {
  const std::string name = Name(type, id);
  const bool drive = type == mjOBJ_ACTUATOR && id >= 0 && m().actuator_trntype[id] == mjTRN_JOINT;
  if (drive && name.empty()) {
    return {kUnnamedDrive, Name(mjOBJ_JOINT, m().actuator_trnid[2 * id])};
  }
  return {mju_type2Str(type), name};
}

std::string Model::Element(mjtObj type, int id) const {
  const auto [kind, name] = KeyOf(type, id);
  if (name.empty() && type == mjOBJ_GEOM) {
    return fmt::format("a geom of body \"{}\"", BodyName(m().geom_bodyid[id]));
  }
  return fmt::format("{} \"{}\"", kind, name);
}

std::string Model::Where(mjtObj type, int id) const {
  const auto [kind, name] = KeyOf(type, id);
  if (name.empty() && type == mjOBJ_GEOM) return Where(mjOBJ_BODY, m().geom_bodyid[id]);
  return lines_.Of(kind, name);
}

std::string Model::ArmFile() const {
  if (arm_joints.empty()) return file_.string();
  return lines_.FileOf("joint", Name(mjOBJ_JOINT, arm_joints.front()));
}

std::string Model::HandFile() const {
  return hand < 0 ? file_.string() : lines_.FileOf("body", Name(mjOBJ_BODY, hand));
}

void Model::Report(bool error, mjtObj type, const std::string& name, const std::string& what,
                   const Cure& cure) {
  Report(error, Where(type, Find(type, name)), fmt::format("{} \"{}\"", mju_type2Str(type), name),
         what, cure);
}

void Model::Report(bool error, mjtObj type, const std::vector<int>& ids, const std::string& what,
                   const Cure& cure) {
  const std::string kind = type == mjOBJ_BODY ? "bodies" : mju_type2Str(type) + std::string("s");
  Report(error, Where(type, ids.front()), kind + " " + NamesOf(type, ids), what, cure);
}

Cure Model::Set(mjtObj type, int id, const Attributes& attributes) const {
  const auto [kind, name] = KeyOf(type, id);
  auto edit = lines_.EditOf(kind, name);
  if (edit) {
    edit->set = attributes;
    return Cure({*edit});
  }
  return TextOf(attributes);
}

Cure Model::Replace(mjtObj type, int id, const std::string& block) const {
  const auto [kind, name] = KeyOf(type, id);
  auto edit = lines_.EditOf(kind, name);
  if (!edit) return "instead " + block;
  edit->block = block;
  edit->replace = true;
  return Cure({*edit});
}

Cure Model::SetNumeric(const std::string& name, const std::string& data,
                       const std::string& file) const {
  if (data.empty()) return fmt::format("in <custom>: <numeric name=\"{}\" data=\"...\"/>", name);
  const int id = Find(mjOBJ_NUMERIC, name);
  if (id >= 0) return Set(mjOBJ_NUMERIC, id, {{"data", data}});
  return Cure::Insert(file, "/*/custom",
                      fmt::format("<numeric name=\"{}\" data=\"{}\"/>", name, data));
}

Cure Model::SetTuple(const std::string& name, mjtObj type, const std::vector<int>& ids,
                     const std::string& file) const {
  Cure cure;
  std::string block = fmt::format("<tuple name=\"{}\">\n", name);
  bool known = !ids.empty();
  bool unnamed = false;
  for (const int id : known ? ids : std::vector{-1}) {
    // Within its own file, an element has no prefixes of attachments.
    std::string element(mjcf::Suffix(Name(type, id)));
    if (type == mjOBJ_GEOM && id >= 0) element = NameGeom(id, cure);
    if (type == mjOBJ_ACTUATOR && id >= 0) element = NameDrive(id, cure);
    unnamed = unnamed || (id >= 0 && element.empty());
    known = known && !element.empty();
    block += fmt::format("  <element objtype=\"{}\" objname=\"{}\"/>\n", mju_type2Str(type),
                         element.empty() ? "NAME" : element);
  }
  block += "</tuple>";
  if (unnamed) {
    return fmt::format(
        "give each {0} a name=\"...\"; without one it cannot be listed. In <custom>:\n{1}",
        mju_type2Str(type), block);
  }
  if (!known) return "in <custom>:\n" + block;
  const int old = Find(mjOBJ_TUPLE, name);
  if (old >= 0) return cure + Replace(mjOBJ_TUPLE, old, block);
  // The engine drops a tuple of an attached file that lists what does not exist.
  pugi::xml_document document;
  const std::string dropped = fmt::format("//tuple[@name='{}']", name);
  if (document.load_file(file.c_str()) && document.select_node(dropped.c_str())) {
    return cure + Cure({{.file = file, .element = dropped, .block = block, .replace = true}});
  }
  return cure + Cure::Insert(file, "/*/custom", block);
}

Cure Model::Stiffer(int actuator, double times) const {
  const mjtNum* bias = m().actuator_biasprm + actuator * mjNBIAS;
  const double kv = -std::sqrt(times) * bias[2];  // the same damping ratio
  const double kp = times * m().actuator_gainprm[actuator * mjNGAIN];
  const auto edit = lines_.EditOf("actuator", Name(mjOBJ_ACTUATOR, actuator));
  if (edit && edit->element.starts_with("//general")) {
    return Set(mjOBJ_ACTUATOR, actuator,
               {{"gainprm", fmt::format("{:.4g}", kp)},
                {"biasprm", fmt::format("{:g} {:.4g} {:.4g}", bias[0], times * bias[1], -kv)}});
  }
  return Set(mjOBJ_ACTUATOR, actuator,
             {{"kp", fmt::format("{:.4g}", kp)},
              {"kv", bias[2] == 0.0 ? "" : fmt::format("{:.4g}", kv)},
              {"dampratio", ""}});
}

Cure Model::Rename(int body, const std::string& name) const {
  const std::string old = Name(mjOBJ_BODY, body);
  if (old.empty()) return fmt::format("name=\"{}\" in its <body>", name);
  Cure cure = Set(mjOBJ_BODY, body, {{"name", name}});
  for (const char* reference : {"body1", "body2", "objname"}) {
    cure.edits.push_back({.file = file_.string(),
                          .element = fmt::format("//*[@{}='{}']", reference, old),
                          .set = {{reference, name}}});
  }
  return cure;
}

Cure Model::Exclude(int body1, int body2) const {
  return Cure::Insert(
      file_.string(), "/*/contact",
      fmt::format("<exclude body1=\"{}\" body2=\"{}\"/>", BodyName(body1), BodyName(body2)));
}

std::string Model::NameGeom(int geom, Cure& cure) const {
  const std::string own = Name(mjOBJ_GEOM, geom);
  if (!own.empty()) return std::string(mjcf::Suffix(own));
  const int body = m().geom_bodyid[geom];
  const auto parent = lines_.EditOf("body", Name(mjOBJ_BODY, body));
  pugi::xml_document document;
  if (!parent || !document.load_file(parent->file.c_str())) return "";
  const pugi::xml_node node = document.select_node(parent->element.c_str()).node();
  const auto geoms = node.children("geom");
  // The engine counts geoms of frames and of omitted meshes in another way.
  if (std::distance(geoms.begin(), geoms.end()) != m().body_geomnum[body]) return "";
  const int place = geom - m().body_geomadr[body];
  const std::string name = fmt::format("{}_{}", mjcf::Suffix(Name(mjOBJ_BODY, body)), place + 1);
  if (Find(mjOBJ_GEOM, name) >= 0) return "";
  cure.edits.push_back({.file = parent->file,
                        .element = fmt::format("{}/geom[{}]", parent->element, place + 1),
                        .set = {{"name", name}}});
  return name;
}

std::string Model::NameDrive(int actuator, Cure& cure) const {
  const std::string own = Name(mjOBJ_ACTUATOR, actuator);
  if (!own.empty()) return std::string(mjcf::Suffix(own));
  if (m().actuator_trntype[actuator] != mjTRN_JOINT) return "";
  const std::string joint = Name(mjOBJ_JOINT, m().actuator_trnid[2 * actuator]);
  const std::string name = "servo_" + std::string(mjcf::Suffix(joint));
  auto edit = lines_.EditOf(kUnnamedDrive, joint);
  // A tuple of the joint's file can list only drives of this file.
  if (!edit || edit->file != lines_.FileOf("joint", joint) || Find(mjOBJ_ACTUATOR, name) >= 0) {
    return "";
  }
  edit->set = {{"name", name}};
  cure.edits.push_back(*edit);
  return name;
}

std::string Model::BodyName(int body) const {
  const std::string name = Name(mjOBJ_BODY, body);
  return name.empty() ? fmt::format("body {}", body) : name;
}

std::string Model::BothNames(int body1, int body2) const {
  return fmt::format("bodies \"{}\" and \"{}\"", BodyName(body1), BodyName(body2));
}

std::string Model::NamesOf(mjtObj type, const std::vector<int>& ids) const {
  std::vector<std::string> names;
  for (const int id : ids) names.push_back(type == mjOBJ_BODY ? BodyName(id) : Name(type, id));
  return base::Join(names);
}

bool Model::IsRobot(int body) const {
  const int first = arm_joints.empty() ? -1 : m().jnt_bodyid[arm_joints.front()];
  return (first > 0 && InSubtree(body, first)) || (hand > 0 && InSubtree(body, hand));
}

std::vector<int> Model::RobotBodies() const {
  std::vector<int> bodies;
  for (int body = 1; body < m().nbody; ++body) {
    if (IsRobot(body)) bodies.push_back(body);
  }
  return bodies;
}

struct SourceLines::Reader {
  SourceLines& lines;

  // One file, with the models that it attaches.
  struct File {
    std::filesystem::path path;
    std::string text;
    std::string prefix;
    int depth;
    bool own;  // not attached
    std::map<std::string, std::filesystem::path> models;

    int LineOf(const pugi::xml_node& node) const {
      return sim::internal::LineAt(text, std::max<std::ptrdiff_t>(0, node.offset_debug()));
    }
  };

  void Read(const std::filesystem::path& path, const std::string& prefix, int depth, bool own) {
    if (depth > kMaxDepth || !std::filesystem::is_regular_file(path)) return;
    File file{path.lexically_normal(), base::ReadFile(path), prefix, depth, own, {}};
    pugi::xml_document document;
    const auto read = document.load_buffer(file.text.data(), file.text.size());
    if (!read && depth == 0) {
      const int line = sim::internal::LineAt(file.text, std::max<std::ptrdiff_t>(0, read.offset));
      throw base::InputError(
          fmt::format("{}:{}: not XML: {}", path.string(), line, read.description()));
    }
    for (const auto& found : document.select_nodes("//asset/model")) {
      const pugi::xml_node model = found.node();
      const std::filesystem::path of = path.parent_path() / model.attribute("file").value();
      file.models[model.attribute("name").value()] = of;
    }
    Walk(document.root(), file);
  }

  void Walk(const pugi::xml_node& node, File& file) {
    for (const pugi::xml_node& child : node.children()) {
      const std::string tag = child.name();
      if (tag == "include") {
        Read(file.path.parent_path() / child.attribute("file").value(), file.prefix, file.depth + 1,
             file.own);
      } else if (tag == "attach") {
        const auto model = file.models.find(child.attribute("model").value());
        if (model == file.models.end()) continue;
        Read(model->second, file.prefix + child.attribute("prefix").value(), file.depth + 1, false);
      } else {
        Note(child, file);
        Walk(child, file);
      }
    }
  }

  void Note(const pugi::xml_node& node, const File& file) {
    const std::string tag = node.name();
    const bool in_world = InWorld(node);
    const std::string type = node.attribute("type").value();
    if (file.own && in_world && (tag == "freejoint" || (tag == "joint" && type == "free"))) {
      lines.seen_.insert("freejoint");
    } else if (file.own && in_world && tag == "joint" && type != "ball") {
      lines.longest_chain_ = std::max(lines.longest_chain_, JointsAbove(node));
    }
    const std::string kind = KindOf(node);
    const std::string name = NameOf(node);
    if (kind.empty() || name.empty()) return;
    if (file.own) lines.seen_.insert(kind + " " + std::string(mjcf::Suffix(name)));
    lines.lines_.try_emplace(kind + " " + file.prefix + name,
                             Line{file.path.string(), file.LineOf(node), XPathOf(node, kind)});
  }
};

SourceLines::SourceLines(const std::filesystem::path& mjcf)
    : root_(mjcf.lexically_normal().string()) {
  sim::internal::NeedMjcf(mjcf);
  Reader{*this}.Read(mjcf, "", 0, true);
}

std::string SourceLines::Of(const std::string& kind, const std::string& name) const {
  const auto found = lines_.find(kind + " " + name);
  if (found == lines_.end()) return root_;
  return found->second.file + ":" + std::to_string(found->second.line);
}

std::string SourceLines::FileOf(const std::string& kind, const std::string& name) const {
  const auto found = lines_.find(kind + " " + name);
  return found == lines_.end() ? root_ : found->second.file;
}

std::optional<base::Edit> SourceLines::EditOf(const std::string& kind,
                                              const std::string& name) const {
  auto found = lines_.find(kind + " " + name);
  if (found == lines_.end()) {
    found = std::ranges::find_if(lines_, [&](const auto& line) {
      return line.first.starts_with(kind + " ") &&
             mjcf::Suffix(line.first.substr(kind.size() + 1)) == name;
    });
  }
  if (found == lines_.end() || found->second.element.empty()) return std::nullopt;
  return base::Edit{.file = found->second.file, .element = found->second.element};
}

}  // namespace rangegrasp::check::internal
