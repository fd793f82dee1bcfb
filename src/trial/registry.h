#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "experiment/record.h"
#include "trial/arranger.h"
#include "trial/cell.h"
#include "trial/options.h"

namespace rangegrasp::trial {

struct Cell;
struct LookedAround;

// What an experiment file chooses by a word, and who answers for the word. The core adds its own;
// a system adds more when the program starts (docs/architecture.md).

/// What looks at the settled objects: the `type` of a sensor's file.
struct SensorKind {
  std::string word;
  /// Its samples' errors hang together, so that it states its noise: it cannot be measured on them.
  bool states_noise = false;
  /// The line scanner's file where the sensor has one; empty otherwise. Objects are laid out in the
  /// scanner's view in any case.
  std::filesystem::path (*laser)(const std::filesystem::path& sensor_file) = nullptr;
  /// All files that it is made of, beside its own.
  std::vector<std::filesystem::path> (*files)(const std::filesystem::path& sensor_file) = nullptr;
  std::unique_ptr<Sensor> (*make)(const Cell& cell) = nullptr;
};
void AddSensor(const SensorKind& kind);
/// null if there is none of the word.
const SensorKind* FindSensor(const std::string& word);
/// What a sensor's file says that it is: kLineScanner where it says nothing, or there is none.
/// @throws base::InputError naming the file and the words that there are.
std::string ReadSensorType(const std::filesystem::path& sensor_file);
inline constexpr const char* kLineScanner = "line_scanner";

/// Lays objects out: the key `arrangement`.
struct ArrangerKind {
  std::string word;
  std::unique_ptr<Arranger> (*make)(const Options& options, const robot::Robot& robot,
                                    const sensing::LineScannerOptions& scanner) = nullptr;
};
void AddArranger(const ArrangerKind& kind);
std::vector<std::string> ArrangerWords();
/// The one that the options name. The arguments must outlive it.
/// @throws base::InputError if an object has no resting pose, there are too few objects or the
/// scene has no box.
std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner);

/// Finds objects and grasps: the key `detector`.
struct DetectorKind {
  std::string word;
  std::unique_ptr<Detector> (*make)(const Options& options, const robot::Robot& robot,
                                    SceneObserver observer) = nullptr;
  /// The rest is of the one that has keys of its own below `detector`, and null otherwise.
  void (*read)(base::YamlMap keys, Options& options) = nullptr;
  /// @throws base::InputError for what does not go with the experiment
  void (*check)(const base::YamlMap& map, const Options& options, double case_limit_s) = nullptr;
  void (*add_to)(const Options& options, experiment::Stamp& stamp) = nullptr;
  /// Results lie in the folder: they hold the truth.
  void (*hide)(const std::filesystem::path& folder, Options& options) = nullptr;
  /// Asks it about a few scans and writes what was understood of its answers.
  /// @return whether they can be used
  bool (*check_answers)(const Cell& cell, std::string& text) = nullptr;
};
inline constexpr const char* kDissertation = "dissertation";
/// In place of a word the file holds keys below `detector`.
inline constexpr const char* kDetectorWithKeys = "keys below";
void AddDetector(const DetectorKind& kind);
const DetectorKind* FindDetector(const std::string& word);
/// The detector that the options name. The arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeDetector(const Options& options, const robot::Robot& robot,
                                       SceneObserver observer = {});
/// For tasks that have a method of their own.
/// @throws base::InputError for any other detector.
void RequireOwnDetector(const base::YamlMap& map, const Options& options);
/// For tasks that take any.
/// @throws base::InputError
void CheckDetector(const base::YamlMap& map, const Options& options, double case_limit_s);
/// Puts into the stamp's identity what the detector's answers depend on.
void AddDetectorTo(const Options& options, experiment::Stamp& stamp);

/// Reads keys of grasping experiments that belong to a system, into Options::of_systems.
using KeyReader = void (*)(base::YamlMap& map, Options& options);
void AddKeyReader(KeyReader reader);
const std::vector<KeyReader>& KeyReaders();

/// Files that such keys name: results depend on them.
using FileList = std::vector<std::filesystem::path> (*)(const Options& options);
void AddFileList(FileList files);
const std::vector<FileList>& FileLists();

/// Stage 2 from several places, after the sensor's own look.
struct FurtherLooks {
  bool (*wanted)(const Options& options) = nullptr;
  LookedAround (*look)(const Cell& cell, Sensed first, sim::World& world,
                       std::uint64_t seed) = nullptr;
};
void SetFurtherLooks(const FurtherLooks& looks);
/// null: there is nothing that looks again.
const FurtherLooks* GetFurtherLooks();

}  // namespace rangegrasp::trial

namespace rangegrasp {

/// The grasping testbed: its task, words, commands and listings. When the program starts, before
/// any system.
void RegisterTrial();

}  // namespace rangegrasp
