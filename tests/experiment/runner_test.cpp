#include "experiment/runner.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "base/error.h"
#include "base/stopwatch.h"
#include "error_of.h"
#include "experiment/child.h"
#include "experiment/sample_record.h"
#include "temp_folder.h"

namespace {
// Seconds that a process takes to end from now on.
unsigned end_takes_s = 0;
}  // namespace

// Replaces the C library's _exit, so that a case's process can end late, as happens with threads of
// libraries on a busy machine.
extern "C" void _exit(int code) {
  if (end_takes_s > 0) sleep(end_takes_s);
  syscall(SYS_exit_group, code);
  std::abort();
}

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing_support::InChild;
using testing_support::TempFolder;

constexpr std::uint64_t kSeed = 42;

Result Good(const Case& which) { return SampleResult(which); }

std::vector<Case> Cases(int count) {
  std::vector<Case> cases;
  for (int i = 0; i < count; ++i) cases.push_back(SampleCase(i % 2 ? "mug" : "box", i, kSeed));
  return cases;
}

std::vector<std::string> Rows(const Store& store) {
  std::vector<std::string> rows;
  for (const auto& result : store.ReadAll()) rows.push_back(Row(result));
  return rows;
}

std::vector<std::string> RowsOfRun(const std::vector<Case>& cases, const CaseRunner& run,
                                   int jobs) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  RunCases(cases, run, store, {.jobs = jobs}, {});
  return Rows(store);
}

bool NoChildIsLeft() { return waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD; }

// Runs three cases, two at a time; the second one is `bad`.
Record RunBad(const CaseRunner& bad, double limit_s = 30.0) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  const auto run = [&](const Case& which) {
    return which.position == 1 ? bad(which) : Good(which);
  };
  RunCases(Cases(3), run, store, {.jobs = 2, .case_limit_s = limit_s}, {});
  EXPECT_TRUE(NoChildIsLeft());
  const auto all = store.ReadAll();
  if (all.size() != 3) {
    ADD_FAILURE() << all.size() << " rows";
    return {};
  }
  EXPECT_EQ(Row(all[0]), Row(SampleRecord("box", 0, kSeed)));
  EXPECT_EQ(Row(all[2]), Row(SampleRecord("box", 2, kSeed)));
  EXPECT_EQ(all[1].which.id, "mug-0001");
  EXPECT_EQ(all[1].which.params, SampleCase("mug", 1).params);  // its row says what it was
  return all[1];
}

// Later cases end earlier.
Result Staggered(const Case& which) {
  usleep(static_cast<useconds_t>(20000 - 1500 * which.position));
  return Good(which);
}

TEST(RunCases, RowsDoNotDependOnTheNumberOfJobs) {
  const auto one = RowsOfRun(Cases(12), Staggered, 1);
  ASSERT_EQ(one.size(), 12u);
  for (const int jobs : {2, 3, 12, 100})
    EXPECT_EQ(RowsOfRun(Cases(12), Staggered, jobs), one) << jobs;
}

TEST(RunCases, ShardsHoldEveryCaseOnce) {
  const auto whole = RowsOfRun(Cases(11), Good, 2);
  for (const int shards : {1, 2, 3, 11, 20}) {
    const TempFolder folder;
    std::size_t rows = 0;
    Store joined = Store::Create(folder / "joined");
    for (int shard = 1; shard <= shards; ++shard) {
      Store part = Store::Create(folder / std::to_string(shard));
      RunCases(ShardOf(Cases(11), shard, shards), Good, part, {.jobs = 2}, {});
      for (const auto& record : part.ReadAll()) {
        joined.Write(record);
        ++rows;
      }
    }
    EXPECT_EQ(rows, 11u) << shards;
    EXPECT_EQ(Rows(joined), whole) << shards;
  }
}

// The first of three shards has cases 0, 3, 6, ...
TEST(ShardOf, TakesEveryCaseOfItsTurn) {
  const auto cases = Cases(11);
  for (int shard = 1; shard <= 3; ++shard) {
    const auto mine = ShardOf(cases, shard, 3);
    ASSERT_EQ(mine.size(), shard == 3 ? 3u : 4u);
    for (std::size_t i = 0; i < mine.size(); ++i) {
      EXPECT_EQ(mine[i].id, cases[3 * i + static_cast<std::size_t>(shard - 1)].id);
    }
  }
}

std::vector<int> PositionsOf(const std::vector<Case>& cases) {
  std::vector<int> positions;
  for (const Case& c : cases) positions.push_back(c.position);
  return positions;
}

TEST(Missing, IsWhatTheStoreDoesNotHoldFailedOnesIncluded) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  const auto cases = Cases(8);
  for (const std::size_t done : {0u, 3u, 4u})
    store.Write({cases[done], {kCrashed, "case", "", "{}", {}}});
  EXPECT_EQ(PositionsOf(Missing(cases, store)), (std::vector<int>{1, 2, 5, 6, 7}));
  EXPECT_EQ(store.ReadAll().front().result.outcome, kCrashed);
}

TEST(Missing, MayHoldWhatCrashedAgain) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  const auto cases = Cases(4);
  store.Write({cases[1], {kCrashed, "case", "killed by Killed", "{}", {}}});
  store.Write({cases[2], {"delivered", "", "", "{}", {}}});
  EXPECT_EQ(PositionsOf(Missing(cases, store, /*again_crashed=*/true)),
            (std::vector<int>{0, 1, 3}));
}

// Changes that the case makes stay in its own process, and its result comes back.
TEST(RunApart, GivesWhatACaseGaveInAProcessOfItsOwn) {
  const Case which = Cases(1).front();
  int here = 1;
  const Result result = RunApart(which, 60.0, [&here](const Case& given) {
    here = 2;
    return SampleResult(given);
  });
  EXPECT_EQ(here, 1);
  EXPECT_EQ(result.data, SampleResult(which).data);
  EXPECT_EQ(RunApart(which, 60.0, [](const Case&) -> Result { std::abort(); }).outcome, kCrashed);
  const auto hang = [](const Case&) -> Result {
    while (true) pause();
  };
  EXPECT_EQ(RunApart(which, 0.2, hang).outcome, kTimedOut);
}

// The case hands over its result and then hangs. The result counts after one more second, not after
// the case's time limit or the end of the process, and no process is left.
TEST(RunCases, AWholeResultCountsThoughItsProcessEndsLate) {
  const base::Stopwatch watch;
  const auto ends_late = [](const Case& which) {
    end_takes_s = 60;
    return Good(which);
  };
  const Record record = RunBad(ends_late);
  EXPECT_EQ(Row(record), Row({record.which, Good(record.which)}));
  EXPECT_LT(watch.Seconds(), 20.0);
  EXPECT_EQ(end_takes_s, 0u);
}

TEST(RunCases, AProcessThatEndsLateWithoutAResultTimesOut) {
  const Record record = RunBad(
      [](const Case&) -> Result {
        end_takes_s = 60;
        throw std::runtime_error("no result");
      },
      1.0);
  EXPECT_EQ(record.result.outcome, kTimedOut);
}

TEST(RunCases, NothingToDoIsDone) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  RunCases({}, Good, store, {}, [](int, int, const Record&) { FAIL(); });
  EXPECT_TRUE(store.ReadAll().empty());
}

TEST(RunCases, ProgressCountsFromOneToTheTotalAfterTheRowIsWritten) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  int expected = 0;
  RunCases(Cases(7), Staggered, store, {.jobs = 3}, [&](int done, int total, const Record& last) {
    EXPECT_EQ(done, ++expected);
    EXPECT_EQ(total, 7);
    const auto rows = Store::Open(folder.path()).ReadAll();
    EXPECT_EQ(rows.size(), static_cast<std::size_t>(done));
    EXPECT_TRUE(std::any_of(rows.begin(), rows.end(),
                            [&](const auto& row) { return row.which.id == last.which.id; }));
  });
  EXPECT_EQ(expected, 7);
}

TEST(RunCases, JobsRunAtTheSameTime) {
  const base::Stopwatch watch;
  RowsOfRun(
      Cases(6),
      [](const Case& which) {
        usleep(200000);
        return Good(which);
      },
      6);
  EXPECT_LT(watch.Seconds(), 1.0);  // in sequence: 1.2 s
}

TEST(RunCases, ASegmentationFaultCostsOneTrial) {
  const auto result = RunBad([](const Case& which) {
    std::signal(SIGSEGV, SIG_DFL);  // a sanitizer may have its own handler
    raise(SIGSEGV);
    return Good(which);
  });
  EXPECT_EQ(result.result.outcome, kCrashed);
  EXPECT_THAT(result.result.detail, HasSubstr("Segmentation fault"));
}

TEST(RunCases, AnAbortKeepsTheLastLineOfItsMessage) {
  const auto result = RunBad([](const Case&) -> Result {
    std::fputs("first line\nassertion failed: x > 0\n", stderr);
    std::abort();
  });
  EXPECT_EQ(result.result.outcome, kCrashed);
  EXPECT_THAT(result.result.detail, HasSubstr("Aborted"));
  EXPECT_THAT(result.result.detail, HasSubstr("assertion failed: x > 0"));
  EXPECT_THAT(result.result.detail, Not(HasSubstr("first line")));
}

TEST(RunCases, AnExceptionCostsOneTrialAndIsNamed) {
  const auto result =
      RunBad([](const Case&) -> Result { throw std::runtime_error("no such luck"); });
  EXPECT_EQ(result.result.outcome, kCrashed);
  EXPECT_THAT(result.result.detail, HasSubstr("no such luck"));
  EXPECT_EQ(RunBad([](const Case&) -> Result { throw 3; }).result.outcome, kCrashed);
}

TEST(RunCases, AnExitWithoutAResultIsACrash) {
  auto result = RunBad([](const Case&) -> Result { _exit(0); });
  EXPECT_EQ(result.result.outcome, kCrashed);
  EXPECT_THAT(result.result.detail, HasSubstr("no result"));
  result = RunBad([](const Case&) -> Result { _exit(7); });
  EXPECT_EQ(result.result.outcome, kCrashed);
  EXPECT_THAT(result.result.detail, HasSubstr("code 7"));
}

TEST(RunCases, AHangIsKilledAtItsLimit) {
  const base::Stopwatch watch;
  const auto result = RunBad(
      [](const Case& which) {
        for (;;) pause();
        return Good(which);
      },
      0.1);
  EXPECT_EQ(result.result.outcome, kTimedOut);
  EXPECT_GE(watch.Seconds(), 0.5);  // five times the limit, since it waits
  EXPECT_LT(watch.Seconds(), 2.0);
}

// On a busy machine a case takes longer, but its row must be the same.
TEST(RunCases, ACaseThatWaitsLongerThanItsLimitCounts) {
  const auto result = RunBad(
      [](const Case& which) {
        usleep(600000);
        return Good(which);
      },
      0.3);
  EXPECT_EQ(result.result.outcome, Good(result.which).outcome);
}

TEST(RunCases, ABusyLoopThatIgnoresSignalsIsKilledToo) {
  const auto result = RunBad(
      [](const Case& which) {
        std::signal(SIGTERM, SIG_IGN);
        std::signal(SIGINT, SIG_IGN);
        for (std::atomic<int> i = 0; i >= 0;) i = 0;
        return Good(which);
      },
      0.3);
  EXPECT_EQ(result.result.outcome, kTimedOut);
}

// The open write ends of pipes of this process.
std::vector<int> PipesForWriting() {
  std::vector<int> pipes;
  for (int fd = 3; fd < 256; ++fd) {
    struct stat info {};
    if (fstat(fd, &info) == 0 && S_ISFIFO(info.st_mode) &&
        (fcntl(fd, F_GETFL) & O_ACCMODE) == O_WRONLY) {
      pipes.push_back(fd);
    }
  }
  return pipes;
}

TEST(RunCases, GarbageInPlaceOfAResultIsACrash) {
  const auto result = RunBad([](const Case&) -> Result {
    // The runner may stop reading before everything is written.
    std::signal(SIGPIPE, SIG_IGN);
    for (const int fd : PipesForWriting()) {
      for (int i = 0; i < 1000; ++i) {
        if (write(fd, "{\"id\": \xff garbage", 16) < 0) break;
      }
    }
    _exit(0);
  });
  EXPECT_EQ(result.result.outcome, kCrashed);
  EXPECT_THAT(result.result.detail, HasSubstr("no result"));
}

TEST(RunCases, AProcessThatClosesItsPipeAndStaysIsKilled) {
  const base::Stopwatch watch;
  const auto result = RunBad([](const Case& which) {
    for (const int fd : PipesForWriting()) close(fd);
    for (;;) pause();
    return Good(which);
  });
  EXPECT_EQ(result.result.outcome, kTimedOut);
  EXPECT_LT(watch.Seconds(), 10.0);
}

TEST(RunCases, WhatATrialPrintsDoesNotMixWithResults) {
  testing::internal::CaptureStdout();
  const auto result = RunBad([](const Case& which) {
    std::cout << "noise" << std::endl;
    std::puts("noise");
    std::fflush(stdout);
    return Good(which);
  });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(Row(result), Row(SampleRecord("mug", 1, kSeed)));
}

TEST(RunCases, AResultLargerThanAPipeComesThrough) {
  const auto result = RunBad([](const Case& which) {
    Result large = Good(which);
    large.data = LargeData(3000000);
    return large;
  });
  EXPECT_EQ(result.result.data.size(), 3000000u);
}

TEST(RunCases, AFullDiskEndsTheRunAndLeavesNoProcessBehind) {
  const TempFolder folder;
  const int code = InChild([&] {
    Store store = Store::Create(folder.path());
    testing_support::LimitFileSize(400000);
    try {
      RunCases(Cases(100),
               [](const Case& which) {
                 Result large = Good(which);
                 large.data = LargeData(50000);
                 return large;
               },
               store, {.jobs = 3}, {});
    } catch (const base::RunError&) {
      return NoChildIsLeft() ? 10 : 11;
    }
    return 1;
  });
  EXPECT_EQ(code, 10);
  EXPECT_GT(Store::Open(folder.path()).ReadAll().size(), 1u);
}

// True if the process is running or sleeping; false for a zombie that waits to be reaped.
bool Lives(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (!std::getline(in, line)) return false;
  return line.substr(line.rfind(')') + 2, 1) != "Z";
}

TEST(RunCases, AKilledRunTakesItsTrialsAlong) {
  const TempFolder folder;
  const pid_t run = fork();
  if (run == 0) {
    Store store = Store::Create(folder.path());
    RunCases(Cases(1),
             [&](const Case& which) {
               folder.Write("part", std::to_string(getpid()));
               std::filesystem::rename(folder / "part", folder / "pid");
               for (;;) pause();
               return Good(which);
             },
             store, {}, {});
    _exit(0);
  }
  const base::Stopwatch watch;
  while (!std::filesystem::exists(folder / "pid") && watch.Seconds() < 20.0) usleep(1000);
  pid_t trial = 0;
  std::ifstream(folder / "pid") >> trial;
  ASSERT_GT(trial, 1);
  EXPECT_TRUE(Lives(trial));
  kill(run, SIGKILL);
  waitpid(run, nullptr, 0);
  while (Lives(trial) && watch.Seconds() < 20.0) usleep(1000);
  EXPECT_FALSE(Lives(trial));
}

// Two objects with `trials` trials each, numbered as in an experiment.
std::vector<Case> CasesOf(int trials) {
  std::vector<Case> cases;
  for (const char* object : {"mug", "ball"}) {
    for (int i = 0; i < trials; ++i) cases.push_back(SampleCase(object, i));
  }
  for (std::size_t i = 0; i < cases.size(); ++i) cases[i].position = static_cast<int>(i);
  return cases;
}

Stamp ResumeStampOf(std::size_t cases, const std::string& commit = "abc") {
  return {{{"experiment", "demo"}, {"seed", "1"}, {"cases", std::to_string(cases)}},
          {{"version", "0.1"}, {"commit", commit}},
          {{"set", "of " + std::to_string(cases)}}};
}

class ResumeTest : public testing::Test {
 protected:
  ResumeTest() : store_(Store::Create(folder_.path())) {
    store_.WriteStamp(ResumeStampOf(4));
    for (const Case& c : CasesOf(2)) store_.Write({c, SampleResult(c)});
  }

  testing_support::TempFolder folder_;
  Store store_;
};

// The stored rows are where a run with all cases would have put them.
TEST_F(ResumeTest, MoreTrialsFindTheirPlaceAmongThoseThatAreThere) {
  const auto cases = CasesOf(3);
  const auto before = store_.ReadAll();
  const Stamp stamp = Resume(store_, ResumeStampOf(6), cases);
  EXPECT_EQ(stamp, ResumeStampOf(6));
  const auto after = store_.ReadAll();
  ASSERT_EQ(after.size(), 4u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_TRUE(SameButTimes(before[i], after[i]));
    EXPECT_EQ(before[i].result.seconds, after[i].result.seconds);
    EXPECT_EQ(after[i].which.position, (std::array{0, 1, 3, 4})[i]);
  }
}

TEST_F(ResumeTest, FewerTrialsAreRefusedAndNothingIsChanged) {
  const auto before = store_.ReadAll();
  EXPECT_THAT(testing_support::MessageOf([&] { Resume(store_, ResumeStampOf(2), CasesOf(1)); }),
              HasSubstr("contains the case mug-0001"));
  EXPECT_EQ(store_.ReadStamp(), ResumeStampOf(4));
  const auto after = store_.ReadAll();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(Row(before[i]), Row(after[i]));
}

// Shapes that take turns: more trials reach more of them.
TEST_F(ResumeTest, MoreTrialsMayReachMoreGroupsButDropNone) {
  const auto stamp_of = [](std::size_t cases, const std::string& groups) {
    Stamp stamp = ResumeStampOf(cases);
    stamp.identity["groups"] = groups;
    return stamp;
  };
  const auto refusal = [&](const std::string& groups) {
    return testing_support::MessageOf([&] { Resume(store_, stamp_of(6, groups), CasesOf(3)); });
  };
  store_.WriteStamp(stamp_of(4, "mug,ball"));
  EXPECT_EQ(refusal("mug,box,ball,can"), "");
  EXPECT_THAT(refusal("mug,box"), testing::AllOf(HasSubstr("(groups mug,ball instead of mug,box)"),
                                                 HasSubstr("--resume can only add trials")));
  EXPECT_THAT(refusal("ball,mug"), HasSubstr("groups mug,ball instead of ball,mug"));
}

TEST_F(ResumeTest, AnotherSeedIsRefused) {
  Stamp other = ResumeStampOf(4);
  other.identity["seed"] = "2";
  EXPECT_THAT(testing_support::MessageOf([&] { Resume(store_, other, CasesOf(2)); }),
              HasSubstr("(seed 1 instead of 2); choose another folder"));
}

TEST_F(ResumeTest, TheCommitThatBeganTheRunStays) {
  Stamp stamp = Resume(store_, ResumeStampOf(4, "def"), CasesOf(2));
  EXPECT_EQ(stamp.build.at("commit"), "abc");
  EXPECT_EQ(stamp.build.at("resumed_with"), "def");
  store_.WriteStamp(stamp);
  stamp = Resume(store_, ResumeStampOf(4, "def"), CasesOf(2));
  EXPECT_EQ(stamp.build.at("resumed_with"), "def");
  store_.WriteStamp(stamp);
  EXPECT_EQ(Resume(store_, ResumeStampOf(4), CasesOf(2)).build.at("commit"), "abc");
}

using testing::ElementsAre;

Record Ended(int i, const std::string& outcome, const std::string& stage,
             const std::string& detail) {
  Record record = SampleRecord("cup", i);
  record.result.outcome = outcome;
  record.result.stage = stage;
  record.result.detail = detail;
  return record;
}

TEST(InTurn, TakesOneOfEachGroupAfterTheOther) {
  std::vector<Case> cases;
  for (const char* group : {"a", "b", "c"}) {
    for (int i = 0; i < (group[0] == 'b' ? 1 : 3); ++i) cases.push_back(SampleCase(group, i));
  }
  std::vector<std::string> ids;
  for (const Case& c : InTurn(cases)) ids.push_back(c.id);
  EXPECT_THAT(ids,
              ElementsAre("a-0000", "b-0000", "c-0000", "a-0001", "c-0001", "a-0002", "c-0002"));
}

TEST(SameFailure, SaysWhatAllHaveInCommonWithTheirMostFrequentDetail) {
  const std::vector<Record> records = {Ended(0, "no_path", "plan", "no_ik x3"),
                                       Ended(1, "no_path", "plan", "no_ik x24"),
                                       Ended(2, "no_path", "plan", "no_ik x24")};
  EXPECT_EQ(SameFailure(records, "delivered"), "no_path in plan: no_ik x24");
}

TEST(SameFailure, IsNoneWhereOneSucceedsOrFailsOtherwise) {
  const Record failed = Ended(0, "no_path", "plan", "");
  EXPECT_TRUE(SameFailure({failed, failed}, "delivered"));
  EXPECT_FALSE(SameFailure({failed, Ended(1, "delivered", "score", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({failed, Ended(1, "dropped", "plan", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({failed, Ended(1, "no_path", "score", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({Ended(0, "delivered", "score", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({}, "delivered"));
}

TEST(CrashReasons, AreDistinctAndMostFrequentFirst) {
  EXPECT_THAT(CrashReasons({Ended(0, kCrashed, "scan", "b"), Ended(1, kCrashed, "plan", "a"),
                            Ended(2, "dropped", "score", "c"), Ended(3, kCrashed, "plan", "a"),
                            Ended(4, kCrashed, "", "")}),
              ElementsAre("2 x plan: a", "1 x no reason given", "1 x scan: b"));
}

}  // namespace

}  // namespace rangegrasp::experiment
