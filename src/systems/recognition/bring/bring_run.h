#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "grasp/named_grasps.h"
#include "recognition/bring/understanding.h"
#include "recognition/library.h"
#include "sim/world.h"
#include "trial/options.h"
#include "trial/trial.h"

namespace rangegrasp::bring {

/// How a known object is looked for, taken and handed over (section 7.2).
struct BringOptions {
  int runs_per_object = 20;
  std::vector<std::string> known;
  bool absent = false;
  std::string use;  ///< empty: any
  int max_tries = 4;
  int max_clear = 0;
  int max_looks = 3;
  double near_m = 0.08;
  double same_place_m = 0.03;  ///< when tries are counted
  recognition::RecognitionOptions recognition;
  recognition::LibraryOptions library;
  trial::HandOverOptions hand_over;
};

/// A bring experiment, as its file states it.
struct Options {
  trial::Options grasping;
  BringOptions bring;
};

/// The known objects' grasps, by the object's name; an object without a file has none of its own.
using GraspsOf = std::map<std::string, grasp::NamedGrasps>;

/// What the program takes its run for.
enum class Said {
  kHereYouAre,  ///< it was handed over
  kNotThere,    ///< it has looked everywhere it can
  kCannot,      ///< it is seen, and cannot be taken
  kBroken,      ///< the engine, or an attempt, broke down
};
constexpr std::array<std::string_view, 4> WordsOf(Said) {
  return {"here_you_are", "not_there", "cannot", "broken"};
}

/// Outcomes in addition to those of an attempt that ends with a person.
inline constexpr const char* kSaidAbsent = "said_absent";    ///< it was not there, as said
inline constexpr const char* kNotFound = "not_found";        ///< it was there, but not found
inline constexpr const char* kClearedAway = "cleared_away";  ///< it was taken for another thing
inline constexpr const char* kWrongObject = "wrong_object";  ///< another thing was handed over

/// One attempt at an object.
struct Step {
  trial::Attempt attempt;
  bool at_wanted = false;             ///< as the program sees it
  std::string taken_for;              ///< the known object that it is taken for; empty: unknown
  std::string grasp;                  ///< name of the grasp that was executed; empty: of chapter 5
  std::optional<bool> asked_upright;  ///< of an executed grasp at the wanted object
  /// Truth: the hand pressed on what is kept free on the wanted object when it had lifted it.
  bool touched_kept_free = false;
};

/// A run, from the word to the hand of a person.
struct Bring {
  Said said = Said::kNotThere;
  std::string outcome;  ///< as the judge sees it, who knows the truth
  std::string detail;
  std::optional<double> friction;  ///< truth: the glove's static one on the wanted object
  std::vector<std::string> words;  ///< what the program says, in turn
  std::vector<Step> steps;
  int looks = 0;
  int cleared = 0;        ///< others that were put aside
  double look_s = 0.0;    ///< computing time of all looks
  double homing_s = 0.0;  ///< ways home, by the arm's limits; not simulated
  double moved_s = 0.0;   ///< to the places that it looks from
};

/// What a viewer sees of a run; each may be empty.
struct BringObserver {
  sim::ExecutionObserver execution;
  std::function<void(const std::string&)> on_words;
  std::function<void(int attempt)> on_attempt;  ///< before each, from 1
};

/// What all runs of an experiment share.
struct Setup {
  const Options& options;
  const trial::Cell& cell;
  const recognition::Library& library;
  const GraspsOf& grasps;
};

/// Brings an object (section 7.2): looks, finds it among what it knows, clears away what is in the
/// way, takes it as its use asks for and hands it over; or says that it is not there, when nothing
/// is left that could hide it.
///
/// The program knows no truth but its scans, the closed hand's aperture and the pull that it feels.
/// What is cleared away goes to the delivery place, from which an attendant takes it; between two
/// attempts the arm stands at home again (as in clearing).
/// @param world  settled, the arm at home
/// @param wanted  an object of the library
/// @param target  truth: its number in the world; nullopt: it is not there
Bring BringObject(const Setup& setup, const std::string& wanted, std::optional<int> target,
                  std::uint64_t seed, sim::World& world, const BringObserver& observer = {});

}  // namespace rangegrasp::bring
