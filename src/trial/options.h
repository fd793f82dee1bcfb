#pragma once

#include <any>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "base/yaml_map.h"
#include "grasp/detector.h"
#include "grasp/mover.h"
#include "grasp/workspace.h"
#include "sim/execute.h"
#include "sim/world.h"
#include "trial/clutter_options.h"

namespace rangegrasp::trial {

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
/// switch of base/additions.h; keys of single switches win over it.
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

}  // namespace rangegrasp::trial
