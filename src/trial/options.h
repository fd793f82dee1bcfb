#pragma once

#include <any>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "experiment/task.h"
#include "grasp/detector.h"
#include "grasp/mover.h"
#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::trial {

/// Options of the arrangements with several objects: scattered, touching, side_by_side, box, pile.
/// The texts of the keys (options.cpp) describe the fields.
struct ClutterOptions {
  std::vector<std::string> always;
  std::vector<std::string> others;       ///< empty: all rows' objects
  std::optional<double> standing_share;  ///< without it slender objects hardly ever stand
  double scatter_radius_m = 0.22;
  int min_others = 2;  ///< table 5.3: 2 to 5
  int max_others = 5;
  bool draw_others = false;  ///< table 5.6
  int max_draws = 200;
  double settle_limit_s = 4.0;
  double rest_speed_m_s = 0.002;  ///< sim::World::Settle
};

// The parts without access to ground truth are in a lower layer: grasp/detector.h.
using grasp::Detected;
using grasp::Detector;
using grasp::DetectorFailed;
using grasp::PlacesOf;
using grasp::SceneObserver;
using grasp::Turn;
using grasp::WorkspaceOf;

/// The dissertation's method as published, or with this program's additions (MethodDifferences).
/// Keys in the file override it.
enum class MethodKind { kImproved, kPublished };
constexpr std::array<std::string_view, 2> WordsOf(MethodKind) { return {"improved", "published"}; }

/// The contents of a grasping experiment's file: the options of its parts and its own options.
struct Options : grasp::DetectorOptions, grasp::MoverOptions {
  std::filesystem::path scene;
  std::filesystem::path sensor;
  std::string sensor_type;  ///< the word of a SensorKind (registry.h)
  /// Each contains NAME/NAME.xml for its objects. The first folder that has a name is used.
  std::vector<std::filesystem::path> object_folders;
  std::filesystem::path reference;  ///< may be empty
  std::vector<std::string> objects;
  int trials_per_object = 10;

  std::string arranger;  ///< the word of an arrangement (arranger.h)
  std::string detector;  ///< the word of a DetectorKind
  MethodKind method = MethodKind::kImproved;

  ClutterOptions clutter;
  /// A pose that tips over earlier would not last on a real table. The upright prism tips over at
  /// 6.6 deg.
  double min_tipping_rad = 10.0 * base::kDeg;
  bool as_drawn = false;  ///< an open vessel upside down is a different object

  bool color = false;
  std::uint64_t seed = 1;  ///< of the experiment; for what is drawn once, before all trials
  sim::PhysicsOptions physics;
  sim::HandControlOptions hand;
  /// Contact angle above which the hand grips with its maximum force at once. 90 deg: never, like
  /// the prosthesis, which starts with one force and increases it only after slips.
  double firm_from_rad = 90.0 * base::kDeg;
  sim::AuditBounds audit;

  /// Options that systems read from the file (registry.h), each under its own name.
  std::map<std::string, std::any> of_systems;
};

/// The options of a system by name; its defaults if nothing was read.
template <typename T>
T& Of(Options& options, const std::string& name) {
  std::any& any = options.of_systems[name];
  if (!any.has_value()) any = T();
  return std::any_cast<T&>(any);
}
template <typename T>
T Of(const Options& options, const std::string& name) {
  const auto found = options.of_systems.find(name);
  return found == options.of_systems.end() ? T() : std::any_cast<const T&>(found->second);
}

/// Reads all keys of a grasping experiment except the common ones, to the end of the map.
/// @param seed  of the experiment
/// @throws base::InputError naming file, line, key, value and the nearest valid key.
Options ReadOptions(base::YamlMap& map, std::uint64_t seed);

/// Sets all options in which the methods differ.
void SetMethod(MethodKind method, Options& options);

/// A key of experiment files with different values in the improved and the published method.
struct MethodDifference {
  std::string key;  ///< "perception.ridge_tops"
  std::string doc;
  std::string improved = "true";  ///< value of the key
  std::string published = "false";
};
/// All differences.
std::vector<MethodDifference> MethodDifferences();

/// Appends the names that are not in the list yet.
void AddOnce(const std::vector<std::string>& names, std::vector<std::string>& list);

/// The objects of the rows, then the others that may be in the scene; each once.
std::vector<std::string> AllObjects(const Options& options);

/// The MJCF file of one of the experiment's objects. If no folder has it, the path that it would
/// have in the first folder.
sim::ObjectModel ObjectModelOf(const Options& options, const std::string& object);

/// Names the first of the objects that no folder has, with the nearest name; empty if there is
/// none.
std::string MissingObject(const std::vector<std::string>& objects, const Options& options);

/// @throws base::InputError if an object is missing.
void CheckObjects(const base::YamlMap& map, const Options& options);

/// Passes the errors of the scene, its arm, its hand (sim/check/check.h) and the objects to
/// common.on_findings, with IgnoredKeys (arranger.h) and the task's own warnings, then calls
/// CheckObjects and CheckArrangement (arranger.h).
/// @return false if on_findings returns false
/// @throws base::InputError like these.
bool ModelsPass(const base::YamlMap& map, const Options& options, const experiment::Common& common,
                const std::vector<base::Finding>& warnings = {});

/// A hash of all files that decide a trial: the scene, the objects, what both refer to, surfaces,
/// the sensor, the grasp score and files of systems.
std::string SceneHash(const Options& options);

}  // namespace rangegrasp::trial
