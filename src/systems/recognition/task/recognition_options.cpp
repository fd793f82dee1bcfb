#include "recognition/task/recognition_options.h"

namespace rangegrasp::recognition_task {

using base::kDeg;
using base::kMm;

void ReadRecognitionKeys(base::YamlMap& map, Options& o) {
  auto keys = map.Child("recognition", "from what is perceived to known objects and their poses");
  auto& r = o.recognition;
  keys.Read("without_target", o.without_target,
            "the library lacks the scene's target, which must stay unknown then");
  keys.Read("until_sure", o.until_sure,
            "looks again only at what is not known or whose pose is open, up to `views` in all");
  keys.ReadScaled("max_distance_mm", o.max_distance_m, kMm, 0.1, 100.0,
                  "a pose counts as found up to here ...");
  keys.ReadScaled("max_angle_deg", o.max_angle_rad, kDeg, 0.1, 180.0, "... and here");
  keys.ReadScaled("tolerance_mm", r.tolerance_m, kMm, 0.5, 20.0,
                  "a sample this near to a model's surface is explained");
  keys.Read("min_score", r.min_score, 0.0, 1.0, "what is found scores so high at least ...");
  keys.Read("margin", r.margin, 0.0, 1.0, "... and so much higher than any other object there");
  keys.Read("unexplained_weight", r.unexplained_weight, 0.0, 1.0,
            "of samples that a model leaves unexplained so much counts");
  keys.Read("color_weight", r.color_weight, 0.0, 1.0,
            "where the sensors see colors (color): colors that agree nowhere take this share off "
            "the score");
  keys.Read("references", r.references, 0, 1000,
            "points of a segment whose pairs vote for poses; 0: none");
  keys.Read("registered", r.registered, 1, 1000, "poses of one object that are registered");
  keys.Finish();
}

Options ReadOptions(base::YamlMap& map) {
  Options options;
  ReadRecognitionKeys(map, options);
  options.grasping = trial::ReadOptions(map);
  if (options.grasping.take != grasp::kAnywhere) {
    map.Fail("grasp", "take: `task: recognition` has no use for it, `task: grasping` has");
  }
  return options;
}

}  // namespace rangegrasp::recognition_task
