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

/// How objects come to lie on and next to each other: scattered, touching, side_by_side, box, pile.
/// The texts of the keys (options.cpp) describe the fields.
struct ClutterOptions {
  std::vector<std::string> always;
  std::vector<std::string> others;       ///< empty: all rows' objects
  std::optional<double> standing_share;  ///< without it slender things hardly ever stand
  double min_seen_share = 0.0;
  double scatter_radius_m = 0.22;
  int min_others = 2;  ///< table 5.3: 2 to 5
  int max_others = 5;
  bool draw_others = false;  ///< table 5.6
  int min_touching = 2;
  /// Less than the scanner's noise, about what two boards that were pushed together leave between
  /// them.
  double touch_m = 0.0005;
  double drop_height_m = 0.03;      ///< as from a hand, or a bag's mouth above the growing pile
  double touching_radius_m = 0.06;  ///< of two hands' width
  double mouth_radius_m = 0.08;
  double interval_s = 0.15;  ///< the first object has left its place by then
  int max_put_back = 12;
  int target_drops = 8;
  int max_draws = 200;
  double settle_limit_s = 4.0;
  double rest_speed_m_s = 0.002;  ///< sim::World::Settle
  double rest_time_s = 0.3;
  double max_penetration_m = 0.001;
};

// The parts that see no truth live below: grasp/detector.h, grasp/mover.h.
using grasp::Detected;
using grasp::Detector;
using grasp::DetectorFailed;
using grasp::Mover;
using grasp::PlacesOf;
using grasp::SceneObserver;
using grasp::Turn;
using grasp::WorkspaceOf;

/// The dissertation's method as it was published, or with what this program adds to it
/// (MethodDifferences); keys in the file win over it.
enum class MethodKind { kImproved, kPublished };
constexpr std::array<std::string_view, 2> WordsOf(MethodKind) { return {"improved", "published"}; }

/// A grasping experiment, as its file states it: the options of its parts, and its own. Defaults
/// are those of the option structs.
struct Options : grasp::DetectorOptions, grasp::MoverOptions {
  std::filesystem::path scene;
  std::filesystem::path sensor;
  std::string sensor_type;  ///< the word of a SensorKind (registry.h)
  /// Each holds NAME/NAME.xml for objects; of two with the same name that of the first counts.
  std::vector<std::filesystem::path> object_folders;
  std::filesystem::path reference;  ///< may be empty
  std::vector<std::string> objects;
  int trials_per_object = 10;

  std::string arranger;  ///< the word of an arrangement (arranger.h)
  std::string detector;  ///< the word of a DetectorKind
  MethodKind method = MethodKind::kImproved;

  ClutterOptions clutter;
  /// Such a pose would not stand long on a real table; the upright prism tips over at 6.6 deg.
  double min_tipping_rad = 10.0 * base::kDeg;
  bool as_drawn = false;  ///< an open vessel upside down is another object
  /// The last time, and with 1 always, the hand closes where it is.
  int max_approaches = 3;
  double early_m = 0.006;  ///< less is within the error of what is perceived

  bool color = false;
  std::uint64_t seed = 1;  ///< of the experiment; for what is done once before all trials
  sim::PhysicsOptions physics;
  sim::HandControlOptions hand;
  /// Contact angle from which the first grip is the strongest one; 90 deg: never, as the
  /// prosthesis, whose grip begins with one force and is raised by slips alone.
  double firm_from_rad = 90.0 * base::kDeg;
  sim::AuditBounds audit;

  /// What systems read of the file (registry.h), each under a name of its own.
  std::map<std::string, std::any> of_systems;
};

/// What a system keeps in the options under a name; its defaults where nothing was read.
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

/// Reads all keys of a grasping experiment but the common ones, to the end of the map.
/// @throws base::InputError naming file, line, key, value and the nearest valid key.
Options ReadOptions(base::YamlMap& map);

/// Sets all that the methods differ in.
void SetMethod(MethodKind method, Options& options);

/// A key of experiment files by which the improved method differs from the published one.
struct MethodDifference {
  std::string key;  ///< "perception.ridge_tops"
  std::string doc;
  std::string improved = "true";  ///< its value
  std::string published = "false";
};
/// All of them.
std::vector<MethodDifference> MethodDifferences();

/// Appends those names that the list does not hold yet.
void AddOnce(const std::vector<std::string>& names, std::vector<std::string>& list);

/// The rows' objects, and what else may lie there; each once, the rows' first.
std::vector<std::string> AllObjects(const Options& options);

/// The MJCF of one of the experiment's objects; where it would stand in the first folder if it is
/// in none.
sim::ObjectModel ObjectModelOf(const Options& options, const std::string& object);

/// @throws base::InputError if an object is missing.
void CheckObjects(const base::YamlMap& map, const Options& options);

/// Shows common.on_findings what is wrong with the scene, its arm and its hand (sim/check/check.h),
/// and with the objects; then CheckObjects.
/// @return false where on_findings does not want to go on
/// @throws base::InputError as CheckObjects.
bool ModelsPass(const base::YamlMap& map, const Options& options, const experiment::Common& common);

/// A hash over the scene, the models that it and the objects refer to, and the sensor.
std::string SceneHash(const Options& options);

}  // namespace rangegrasp::trial
