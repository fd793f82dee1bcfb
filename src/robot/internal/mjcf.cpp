#include "robot/internal/mjcf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/error.h"
#include "robot/mjcf/names.h"

namespace rangegrasp::robot::internal {
namespace {

// While one lives, the engine neither prints warnings nor leaves a log file: a scene's are told by
// who compiles it to simulate it.
class QuietEngine {
 public:
  QuietEngine() : before_(mju_setLogHandler([](const mjLogMessage*) {})) {}
  ~QuietEngine() { mju_setLogHandler(before_); }
  QuietEngine(const QuietEngine&) = delete;
  QuietEngine& operator=(const QuietEngine&) = delete;

 private:
  mjfLogHandler before_;
};

geometry::Shape::Kind KindOf(int type) {
  using Kind = geometry::Shape::Kind;
  switch (type) {
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
      return Kind::kConvex;
  }
}

/// The convex hull that MuJoCo collides for a mesh. Layout of mesh_graph: numvert, numface,
/// vert_edgeadr[numvert], vert_globalid[numvert], edge_localid[numvert + 3 numface],
/// face_globalid[3 numface].
geometry::TriangleMesh HullOf(const mjModel& m, int mesh) {
  geometry::TriangleMesh out;
  const float* vertices = m.mesh_vert + 3 * m.mesh_vertadr[mesh];
  for (int i = 0; i < m.mesh_vertnum[mesh]; ++i) {
    out.vertices.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
  }
  const int* faces = m.mesh_face + 3 * m.mesh_faceadr[mesh];
  int count = m.mesh_facenum[mesh];
  if (m.mesh_graphadr[mesh] >= 0) {
    const int* graph = m.mesh_graph + m.mesh_graphadr[mesh];
    count = graph[1];
    faces = graph + 2 + 3 * graph[0] + 3 * graph[1];
  }
  for (int i = 0; i < count; ++i) {
    out.triangles.push_back({static_cast<std::uint32_t>(faces[3 * i]),
                             static_cast<std::uint32_t>(faces[3 * i + 1]),
                             static_cast<std::uint32_t>(faces[3 * i + 2])});
  }
  return out;
}

}  // namespace

base::Pose FromPosQuat(const mjtNum* pos, const mjtNum* quat) {
  const Eigen::Quaterniond q(quat[0], quat[1], quat[2], quat[3]);
  return base::MakePose(q.normalized().toRotationMatrix(), {pos[0], pos[1], pos[2]});
}

base::Pose FromPosMat(const mjtNum* pos, const mjtNum* mat) {
  Eigen::Matrix3d R;
  R << mat[0], mat[1], mat[2], mat[3], mat[4], mat[5], mat[6], mat[7], mat[8];
  return base::MakePose(R, {pos[0], pos[1], pos[2]});
}

Mjcf::Mjcf(const std::filesystem::path& file)
    : file_(file), model_(nullptr, mj_deleteModel), data_(nullptr, mj_deleteData) {
  std::array<char, 1000> text{};
  // Of a relative path the engine loses what an included file refers to.
  const std::string path = std::filesystem::absolute(file).string();
  {
    const QuietEngine quiet;
    model_.reset(mj_loadXML(path.c_str(), nullptr, text.data(), static_cast<int>(text.size())));
  }
  if (!model_) throw base::InputError(file.string() + ": " + text.data());
  data_.reset(mj_makeData(model_.get()));
  mj_kinematics(model_.get(), data_.get());
}

void Mjcf::Fail(const std::string& what) const {
  throw base::InputError(file_.string() + ": " + what);
}

std::string Mjcf::Name(mjtObj type, int id) const {
  const char* name = mj_id2name(model_.get(), type, id);
  return name ? name : "";
}

std::string Mjcf::GeomTitle(int geom) const {
  const std::string name = Name(mjOBJ_GEOM, geom);
  if (!name.empty()) return name;
  const std::string body = Name(mjOBJ_BODY, model_->geom_bodyid[geom]);
  return "a geom of " + (body.empty() ? "a body without a name" : body);
}

int Mjcf::Require(mjtObj type, std::string_view name) const {
  int found = -1;
  const std::string what = fmt::format("{} \"{}\"", mju_type2Str(type), name);
  for (int id = 0; id < mjcf::CountOf(model_.get(), type); ++id) {
    if (mjcf::Suffix(Name(type, id)) != name) continue;
    if (found >= 0) {
      Fail(fmt::format("{} is there twice: {} and {}", what, Name(type, found), Name(type, id)));
    }
    found = id;
  }
  if (found < 0) Fail(fmt::format("no {} (with any prefix)", what));
  return found;
}

int Mjcf::FindIfAny(mjtObj type, std::string_view name) const {
  return mjcf::TryFind(model_.get(), type, name);
}

std::vector<int> Mjcf::TupleIfAny(std::string_view name, mjtObj type) const {
  return FindIfAny(mjOBJ_TUPLE, name) >= 0 ? Tuple(name, type) : std::vector<int>();
}

std::vector<int> Mjcf::Tuple(std::string_view name, mjtObj type) const {
  const int id = Require(mjOBJ_TUPLE, name);
  const int* types = model_->tuple_objtype + model_->tuple_adr[id];
  const int* ids = model_->tuple_objid + model_->tuple_adr[id];
  const int size = model_->tuple_size[id];
  if (size == 0 || !std::all_of(types, types + size, [&](int t) { return t == type; })) {
    Fail(fmt::format("tuple \"{}\" should hold elements of type {}", name, mju_type2Str(type)));
  }
  return {ids, ids + size};
}

Eigen::VectorXd Mjcf::Numeric(std::string_view name, int size) const {
  const int id = Require(mjOBJ_NUMERIC, name);
  if (model_->numeric_size[id] != size) {
    Fail(fmt::format("numeric \"{}\" should hold {} values", name, size));
  }
  return Eigen::Map<const Eigen::VectorXd>(model_->numeric_data + model_->numeric_adr[id], size);
}

bool Mjcf::InSubtree(int body, int root) const { return mjcf::InSubtree(model_.get(), body, root); }

bool Mjcf::Collides(int geom) const {
  return model_->geom_contype[geom] != 0 || model_->geom_conaffinity[geom] != 0;
}

geometry::Shape Mjcf::ShapeOf(int geom, const base::Pose& X_BS) const {
  const mjModel& m = *model_;
  geometry::Shape shape;
  shape.kind = KindOf(m.geom_type[geom]);
  shape.X_BS = X_BS;
  shape.size = Eigen::Map<const Eigen::Vector3d>(m.geom_size + 3 * geom);
  shape.name = Name(mjOBJ_GEOM, geom);
  if (shape.kind == geometry::Shape::Kind::kConvex) {
    if (m.geom_type[geom] != mjGEOM_MESH)
      Fail(fmt::format("geom \"{}\": unsupported type", shape.name));
    shape.mesh = HullOf(m, m.geom_dataid[geom]);
  }
  return shape;
}

base::Pose Mjcf::BodyPose(int body) const {
  return FromPosMat(data_->xpos + 3 * body, data_->xmat + 9 * body);
}
base::Pose Mjcf::GeomPose(int geom) const {
  return FromPosMat(data_->geom_xpos + 3 * geom, data_->geom_xmat + 9 * geom);
}
base::Pose Mjcf::SitePose(int site) const {
  return FromPosMat(data_->site_xpos + 3 * site, data_->site_xmat + 9 * site);
}

}  // namespace rangegrasp::robot::internal
