#include "trial/registry.h"

#include <fmt/format.h>

#include <deque>
#include <optional>

#include "base/error.h"
#include "cli/commands.h"
#include "experiment/experiment.h"
#include "libraries.h"
#include "sim/surfaces.h"
#include "sim/world.h"
#include "trial/command/grasping_commands.h"
#include "trial/command/perceive_command.h"
#include "trial/grasping_task.h"

namespace rangegrasp::trial {
namespace {

struct Registry {
  std::deque<SensorKind> sensors;
  std::deque<ArrangerKind> arrangers;
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
  for (const Kind& kind : kinds) {
    if (kind.word == word) return &kind;
  }
  return nullptr;
}

template <typename Kind>
std::vector<std::string> WordsOfAll(const std::deque<Kind>& kinds) {
  std::vector<std::string> words;
  for (const Kind& kind : kinds) words.push_back(kind.word);
  return words;
}

// What `rangegrasp list` lists.

std::string ListObjects() {
  std::string text;
  for (const auto& file : cli::ShippedFiles("models/objects", ".xml")) {
    const std::string name = file.stem().string();
    if (file.parent_path().filename() == name) {
      text += cli::ListingLine(name, sim::ObjectTitle({name, file}));
    }
  }
  return text;
}

std::string ListSurfaces() {
  std::string text;
  for (const auto& surface : sim::ReadSurfaces(sim::ShippedSurfaces())) {
    text += cli::ListingLine(surface.name, fmt::format("friction of the glove {:.2f} to {:.2f}",
                                                       surface.glove.low, surface.glove.high));
  }
  return text;
}

std::string ListFiles(const char* folder, const char* ending) {
  std::string text;
  for (const auto& file : cli::ShippedFiles(folder, ending)) text += file.stem().string() + "\n";
  return text;
}

std::string ListAdditions() {
  std::string text;
  for (const auto& key : AdditionKeys()) text += cli::ListingLine(key.path, key.doc);
  return text;
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
  AddSensor(
      {.word = kLineScanner,
       .laser = [](const std::filesystem::path& file) { return file; },
       .files = [](const std::filesystem::path&) { return std::vector<std::filesystem::path>(); },
       .make =
           [](const Cell& cell) { return MakeLineScanner(cell.scanner, cell.robot.X_WScanner); }});
  AddArranger({kSingle, MakeSingleArranger});
  AddArranger({kScattered, MakeScatteredArranger});
  for (const char* word : {kTouching, kBox, kPile}) {
    AddArranger({word, MakeClutterArranger});
  }
  AddDetector({.word = kDissertation,
               .make = [](const Options& options, const robot::Robot& robot,
                          grasp::SceneObserver observer) {
                 return grasp::MakeDissertationDetector(options, robot, std::move(observer));
               }});
}

}  // namespace

void AddSensor(const SensorKind& kind) { All().sensors.push_back(kind); }
const SensorKind* FindSensor(const std::string& word) { return Find(All().sensors, word); }

std::string ReadSensorType(const std::filesystem::path& sensor_file) {
  std::string type = kLineScanner;
  if (sensor_file.empty()) return type;
  auto map = base::YamlMap::FromFile(sensor_file);
  map.Read("type", type, WordsOfAll(All().sensors), "what the sensor is");
  return type;
}

void AddArranger(const ArrangerKind& kind) { All().arrangers.push_back(kind); }
std::vector<std::string> ArrangerWords() { return WordsOfAll(All().arrangers); }

std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner) {
  return Find(All().arrangers, options.arranger)->make(options, robot, scanner);
}

void AddDetector(const DetectorKind& kind) { All().detectors.push_back(kind); }
const DetectorKind* FindDetector(const std::string& word) { return Find(All().detectors, word); }

std::unique_ptr<Detector> MakeDetector(const Options& options, const robot::Robot& robot,
                                       SceneObserver observer) {
  return FindDetector(options.detector)->make(options, robot, std::move(observer));
}

void RequireOwnDetector(const base::YamlMap& map, const Options& options) {
  if (options.detector == kDissertation) return;
  map.Fail("detector", "a program of your own is for `task: grasping` and `task: clearing`");
}

void CheckDetector(const base::YamlMap& map, const Options& options, double case_limit_s) {
  const DetectorKind& kind = *FindDetector(options.detector);
  if (kind.check) kind.check(map, options, case_limit_s);
}

void AddDetectorTo(const Options& options, experiment::Stamp& stamp) {
  const DetectorKind& kind = *FindDetector(options.detector);
  if (kind.add_to) kind.add_to(options, stamp);
}

void AddKeyReader(KeyReader reader) { All().key_readers.push_back(reader); }
const std::vector<KeyReader>& KeyReaders() { return All().key_readers; }
void AddFileList(FileList files) { All().file_lists.push_back(files); }
const std::vector<FileList>& FileLists() { return All().file_lists; }
void SetFurtherLooks(const FurtherLooks& looks) { All().further_looks = looks; }
const FurtherLooks* GetFurtherLooks() {
  return All().further_looks ? &*All().further_looks : nullptr;
}

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
