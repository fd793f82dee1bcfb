#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "base/yaml_map.h"
#include "times/sized_scan.h"
#include "trial/options.h"

namespace rangegrasp::times {

/// What is timed.
enum class Timed {
  kStages,         ///< table 5.1
  kSegmentations,  ///< figures 5.8 and 5.9
};
constexpr std::array<std::string_view, 2> WordsOf(Timed) { return {"stages", "segmentations"}; }

struct Options {
  trial::Options grasping;
  Timed timed = Timed::kStages;
  int scenes = 10;              ///< at most as many as are published, of `segmentations`
  ScanSize size{22377, 19646};  ///< of `stages`: the published scene's (fig. 5.5)
  int repeats = 5;              ///< of each scene; the median counts
  std::vector<trial::MethodKind> methods = {trial::MethodKind::kPublished,
                                            trial::MethodKind::kImproved};
  std::vector<perception::SegmentMethod> segmentations = {perception::SegmentMethod::kRegionGrowing,
                                                          perception::SegmentMethod::kMesh};
  std::vector<ScanSize> published;  ///< of `segmentations`: the reference's scenes
};

/// The keys but those that it shares with grasping. @throws base::InputError
void ReadTimesKeys(base::YamlMap& map, Options& options);
/// All keys, to the end of the map. @throws base::InputError also for a reference that is none.
Options ReadOptions(base::YamlMap& map);

}  // namespace rangegrasp::times
