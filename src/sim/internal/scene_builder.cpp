#include "sim/internal/scene_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/pattern.h"
#include "base/process/program.h"

namespace rangegrasp::sim::internal {
namespace {

constexpr char kDefaultSurface[] = "cardboard";  // for an object that names none
constexpr double kSameRim_m = 1e-4;              // numbers in scenes are rounded to less
// `check` refuses smaller ones, too. With 1e20 kg an object settles in 5 s, with 1e100 kg not
// in 30.
constexpr double kMaxMass_kg = 1e6;

base::InputError Wrong(const std::filesystem::path& file, const std::string& what) {
  return base::InputError(file.string() + ": " + what);
}

// The engine reads "nan" as "not given" and uses its own default instead.
void RefuseNan(const std::filesystem::path& file) {
  const std::string text = base::ReadFile(file);
  const auto match = base::FindMatch(
      text,
      "\\b(mass|density|inertia|diaginertia|fullinertia|size|pos)\\s*=\\s*[\"'][^\"']*"
      "\\b[nN][aA][nN]\\b");
  if (!match) return;
  throw base::InputError(fmt::format("{}:{}: {} is nan; a number is expected", file.string(),
                                     LineAt(text, match->begin), match->groups[1]));
}

SpecPtr Parse(const std::filesystem::path& file) {
  NeedMjcf(file);
  char error[1000] = "";
  mjSpec* spec = nullptr;
  // With a relative path, the engine loses the files that an included file refers to.
  const std::string path = std::filesystem::absolute(file).string();
  process::NeedMemory(mjcf::kEngine_bytes);
  CallEngine(nullptr, [&] { spec = mj_parseXML(path.c_str(), nullptr, error, sizeof(error)); });
  if (!spec) throw base::InputError(mjcf::EngineMessage(file, error));
  return SpecPtr(spec);
}

ModelPtr Compile(mjSpec* spec, const std::filesystem::path& file) {
  mjModel* model = nullptr;
  CallEngine(nullptr, [&] { model = mj_compile(spec, nullptr); });
  if (!model) throw base::InputError(mjcf::EngineMessage(file, mjs_getError(spec)));
  if (const std::string far = mjcf::FarAway(*model); !far.empty()) {
    mj_deleteModel(model);
    throw Wrong(file, far + ": is more than 10 km away");
  }
  return ModelPtr(model);
}

std::vector<mjsElement*> Children(const mjsBody* body, mjtObj type, bool recurse) {
  std::vector<mjsElement*> children;
  for (mjsElement* e = mjs_firstChild(body, type, recurse); e;
       e = mjs_nextChild(body, e, recurse)) {
    children.push_back(e);
  }
  return children;
}

mjsElement* FindSo(mjSpec* spec, mjtObj type, std::string_view suffix) {
  mjsElement* e = mjs_firstElement(spec, type);
  while (e && Suffix(mjs_getString(mjs_getName(e))) != suffix) e = mjs_nextElement(spec, e);
  return e;
}

// The number of a numeric; nullopt if it does not hold exactly one.
std::optional<double> NumberOf(mjsElement* numeric) {
  int size = 0;
  const double* data = mjs_getDouble(mjs_asNumeric(numeric)->data, &size);
  return size == 1 ? std::optional(data[0]) : std::nullopt;
}

// Bodies that set gravcomp themselves keep it.
void CompensateGravity(mjsBody* body) {
  if (body->gravcomp == 0.0) {
    body->gravcomp = 1.0;
    for (mjsElement* joint : Children(body, mjOBJ_JOINT, false)) {
      mjs_asJoint(joint)->actgravcomp = 1;
    }
  }
  for (mjsElement* child : Children(body, mjOBJ_BODY, false)) CompensateGravity(mjs_asBody(child));
}

// The body that the arm's first joint moves: the hand's topmost ancestor with a joint.
mjsBody* FirstMoving(mjSpec* spec) {
  mjsElement* hand = FindSo(spec, mjOBJ_BODY, "hand");
  if (!hand) return nullptr;
  mjsBody* first = nullptr;
  for (mjsBody* body = mjs_getParent(hand); body; body = mjs_getParent(body->element)) {
    if (!Children(body, mjOBJ_JOINT, false).empty()) first = body;
  }
  return first;
}

// If the numeric "gravity_compensation" is not 0, the drives carry arm and hand, as in real arms.
// This applies to all bodies from the first joint on; in MJCF each body would have to state it
// itself.
void CompensateGravityIfAsked(mjSpec* spec) {
  mjsElement* numeric = FindSo(spec, mjOBJ_NUMERIC, "gravity_compensation");
  if (!numeric || NumberOf(numeric).value_or(0.0) == 0.0) return;
  if (mjsBody* first = FirstMoving(spec)) CompensateGravity(first);
}

// Changes the height of the interior of the site "container" and of the geoms that reach its rim;
// the bottom stays. The body's z axis is the box's.
void SetBoxWalls(mjSpec* spec, const std::filesystem::path& file, double height_m) {
  mjsElement* element = FindSo(spec, mjOBJ_SITE, "container");
  if (!element) {
    throw Wrong(file,
                "has no box with adjustable walls; it needs a box-shaped site \"container\" that "
                "fills its interior");
  }
  mjsSite* interior = mjs_asSite(element);
  const double rim_m = interior->pos[2] + interior->size[2];
  const double new_rim_m = interior->pos[2] - interior->size[2] + height_m;
  const auto set_rim = [&](double* pos, double* size) {
    const double bottom_m = pos[2] - size[2];
    pos[2] = 0.5 * (new_rim_m + bottom_m);
    size[2] = 0.5 * (new_rim_m - bottom_m);
  };
  set_rim(interior->pos, interior->size);
  for (mjsElement* child : Children(mjs_getParent(element), mjOBJ_GEOM, false)) {
    mjsGeom* geom = mjs_asGeom(child);
    const bool reaches_rim = std::abs(geom->pos[2] + geom->size[2] - rim_m) < kSameRim_m;
    if (geom->type == mjGEOM_BOX && reaches_rim) set_rim(geom->pos, geom->size);
  }
}

// Why a file does not hold one free body and nothing else; empty if it does.
std::string WhyNotAnObject(const mjSpec* spec) {
  const mjsBody* world = mjs_findBody(spec, "world");
  const auto roots = Children(world, mjOBJ_BODY, false);
  if (roots.size() != 1) {
    return fmt::format("an object must have one root body in its worldbody, this file has {}",
                       roots.size());
  }
  if (!Children(world, mjOBJ_GEOM, false).empty()) {
    return "an object's geoms must belong to its root body, but this file has some in the "
           "worldbody";
  }
  const auto joints = Children(mjs_asBody(roots[0]), mjOBJ_JOINT, false);
  if (joints.size() == 1 && mjs_asJoint(joints[0])->type == mjJNT_FREE) return "";
  return "an object's root body must have one <freejoint/> and no other joint";
}

// The root body of an object's spec, after checking that it is an object.
mjsBody* ObjectRoot(const mjSpec* spec, const std::filesystem::path& file) {
  if (const std::string why = WhyNotAnObject(spec); !why.empty()) throw Wrong(file, why);
  mjsBody* root = mjs_asBody(mjs_firstChild(mjs_findBody(spec, "world"), mjOBJ_BODY, false));
  const auto collides = [](mjsElement* geom) {
    return mjs_asGeom(geom)->contype != 0 || mjs_asGeom(geom)->conaffinity != 0;
  };
  if (std::ranges::any_of(Children(root, mjOBJ_GEOM, true), collides)) return root;
  throw Wrong(
      file,
      "an object must have at least one collision geom (contype or conaffinity other than 0)");
}

double Numeric(const mjSpec* spec, const std::filesystem::path& file, const char* name,
               double otherwise) {
  mjsElement* element = mjs_findElement(spec, mjOBJ_NUMERIC, name);
  if (!element) return otherwise;
  const auto number = NumberOf(element);
  if (number && *number >= 0.0 && *number <= 1.0) return *number;
  throw Wrong(file, fmt::format("numeric \"{}\" must be one number from 0 to 1", name));
}

// The surface that an object's text "surface" names.
Surface SurfaceOf(const mjSpec* spec, const std::filesystem::path& file) {
  std::string name = kDefaultSurface;
  if (mjsElement* text = mjs_findElement(spec, mjOBJ_TEXT, "surface")) {
    name = mjs_getString(mjs_asText(text)->data);
  }
  try {
    return FindSurface(SurfacesFor(file), name);
  } catch (const base::InputError& error) {
    throw Wrong(file, error.what());
  }
}

ObjectEntry ReadEntry(const ObjectModel& object, const mjSpec* spec) {
  ObjectEntry entry;
  entry.name = object.name;
  entry.surface = SurfaceOf(spec, object.mjcf);
  OpticalSurface& optical = entry.optical;
  optical = entry.surface.optical;
  optical.albedo = Numeric(spec, object.mjcf, "albedo", optical.albedo);
  optical.gloss = Numeric(spec, object.mjcf, "gloss", optical.gloss);
  optical.clarity = Numeric(spec, object.mjcf, "clarity", optical.clarity);
  // Absorbed light does not come back either, whatever is printed on the surface.
  const double absorption = Numeric(spec, object.mjcf, "absorption", 0.0);
  optical.clarity = 1.0 - (1.0 - optical.clarity) * (1.0 - absorption);
  return entry;
}

void Locate(mjModel* model, int body, const std::filesystem::path& file, ObjectEntry& entry) {
  entry.body = body;
  const int joint = model->body_jntadr[body];
  entry.qpos = model->jnt_qposadr[joint];
  entry.dof = model->jnt_dofadr[joint];
  const double mass = model->body_subtreemass[body];
  if (!(mass > 0.0 && mass <= kMaxMass_kg)) {
    throw Wrong(file, fmt::format("an object's mass must be above 0 and at most {:g} kg, but is "
                                  "{:.4g} kg",
                                  kMaxMass_kg, mass));
  }
  const double mu = entry.surface.on_laminate.kinetic_mu;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (model->body_rootid[model->geom_bodyid[geom]] != body || !Collides(model, geom)) continue;
    model->geom_friction[3 * geom] = mu;
    const double reach = mju_norm3(model->geom_pos + 3 * geom) + model->geom_rbound[geom];
    entry.radius_m = std::max(entry.radius_m, reach);
  }
}

// Attaches an object to the scene and returns its root body there.
mjsElement* Attach(mjSpec* scene, mjsBody* root, const std::filesystem::path& file,
                   const std::string& prefix) {
  // Weightless while parked. The compiler counts it as such, and World switches it.
  root->gravcomp = 1.0;
  mjsFrame* frame = mjs_addFrame(mjs_findBody(scene, "world"), nullptr);
  mjsElement* attached = mjs_attach(frame->element, root->element, prefix.c_str(), "");
  if (!attached) throw base::InputError(mjcf::EngineMessage(file, mjs_getError(scene)));
  return attached;
}

}  // namespace

void NeedMjcf(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) {
    const auto own = [](const std::filesystem::path& folder) {
      return folder / (std::filesystem::canonical(folder).filename().string() + ".xml");
    };
    auto inside = own(file);
    std::error_code unreadable;
    for (const auto& entry : std::filesystem::directory_iterator(file, unreadable)) {
      if (std::filesystem::exists(inside)) break;
      if (entry.is_directory()) inside = own(entry.path());  // in a folder of objects
    }
    const bool found = std::filesystem::exists(inside);
    throw Wrong(file, "is a folder; name its file" + (found ? ", such as " + inside.string() : ""));
  }
  if (!std::filesystem::is_regular_file(file)) {
    throw Wrong(file, "no such file; an MJCF file is expected");
  }
  mjcf::CheckFiles(file);
}

BuiltScene BuildScene(const std::filesystem::path& scene_mjcf,
                      const std::vector<ObjectModel>& objects, const PhysicsOptions& options) {
  if (!(options.timestep_s > 0.0)) throw base::InputError("timestep_s must be above 0");
  SpecPtr scene = Parse(scene_mjcf);
  mjs_setDeepCopy(scene.get(), 1);
  scene->option.timestep = options.timestep_s;
  // A bad state must not be hidden by a reset.
  scene->option.disableflags |= mjDSBL_AUTORESET;

  CompensateGravityIfAsked(scene.get());
  if (options.box_wall_m) SetBoxWalls(scene.get(), scene_mjcf, *options.box_wall_m);

  BuiltScene built;
  std::vector<std::string> bodies;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const SpecPtr spec = Parse(objects[i].mjcf);
    RefuseNan(objects[i].mjcf);
    mjsBody* root = ObjectRoot(spec.get(), objects[i].mjcf);
    built.objects.push_back(ReadEntry(objects[i], spec.get()));
    mjsElement* attached =
        Attach(scene.get(), root, objects[i].mjcf, fmt::format("{}_{}/", objects[i].name, i));
    bodies.emplace_back(mjs_getString(mjs_getName(attached)));
  }
  try {
    built.model = Compile(scene.get(), scene_mjcf);
  } catch (const base::InputError&) {
    // If an object causes the error, say which.
    for (const ObjectModel& object : objects) BuildObject(object);
    throw;
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const int body = mj_name2id(built.model.get(), mjOBJ_BODY, bodies[i].c_str());
    if (body < 0) throw Wrong(objects[i].mjcf, "the root body needs a name");
    Locate(built.model.get(), body, objects[i].mjcf, built.objects[i]);
  }
  return built;
}

BuiltScene BuildObject(const ObjectModel& object) {
  const SpecPtr spec = Parse(object.mjcf);
  RefuseNan(object.mjcf);
  ObjectRoot(spec.get(), object.mjcf);
  BuiltScene built;
  built.objects.push_back(ReadEntry(object, spec.get()));
  built.model = Compile(spec.get(), object.mjcf);
  Locate(built.model.get(), 1, object.mjcf, built.objects[0]);
  return built;
}

bool IsObject(const std::filesystem::path& mjcf) {
  return WhyNotAnObject(Parse(mjcf).get()).empty();
}

}  // namespace rangegrasp::sim::internal
