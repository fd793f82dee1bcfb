#include "trial/clutter_options.h"

#include <fmt/format.h>

#include "base/units.h"

namespace rangegrasp::trial {

using base::kMm;
using base::YamlMap;

void ReadClutterOptions(YamlMap map, ClutterOptions& options) {
  map.Read("always", options.always, "scattered: objects that lie there in every trial");
  map.Read("others", options.others,
           "scattered: objects that others are drawn from; those of `objects` where it is empty");
  map.Read("standing_share", options.standing_share, 0.0, 1.0,
           "scattered: the target and what is always there stand so often; without it as often as "
           "a drop ends so");
  map.Read("min_seen_share", options.min_seen_share, 0.0, 1.0,
           "scattered: of what would be seen of the target alone, so much is seen at least");
  map.ReadScaled("scatter_radius_mm", options.scatter_radius_m, kMm, 10.0, 1000.0,
                 "scattered: others lie no further from the middle of the workspace");
  map.Read("min_others", options.min_others, 1, 30,
           "scattered, touching: objects beside the target, the number is drawn from here ...");
  map.Read("max_others", options.max_others, 1, 30, "... to here");
  map.Read("draw_others", options.draw_others,
           "box, pile: so many are drawn there, too; off: all others");
  map.Read("min_touching", options.min_touching, 0, 30,
           "touching: so many of them the target touches at least");
  map.ReadScaled("touch_mm", options.touch_m, kMm, 0.0, 5.0, "surfaces this close touch");
  map.ReadScaled("drop_height_mm", options.drop_height_m, kMm, 1.0, 300.0,
                 "objects are let go this high above what lies below");
  map.ReadScaled("touching_radius_mm", options.touching_radius_m, kMm, 0.0, 300.0,
                 "touching: radius of the disc over which objects are let go");
  map.ReadScaled("mouth_radius_mm", options.mouth_radius_m, kMm, 0.0, 300.0,
                 "pile: radius of the bag's mouth");
  map.Read("interval_s", options.interval_s, 0.01, 5.0, "from one object to the next");
  map.Read("max_put_back", options.max_put_back, 0, 1000,
           "objects that roll off their place are put back, so often at most in one heap");
  map.Read("target_drops", options.target_drops, 1, 100,
           "the target is dropped so often at most onto the same heap");
  map.Read("max_draws", options.max_draws, 1, 1000,
           "heaps that are drawn before the trial is given up");
  map.Read("settle_limit_s", options.settle_limit_s, 0.5, 60.0,
           "an arrangement that moves for longer is drawn again");
  map.ReadScaled("rest_speed_mm_s", options.rest_speed_m_s, kMm, 0.01, 100.0,
                 "slower objects rest");
  map.Read("rest_time_s", options.rest_time_s, 0.05, 5.0, "for as long");
  map.ReadScaled("max_penetration_mm", options.max_penetration_m, kMm, 0.01, 10.0,
                 "deepest overlap of two things at rest");
  if (options.min_others > options.max_others) {
    map.Fail(map.Has("max_others") ? "max_others" : "min_others",
             fmt::format("from {} to {}: the first must not be larger", options.min_others,
                         options.max_others));
  }
  map.Finish();
}

}  // namespace rangegrasp::trial
