#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clearing/clearing_options.h"
#include "clearing/tried_objects.h"
#include "sim/world.h"
#include "trial/attempt.h"

namespace rangegrasp::clearing {

/// Why a run ended.
enum class Stop {
  kNothingPerceived,  ///< the program takes the table for empty
  kNothingGraspable,  ///< of all that it sees none has a free grasp
  kNoPath,            ///< some have one, none is reached
  kTriesUsedUp,       ///< what is left has been tried as often as allowed
  kMaxGrasps,
  kEmpty,           ///< truth: no object is left; the program still sees something
  kBrokenPhysics,   ///< the engine lost the state of the world
  kDetectorFailed,  ///< one that is another program
  kCrashed,         ///< an attempt did
};
constexpr std::array<std::string_view, 9> WordsOf(Stop) {
  return {"nothing_perceived", "nothing_graspable", "no_path",
          "tries_used_up",     "max_grasps",        "empty",
          "broken_physics",    "detector_failed",   "crashed"};
}

/// Where an object is at the end, by truth.
enum class Fate {
  kDelivered,  ///< a grasp at it was judged so
  kBrought,    ///< it came to the delivery place otherwise: beside another one, or not validly
  kLeft,
};
constexpr std::array<std::string_view, 3> WordsOf(Fate) { return {"delivered", "brought", "left"}; }

struct ObjectEnd {
  std::string object;
  Fate fate = Fate::kLeft;
  int grasps = 0;  ///< in which the hand had it, or nothing and was at it
  /// Why it was left: off_table, out_of_workspace, not_perceived (it is not the main part of any
  /// object of the last scan), or what the program has it passed over for (Passed). Of what was
  /// brought: the outcome of the grasp. Empty if delivered.
  std::string why;
};

/// One attempt of a run.
struct Step {
  trial::Attempt attempt;
  int scan = 0;                 ///< it was made on, from 1
  int try_number = 0;           ///< at that object, as the program counts, from 1
  bool felt = false;            ///< the hand's aperture told to the end that it held something
  std::vector<int> taken_away;  ///< objects that it left at the delivery place
};

/// A run, from its arrangement to its end.
struct Clearing {
  Stop stop = Stop::kNothingPerceived;
  std::string detail;
  int scans = 0;
  std::size_t perceived = 0;  ///< objects of the last scan
  double homing_s = 0.0;      ///< ways home, by the arm's limits; not simulated
  double scan_s = 0.0;        ///< computing time of all scans
  std::vector<Step> steps;
  std::vector<ObjectEnd> objects;

  int Grasps() const;  ///< attempts that were executed
  int Delivered() const;
};

/// What a viewer sees of a run.
struct ClearingObserver {
  const trial::Detector* detector = nullptr;  ///< in place of the cell's; may be null
  sim::ExecutionObserver execution;
  std::function<void(int attempt)> on_attempt;  ///< before each, from 1; may be empty
  std::function<void(sim::World&)> on_end;      ///< may be empty
};

/// Clears the world (section 5.1, fig. 5.2): scan, take the topmost object, deliver it, and again,
/// until nothing is perceived or nothing can be done.
///
/// The program knows no truth. That a grasp has failed it feels by the aperture of the closed hand;
/// then it tries again, another grasp where there is one, at most tries_per_object times at one
/// object, which it knows again by its samples. An object without a free grasp, or that the arm
/// does not reach, is passed over until something else has been taken.
///
/// Between two attempts an attendant takes away what lies at the delivery place, and the arm stands
/// at home again: its way there is timed, not simulated. Friction should be drawn before.
/// @param world  settled, the arm at home; what is left stays in it
/// @param seed  each scan and each attempt draws from its own stream of it
Clearing ClearTable(const trial::Cell& cell, const ClearingOptions& options, int max_grasps,
                    sim::World& world, std::uint64_t seed, const ClearingObserver& observer = {});

}  // namespace rangegrasp::clearing
