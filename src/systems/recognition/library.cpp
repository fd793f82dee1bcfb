#include "recognition/library.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "recognition/internal/prepared_object.h"

namespace rangegrasp::recognition {

KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            geometry::MeshColors colors) {
  const std::size_t triangles = mesh_B.triangles.size();
  if ((colors.print && colors.uv.size() != triangles) ||
      (!colors.plain.empty() && colors.plain.size() != triangles)) {
    throw std::invalid_argument(fmt::format("{}: its colors are of another mesh", name));
  }
  KnownObject object;
  object.name = std::move(name);
  object.title = std::move(title);
  object.mesh_B = std::move(mesh_B);
  object.colors = std::move(colors);
  object.surface_B = SampledSurface(object.mesh_B, 0.003);
  if (object.surface_B.size() < 4) {
    throw std::invalid_argument(
        fmt::format("{}: its mesh is too small to be an object", object.name));
  }
  object.symmetry = SymmetryOf(object.mesh_B, object.surface_B);
  return object;
}

Library::Library(std::vector<KnownObject> objects) {
  auto prepared = std::make_shared<Prepared>();
  for (KnownObject& object : objects) {
    for (const auto& other : prepared->ready) {
      if (other->object.name != object.name) continue;
      throw std::invalid_argument("two known objects are named " + object.name);
    }
    prepared->ready.push_back(std::make_unique<internal::PreparedObject>(std::move(object)));
  }
  prepared_ = std::move(prepared);
}

const KnownObject& Library::Find(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& one : prepared_->ready) {
    if (one->object.name == name) return one->object;
    known.push_back(one->object.name);
  }
  throw base::InputError(
      fmt::format("no known object is named '{}'; known: {}", name, base::Join(known)));
}

}  // namespace rangegrasp::recognition
