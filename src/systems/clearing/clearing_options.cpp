#include "clearing/clearing_options.h"

namespace rangegrasp::clearing {

int Options::MaxGrasps() const {
  if (clearing.max_grasps > 0) return clearing.max_grasps;
  return clearing.tries_per_object * static_cast<int>(grasping.objects.size());
}

void ReadClearingKeys(base::YamlMap& map, ClearingOptions& o) {
  map.Read("runs", o.runs, 1, 100000, "arrangements that are cleared");
  auto keys = map.Child("clearing", "from one grasp to the next");
  keys.Read(
      "rescan", o.rescan,
      "a new scan after each grasp, or only after a failed one: what was taken is left out of "
      "the last scan");
  keys.Read("retry", o.retry,
            "a failed object is tried again at once, or after those with fewer failed tries");
  keys.Read("tries_per_object", o.tries_per_object, 1, 20,
            "failed grasps at one object before it is passed over");
  keys.Read("max_grasps", o.max_grasps, 0, 10000,
            "grasps before the run is given up; 0: tries_per_object for each object");
  keys.Read("idle_scans", o.idle_scans, 0, 20,
            "new scans in which nothing can be done before the run is given up");
  keys.Read("same_object_share", o.same_object_share, 0.0, 1.0,
            "objects of two scans with this share of their samples in common are one");
  keys.ReadScaled("other_grasp_mm", o.other_grasp_m, base::kMm, 0.0, 1000.0,
                  "a grasp this far from a failed one is another one");
  keys.ReadScaled("other_grasp_deg", o.other_grasp_rad, base::kDeg, 0.0, 180.0,
                  "likewise one that is turned by so much");
  keys.Finish();
}

Options ReadOptions(base::YamlMap& map) {
  Options options;
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "a clearing experiment has `runs` in its place");
  }
  if (map.Has("views")) {
    map.Fail("views", "a table is cleared with one look a grasp, by its own sensor");
  }
  ReadClearingKeys(map, options.clearing);
  options.grasping = trial::ReadOptions(map);
  return options;
}

}  // namespace rangegrasp::clearing
