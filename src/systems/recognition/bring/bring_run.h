#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "grasp/named_grasps.h"
#include "recognition/bring/understanding.h"
#include "recognition/library.h"
#include "recognition/recognize.h"
#include "sim/world.h"
#include "trial/recorder.h"
#include "trial/trial.h"

namespace rangegrasp::bring {

/// Options for searching, grasping and handing over a known object (section 7.2).
struct BringOptions {
  int runs_per_object = 20;
  bool absent = false;
  std::string use;  ///< empty: any use
  int max_tries = 4;
  int max_looks = 3;
  recognition::LibraryOptions library;
  recognition::RecognitionOptions recognition;
  trial::HandOverOptions hand_over;
};

/// Grasps of the known objects by object name; an object without a file has none of its own.
using GraspsOf = std::map<std::string, grasp::NamedGrasps>;

/// The program's own view of how its run ended.
enum class Said {
  kHereYouAre,  ///< the object was handed over
  kNotThere,    ///< it has looked everywhere it can
  kCannot,      ///< the object is seen, but cannot be grasped
  kBroken,      ///< the physics engine or an attempt failed
};
constexpr std::array<std::string_view, 4> WordsOf(Said) {
  return {"here_you_are", "not_there", "cannot", "broken"};
}

/// Outcomes in addition to those of an attempt that ends with a person.
inline constexpr const char* kSaidAbsent = "said_absent";    ///< it was absent, as reported
inline constexpr const char* kNotFound = "not_found";        ///< it was present, but not found
inline constexpr const char* kClearedAway = "cleared_away";  ///< it was mistaken for another one
inline constexpr const char* kWrongObject = "wrong_object";  ///< another object was handed over

/// One attempt at an object.
struct Step {
  trial::Attempt attempt;
  bool at_wanted = false;             ///< the program believes that it is the wanted object
  std::string taken_for;              ///< the known object it was recognized as; empty: unknown
  std::string grasp;                  ///< name of the executed grasp; empty: a grasp of chapter 5
  std::optional<bool> asked_upright;  ///< must stay upright; for executed grasps of the wanted one
  /// Ground truth: after lifting, the hand pressed on a keep-free part of the wanted object.
  bool touched_kept_free = false;
};

/// A run, from the request to the handover to a person.
struct Bring {
  Said said = Said::kNotThere;
  std::string outcome;  ///< judged with ground truth
  std::string detail;
  std::optional<double> friction;  ///< truth: the glove's static friction on the wanted object
  std::vector<std::string> words;  ///< what the program says, in order
  std::vector<Step> steps;
  int looks = 0;
  int cleared = 0;        ///< other objects that were put aside
  double look_s = 0.0;    ///< computing time of all looks
  double homing_s = 0.0;  ///< motions home, by the arm's limits; not simulated
  double moved_s = 0.0;   ///< motions to the viewpoints
};

/// Data shared by all runs of an experiment.
struct Setup {
  const BringOptions& options;
  const trial::Cell& cell;
  const recognition::Library& library;
  const GraspsOf& grasps;
};

/// Brings an object (section 7.2): looks, finds it among the known objects, clears away what is in
/// the way, grasps it as its use requires and hands it over. If nothing is left that could hide it,
/// reports that it is absent.
///
/// The program uses no ground truth: only its scans, the closed hand's aperture and the pull that
/// it feels. Cleared objects go to the delivery place, where an attendant removes them. Between two
/// attempts the arm returns home (as in clearing).
/// @param world  settled, with the arm at home
/// @param wanted  an object of the library
/// @param target  ground truth: its index in the world; nullopt: it is absent
/// @param recorder  takes pictures of each attempt
Bring BringObject(const Setup& setup, const std::string& wanted, std::optional<int> target,
                  std::uint64_t seed, sim::World& world, trial::Recorder& recorder);

}  // namespace rangegrasp::bring
