#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "experiment/record.h"
#include "sensing/range_sensor.h"
#include "trial/cell.h"
#include "trial/options.h"

namespace rangegrasp::trial {

struct LookedAround;

// Parts that an experiment file selects by a word. The core registers its own; a system adds more
// when the program starts (docs/architecture.md).

/// A kind of sensor: the `type` in a sensor's file.
struct SensorKind {
  std::string word;
  /// The errors of its samples are correlated, so that the noise is stated instead of measured.
  bool states_noise = false;
  /// The line scanner's file if the sensor has one; otherwise empty.
  std::filesystem::path (*laser)(const std::filesystem::path& sensor_file) =
      [](const std::filesystem::path&) { return std::filesystem::path(); };
  /// The files that the sensor's file refers to.
  std::vector<std::filesystem::path> (*files)(const std::filesystem::path& sensor_file) =
      [](const std::filesystem::path&) { return std::vector<std::filesystem::path>(); };
  std::unique_ptr<Sensor> (*make)(const Cell& cell) = nullptr;
};
void AddSensor(const SensorKind& kind);
/// null if no sensor has the word.
const SensorKind* FindSensor(const std::string& word);
/// The `type` in a sensor's file; kLineScanner if there is no type or no file.
/// @throws base::InputError naming the file and the valid words.
std::string ReadSensorType(const std::filesystem::path& sensor_file);
using sensing::kLineScanner;

/// A kind of detector, which finds objects and grasps: a word of the key `detector`.
struct DetectorKind {
  std::string word;
  std::unique_ptr<Detector> (*make)(const Options& options, const robot::Robot& robot,
                                    SceneObserver observer) = nullptr;
  /// Reads the keys below `detector`; null for detectors without keys.
  void (*read)(base::YamlMap keys, Options& options) = nullptr;
  /// @throws base::InputError if its options do not fit the experiment
  void (*check)(const base::YamlMap& map, const Options& options,
                double case_limit_s) = [](const base::YamlMap&, const Options&, double) {};
  /// Adds the dependencies of its answers to the stamp's identity.
  void (*add_to)(const Options& options, experiment::Stamp& stamp) = [](const Options&,
                                                                        experiment::Stamp&) {};
  /// Hides a folder of results from the detector, since results contain ground truth.
  void (*hide)(const std::filesystem::path& folder, Options& options) = nullptr;
  /// Queries it on a few scans and describes its answers. @return whether they are usable
  bool (*check_answers)(const Cell& cell, std::string& text) = nullptr;
};
inline constexpr const char* kDissertation = "dissertation";
inline constexpr const char* kStraightDown = "straight_down";
/// The detector for which the file has keys below `detector` instead of a word.
inline constexpr const char* kDetectorWithKeys = "keys below";
void AddDetector(const DetectorKind& kind);
const DetectorKind* FindDetector(const std::string& word);
/// The words that a file may use.
std::vector<std::string> DetectorWords();
/// The detector selected by the options. The arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeDetector(const Options& options, const robot::Robot& robot,
                                       SceneObserver observer = {});
/// For tasks with their own method. @throws base::InputError unless the detector is dissertation
void RequireOwnDetector(const base::YamlMap& map, const Options& options);

/// Reads keys of grasping experiments that belong to a system, into Options::of_systems.
using KeyReader = void (*)(base::YamlMap& map, Options& options);
std::vector<KeyReader>& KeyReaders();

/// Files that such keys refer to. Results depend on them.
using FileList = std::vector<std::filesystem::path> (*)(const Options& options);
std::vector<FileList>& FileLists();

/// Predicted probability of delivery of the best grasp in the scans so far; 0 without a grasp.
using Promise = std::function<double(const Sensed&)>;

/// Additional scans from other viewpoints in stage 2, after the sensor's own scan.
struct FurtherLooks {
  bool (*wanted)(const Options& options) = nullptr;
  LookedAround (*look)(const Cell& cell, Sensed first, sim::World& world, std::uint64_t seed,
                       const Promise& promise) = nullptr;
};
/// Absent if no system makes additional scans.
std::optional<FurtherLooks>& FurtherLooking();

}  // namespace rangegrasp::trial

namespace rangegrasp {

/// Registers the grasping testbed: its task, words, commands and listings. Called when the program
/// starts, before any system registers.
void RegisterTrial();

}  // namespace rangegrasp
