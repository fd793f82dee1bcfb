#include "recognition/library.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "recognition/internal/prepared_object.h"

namespace rangegrasp::recognition {

KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            const LibraryOptions& options, geometry::MeshColors colors) {
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
  object.surface_B = SampledSurface(object.mesh_B, options.spacing_m);
  if (object.surface_B.size() < 4) {
    throw std::invalid_argument(
        fmt::format("{}: its mesh is too small to be an object", object.name));
  }
  object.symmetry = SymmetryOf(object.mesh_B, object.surface_B, options.symmetry);
  return object;
}

Library::Library(std::vector<KnownObject> objects, const LibraryOptions& options) {
  auto prepared = std::make_shared<Prepared>();
  prepared->objects = std::move(objects);
  for (std::size_t i = 0; i < prepared->objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (prepared->objects[i].name != prepared->objects[j].name) continue;
      throw std::invalid_argument("two known objects are named " + prepared->objects[i].name);
    }
    prepared->ready.push_back(
        std::make_unique<internal::PreparedObject>(prepared->objects[i], options));
  }
  prepared_ = std::move(prepared);
}

const KnownObject& Library::Find(const std::string& name) const {
  std::string known;
  for (const KnownObject& object : prepared_->objects) {
    if (object.name == name) return object;
    known += (known.empty() ? "" : ", ") + object.name;
  }
  throw base::InputError(fmt::format("no known object is named '{}'; known: {}", name, known));
}

}  // namespace rangegrasp::recognition
