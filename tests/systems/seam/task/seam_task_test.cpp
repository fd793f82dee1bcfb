#include "seam/task/seam_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "experiment/view.h"
#include "seam/task/seam_score.h"
#include "seam/task/small_experiment.h"
#include "temp_folder.h"

namespace rangegrasp::seam {
namespace {

using experiment::Case;
using experiment::ReplayOptions;
using experiment::Result;
using experiment::Task;
using testing::HasSubstr;
using testing::StartsWith;
using testing_support::kSource;
using testing_support::TempFolder;

// Reads a file as the engine does: its own keys first.
std::unique_ptr<Task> Shortened(const std::string& name, int seams) {
  const auto file = kSource / "experiments" / (name + ".yaml");
  auto map = base::YamlMap::FromFile(
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
        std::string(name) == "seam_base" || std::string(name) == "seam_three_lines" ? 13U : 39U);
  }
}

// A case does not depend on the number of cases, so a longer run continues a shorter one.
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
    EXPECT_EQ(ParamsOf(params), c.params);
    EXPECT_EQ(ToJson(RunResultFrom(params, result.data)), result.data);
    EXPECT_GT(nlohmann::json::parse(result.data)["settled_m"], 0.0);
    EXPECT_EQ(result.outcome, nlohmann::json::parse(result.data)["end"]);
  }
  const auto rates = Shortened("seam_base", 2);
  for (const Case& c : rates->Cases()) {
    const Result result = rates->Run(c);
    const SeamParams params = ParamsFrom(c.params);
    EXPECT_EQ(ParamsOf(params), c.params);
    EXPECT_EQ(ToJson(SeamResultFrom(params, result.data)), result.data);
    EXPECT_EQ(result.outcome, "measured");
  }
}

TEST(SeamTask, DamagedRecordsAreRefused) {
  for (const experiment::Params& params : {experiment::Params(), experiment::Params{{"seam", 3}},
                                           experiment::Params{{"run", 1}, {"shape", "step"}}}) {
    EXPECT_THROW(ParamsFrom(params), base::InputError) << ToJson(params);
  }
  EXPECT_THROW(SeamResultFrom({}, "{}"), base::RunError);
  EXPECT_THROW(RunResultFrom({}, "{}"), base::RunError);
}

TEST(SeamTask, ReplayLeavesThePathPacketsAndPictureOfARun) {
  const TempFolder folder;
  const auto task = Shortened("seam_track", 1);
  const Case which = task->Cases()[1];
  ReplayOptions options;
  options.folder = folder / "r";
  EXPECT_EQ(task->Replay(which, options).data, task->Run(which).data);
  EXPECT_THAT(base::ReadFile(folder / "r" / which.id / "path.csv"),
              StartsWith("time_s,x_mm,y_mm,"));
  EXPECT_THAT(base::ReadFile(folder / "r" / which.id / "packets.xml"), StartsWith("<correction>"));
  EXPECT_THAT(base::ReadFile(folder / "r" / which.id / "path.svg"), HasSubstr("</svg>"));
  options.video = "v.mp4";
  EXPECT_THROW(task->Replay(which, options), base::InputError);
}

TEST(SeamTask, ReplayLeavesTheProfilesLabelsAndPictureOfASeam) {
  const TempFolder folder;
  const auto task = Shortened("seam_base", 1);
  const Case which = task->Cases()[0];
  EXPECT_EQ(task->Replay(which, {.folder = folder / "r"}).data, task->Run(which).data);
  const auto lines = [&](const char* name) {
    const std::string text = base::ReadFile(folder / "r" / which.id / name);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines("profiles.csv"), 40);
  EXPECT_EQ(lines("labels.csv"), 41);
  EXPECT_THAT(base::ReadFile(folder / "r" / which.id / "profile.svg"),
              HasSubstr("Gradient-Accumulation"));
}

// For each method, a view shows as many positions within 10 px as the record counts.
TEST(SeamTask, AViewOfASeamShowsWhatItsRecordCounts) {
  const auto task = Shortened("seam_base", 1);
  const Case which = task->Cases()[0];
  experiment::View view;
  const Result result = task->Replay(which, {.view = &view});
  EXPECT_EQ(result.data, task->Run(which).data);
  ASSERT_EQ(view.panels.size(), 2U);
  const auto& series = view.panels[0].series;
  ASSERT_EQ(series.size(), 1 + kMethods);
  EXPECT_EQ(series[0].label, "truth");
  constexpr double kTaskColumnsPerMm = 12.0;
  // Edges closer to the end than 20 columns are not counted.
  const double end_mm = 0.5 * 1023 / kTaskColumnsPerMm - 20.0 / kTaskColumnsPerMm;
  const auto seam = SeamResultFrom(ParamsFrom(which.params), result.data);
  for (std::size_t m = 0; m < kMethods; ++m) {
    EXPECT_EQ(series[m + 1].label, MethodTitle(m));
    int within = 0;
    for (std::size_t i = 0; i < 40; ++i) {
      if (std::abs(series[0].y[i]) > end_mm) continue;
      within += std::abs(series[m + 1].y[i] - series[0].y[i]) <= 10.0 / kTaskColumnsPerMm ? 1 : 0;
    }
    EXPECT_EQ(within, seam.all[m].within[1]) << MethodTitle(m);
  }
}

TEST(SeamTask, APageIsAProfileWithTheTruthAndThoseThatWentMostWrongAreAmongThem) {
  const auto task = Shortened("seam_base", 6);
  for (const Case& which : task->Cases()) {
    experiment::View view;
    task->Replay(which, {.view = &view});
    EXPECT_GE(view.pages.size(), 8U);
    EXPECT_LE(view.pages.size(), 16U);
    constexpr auto kShown = static_cast<std::size_t>(DecisionMethod::kWeights);  // on the pages
    const auto& truth = view.panels[0].series[0].y;
    const auto& found = view.panels[0].series[1 + kAlone + kShown].y;
    double max_error = -1.0;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (std::isnan(truth[i]) && std::isnan(found[i])) continue;  // no edge, and none found
      const double error = std::abs(view.panels[1].series[kShown].y[i]);
      // A missed edge counts as worse than any error.
      const double wrong = std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
      if (wrong > max_error) worst = i;
      max_error = std::max(max_error, wrong);
    }
    const auto name = "profile " + std::to_string(worst + 1) + " of 40,";
    const auto is_worst = [&](const auto& page) { return page.name.starts_with(name); };
    EXPECT_TRUE(std::ranges::any_of(view.pages, is_worst)) << name;
    for (const auto& page : view.pages) {
      ASSERT_EQ(page.panels.size(), 3U);
      EXPECT_EQ(page.panels[0].series[0].y.size(), 1024U);
    }
  }
}

TEST(SeamTask, AViewOfARunHasTheTruthAsFarAsTheSensorLooked) {
  const auto task = Shortened("seam_track", 1);
  experiment::View view;
  task->Replay(task->Cases()[1], {.view = &view});
  ASSERT_EQ(view.panels.size(), 3U);
  const auto& map = view.panels[0].series;
  EXPECT_EQ(map[0].label, "edge");
  EXPECT_NEAR(map[0].x.back(), map[1].x.back(), 1.0);  // edge and sent positions
  // The head settles on the wanted distance, 5 mm, so the error in the second panel is small.
  EXPECT_LT(std::abs(view.panels[1].series[0].y.back()), 1.0);
}

TEST(SeamTask, APictureOfAFallingEdgeHasItsMarkerAtTheStep) {
  TrackerOptions options;
  options.method = DecisionMethod::kWeights;
  options.positive_edge = false;
  EdgeTracker tracker(options);
  Reading reading;
  for (int k = 0; k < 5; ++k) {
    Profile profile;
    profile.time_s = 0.01 * k;
    for (int i = 0; i < 1024; ++i) profile.height_m.push_back(i < 300 ? 1e-3F : 0.0F);
    reading = tracker.Update(profile);
  }
  const auto panels = ProfilePanels(tracker, reading, options.line);
  ASSERT_EQ(panels[1].markers.size(), 1U);
  const double marker = panels[1].markers[0].x;
  EXPECT_NEAR(marker, 300.0, 2.0);
  for (int panel : {0, 1}) {
    const auto& heights = panels[static_cast<std::size_t>(panel)].series[0].y;
    const auto at = [&](double column) { return heights[static_cast<std::size_t>(column)]; };
    EXPECT_GT(at(marker - 20.0), at(marker + 20.0) + 0.5) << panel;
  }
}

TEST(SeamTask, EveryKeyIsDocumented) {
  auto map = base::YamlMap::ForDocumentation();
  SeamTask().read_keys(map);
  EXPECT_GT(map.Keys().size(), 40U);
  for (const base::KeyDoc& key : map.Keys()) {
    EXPECT_FALSE(key.doc.empty()) << key.path;
    EXPECT_FALSE(key.doc.ends_with('.')) << key.path;
  }
}

}  // namespace
}  // namespace rangegrasp::seam
