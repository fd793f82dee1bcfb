// Tests runs that end early and runs with crashing cases.

#include <gmock/gmock.h>

#include "base/error.h"
#include "cli/own_cell.h"
#include "experiment/store.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing_support::OwnCell;
using testing_support::RunProgram;

TEST_F(OwnCell, ARunThatFailsAlwaysInTheSameWayStopsAndSaysWhatIsNotRun) {
  // Every box slips out of a glove without friction (a lying can would rest in the fingers).
  const std::vector<std::string> slippery = {
      "--objects", "salt_cuboid",  "--trials", "6",
      "--set",     "stop_after=4", "--set",    "physics.glove_friction=0.01"};
  const auto ran = Run(slippery);
  EXPECT_EQ(ran.code, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("stopped after 4 of 6 cases, which all ended in not_lifted"));
  EXPECT_THAT(ran.err, HasSubstr("2 cases were not run"));
  EXPECT_THAT(ran.err, HasSubstr(" --set 'physics.glove_friction=0.01'"));
  EXPECT_THAT(ran.out, HasSubstr("2 of 6 cases are missing"));
  auto again = slippery;
  again.push_back("--resume");
  const auto resumed = Succeeded(Run(again));
  EXPECT_THAT(resumed.out, Not(HasSubstr("missing")));
}

TEST_F(OwnCell, ARunThatMayNotStopGoesOn) {
  experiment_ += "stop_after: 4\n";
  const auto ran = Succeeded(Run({"--objects", "salt_cuboid", "--trials", "6", "--set",
                                  "stop_after=0", "--set", "physics.glove_friction=0.01"}));
  EXPECT_THAT(ran.out, Not(HasSubstr("missing")));
  EXPECT_THAT(ran.err, Not(HasSubstr("stopped after")));
}

TEST_F(OwnCell, CtrlCAndSigtermTellHowFarTheRunIsAndEndIt) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string out = folder_ / ("out" + std::to_string(signal));
    testing_support::Command run({"run", Write(), "--jobs", "1", "--out", out, "--trials", "1000"});
    const auto has_a_case = [&] {
      try {
        return experiment::Store::Open(out).Count() > 0;
      } catch (const base::InputError&) {  // not yet created, or without its tables
        return false;
      }
    };
    while (run.Runs() && !has_a_case()) usleep(10'000);
    run.Send(signal);
    EXPECT_EQ(run.Wait(), -signal);
    EXPECT_THAT(run.Err(),
                testing::ContainsRegex("stopped after [0-9]+ of 2000 cases; `--resume` continues"));
  }
}

TEST(Run, CasesThatCrashEndItWithOneAndTheirReasons) {
  testing_support::TempFolder folder;
  // A single draw hardly ever gives a pile of touching objects.
  const auto ran = RunProgram({"run", testing_support::kSource + "/experiments/laser_touching.yaml",
                               "--objects", "salt_cuboid", "--trials", "2", "--set",
                               "clutter.max_draws=1", "--jobs", "1", "--out", folder / "out"});
  EXPECT_EQ(ran.code, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("cases crashed:"));
  EXPECT_THAT(ran.err, HasSubstr("x arrange: no arrangement"));
  EXPECT_THAT(ran.out, HasSubstr("Salt Shaker"));
}

}  // namespace
}  // namespace rangegrasp
