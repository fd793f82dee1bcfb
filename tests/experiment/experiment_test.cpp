#include "experiment/experiment.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <tuple>

#include "base/error.h"
#include "error_of.h"
#include "experiment/report.h"
#include "experiment/runner.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;

// A test task: `groups` words with `cases_each` cases each; a case squares its number.
class Squares : public Task {
 public:
  Squares(std::vector<std::string> groups, int each, std::uint64_t seed)
      : groups_(std::move(groups)), each_(each), seed_(seed) {}
  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const auto& group : groups_) {
      for (int i = 0; i < each_; ++i) {
        cases.push_back({fmt::format("{}-{}", group, i), group, seed_, {{"number", i}}});
      }
    }
    return cases;
  }
  Result Run(const Case& which) const override {
    const int i = which.params.Int("number");
    return {"done", "count", fmt::format("{}", i * i), "{}", {{"count", 1.0}}};
  }
  Result Replay(const Case& which, const ReplayOptions&) const override { return Run(which); }
  void AddTo(Stamp& stamp) const override { stamp.data["unit"] = "1"; }

 private:
  std::vector<std::string> groups_;
  int each_;
  std::uint64_t seed_;
};

struct SquareOptions {
  std::vector<std::string> groups = {"a", "b"};
  int each = 3;
};
SquareOptions ReadSquares(base::YamlMap& map) {
  SquareOptions options;
  map.Read("groups", options.groups, "words");
  map.Read("cases_each", options.each, 1, 10, "cases of each word");
  map.Finish();
  return options;
}

void AddSquares(const std::string& name, bool uses_seed) {
  TaskKind kind;
  kind.name = name;
  kind.description = "Squares numbers.";
  kind.trials_key = "cases_each";
  kind.uses_seed = uses_seed;
  kind.success = "done";
  kind.read = [](base::YamlMap& map, const Common& common) -> std::unique_ptr<Task> {
    const SquareOptions o = ReadSquares(map);
    return std::make_unique<Squares>(o.groups, o.each, common.seed);
  };
  kind.read_keys = [](base::YamlMap& map) { ReadSquares(map); };
  kind.report = [](const Stamp& stamp, const std::vector<Record>& records) {
    std::ignore = nlohmann::json::parse(ValueOr(stamp.data, "rows", "[]"));
    Report report;
    report.sections.push_back({"Squares", {{"id", "square"}, {true, false}, {}, false}});
    for (const auto& r : records) {
      const auto log = nlohmann::json::parse(r.result.data).value("log", nlohmann::json::object());
      std::ignore = log.value("count", 0);
      report.sections[0].grid.rows.push_back({r.which.id, r.result.detail});
    }
    return report;
  };
  AddKind(kind);
}

[[maybe_unused]] const bool kAdded = [] {
  AddSquares("squares", true);
  AddSquares("seedless", false);
  return true;
}();

class ExperimentTest : public testing::Test {
 protected:
  Experiment Open(const std::string& text, const Changes& changes = {}) {
    return OpenExperiment(folder_.Write("demo.yaml", text), changes);
  }
  static std::vector<std::string> Ids(const Experiment& e) {
    std::vector<std::string> ids;
    for (const Case& c : e.cases) ids.push_back(c.id);
    return ids;
  }

  TempFolder folder_;
};

TEST_F(ExperimentTest, NameAndSeedHaveDefaults) {
  const auto e = Open("task: squares\n");
  EXPECT_EQ(e.common.name, "demo");
  EXPECT_EQ(e.common.seed, 1u);
  EXPECT_EQ(e.cases.size(), 6u);
  EXPECT_EQ(e.cases[4].position, 4);
  EXPECT_EQ(e.stamp.identity.at("cases"), "6");
  EXPECT_EQ(e.stamp.identity.at("groups"), "a,b");
}

TEST_F(ExperimentTest, TheCommandLineChangesTheFile) {
  const auto e = Open("task: squares\nseed: 3\ncases_each: 9\n",
                      {.set = {"groups=[x, y, z]"}, .trials = 2, .seed = 7, .groups = {"z", "x"}});
  EXPECT_EQ(Ids(e), (std::vector<std::string>{"x-0", "x-1", "z-0", "z-1"}));  // in the file's order
  EXPECT_EQ(e.cases[2].position, 4);  // a row's position does not depend on the others
  EXPECT_EQ(e.common.seed, 7u);
}

TEST_F(ExperimentTest, ItsHashLeavesOutSeedAndNumberOfTrialsAlone) {
  const auto hash = [&](const std::string& text, const Changes& changes = {}) {
    return Open(text, changes).stamp.identity.at("experiment_hash");
  };
  const std::string plain = hash("task: squares\n");
  EXPECT_EQ(hash("task: squares\nseed: 5\ncases_each: 2\n"), hash("task: squares\n"));
  Changes changes{.trials = 1, .seed = 9};
  EXPECT_EQ(hash("task: squares\n", changes), plain);
  changes.set = {"groups=[a]"};
  EXPECT_NE(hash("task: squares\n", changes), plain);
  EXPECT_NE(hash("task: squares\ngroups: [a]\n"), plain);
}

TEST_F(ExperimentTest, ARunMayCountAnotherOutcomeAsSuccessThanItsKind) {
  auto e = Open("task: squares\n");
  EXPECT_EQ(SuccessOf(*e.kind, e.stamp), e.kind->success);
  e.stamp.data[kSuccess] = "absent";
  EXPECT_EQ(SuccessOf(*e.kind, e.stamp), "absent");
}

TEST_F(ExperimentTest, ItsStampNamesTheKeyOfTheNumberOfTrials) {
  EXPECT_EQ(Open("task: squares\n").stamp.data.at(kTrialsKey), "cases_each");
}

TEST_F(ExperimentTest, WhatIsWrongIsNamed) {
  EXPECT_THAT(ErrorOf([&] { Open("task: square\n"); }), HasSubstr("demo.yaml:1: key 'task'"));
  EXPECT_THAT(ErrorOf([&] { Open("task: square\n"); }), HasSubstr("nearest: squares"));
  EXPECT_THAT(ErrorOf([&] { Open("task: squares\nname: a/b\n"); }), HasSubstr("'a/b'"));
  EXPECT_THAT(ErrorOf([&] { Open("task: squares\nseeds: 1\n"); }),
              HasSubstr("nearest valid key: 'seed'"));
  EXPECT_THAT(ErrorOf([&] { Open("task: squares\n", {.groups = {"c"}}); }),
              testing::AllOf(HasSubstr("has no 'c'; did you mean"),
                             HasSubstr("(the groups of its tables are a, b; ")));
  EXPECT_THAT(ErrorOf([&] { Open("task: squares\n", {.trials = 11}); }),
              HasSubstr("--set cases_each"));
  EXPECT_THAT(ErrorOf([&] { Open("task: squares\ngroups: [a, a]\n"); }),
              HasSubstr("is given twice"));
  EXPECT_THAT(ErrorOf([&] { Open("task: seedless\n", {.seed = 3}); }),
              HasSubstr("draws no random numbers"));
}

TEST_F(ExperimentTest, AStampBringsTheExperimentBackAfterTheFileHasChanged) {
  const auto e = Open("task: squares\nname: first\n", {.trials = 2, .groups = {"b"}});
  folder_.Write("demo.yaml", "task: squares\nname: second\n");
  const auto again = OpenAgain(e.stamp, false);
  EXPECT_EQ(Ids(again), Ids(e));
  EXPECT_EQ(again.stamp.identity, e.stamp.identity);
  EXPECT_THROW(OpenAgain(Stamp{}, false), base::InputError);
}

TEST_F(ExperimentTest, KeysInWhichTwoRunsDifferAreFoundInFileAndCommandLine) {
  const auto one =
      Open("task: squares\nname: one\ngroups: [a, b]  # comment\nseed: 1\n", {.trials = 2});
  const auto two = Open("# other order\ngroups:\n  - a\n  - b\ntask: squares\n",
                        {.set = {"name=two", "stop_after=3"}, .trials = 3, .seed = 2});
  const auto keys = DifferingKeys(one.stamp, two.stamp);
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].key + ": " + keys[0].first + ", " + keys[0].second, "name: one, two");
  EXPECT_EQ(keys[1].key + ": " + keys[1].first + ", " + keys[1].second, "stop_after: , 3");
  EXPECT_TRUE(DifferingKeys(one.stamp, one.stamp).empty());
}

TEST_F(ExperimentTest, CasesAreFoundByTheirIds) {
  const auto e = Open("task: squares\n");
  EXPECT_EQ(CaseOf(e, "b-1").position, 4);
  EXPECT_THAT(ErrorOf([&] { CaseOf(e, "b-7"); }), HasSubstr("nearest: 'b-"));
}

TEST_F(ExperimentTest, ReportsSayWhatIsMissing) {
  const auto e = Open("task: squares\n");
  Store store = Store::Create(folder_ / "out");
  store.WriteStamp(e.stamp);
  RunCases(ShardOf(e.cases, 1, 2), [&](const Case& c) { return e.task->Run(c); }, store, {}, {});
  const std::string part =
      Format(ReportOf({store.ReadStamp(), store.ReadAll()}), store.ReadStamp(), TableFormat::kText);
  EXPECT_THAT(part, HasSubstr("3 of 6 cases are missing"));
  RunCases(Missing(e.cases, store), [&](const Case& c) { return e.task->Run(c); }, store, {}, {});
  const Report whole = ReportOf({store.ReadStamp(), store.ReadAll()});
  EXPECT_THAT(Format(whole, store.ReadStamp(), TableFormat::kText),
              testing::Not(HasSubstr("missing")));
  const auto json = nlohmann::json::parse(Format(whole, store.ReadStamp(), TableFormat::kJson));
  EXPECT_EQ(json["experiment"], "demo");
  EXPECT_EQ(json["stamp"]["task"], "squares");
  EXPECT_FALSE(json["stamp"].contains("experiment_text"));
  EXPECT_EQ(json["tables"][0]["rows"][5], nlohmann::json({"b-2", 4}));
  EXPECT_THAT(Format(whole, store.ReadStamp(), TableFormat::kCsv),
              testing::StartsWith("id,square\na-0,0\n"));
  EXPECT_THAT(Format(whole, store.ReadStamp(), TableFormat::kMarkdown),
              testing::StartsWith("Squares:\n\n| id | square |\n"));
}

TEST_F(ExperimentTest, ATableThatFailsNamesTheCaseAndTheKey) {
  const auto e = Open("task: squares\n");
  Results results{e.stamp, {}, "out"};
  for (const Case& c : e.cases) results.records.push_back({c, e.task->Run(c)});
  results.records[4].result.data =
      R"({"pose": "lies", "log": {"lift": 1, "count": ")" + std::string(5000, 'x') + "\"}}";
  const std::string error = ErrorOf([&] { ReportOf(results); });
  EXPECT_THAT(error, testing::StartsWith("out: the tables cannot be written: case b-1: 'log.count' "
                                         "of its data is \"xxx"));
  EXPECT_THAT(error, testing::EndsWith("xxx...: type must be number, but is string"));
  EXPECT_LT(error.size(), 250u);
}

TEST_F(ExperimentTest, ATableThatFailsNamesTheValueOfTheStamp) {
  const auto e = Open("task: squares\n");
  Results results{e.stamp, {}, "out"};
  results.stamp.data["rows"] = "[1, ";
  EXPECT_THAT(ErrorOf([&] { ReportOf(results); }),
              HasSubstr("out: the tables cannot be written: stamp 'rows' is '[1, ': "));
  results.stamp.identity.erase("task");
  EXPECT_THAT(ErrorOf([&] { ReportOf(results); }),
              testing::StartsWith("out: the results have no stamp 'task'"));
}

TEST_F(ExperimentTest, AComparisonNamesTheFolderWhoseStampIsDamaged) {
  const auto e = Open("task: squares\n");
  const auto write = [&](const std::string& name, const Stamp& stamp) {
    Store store = Store::Create(folder_ / name);
    store.WriteStamp(stamp);
    for (const Case& c : e.cases) store.Write({c, e.task->Run(c)});
  };
  write("good", e.stamp);
  const auto expect = [&](const std::string& part, const std::string& value,
                          const std::string& what) {
    Stamp stamp = e.stamp;
    stamp.data[part] = value;
    write(part, stamp);
    const auto bad = folder_ / part;
    for (const bool first : {true, false}) {
      const std::string error = ErrorOf(
          [&] { CompareRuns(first ? bad : folder_ / "good", first ? folder_ / "good" : bad); });
      EXPECT_THAT(error, testing::StartsWith(bad.string() + ": " + what));
    }
  };
  expect("set", "garbage", "--set 'garbage'");
  expect("experiment_text", "{task: [", "experiment_text:1: not valid YAML");
}

TEST_F(ExperimentTest, TheKeysPageIsMadeFromTheReadingCode) {
  const std::string page = KeysAsMarkdown();
  EXPECT_THAT(page, HasSubstr("| `seed` | seed of all random numbers | `1` |"));
  EXPECT_THAT(page, HasSubstr("## `task: squares`"));
  EXPECT_THAT(page, HasSubstr("| `cases_each` | cases of each word | `3` | 1 to 10 |"));
}

}  // namespace
}  // namespace rangegrasp::experiment
