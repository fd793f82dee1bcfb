#include "robot/mjcf/names.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::mjcf {
namespace {

std::string_view NameOf(const mjModel* model, mjtObj type, int id) {
  const char* name = mj_id2name(model, type, id);
  return name ? std::string_view(name) : std::string_view();
}

}  // namespace

std::string_view Suffix(std::string_view name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

int CountOf(const mjModel* model, mjtObj type) {
  switch (type) {
    case mjOBJ_BODY:
      return static_cast<int>(model->nbody);
    case mjOBJ_JOINT:
      return static_cast<int>(model->njnt);
    case mjOBJ_GEOM:
      return static_cast<int>(model->ngeom);
    case mjOBJ_SITE:
      return static_cast<int>(model->nsite);
    case mjOBJ_CAMERA:
      return static_cast<int>(model->ncam);
    case mjOBJ_ACTUATOR:
      return static_cast<int>(model->nu);
    case mjOBJ_NUMERIC:
      return static_cast<int>(model->nnumeric);
    case mjOBJ_TUPLE:
      return static_cast<int>(model->ntuple);
    default:
      return 0;
  }
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
          fmt::format("tuple \"{}\" of the scene must hold elements of type {} only", suffix,
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

bool InSubtree(const mjModel* model, int body, int root) {
  while (body > root) body = model->body_parentid[body];  // parents have lower ids
  return body == root;
}

}  // namespace rangegrasp::mjcf
