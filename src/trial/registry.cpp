#include "trial/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <optional>

#include "cli/commands.h"
#include "experiment/experiment.h"
#include "libraries.h"
#include "sensing/range_sensor.h"
#include "sim/surfaces.h"
#include "sim/world.h"
#include "trial/command/grasping_commands.h"
#include "trial/command/perceive_command.h"
#include "trial/grasping_task.h"

namespace rangegrasp::trial {
namespace {

struct Registry {
  std::deque<SensorKind> sensors;
  std::deque<DetectorKind> detectors;
  std::vector<KeyReader> key_readers;
  std::vector<FileList> file_lists;
  std::optional<FurtherLooks> further_looks;
};

Registry& All() {
  static Registry registry;
  return registry;
}

template <typename Kind>
const Kind* Find(const std::deque<Kind>& kinds, const std::string& word) {
  const auto found = std::ranges::find(kinds, word, &Kind::word);
  return found == kinds.end() ? nullptr : &*found;
}

// The listings of `rangegrasp list`.

using Entries = std::vector<cli::ListEntry>;

Entries ListObjects() {
  Entries entries;
  for (const auto& file : cli::ShippedFiles("models/objects", ".xml")) {
    const std::string name = file.stem().string();
    if (file.parent_path().filename() == name) {
      entries.push_back({name, sim::ObjectTitle({name, file})});
    }
  }
  return entries;
}

Entries ListSurfaces() {
  Entries entries;
  for (const auto& surface : sim::ReadSurfaces(sim::ShippedSurfaces())) {
    entries.push_back({surface.name, fmt::format("friction of the glove {:.2f} to {:.2f}",
                                                 surface.glove.low, surface.glove.high)});
  }
  return entries;
}

Entries ListFiles(const char* folder, const char* ending) {
  Entries entries;
  for (const auto& file : cli::ShippedFiles(folder, ending)) {
    entries.push_back({file.stem().string(), ""});
  }
  return entries;
}

Entries ListAdditions() {
  Entries entries;
  for (const auto& [key, doc, improved, published] : MethodDifferences()) {
    entries.push_back({key, improved == "true" ? doc
                                               : fmt::format("{} (improved: {}; published: {})",
                                                             doc, improved, published)});
  }
  return entries;
}

void AddListings() {
  cli::AddListing({"objects", "objects", ListObjects});
  cli::AddListing({"surfaces", "kinds of surfaces", ListSurfaces});
  cli::AddListing({"scenes", "scenes", [] { return ListFiles("scenes", ".xml"); }});
  cli::AddListing({"sensors", "sensors", [] { return ListFiles("models/sensors", ".yaml"); }});
  cli::AddListing({"additions", "keys of grasping experiments that go beyond the dissertation",
                   ListAdditions, false});
}

void AddParts() {
  AddSensor({.word = kLineScanner,
             .laser = [](const std::filesystem::path& file) { return file; },
             .make = MakeLineScanner});
  AddSensor({.word = sensing::kDepthCamera, .states_noise = true, .make = MakeDepthCamera});
  AddDetector({.word = kDissertation,
               .make = [](const Options& options, const robot::Robot& robot,
                          grasp::SceneObserver observer) {
                 return grasp::MakeDissertationDetector(options, robot, std::move(observer));
               }});
  AddDetector({.word = kStraightDown,
               .make = [](const Options& options, const robot::Robot& robot,
                          grasp::SceneObserver observer) {
                 return grasp::MakeStraightDownDetector(options, robot, std::move(observer));
               }});
}

}  // namespace

void AddSensor(const SensorKind& kind) { All().sensors.push_back(kind); }
const SensorKind* FindSensor(const std::string& word) { return Find(All().sensors, word); }

std::string ReadSensorType(const std::filesystem::path& sensor_file) {
  std::string type = kLineScanner;
  if (sensor_file.empty()) return type;
  auto map = base::YamlMap::FromFile(sensor_file);
  std::vector<std::string> words;
  for (const SensorKind& kind : All().sensors) words.push_back(kind.word);
  map.Read("type", type, words, "type of the sensor");
  return type;
}

void AddDetector(const DetectorKind& kind) { All().detectors.push_back(kind); }
const DetectorKind* FindDetector(const std::string& word) { return Find(All().detectors, word); }

std::vector<std::string> DetectorWords() {
  std::vector<std::string> words;
  for (const DetectorKind& kind : All().detectors) {
    if (kind.word != kDetectorWithKeys) words.push_back(kind.word);
  }
  return words;
}

std::unique_ptr<Detector> MakeDetector(const Options& options, const robot::Robot& robot,
                                       SceneObserver observer) {
  return FindDetector(options.detector)->make(options, robot, std::move(observer));
}

void RequireOwnDetector(const base::YamlMap& map, const Options& options) {
  if (options.detector == kDissertation) return;
  map.Fail("detector",
           "must be dissertation here; others are for `task: grasping` and `task: clearing`");
}

std::vector<KeyReader>& KeyReaders() { return All().key_readers; }
std::vector<FileList>& FileLists() { return All().file_lists; }
std::optional<FurtherLooks>& FurtherLooking() { return All().further_looks; }

}  // namespace rangegrasp::trial

namespace rangegrasp {

void RegisterTrial() {
  trial::AddParts();
  experiment::AddKind(trial::GraspingTask());
  cli::AddCommand(cli::AddPictureCommands);
  cli::AddCommand(cli::AddPerceiveCommand);
  cli::AddCommand(cli::AddCheckCommand);
  trial::AddListings();
  cli::AddLibrary("mujoco", sim::EngineVersion());
  for (const auto& [name, version] : trial::kLibraries) cli::AddLibrary(name, version);
}

}  // namespace rangegrasp
