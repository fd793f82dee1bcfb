#pragma once

#include <optional>
#include <vector>

#include "base/frames.h"
#include "clearing/clearing_options.h"
#include "geometry/observation.h"
#include "grasp/detection.h"

namespace rangegrasp::clearing {

using Samples = std::vector<geometry::SampleId>;

/// Samples that two objects of scans from the same place have in common, of those that either has.
double SharedSamples(Samples a, Samples b);

/// Why an object is passed over.
enum class Passed {
  kNotYet,       ///< it is not
  kNoGrasp,      ///< none is free, as the scene stands
  kNoPath,       ///< none is reached, as the scene stands
  kTriesUsedUp,  ///< for good
};
constexpr std::array<std::string_view, 4> WordsOf(Passed) {
  return {"not_tried", "no_grasp", "no_path", "tries_used_up"};
}

/// What the program remembers of objects that it could not take. It knows an object again by its
/// samples alone: one that a grasp has moved is a new one to it.
class TriedObjects {
 public:
  explicit TriedObjects(const ClearingOptions& options) : options_(&options) {}

  Passed StateOf(const Samples& object) const;
  bool MayBeTaken(const Samples& object) const { return StateOf(object) == Passed::kNotYet; }
  /// nullopt if it may not be taken; else 0, or its failed tries where others come before it.
  std::optional<int> TurnOf(const Samples& object) const;
  int TriesAt(const Samples& object) const;

  /// No grasp could be executed: it is passed over until the scene changes.
  void PassOver(const Samples& object, Passed why);
  /// A grasp with the hand there was executed and failed.
  void Failed(const Samples& object, const base::Pose& X_CH);
  /// It is gone; another one may be seen in its place.
  void Taken(const Samples& object);
  /// What could not be grasped may be free now. Used-up tries stay so.
  void SceneChanged();

  /// Puts the first object's grasps that are like one that has failed at it behind the others.
  void PutFailedLast(grasp::Detection& detection) const;

 private:
  struct Entry {
    Samples samples;
    int tries = 0;
    Passed passed = Passed::kNotYet;
    std::vector<base::Pose> failed_X_CH;
  };
  const Entry* Find(const Samples& object) const;
  Entry& FindOrAdd(const Samples& object);
  bool LikeFailed(const Entry& entry, const base::Pose& X_CH) const;

  const ClearingOptions* options_;
  std::vector<Entry> entries_;
};

}  // namespace rangegrasp::clearing
