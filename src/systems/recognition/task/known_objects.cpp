#include "recognition/task/known_objects.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "sim/info.h"
#include "sim/object_surface.h"

namespace rangegrasp::recognition {

recognition::Library LibraryOf(std::span<const sim::ObjectModel> objects,
                               const recognition::LibraryOptions& options) {
  std::vector<recognition::KnownObject> known;
  for (const sim::ObjectModel& object : objects) {
    geometry::ColoredMesh surface = sim::ObjectSurface(object);
    known.push_back(recognition::MakeKnownObject(object.name, sim::ObjectTitle(object),
                                                 std::move(surface.mesh), options,
                                                 std::move(surface.colors)));
  }
  return recognition::Library(std::move(known), options);
}

recognition::Library LoadLibrary(std::span<const std::filesystem::path> folders,
                                 const recognition::LibraryOptions& options) {
  std::map<std::string, std::filesystem::path> files;  // by name: the same on every file system
  for (const auto& folder : folders) {
    if (!std::filesystem::is_directory(folder)) {
      throw base::InputError(folder.string() +
                             ": no folder (it must hold NAME/NAME.xml for every known object)");
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      const auto mjcf = entry.path() / (name + ".xml");
      if (std::filesystem::is_regular_file(mjcf)) files.try_emplace(name, mjcf);
    }
  }
  if (files.empty()) {
    throw base::InputError((folders.empty() ? std::string("no folder") : folders.front().string()) +
                           ": holds no known object (NAME/NAME.xml)");
  }
  std::vector<sim::ObjectModel> objects;
  for (const auto& [name, mjcf] : files) objects.push_back({name, mjcf});
  return LibraryOf(objects, options);
}

}  // namespace rangegrasp::recognition
