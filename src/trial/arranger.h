#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/rng.h"
#include "robot/robot.h"
#include "sensing/range_sensor.h"
#include "sim/world.h"
#include "trial/options.h"

namespace rangegrasp::trial {

/// Why an arrangement is drawn again.
enum class Redraw {
  kNotAtRest,   ///< an object still moves at the time limit, or moves again
  kOtherPose,   ///< single, scattered: an object rests in another pose than the one drawn
  kOutOfView,   ///< an object is not in the scanner's view
  kOutOfReach,  ///< the target lies outside the workspace
  kLeftTable,   ///< an object fell off the table, or out of the box
  kTouchesArm,
  kOverlaps,    ///< two objects penetrate each other
  kNotHighest,  ///< another object is higher than the target, or no drop of it ends lower
  kTouchesFew,  ///< the target touches too few other objects
  kDoesNotFit,  ///< an object is larger than the box, or there is no free place for it
};
constexpr std::array<std::string_view, 10> WordsOf(Redraw) {
  return {"not_at_rest", "other_pose", "out_of_view", "out_of_reach", "left_table",
          "touches_arm", "overlaps",   "not_highest", "touches_few",  "does_not_fit"};
}

/// How often an arrangement was drawn again, by reason.
using Redraws = std::map<Redraw, int>;

int Total(const Redraws& redraws);
std::string Text(const Redraws& redraws);  ///< "not_at_rest x2, out_of_view x1"

/// Maximum distance of surfaces that count as touching. Less than the scanner's noise; about the
/// gap between two boards that are pushed together.
inline constexpr double kTouch_m = 0.0005;
/// Maximum overlap of two bodies at rest.
inline constexpr double kMaxPenetration_m = 0.001;

/// The experiment's scene with these objects, where their models place them.
sim::World WorldOf(const Options& options, const std::vector<std::string>& objects);

/// A settled world with the target in it.
struct Arrangement {
  sim::World world;
  int target = 0;            ///< index in `world`; the other objects follow
  std::string pose_class{};  ///< label of the target's resting pose; "leaning" if it is in none
  int touching = 0;          ///< number of objects that the target touches
};

/// Stage 1: arranges the objects.
class Arranger {
 public:
  virtual ~Arranger() = default;
  /// @param target  the row's object
  /// @param redraws  counts the arrangements that were drawn again
  /// @return nullopt if no drawn arrangement meets the experiment's conditions.
  virtual std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                             Redraws& redraws) const = 0;
  /// Maximum number of objects of an arrangement, including the target.
  virtual int MaxObjects() const = 0;
};

// The words of the key `arrangement` (docs/architecture.md, definitions).
//
// scattered: the target, the objects that are always there and a random number of others. Each has
// a pose like those of `single` and lies anywhere in the workspace where it does not penetrate
// another object; they may touch. The target need not be the topmost.
//
// side_by_side: the target and a random number of others, each in a pose in which a drop onto the
// table ended. The others are lower than the target. One after the other is moved from a random
// side straight towards the target until it touches an object. All objects then form one group of
// touching objects, and the first one touches the target.
//
// In both, objects are put down upright if as_drawn is set; single repeats the drop until one ends
// upright.
//
// touching, box, pile: objects are dropped one after the other, with random rotations, from a small
// height above the objects below: onto a small area of the table (touching), through the mouth of a
// bag (pile), into an open box (box). When they are at rest, the target is dropped. This is
// repeated, at first for the target alone and then for all objects, until all are at rest in view
// and none overlap.

inline constexpr const char* kSingle = "single";
inline constexpr const char* kScattered = "scattered";
inline constexpr const char* kTouching = "touching";
inline constexpr const char* kSideBySide = "side_by_side";
inline constexpr const char* kBox = "box";
inline constexpr const char* kPile = "pile";

/// @throws base::InputError naming the file, line and key if there are too few objects for the
/// arrangement, or the scene has no box that it or clutter.box_wall_mm needs.
void CheckArrangement(const base::YamlMap& map, const Options& options);

/// Warnings of keys of `clutter` in the file that the experiment's arrangement does not read.
std::vector<base::Finding> IgnoredKeys(const base::YamlMap& map, const Options& options);

/// The arranger selected by the options, which passed CheckArrangement. The arguments must outlive
/// it.
/// @throws base::InputError if an object has no resting pose.
std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::trial
