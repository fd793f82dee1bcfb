#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/rng.h"
#include "robot/robot.h"
#include "sensing/line_scanner_options.h"
#include "sim/world.h"
#include "trial/options.h"

namespace rangegrasp::trial {

/// Why an arrangement is drawn again.
enum class Redraw {
  kNotAtRest,   ///< something still moves at the time limit, or moves again
  kOtherPose,   ///< single, scattered: something rests in another pose than the one drawn
  kOutOfView,   ///< something is not in the scanner's view
  kOutOfReach,  ///< the target lies outside the workspace
  kLeftTable,   ///< something fell off the table, or out of the box
  kTouchesArm,
  kOverlaps,    ///< two things are inside each other
  kNotHighest,  ///< another object is higher than the target, or no drop ends lower
  kTouchesFew,  ///< the target touches fewer others than it should
  kDoesNotFit,  ///< something is larger than the box, or no place is left for it
  kHidden,      ///< scattered: too little of the target is seen behind the others
};
constexpr std::array<std::string_view, 11> WordsOf(Redraw) {
  return {"not_at_rest", "other_pose",  "out_of_view", "out_of_reach", "left_table", "touches_arm",
          "overlaps",    "not_highest", "touches_few", "does_not_fit", "hidden"};
}

/// How often an arrangement was drawn again, by reason.
using Redraws = std::map<Redraw, int>;

int Total(const Redraws& redraws);
std::string Text(const Redraws& redraws);  ///< "not_at_rest x2, out_of_view x1"

/// A settled world with the target in it.
struct Arrangement {
  sim::World world;
  int target = 0;            ///< in `world`; the others follow
  std::string pose_class{};  ///< of the target's resting pose; "leaning" where it is none of those
  int touching = 0;          ///< objects that the target touches
};

/// Stage 1: lays objects out.
class Arranger {
 public:
  virtual ~Arranger() = default;
  /// @param target  the row's object
  /// @param redraws  counts the arrangements that were drawn again
  /// @return nullopt if none that was drawn is what the experiment asks for.
  virtual std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                             Redraws& redraws) const = 0;
};

// The words of the key `arrangement` (docs/architecture.md, definitions).
//
// scattered: the target, what is always there and a drawn number of others, each in a pose like
// those of single, anywhere in the workspace where it is inside no other; they may touch.
//
// side_by_side: the target and a drawn number of others, each in a pose in which a drop onto the
// table ended, and the others in one that is lower than the target. One after the other comes from
// a random side straight towards the target until it touches what stands there, so that all touch
// in one group and the first touches the target.
//
// touching, box, pile: objects are let go one after the other, turned at random, from a small
// height above what lies below them: over a small place on the table (touching), through the mouth
// of a bag (pile), into an open box (box). When they rest, the target follows. Drawn again, the
// target alone at first and then all, until everything rests in view and nothing overlaps.

inline constexpr const char* kSingle = "single";
inline constexpr const char* kScattered = "scattered";
inline constexpr const char* kTouching = "touching";
inline constexpr const char* kSideBySide = "side_by_side";
inline constexpr const char* kBox = "box";
inline constexpr const char* kPile = "pile";

/// Lays objects out: a word of the key `arrangement`.
struct ArrangerKind {
  std::string word;
  std::unique_ptr<Arranger> (*make)(const Options& options, const robot::Robot& robot,
                                    const sensing::LineScannerOptions& scanner) = nullptr;
};
/// All that there are; a system adds its own.
std::vector<ArrangerKind>& ArrangerKinds();

/// The arranger that the options name. The arguments must outlive it.
/// @throws base::InputError if an object has no resting pose, there are too few, or the scene has
/// no box.
std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::trial
