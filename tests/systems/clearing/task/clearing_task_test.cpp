#include "clearing/task/clearing_task.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiment/experiment.h"

namespace rangegrasp::clearing {
namespace {

experiment::Experiment OpenPile(const std::vector<std::string>& set) {
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/clear_pile.yaml",
                                    {.set = set});
}

int ObjectsOf(const experiment::Experiment& e) { return e.cases.at(0).params.Int("objects"); }

// A run without a record counts them as not delivered.
TEST(ClearingCases, StateTheMaximumNumberOfObjectsOfARun) {
  EXPECT_EQ(ObjectsOf(OpenPile({})), 12);
  const auto drawn = [](const std::string& set) {
    return OpenPile({"clutter.min_others=1", "clutter.max_others=1", set});
  };
  EXPECT_EQ(ObjectsOf(drawn("clutter.draw_others=true")), 2);
  EXPECT_EQ(ObjectsOf(drawn("arrangement=scattered")), 2);
  EXPECT_EQ(ObjectsOf(drawn("arrangement=side_by_side")), 2);
}

// By default a run has as many grasps as its own objects have tries, not those of the experiment.
TEST(ClearingRun, EndsAfterTheTriesOfTheObjectsInIt) {
  const auto e = OpenPile({"arrangement=single", "clearing.tries_per_object=1"});
  const auto data = nlohmann::json::parse(e.task->Run(e.cases.at(0)).data);
  EXPECT_EQ(data["objects"], 1);
  EXPECT_EQ(data["grasps"], 1);
  EXPECT_EQ(data["stop"], "max_grasps");
}

experiment::Record RecordOf(const std::string& id, Stop stop, const std::vector<ObjectEnd>& ends) {
  Clearing clearing;
  clearing.stop = stop;
  clearing.scans = 3;
  clearing.objects = ends;
  return {{id, "pile", 1, {}, 0}, ResultOf(clearing, "a")};
}

TEST(ReportOf, CountsObjectsOverRunsAlsoOfThoseThatLeaveNoRecord) {
  const std::vector<experiment::Record> records = {
      RecordOf("pile-0000", Stop::kNothingPerceived,
               {{"a", Fate::kDelivered, 1, ""}, {"b", Fate::kDelivered, 2, ""}}),
      RecordOf("pile-0001", Stop::kTriesUsedUp,
               {{"a", Fate::kLeft, 3, "tries_used_up"}, {"b", Fate::kBrought, 1, "dropped"}}),
      {{"pile-0002", "pile", 1, {{"objects", 2}}, 0}, {"timed_out", "", "", "{}", {}}}};
  const auto report = ReportOf({}, records);
  ASSERT_EQ(report.csv.rows.size(), 1u);
  const auto& row = report.csv.rows[0];
  // None of the third run's 2 objects is delivered.
  EXPECT_EQ(std::vector(row.begin(), row.begin() + 5),
            (std::vector<std::string>{"pile", "3", "6", "2", "33.33"}));
  EXPECT_EQ(row.back(), "cleared 1, timed_out 1, tries_used_up 1");
  const auto& objects = report.sections[1].grid.rows;
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].back(), "left: tries_used_up 1");
  EXPECT_EQ(objects[1].back(), "brought: dropped 1");
  EXPECT_EQ(objects[1][5], "1.50");  // grasps / run
}

TEST(ReportOf, ARunWithoutAnyRecordHasNoRates) {
  const auto report =
      ReportOf({}, {{{"pile-0002", "pile", 1, {}, 0}, {"timed_out", "", "", "{}", {}}}});
  EXPECT_EQ(report.csv.rows.at(0)[4], "-");
}

}  // namespace
}  // namespace rangegrasp::clearing
