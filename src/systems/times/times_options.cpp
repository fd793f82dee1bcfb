#include "times/times_options.h"

#include "base/csv.h"
#include "base/file.h"

namespace rangegrasp::times {

void ReadTimesKeys(base::YamlMap& map, Options& o) {
  constexpr int kMaxPoints = 10'000'000;
  map.Read("timed", o.timed,
           "the stages of table 5.1, or the segmentations of figures 5.8 and 5.9");
  map.Read("scenes", o.scenes, 1, 10000,
           "arrangements; of segmentations at most those of the reference");
  map.Read("object_points", o.size.object_points, 100, kMaxPoints,
           "of a scan; segmentations: as the reference says");
  map.Read("table_points", o.size.table_points, 100, kMaxPoints, "likewise");
  map.Read("repeats", o.repeats, 1, 1000, "times that each is timed; the median counts");
  map.Read("methods", o.methods, "that stages are timed of");
  map.Read("segmentations", o.segmentations, "that are timed");
}

Options ReadOptions(base::YamlMap& map) {
  Options options;
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "an experiment with times has `scenes` in its place");
  }
  ReadTimesKeys(map, options);
  options.grasping = trial::ReadOptions(map);
  if (options.grasping.take != grasp::kAnywhere) {
    map.Fail("grasp", "take: `task: times` has no use for it, `task: grasping` has");
  }
  if (options.timed != Timed::kSegmentations) return options;
  if (options.grasping.reference.empty()) {
    map.Fail("reference",
             "the published scenes' sizes are needed (columns object_points, "
             "table_points)");
  }
  const auto& file = options.grasping.reference;
  const auto csv = base::CsvTable::Parse(base::ReadFile(file), file.string());
  for (std::size_t row = 0; row < csv.rows(); ++row) {
    options.published.push_back({static_cast<int>(csv.Number(row, csv.Column("object_points"))),
                                 static_cast<int>(csv.Number(row, csv.Column("table_points")))});
  }
  return options;
}

}  // namespace rangegrasp::times
