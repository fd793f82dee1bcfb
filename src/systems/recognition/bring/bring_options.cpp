#include "recognition/bring/bring_options.h"

namespace rangegrasp::bring {

using base::kMm;
using base::YamlMap;

void ReadBringKeys(YamlMap& map, BringOptions& o) {
  map.Read("runs_per_object", o.runs_per_object, 1, 100000, "each of `objects` is wanted so often");
  map.Read("known", o.known,
           "objects that the program knows the models of; all of `objects` unless given");
  auto keys = map.Child("bring", "from the word to the hand of a person");
  keys.Read("absent", o.absent,
            "the wanted object is taken off the table before the program looks: it has to say so");
  keys.Read("use", o.use,
            "what it is wanted for: of the grasps in its grasps.yaml those for this use; all");
  keys.Read("max_tries", o.max_tries, 1, 20, "grasps at the wanted object");
  keys.Read("max_clear", o.max_clear, 0, 1000,
            "attempts to clear others away; 0: two for each object");
  keys.Read("max_looks", o.max_looks, 1, 20,
            "looks at one table before others are cleared away: the first from the fixed sensor, "
            "more from the wrist where look.sensor is given");
  keys.ReadScaled("near_mm", o.near_m, kMm, 0.0, 1000.0,
                  "others this near to the wanted one may be in its way");
  keys.ReadScaled("same_place_mm", o.same_place_m, kMm, 0.0, 1000.0,
                  "objects of two looks whose centers are no further apart are one");
  trial::ReadUser(keys.Child("user", "the person who takes it"), o.hand_over);
  keys.Finish();
}

Options ReadOptions(YamlMap& map) {
  Options options;
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "`task: bring` has `runs_per_object` in its place");
  }
  if (map.Has("views")) map.Fail("views", "`task: bring` has bring.max_looks in its place");
  ReadBringKeys(map, options.bring);
  options.grasping = trial::ReadOptions(map);
  if (options.grasping.take != grasp::kAnywhere) {
    map.Fail("grasp", "take: `task: bring` has no use for it, `task: grasping` has");
  }
  if (options.bring.known.empty()) options.bring.known = options.grasping.objects;
  return options;
}

}  // namespace rangegrasp::bring
