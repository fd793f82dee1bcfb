#include "grasp/read_options.h"

#include "base/read_additions.h"
#include "base/units.h"

namespace rangegrasp::grasp {
namespace {

using base::kMm;
using base::YamlMap;

std::string WhereTaken() {
  std::string text = "where objects are taken: anywhere";
  for (const std::string& word : GraspSelectorWords()) {
    if (const GraspSelector* selector = FindGraspSelector(word)) text += ", or " + selector->about;
  }
  return text;
}

}  // namespace

void ReadGraspOptions(YamlMap map, DetectorOptions& all) {
  GraspOptions& options = all.grasp;
  map.Read("take", all.take, GraspSelectorWords(), WhereTaken());
  map.ReadScaled("table_clearance_mm", options.table_clearance_m, kMm, 0.0, 50.0,
                 "the hand stays this far above the table");
  map.Read("max_candidates", options.max_candidates, 1, 200, "grasps that are kept, best first");
  map.Read("power_only", options.power_only,
           "only power grasps, of rotational objects, too: as on stereo data (section 5.3.2)");
  map.Read("approach", options.approach,
           "the hand comes from above; sides_too: and from the sides where few such grasps are "
           "free; sides: from there alone (section 7.2)");
  map.Read("preshape", options.preshape,
           "the hand opens a little wider than the object; off: fully");
  base::ReadAdditions<GraspAdditions>(map, options);
  map.Finish();
}

void ReadPlanningOptions(YamlMap map, planning::PlanOptions& options, ObstacleOptions& obstacles) {
  map.Read("leftover_obstacles", obstacles.leftovers,
           "motions keep clear of measured points that belong to no object");
  map.Read("unseen_obstacles", obstacles.unseen, "and of the space behind objects but the target");
  map.ReadScaled("approach_mm", options.approach_m, kMm, 20.0, 400.0,
                 "straight approach before the grasp");
  map.ReadScaled("lift_mm", options.lift_m, kMm, 100.0, 400.0, "height of the lift");
  map.Finish();
}

}  // namespace rangegrasp::grasp
