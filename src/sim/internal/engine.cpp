#include "sim/internal/engine.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <limits>
#include <mutex>

#include "base/error.h"

namespace rangegrasp::sim::internal {
namespace {

using Eigen::Vector3d;

struct Recovery;
thread_local Recovery* recovery = nullptr;  // of the innermost call

struct Recovery {
  explicit Recovery(std::vector<std::string>* collected) : warnings(collected) { recovery = this; }
  ~Recovery() { recovery = outer; }
  Recovery(const Recovery&) = delete;
  Recovery& operator=(const Recovery&) = delete;

  std::jmp_buf point;
  char message[1024];
  std::vector<std::string>* warnings;
  Recovery* outer = recovery;  // set before the constructor's body replaces it
};

mjfLogHandler previous_handler = nullptr;

void Handle(const mjLogMessage* message) {
  if (!recovery) {
    // Not our call: pass it to the previous log handler.
    if (previous_handler) previous_handler(message);
    return;
  }
  if (message->level == mjLOG_ERROR) {
    std::strncpy(recovery->message, message->subject, sizeof(recovery->message) - 1);
    recovery->message[sizeof(recovery->message) - 1] = '\0';
    std::longjmp(recovery->point, 1);
  }
  if (message->level == mjLOG_WARNING && recovery->warnings) {
    recovery->warnings->emplace_back(message->subject);
  }
}

// A function of its own, so that no automatic object with a destructor lies between setjmp and
// longjmp.
bool RunRecoverably(Recovery& here, const std::function<void()>& call) {
  if (setjmp(here.point) != 0) return false;
  call();
  return true;
}

// For round primitives: a cylinder of 40 mm radius is 0.2 mm out of round, below a scan's noise.
constexpr int kSegments = 32;
constexpr double kInfinitePlane_m = 10.0;  // half extent: beyond what any sensor sees
// Estimate for blue laminate under a red laser; it exceeds the albedo of dropouts (0.1).
constexpr double kLaminateAlbedo = 0.35;
constexpr double kLaminateGloss = 0.1;
constexpr int kMaxVisibleGroup = 2;  // MuJoCo's viewers show groups 0 to 2

geometry::TriangleMesh PlaneOf(const mjtNum* size) {
  const double x = size[0] > 0 ? size[0] : kInfinitePlane_m;
  const double y = size[1] > 0 ? size[1] : kInfinitePlane_m;
  geometry::TriangleMesh result;
  result.vertices = {{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}};
  result.triangles = {{0, 1, 2}, {0, 2, 3}};
  return result;
}

// The 2-D texture of a material; -1 for none.
int TextureOfMaterial(const mjModel* model, int material) {
  const int texture = model->mat_texid[material * mjNTEXROLE + mjTEXROLE_RGB];
  return texture >= 0 && model->tex_type[texture] == mjTEXTURE_2D ? texture : -1;
}

// Mean color of a print, in 0..1.
Eigen::Vector3f MeanOf(const geometry::Print& print) {
  Vector3d sum = Vector3d::Zero();
  for (const geometry::Rgb& c : print.texels) sum += Vector3d(c[0], c[1], c[2]);
  return (sum / (255.0 * static_cast<double>(print.texels.size()))).cast<float>();
}

geometry::Rgb RgbOf(const Eigen::Vector4f& color) {
  const auto level = [](float share) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
  };
  return {level(color[0]), level(color[1]), level(color[2])};
}

// Appends a geom's surface in one color.
void AppendGeom(const mjModel* model, const mjData* data, int geom, ColorsOfGeoms& colors,
                VisualMesh& visual) {
  geometry::Append(geometry::Transformed(GeomSurface(model, geom, kSegments), GeomPose(data, geom)),
                   visual.mesh_W);
  visual.colors.plain.resize(visual.mesh_W.triangles.size(), RgbOf(colors.Of(geom)));
}

// Appends the texture coordinates of the triangles of a geom's mesh, in their order.
void AppendUv(const mjModel* model, int geom, std::vector<std::array<Eigen::Vector2f, 3>>& uv) {
  const int mesh = model->geom_dataid[geom];
  const float* coordinates = model->mesh_texcoord + 2 * model->mesh_texcoordadr[mesh];
  const int* face = model->mesh_facetexcoord + 3 * model->mesh_faceadr[mesh];
  const float* repeat = model->mat_texrepeat + 2 * model->geom_matid[geom];
  for (int f = 0; f < model->mesh_facenum[mesh]; ++f) {
    auto& corners = uv.emplace_back();
    for (Eigen::Vector2f& corner : corners) {
      const float* at = coordinates + 2 * *face++;
      corner = {at[0] * repeat[0], at[1] * repeat[1]};
    }
  }
}

// The body that holds a site; -1 if there is none.
int BodyOfSite(const mjModel* model, std::string_view name) {
  const int site = TryFind(model, mjOBJ_SITE, name);
  return site >= 0 ? model->site_bodyid[site] : -1;
}

bool IsObject(const mjModel* model, int body) {
  const int root = model->body_rootid[body];
  return model->body_jntnum[root] > 0 && model->jnt_type[model->body_jntadr[root]] == mjJNT_FREE;
}

// Visible geoms of the bodies for which `holds` is true; surface by the custom numerics
// "<prefix>_albedo" and "<prefix>_gloss", else that of the blue laminate.
template <typename Predicate>
VisualMesh VisualOfBodies(const mjModel* model, const mjData* data, const std::string& prefix,
                          ColorsOfGeoms& colors, const Predicate& holds) {
  VisualMesh visual;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!Visible(model, geom) || !holds(model->geom_bodyid[geom])) continue;
    AppendGeom(model, data, geom, colors, visual);
  }
  const auto albedo = NumericOf(model, prefix + "_albedo");
  const auto gloss = NumericOf(model, prefix + "_gloss");
  visual.surface.albedo = albedo.empty() ? kLaminateAlbedo : albedo[0];
  visual.surface.gloss = gloss.empty() ? kLaminateGloss : gloss[0];
  return visual;
}

// Half extent of a convex primitive along the unit direction u, given in the geom's frame.
double Support(int type, const mjtNum* size, const Vector3d& u) {
  const double across = std::hypot(u.x(), u.y());
  switch (type) {
    case mjGEOM_CAPSULE:
      return size[0] + size[1] * std::abs(u.z());
    case mjGEOM_CYLINDER:
      return size[0] * across + size[1] * std::abs(u.z());
    case mjGEOM_BOX:
      return size[0] * std::abs(u.x()) + size[1] * std::abs(u.y()) + size[2] * std::abs(u.z());
    case mjGEOM_ELLIPSOID:
      return Vector3d(size[0] * u.x(), size[1] * u.y(), size[2] * u.z()).norm();
    default:
      return size[0];
  }
}

}  // namespace

void CallEngine(std::vector<std::string>* warnings, const std::function<void()>& call) {
  static std::once_flag installed;
  std::call_once(installed, [] { previous_handler = mju_setLogHandler(Handle); });
  Recovery here(warnings);
  if (!RunRecoverably(here, call)) throw base::RunError(std::string("MuJoCo: ") + here.message);
}

DataPtr MakeData(const mjModel* model) {
  mjData* data = nullptr;
  CallEngine(nullptr, [&] { data = mj_makeData(model); });
  return DataPtr(data);
}

DataPtr DataAtZero(const mjModel* model) {
  DataPtr data = MakeData(model);
  CallEngine(nullptr, [&] {
    mj_kinematics(model, data.get());
    mj_comPos(model, data.get());
  });
  return data;
}

void SetJoints(const mjModel* model, mjData* data, const std::vector<int>& joints,
               const double* positions) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    data->qpos[model->jnt_qposadr[joints[i]]] = positions[i];
  }
}

Eigen::Matrix3Xd JacobianOf(const mjModel* model, const mjData* data,
                            const std::vector<int>& joints, int body, const Vector3d& point_W) {
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> all(3, model->nv);
  mj_jac(model, data, all.data(), nullptr, point_W.data(), body);
  Eigen::Matrix3Xd J(3, joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) J.col(i) = all.col(model->jnt_dofadr[joints[i]]);
  return J;
}

Vector3d CenterOfMass(const mjModel* model, const mjData* data, int root) {
  Vector3d moment = Vector3d::Zero();
  for (int body = root; body < model->nbody && model->body_rootid[body] == root; ++body) {
    moment += model->body_mass[body] * Vec3(data->xipos + 3 * body);
  }
  return moment / model->body_subtreemass[root];
}

Eigen::Vector4f ColorsOfGeoms::Of(int geom) {
  const int material = model_->geom_matid[geom];
  if (material < 0) return Eigen::Map<const Eigen::Vector4f>(model_->geom_rgba + 4 * geom);
  Eigen::Vector4f color = Eigen::Map<const Eigen::Vector4f>(model_->mat_rgba + 4 * material);
  const int texture = TextureOfMaterial(model_, material);
  if (texture < 0) return color;
  const auto [mean, is_new] = means_.try_emplace(texture);
  if (is_new) mean->second = MeanOf(*Print(texture));
  color.head<3>().array() *= mean->second.array();
  return color;
}

std::shared_ptr<const geometry::Print> ColorsOfGeoms::Print(int texture) {
  auto& known = prints_[texture];
  if (known) return known;
  auto print = std::make_shared<geometry::Print>();
  print->width = model_->tex_width[texture];
  print->height = model_->tex_height[texture];
  const int channels = model_->tex_nchannel[texture];
  const mjtByte* texel = model_->tex_data + model_->tex_adr[texture];
  print->texels.resize(std::size_t(print->width) * print->height);
  for (geometry::Rgb& color : print->texels) {
    color = {texel[0], texel[channels < 3 ? 0 : 1], texel[channels < 3 ? 0 : 2]};
    texel += channels;
  }
  return known = print;
}

bool Visible(const mjModel* model, int geom) {
  const int material = model->geom_matid[geom];
  const float alpha =
      material >= 0 ? model->mat_rgba[4 * material + 3] : model->geom_rgba[4 * geom + 3];
  return model->geom_group[geom] <= kMaxVisibleGroup && alpha > 0.0f;
}

int TextureOf(const mjModel* model, int geom) {
  const int material = model->geom_matid[geom];
  if (material < 0 || model->geom_type[geom] != mjGEOM_MESH) return -1;
  if (model->mesh_texcoordadr[model->geom_dataid[geom]] < 0) return -1;
  return TextureOfMaterial(model, material);
}

geometry::TriangleMesh GeomSurface(const mjModel* model, int geom, int segments) {
  const int type = model->geom_type[geom];
  const mjtNum* size = model->geom_size + 3 * geom;
  if (type == mjGEOM_MESH) return mjcf::MeshOf(model, model->geom_dataid[geom]);
  if (type == mjGEOM_PLANE) return PlaneOf(size);
  geometry::Shape shape;
  shape.kind = mjcf::KindOf(type).value_or(geometry::Shape::Kind::kSphere);
  shape.size = Vec3(size);
  return geometry::Tessellate(shape, segments);
}

geometry::Points CollisionVertices(const mjModel* model, const mjData* data, int segments) {
  geometry::TriangleMesh all;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!Collides(model, geom)) continue;
    geometry::Append(
        geometry::Transformed(GeomSurface(model, geom, segments), GeomPose(data, geom)), all);
  }
  return all.vertices;
}

double ReachOfGeom(const mjModel* model, const mjData* data, int geom,
                   const Vector3d& direction_W) {
  const base::Pose X_WG = GeomPose(data, geom);
  const Vector3d direction_G = X_WG.linear().transpose() * direction_W;
  const double along = direction_W.dot(X_WG.translation());
  if (model->geom_type[geom] != mjGEOM_MESH) {
    return along + Support(model->geom_type[geom], model->geom_size + 3 * geom, direction_G);
  }
  const int mesh = model->geom_dataid[geom];
  const float* v = model->mesh_vert + 3 * model->mesh_vertadr[mesh];
  double reach = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < model->mesh_vertnum[mesh]; ++i, v += 3) {
    reach = std::max(reach, direction_G.dot(Vector3d(v[0], v[1], v[2])));
  }
  return along + reach;
}

double GeomDistance(const mjModel* model, mjData* data, int a, int b, double limit_m) {
  if (model->geom_type[b] == mjGEOM_PLANE) {
    const base::Pose X_WP = GeomPose(data, b);
    const Vector3d normal_W = X_WP.linear().col(2);
    const double lowest = -ReachOfGeom(model, data, a, -normal_W);
    return std::min(limit_m, lowest - normal_W.dot(X_WP.translation()));
  }
  const double centers = (Vec3(data->geom_xpos + 3 * a) - Vec3(data->geom_xpos + 3 * b)).norm();
  if (centers - model->geom_rbound[a] - model->geom_rbound[b] > limit_m) return limit_m;
  return mj_geomDistance(model, data, a, b, limit_m, nullptr);
}

VisualMesh VisualOfTree(const mjModel* model, const mjData* data, int root, ColorsOfGeoms& colors) {
  VisualMesh visual;
  int printed = -1;
  const Eigen::Vector2f none = Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (model->body_rootid[model->geom_bodyid[geom]] != root || !Visible(model, geom)) continue;
    AppendGeom(model, data, geom, colors, visual);
    const int texture = TextureOf(model, geom);
    if (texture >= 0 && (printed < 0 || printed == texture)) {
      if (printed < 0) visual.colors.print = colors.Print(texture);
      printed = texture;
      AppendUv(model, geom, visual.colors.uv);
    }
    visual.colors.uv.resize(visual.mesh_W.triangles.size(), {none, none, none});
  }
  if (!visual.colors.print) visual.colors.uv.clear();
  return visual;
}

VisualMesh VisualOfContainer(const mjModel* model, const mjData* data, ColorsOfGeoms& colors) {
  const int container = BodyOfSite(model, "container");
  VisualMesh visual =
      VisualOfBodies(model, data, "container", colors, [&](int body) { return body == container; });
  visual.label = kContainerLabel;
  return visual;
}

VisualMesh VisualOfScene(const mjModel* model, const mjData* data, ColorsOfGeoms& colors) {
  const int container = BodyOfSite(model, "container");
  const int scanner = BodyOfSite(model, "scanner");
  return VisualOfBodies(model, data, "scene", colors, [&](int body) {
    // A scanner in the world itself does not leave that out.
    return !IsObject(model, body) && body != container && (body == 0 || body != scanner);
  });
}

}  // namespace rangegrasp::sim::internal
