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

/// How objects come to lie on and beside each other: scattered, touching, box, pile.
struct ClutterOptions {
  /// scattered: objects that lie there in every trial, and those that others are drawn from; empty:
  /// from all rows' objects.
  std::vector<std::string> always;
  std::vector<std::string> others;
  /// scattered: the target and what is always there stand, the axis z of their models vertical, so
  /// often; without it as often as a drop ends so, which for slender things is hardly ever.
  std::optional<double> standing_share;
  /// scattered: of what the scanner would see of the target if it lay there alone, at least this
  /// share is seen. 0: it may be hidden wholly.
  double min_seen_share = 0.0;
  /// scattered: others lie no further from the middle of the workspace. Larger: less crowded.
  double scatter_radius_m = 0.22;
  /// scattered, touching: how many objects lie there beside the target (tables 5.3: 2 to 5), and
  /// how many of them the target touches at least.
  int min_others = 2;
  int max_others = 5;
  /// box, pile: as many others as touching has, drawn anew with each heap (table 5.6); else all.
  bool draw_others = false;
  int min_touching = 2;
  /// Surfaces this close touch: less than the scanner's noise, about what two boards that were
  /// pushed together leave between them.
  double touch_m = 0.0005;
  /// An object is let go with its lowest point this high above what lies below it, as from a hand
  /// or out of a bag's mouth that follows the growing pile.
  double drop_height_m = 0.03;
  /// Radius of the disc that objects' middles fall through: of two hands' width, of a bag's mouth.
  double touching_radius_m = 0.06;
  double mouth_radius_m = 0.08;
  /// From one object to the next that leaves the bag: the first has left its place by then.
  double interval_s = 0.15;
  /// What rolls off its place is put back on top, so often at most in one heap.
  int max_put_back = 12;
  /// The target is dropped last, so often at most onto one heap; then all is drawn again.
  int target_drops = 8;
  int max_draws = 200;
  double settle_limit_s = 4.0;
  /// At rest all objects are slower than this, for as long (sim::World::Settle), and once more.
  double rest_speed_m_s = 0.002;
  double rest_time_s = 0.3;
  /// Deepest overlap of two things at rest.
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

/// The dissertation's method as it was published, or with what this program adds to it. Sets every
/// switch of base/words.h; keys of single switches win over it.
enum class MethodKind { kImproved, kPublished };
constexpr std::array<std::string_view, 2> WordsOf(MethodKind) { return {"improved", "published"}; }

/// A grasping experiment, as its file states it: the options of its parts, and its own. Defaults
/// are those of the option structs.
struct Options : grasp::DetectorOptions, grasp::MoverOptions {
  std::filesystem::path scene;
  std::filesystem::path sensor;  ///< a sensor's file
  std::string sensor_type;       ///< the word of a SensorKind (registry.h), as that file says
  /// Each holds NAME/NAME.xml for objects; of two with the same name that of the first counts.
  std::vector<std::filesystem::path> object_folders;
  std::filesystem::path reference;  ///< the published table; may be empty
  std::vector<std::string> objects;
  int trials_per_object = 10;

  std::string arranger;  ///< the word of an ArrangerKind
  std::string detector;  ///< the word of a DetectorKind
  MethodKind method = MethodKind::kImproved;

  ClutterOptions clutter;
  /// A resting pose that tips over at a smaller tilt is left out: it would not stand long on a real
  /// table (10 deg; the upright prism tips over at 6.6 deg).
  double min_tipping_rad = 10.0 * base::kDeg;
  /// Only resting poses in which the model stands as it was drawn, its z axis up: an open vessel
  /// upside down is another object.
  bool as_drawn = false;
  /// A hand whose fingertips meet something early comes down elsewhere, so often at most in all;
  /// the last time, and with 1 always, it closes where it is.
  int max_approaches = 3;
  /// With more than this left of an approach it meets something early: less is within
  /// the error of what is perceived.
  double early_m = 0.006;

  /// The sensors see colors, too: as if their files of line scanners said so, and of stereo's left
  /// picture.
  bool color = false;
  std::uint64_t seed = 1;  ///< of the experiment; for what is done once before all trials
  sim::PhysicsOptions physics;
  sim::HandControlOptions hand;
  /// Faces that lean by more than this are gripped with the strongest force at once: once they
  /// slide, kinetic friction does not hold them any more. 90 deg: never.
  double firm_from_rad = 20.0 * base::kDeg;
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

/// Sets all switches of the method's additions.
void SetMethod(MethodKind method, Options& options);

/// What the improved method adds to the published one: a key of experiment files and what it does.
struct AdditionKey {
  std::string path;  ///< "perception.ridge_tops"
  std::string doc;
};
std::vector<AdditionKey> AdditionKeys();

/// The rows' objects, and what else may lie there; each once, the rows' first.
std::vector<std::string> AllObjects(const Options& options);

/// The MJCF of one of the experiment's objects; where it would stand in the first folder if it is
/// in none.
sim::ObjectModel ObjectModelOf(const Options& options, const std::string& object);

/// Checks that every object is there.
/// @throws base::InputError
void CheckObjects(const base::YamlMap& map, const Options& options);

/// Shows common.on_findings what is wrong with the scene, its arm and its hand (sim/check/check.h),
/// and with the objects; then CheckObjects.
/// @return false where on_findings does not want to go on
/// @throws base::InputError as CheckObjects.
bool ModelsPass(const base::YamlMap& map, const Options& options, const experiment::Common& common);

/// A hash over the scene, the models that it and the objects refer to, and the sensor.
std::string SceneHash(const Options& options);

}  // namespace rangegrasp::trial
