#include "trial/objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <set>

#include "base/data_folder.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/words.h"
#include "sim/check/check.h"
#include "sim/check_object.h"
#include "sim/surfaces.h"
#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

using base::YamlMap;

// Adds an MJCF file and, by its file="..." attributes, what it refers to.
void CollectModelFiles(const std::filesystem::path& file, std::set<std::filesystem::path>& files) {
  const auto path = file.lexically_normal();
  if (!std::filesystem::is_regular_file(path) || !files.insert(path).second) return;
  if (path.extension() != ".xml") return;
  const std::string text = base::ReadFile(path);
  static const std::regex kFile("file=\"([^\"]+)\"");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), kFile);
       it != std::sregex_iterator(); ++it) {
    CollectModelFiles(path.parent_path() / (*it)[1].str(), files);
  }
}

// Of objects that come with the program: beside the experiments, or else in the data folder.
std::filesystem::path ShippedObjects(const YamlMap& map) {
  const auto beside = (map.file().parent_path() / "../models/objects").lexically_normal();
  if (std::filesystem::is_directory(beside)) return beside;
  try {
    return base::DataFolder() / "models/objects";
  } catch (const base::InputError&) {
    return beside;
  }
}

// Of all folders, sorted.
std::vector<std::string> KnownObjects(const Options& options) {
  std::set<std::string> known;
  for (const auto& folder : options.object_folders) {
    if (!std::filesystem::is_directory(folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (std::filesystem::is_regular_file(entry.path() / (name + ".xml"))) known.insert(name);
    }
  }
  return {known.begin(), known.end()};
}

}  // namespace

std::vector<std::filesystem::path> ReadObjectFolders(YamlMap& map) {
  std::filesystem::path only = (map.file().parent_path() / "../models/objects").lexically_normal();
  map.ReadPath("object_folder", only, "holds NAME/NAME.xml for every object");
  std::vector<std::string> names;
  map.Read("object_folders", names,
           "several such folders, relative to the file; of two objects with the same name that of "
           "the first counts, and shipped ones are found too");
  if (names.empty()) return {only};
  if (map.Has("object_folder")) {
    map.Fail("object_folders", "goes in place of object_folder: put that folder into the list");
  }
  std::vector<std::filesystem::path> folders;
  for (const std::string& name : names) {
    folders.push_back((map.file().parent_path() / name).lexically_normal());
    if (std::filesystem::is_directory(folders.back())) continue;
    map.Fail("object_folders", fmt::format("no folder '{}' (looked for {}; paths are relative to "
                                           "the YAML file)",
                                           name, folders.back().string()));
  }
  folders.push_back(ShippedObjects(map));
  return folders;
}

std::vector<std::string> AllObjects(const Options& options) {
  std::vector<std::string> all = options.objects;
  for (const auto* names : {&options.clutter.always, &options.clutter.others}) {
    for (const std::string& name : *names) {
      if (std::find(all.begin(), all.end(), name) == all.end()) all.push_back(name);
    }
  }
  return all;
}

sim::ObjectModel ObjectModelOf(const Options& options, const std::string& object) {
  const auto in = [&](const std::filesystem::path& folder) {
    return folder / object / (object + ".xml");
  };
  for (const auto& folder : options.object_folders) {
    if (std::filesystem::is_regular_file(in(folder))) return {object, in(folder)};
  }
  return {object, in(options.object_folders.front())};
}

void CheckObjects(const YamlMap& map, const Options& options) {
  const auto& folders = options.object_folders;
  if (folders.size() == 1 && !std::filesystem::is_directory(folders.front())) {
    map.Fail("object_folder", "no folder " + folders.front().string() +
                                  " (it must hold NAME/NAME.xml for every object)");
  }
  std::set<std::string> seen;
  for (const std::string& object : options.objects) {
    if (!seen.insert(object).second) map.Fail("objects", "names '" + object + "' twice");
  }
  for (const std::string& object : AllObjects(options)) {
    const auto mjcf = ObjectModelOf(options, object).mjcf;
    if (std::filesystem::is_regular_file(mjcf)) continue;
    map.Fail("objects",
             fmt::format("no object '{}' (no file {}); nearest: '{}'", object, mjcf.string(),
                         base::NearestWord(object, KnownObjects(options))));
  }
}

std::vector<base::Finding> CheckModels(const Options& options) {
  auto findings = check::CheckModel(options.scene, check::Kind::kScene);
  sim::ObjectBounds bounds;
  bounds.min_tipping_rad = options.min_tipping_rad;
  for (const std::string& object : AllObjects(options)) {
    const sim::ObjectModel model = ObjectModelOf(options, object);
    if (!std::filesystem::is_regular_file(model.mjcf)) continue;  // CheckObjects names the nearest
    const auto found = sim::CheckObject(model, bounds);
    findings.insert(findings.end(), found.begin(), found.end());
  }
  return findings;
}

std::string SceneHash(const Options& options) {
  std::set<std::filesystem::path> files;
  CollectModelFiles(options.scene, files);
  for (const std::string& object : AllObjects(options)) {
    const auto mjcf = ObjectModelOf(options, object).mjcf;
    CollectModelFiles(mjcf, files);
    for (const auto& surfaces : sim::SurfaceFiles(mjcf)) files.insert(surfaces);
  }
  files.insert(options.sensor);
  for (const auto& file : FindSensor(options.sensor_type)->files(options.sensor)) {
    files.insert(file);
  }
  for (const auto& files_of : FileLists()) {
    for (const auto& file : files_of(options)) files.insert(file);
  }
  // By name, not by path: the same files in another folder hash alike.
  std::vector<std::pair<std::string, std::filesystem::path>> sorted;
  for (const auto& file : files) sorted.emplace_back(file.filename().string(), file);
  std::sort(sorted.begin(), sorted.end());
  std::uint64_t hash = base::Fnv1a("");
  for (const auto& [name, file] : sorted) hash = base::Fnv1a(name + base::ReadFile(file), hash);
  return base::Hex(hash);
}

}  // namespace rangegrasp::trial
