#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cylinders/task/cylinders_task.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {
namespace {

using nlohmann::json;
using testing::HasSubstr;

experiment::Record RecordOf(const std::string& outcome, const json& data) {
  return {{"run", "demo_tube", 1, {}, 0}, {outcome, "score", "", data.dump(), {}}};
}

json Carried(bool felt, bool early) {
  return {{"stands", true},
          {"clearance_m", 0.03},
          {"candidates", 3},
          {"log", {{"held_after_carry", true}, {"hand_over", {{"felt", felt}, {"early", early}}}}}};
}

std::vector<std::string> RowNamed(const experiment::Grid& grid, const std::string& name) {
  for (const auto& row : grid.rows) {
    if (row.front() == name) return row;
  }
  return {};
}

TEST(DemoReport, EveryRunThatDoesNotEndAsItShouldIsAProblemWithInfluence) {
  const std::vector<experiment::Record> records = {
      RecordOf("handed_over", Carried(true, false)),
      RecordOf("no_path", {{"stands", false}}),
      RecordOf("no_grasp", {{"stands", false}}),
      RecordOf("dropped", {{"stands", false}}),
      RecordOf("not_segmented", {{"stands", false}}),
      RecordOf("not_felt", Carried(false, false)),
      RecordOf("felt_early", Carried(true, true)),
      RecordOf("timed_out", json::object()),
      {{"run", "demo_tube", 1, {}, 0}, {"crashed", "", "", "", {}}}};
  const auto report = DemoReport({}, records);
  EXPECT_THAT(report.notes.front(), HasSubstr("with one try 1 of 9 runs were successful"));
  // A pull felt before there was one does not count.
  EXPECT_THAT(report.notes.back(), HasSubstr("detected in 1 of 3 runs that carried the object"));
  // The rows of table 4.1, then others, then their sum.
  const std::vector<std::string> influence = {"2", "1", "1", "2", "2", "8"};
  for (std::size_t i = 0; i < influence.size(); ++i) {
    EXPECT_EQ(report.csv.rows.at(i)[2], influence[i]) << i;  // with one try
    EXPECT_EQ(report.csv.rows.at(i)[6], influence[i]) << i;
  }
}

TEST(DemoReport, FiguresOfTable41AreOfFiftyRunsAndOfTheirCounts) {
  const auto figures = DemoReport({}, {RecordOf("no_path", json::object()),
                                       RecordOf("handed_over", Carried(true, false))})
                           .published;
  ASSERT_EQ(figures.size(), 8u + 7u);  // events and runs of three problems and the sum; table 4.2
  EXPECT_EQ(figures[1].row, "path planning, runs that failed because of it");
  EXPECT_EQ(figures[1].published, 11.0);
  EXPECT_EQ(figures[1].own, 25.0);
  EXPECT_TRUE(figures[1].lower_is_better);
  const auto& counts = std::get<experiment::TrialsEvidence>(figures[1].evidence);
  EXPECT_EQ(counts.own.k, 1);
  EXPECT_EQ(counts.own.n, 2);
  EXPECT_EQ(counts.published.k, 11);
  EXPECT_EQ(counts.published.n, 50);
}

TEST(DemoReport, TimesOfTable42AreMediansOfRunsWithOneTry) {
  auto once = RecordOf("handed_over", Carried(true, false));
  once.result.seconds = {{"cylinders:plane", 0.2}, {"cylinders:filter", 0.3}, {"cylinders", 0.6}};
  json tries = Carried(true, false);
  tries["tries"] = {{{"outcome", "no_path"}}, {{"outcome", "handed_over"}}};
  auto twice = RecordOf("handed_over", tries);
  twice.result.seconds = {{"cylinders:plane", 5.0}};
  const auto figures = DemoReport({}, {once, twice}).published;
  EXPECT_EQ(figures[8].row, "plane fit");
  EXPECT_EQ(figures[8].own, 0.2);
  EXPECT_EQ(figures[8].key, "runtimes");
  EXPECT_FALSE(figures[10].own);
  EXPECT_EQ(figures[14].row, "sum");
  EXPECT_DOUBLE_EQ(figures[14].own.value(), 0.5);
}

TEST(DemoReport, OthersThatArePushedAreAProblemWithoutInfluence) {
  json pushed = Carried(true, false);
  pushed["others_moved"] = 2;
  json lost = pushed;
  const auto report = DemoReport({}, {RecordOf("handed_over", pushed), RecordOf("not_lifted", lost),
                                      RecordOf("handed_over", Carried(true, false))});
  const auto row = RowNamed(report.csv, "hand prosthesis");
  EXPECT_EQ(row[1], "2");  // a run is one event, however many things it pushed
  EXPECT_EQ(row[2], "1");
  EXPECT_EQ(row[9], "4");  // table 4.1
  EXPECT_EQ(row[10], "0");
}

TEST(DemoReport, AProblemThatAnotherTryGotOverHasNoInfluence) {
  json second = Carried(true, false);
  second["tries"] = {{{"outcome", "no_path"}}, {{"outcome", "handed_over"}}};
  const json lost = {{"tries", {{{"outcome", "no_path"}}, {{"outcome", "not_lifted"}}}}};
  const auto report =
      DemoReport({}, {RecordOf("handed_over", second), RecordOf("not_lifted", lost)});
  const auto planning = RowNamed(report.csv, "path planning");
  EXPECT_EQ(planning[1], "2");  // with one try both would have failed
  EXPECT_EQ(planning[2], "2");
  EXPECT_EQ(planning[5], "2");
  EXPECT_EQ(planning[6], "0");
  const auto hand = RowNamed(report.csv, "hand prosthesis");
  EXPECT_EQ(hand[2], "0");
  EXPECT_EQ(hand[5], "1");
  EXPECT_EQ(hand[6], "1");
  EXPECT_THAT(report.notes.front(), HasSubstr("with one try 0 of 2 runs"));
  EXPECT_THAT(report.notes.front(), HasSubstr("with all tries 1 "));
}

TEST(DemoReport, PlacesShareTheRunsBetweenThem) {
  json lying = {{"stands", false}, {"clearance_m", 0.01}, {"touching", 1}};
  const json narrow = {{"stands", true}, {"clearance_m", 0.019}};
  const json lying_alone = {{"stands", false}, {"clearance_m", 0.03}};
  const auto report = DemoReport(
      {}, {RecordOf("handed_over", Carried(true, false)), RecordOf("not_segmented", lying),
           RecordOf("not_segmented", narrow), RecordOf("not_segmented", lying_alone)});
  const auto& grid = report.sections.at(1).grid;
  EXPECT_EQ(RowNamed(grid, "standing")[1], "2");
  EXPECT_EQ(RowNamed(grid, "lying")[1], "2");
  EXPECT_EQ(RowNamed(grid, "nothing within 20 mm")[8], "1");
  EXPECT_EQ(RowNamed(grid, "something within 20 mm")[8], "0");
  // Chapter 4 demands both: a top that the scanner sees, and 20 mm between objects.
  EXPECT_EQ(RowNamed(grid, "standing, nothing within 20 mm")[1], "1");
  EXPECT_EQ(RowNamed(grid, "standing, nothing within 20 mm")[2], "1");
  EXPECT_EQ(RowNamed(grid, "all")[1], "4");
  EXPECT_EQ(RowNamed(grid, "all")[2], "1");  // recognized at the first try
  EXPECT_EQ(RowNamed(grid, "all")[6], "1");
}

TEST(DemoReport, ACylinderWithoutAGraspWasRecognised) {
  json no_grasp = {{"stands", true}, {"candidates", 0}};
  const auto report =
      DemoReport({}, {RecordOf("no_grasp", no_grasp), RecordOf("wrong_target", no_grasp),
                      RecordOf("timed_out", no_grasp)});
  const auto row = RowNamed(report.sections.at(1).grid, "standing");
  EXPECT_EQ(row[2], "1");  // with one try
  EXPECT_EQ(row[6], "1");  // with all tries
}

trial::Attempt AttemptWith(const sim::HandOverLog& hand_over) {
  trial::Attempt attempt;
  attempt.outcome = trial::Outcome::kMisplaced;  // the object is not at the delivery place
  attempt.log.emplace();
  attempt.log->held_after_carry = true;
  attempt.log->hand_over = hand_over;
  return attempt;
}

TEST(DemoOutcome, IsHandedOverOnlyIfThePullWasFeltInTimeAndThePersonHasIt) {
  const auto of = [](bool early, bool felt, bool taken) {
    return trial::HandOverOutcome(AttemptWith({.early = early, .felt = felt, .taken = taken}));
  };
  EXPECT_EQ(of(false, true, true), trial::kHandedOver);
  EXPECT_EQ(of(true, true, true), "felt_early");
  EXPECT_EQ(of(false, false, false), "not_felt");
  EXPECT_EQ(of(false, true, false), "not_taken");
}

TEST(DemoOutcome, AnEmptyHandThatIsHeldOutHandsNothingOver) {
  auto attempt = AttemptWith({.felt = true, .taken = true});
  attempt.log->held_after_carry = false;
  attempt.outcome = trial::Outcome::kDropped;
  EXPECT_EQ(trial::HandOverOutcome(attempt), "dropped");
}

TEST(DemoOutcome, PhysicsThatIsInvalidIsNoSuccess) {
  auto attempt = AttemptWith({.felt = true, .taken = true});
  attempt.outcome = trial::Outcome::kInvalidPhysics;
  EXPECT_EQ(trial::HandOverOutcome(attempt), "invalid_physics");
}

TEST(DemoOutcome, BeforeTheCarryItIsTheAttempts) {
  trial::Attempt attempt;
  attempt.outcome = trial::Outcome::kNoPath;
  EXPECT_EQ(trial::HandOverOutcome(attempt), "no_path");
}

}  // namespace
}  // namespace rangegrasp::cylinders
