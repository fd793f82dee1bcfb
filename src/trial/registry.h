#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "experiment/record.h"
#include "trial/cell.h"
#include "trial/options.h"

namespace rangegrasp::trial {

struct LookedAround;

// What an experiment file chooses by a word, and who answers for the word. The core adds its own;
// a system adds more when the program starts (docs/architecture.md).

/// What looks at the settled objects: the `type` of a sensor's file.
struct SensorKind {
  std::string word;
  /// Its samples' errors depend on each other: its noise is stated, it cannot be measured on them.
  bool states_noise = false;
  /// The line scanner's file where the sensor has one; empty otherwise.
  std::filesystem::path (*laser)(const std::filesystem::path& sensor_file) = nullptr;
  /// The files that its own file names.
  std::vector<std::filesystem::path> (*files)(const std::filesystem::path& sensor_file) = nullptr;
  std::unique_ptr<Sensor> (*make)(const Cell& cell) = nullptr;
};
void AddSensor(const SensorKind& kind);
/// null if there is none of the word.
const SensorKind* FindSensor(const std::string& word);
/// The `type` in a sensor's file; kLineScanner where there is none, or no file.
/// @throws base::InputError naming the file and the words that there are.
std::string ReadSensorType(const std::filesystem::path& sensor_file);
inline constexpr const char* kLineScanner = "line_scanner";

/// Finds objects and grasps: the key `detector`.
struct DetectorKind {
  std::string word;
  std::unique_ptr<Detector> (*make)(const Options& options, const robot::Robot& robot,
                                    SceneObserver observer) = nullptr;
  /// Of the one that has keys of its own below `detector`; null otherwise.
  void (*read)(base::YamlMap keys, Options& options) = nullptr;
  /// @throws base::InputError for what does not go with the experiment
  void (*check)(const base::YamlMap& map, const Options& options,
                double case_limit_s) = [](const base::YamlMap&, const Options&, double) {};
  /// Puts into the stamp's identity what its answers depend on.
  void (*add_to)(const Options& options, experiment::Stamp& stamp) = [](const Options&,
                                                                        experiment::Stamp&) {};
  /// Results lie in the folder: they hold the truth.
  void (*hide)(const std::filesystem::path& folder, Options& options) = nullptr;
  /// Asks it about a few scans and writes what was understood. @return whether that can be used
  bool (*check_answers)(const Cell& cell, std::string& text) = nullptr;
};
inline constexpr const char* kDissertation = "dissertation";
inline constexpr const char* kStraightDown = "straight_down";
/// In place of a word the file holds keys below `detector`.
inline constexpr const char* kDetectorWithKeys = "keys below";
void AddDetector(const DetectorKind& kind);
const DetectorKind* FindDetector(const std::string& word);
/// Those that a file may name.
std::vector<std::string> DetectorWords();
/// The detector that the options name. The arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeDetector(const Options& options, const robot::Robot& robot,
                                       SceneObserver observer = {});
/// For tasks that have a method of their own. @throws base::InputError for any other detector
void RequireOwnDetector(const base::YamlMap& map, const Options& options);

/// Reads keys of grasping experiments that belong to a system, into Options::of_systems.
using KeyReader = void (*)(base::YamlMap& map, Options& options);
std::vector<KeyReader>& KeyReaders();

/// Files that such keys name: results depend on them.
using FileList = std::vector<std::filesystem::path> (*)(const Options& options);
std::vector<FileList>& FileLists();

/// Probability of delivery that the best grasp promises by what was sensed so far; 0 without one.
using Promise = std::function<double(const Sensed&)>;

/// Stage 2 from several places, after the sensor's own look.
struct FurtherLooks {
  bool (*wanted)(const Options& options) = nullptr;
  LookedAround (*look)(const Cell& cell, Sensed first, sim::World& world, std::uint64_t seed,
                       const Promise& promise) = nullptr;
};
/// Absent where nothing looks again.
std::optional<FurtherLooks>& FurtherLooking();

}  // namespace rangegrasp::trial

namespace rangegrasp {

/// The grasping testbed: its task, words, commands and listings. When the program starts, before
/// any system.
void RegisterTrial();

}  // namespace rangegrasp
