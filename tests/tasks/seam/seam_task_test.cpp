#include "tasks/seam/seam_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "tasks/seam/seam_json.h"
#include "tasks/seam/small_experiment.h"
#include "temp_folder.h"

namespace rangegrasp::tasks::seam_task {
namespace {

using experiment::Case;
using experiment::Record;
using experiment::ReplayOptions;
using experiment::Result;
using experiment::Task;
using testing::HasSubstr;
using testing::StartsWith;
using testing_support::kSource;
using testing_support::TempFolder;

// As the engine reads a file: its own keys first.
std::unique_ptr<Task> Shortened(const std::string& name, int seams) {
  const auto file = kSource / "experiments" / (name + ".yaml");
  auto map = core::YamlMap::FromFile(
      file, {"seams=" + std::to_string(seams), "profiles_per_seam=40", "seed=4711"});
  experiment::Common common;
  common.file = file;
  std::string task;
  map.Read("task", task, "kind");
  map.Read("name", common.name, "name");
  map.Read("seed", common.seed, "seed");
  EXPECT_EQ(task, SeamTask().name);
  return SeamTask().read(map, common);
}

TEST(SeamTask, EveryShippedExperimentIsReadAndItsCasesAreNamedOnce) {
  for (const char* name :
       {"seam_base", "seam_three_lines", "seam_track", "seam_half_circle", "seam_hazards"}) {
    const auto cases = Shortened(name, 13)->Cases();
    std::set<std::string> ids;
    for (const Case& c : cases) {
      ids.insert(c.id);
      EXPECT_EQ(c.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-."),
                std::string::npos);
      EXPECT_FALSE(c.group.empty());
    }
    EXPECT_EQ(ids.size(), cases.size());
    EXPECT_EQ(
        cases.size(),
        std::string(name) == "seam_base" || std::string(name) == "seam_three_lines" ? 13U : 26U);
  }
}

// What a case is does not depend on how many there are: a longer run goes on where a short one was.
TEST(SeamTask, CasesOfAShortRunAreTheFirstOfALongOne) {
  for (const char* name : {"seam_base", "seam_hazards"}) {
    const auto few = Shortened(name, 3)->Cases();
    const auto many = Shortened(name, 7)->Cases();
    for (std::size_t i = 0; i < few.size(); ++i) {
      EXPECT_EQ(few[i].id, many[i].id);
      EXPECT_EQ(few[i].group, many[i].group);
      EXPECT_EQ(few[i].seed, many[i].seed);
      EXPECT_EQ(few[i].params, many[i].params);
    }
  }
}

TEST(SeamTask, ACaseGivesTheSameWheneverAndWhereverItIsRun) {
  for (const char* name : {"seam_base", "seam_hazards"}) {
    const auto first = Shortened(name, 4);
    const auto second = Shortened(name, 6);
    const auto cases = first->Cases();
    std::vector<std::string> forward;
    for (const Case& c : cases) forward.push_back(first->Run(c).data);
    for (std::size_t i = cases.size(); i-- > 0;) {
      EXPECT_EQ(second->Run(cases[i]).data, forward[i]) << cases[i].id;
    }
  }
}

TEST(SeamTask, ResultsAreReadBackTheSame) {
  const auto task = Shortened("seam_track", 2);
  for (const Case& c : task->Cases()) {
    const Result result = task->Run(c);
    const SeamParams params = ParamsFrom(c.params);
    EXPECT_EQ(ToJson(params), c.params);
    EXPECT_EQ(ToJson(RunResultFrom(params, result.data)), result.data);
    EXPECT_GT(nlohmann::json::parse(result.data)["settled_m"], 0.0);
    EXPECT_EQ(result.outcome, nlohmann::json::parse(result.data)["end"]);
  }
  const auto rates = Shortened("seam_base", 2);
  for (const Case& c : rates->Cases()) {
    const Result result = rates->Run(c);
    const SeamParams params = ParamsFrom(c.params);
    EXPECT_EQ(ToJson(params), c.params);
    EXPECT_EQ(ToJson(SeamResultFrom(params, result.data)), result.data);
    EXPECT_EQ(result.outcome, "measured");
  }
}

TEST(SeamTask, DamagedRecordsAreToldAsSuch) {
  for (const char* text : {"", "{", "[]", "{\"seam\": 3}", "{\"run\": 1, \"shape\": \"step\"}"}) {
    EXPECT_THROW(ParamsFrom(text), core::RunError) << text;
  }
  EXPECT_THROW(SeamResultFrom({}, "{}"), core::RunError);
  EXPECT_THROW(RunResultFrom({}, "{}"), core::RunError);
}

TEST(SeamTask, ReplayLeavesThePathPacketsAndPictureOfARun) {
  const TempFolder folder;
  const auto task = Shortened("seam_track", 1);
  const Case which = task->Cases()[1];
  ReplayOptions options;
  options.folder = folder / "r";
  EXPECT_EQ(task->Replay(which, options).data, task->Run(which).data);
  EXPECT_THAT(core::ReadFile(folder / "r" / which.id / "path.csv"),
              StartsWith("time_s,x_mm,y_mm,"));
  EXPECT_THAT(core::ReadFile(folder / "r" / which.id / "packets.xml"), StartsWith("<correction>"));
  EXPECT_THAT(core::ReadFile(folder / "r" / which.id / "path.svg"), HasSubstr("</svg>"));
  options.video = "v.mp4";
  EXPECT_THROW(task->Replay(which, options), core::InputError);
}

TEST(SeamTask, ReplayLeavesTheProfilesLabelsAndPictureOfASeam) {
  const TempFolder folder;
  const auto task = Shortened("seam_base", 1);
  const Case which = task->Cases()[0];
  ReplayOptions options;
  options.folder = folder / "r";
  EXPECT_EQ(task->Replay(which, options).data, task->Run(which).data);
  const auto lines = [&](const char* name) {
    const std::string text = core::ReadFile(folder / "r" / which.id / name);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines("profiles.csv"), 40);
  EXPECT_EQ(lines("labels.csv"), 41);
  EXPECT_THAT(core::ReadFile(folder / "r" / which.id / "profile.svg"),
              HasSubstr("Gradient-Accumulation"));
}

TEST(SeamTask, EveryKeyIsDocumented) {
  auto map = core::YamlMap::ForDocumentation();
  SeamTask().read_keys(map);
  EXPECT_GT(map.Keys().size(), 50U);
  for (const core::KeyDoc& key : map.Keys()) {
    EXPECT_FALSE(key.doc.empty()) << key.path;
    EXPECT_FALSE(key.doc.ends_with('.')) << key.path;
  }
}

}  // namespace
}  // namespace rangegrasp::tasks::seam_task
