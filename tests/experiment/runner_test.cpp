#include "experiment/runner.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <set>
#include <stdexcept>

#include "core/error.h"
#include "core/stopwatch.h"
#include "experiment/child.h"
#include "experiment/sample_result.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::InChild;
using testing_support::TempFolder;

constexpr std::uint64_t kSeed = 42;

TrialResult Good(const TrialSpec& spec) { return SampleResult(spec, kSeed); }

RunPlan Plan(int trials, std::function<TrialResult(const TrialSpec&)> run = Good) {
  RunPlan plan;
  for (int i = 0; i < trials; ++i) plan.trials.push_back({i % 2 ? "mug" : "box", i});
  plan.seed = kSeed;
  plan.trial_limit_s = 30.0;
  plan.run = std::move(run);
  return plan;
}

std::vector<std::string> Rows(const Store& store) {
  std::vector<std::string> rows;
  for (const auto& result : store.ReadAll()) rows.push_back(Row(result));
  return rows;
}

std::vector<std::string> RowsOfRun(const RunPlan& plan, const RunOptions& options) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  RunTrials(plan, store, options, {});
  return Rows(store);
}

bool NoChildIsLeft() { return waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD; }

// Runs three trials, the second of which is `bad`, two at a time.
TrialResult RunBad(std::function<TrialResult(const TrialSpec&)> bad, double limit_s = 30.0) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  RunPlan plan =
      Plan(3, [&](const TrialSpec& spec) { return spec.index == 1 ? bad(spec) : Good(spec); });
  plan.trial_limit_s = limit_s;
  RunTrials(plan, store, {.jobs = 2}, {});
  EXPECT_TRUE(NoChildIsLeft());
  const auto all = store.ReadAll();
  if (all.size() != 3) {
    ADD_FAILURE() << all.size() << " rows";
    return {};
  }
  // By id: box-0000, box-0002, mug-0001.
  EXPECT_EQ(Row(all[0]), Row(Good({"box", 0})));
  EXPECT_EQ(Row(all[1]), Row(Good({"box", 2})));
  EXPECT_EQ(all[2].id, "mug-0001");
  EXPECT_EQ(all[2].object, "mug");
  EXPECT_EQ(all[2].index, 1);
  EXPECT_EQ(all[2].seed, TrialSeed(kSeed, {"mug", 1}));
  EXPECT_FALSE(all[2].detected);
  return all[2];
}

// Later trials end earlier.
TrialResult Staggered(const TrialSpec& spec) {
  usleep(static_cast<useconds_t>(20000 - 1500 * spec.index));
  return Good(spec);
}

TEST(RunTrials, RowsDoNotDependOnTheNumberOfJobs) {
  const auto one = RowsOfRun(Plan(12, Staggered), {.jobs = 1});
  ASSERT_EQ(one.size(), 12u);
  for (const int jobs : {2, 3, 12, 100}) {
    EXPECT_EQ(RowsOfRun(Plan(12, Staggered), {.jobs = jobs}), one) << jobs;
  }
}

TEST(RunTrials, ShardsHoldEveryTrialOnce) {
  const auto whole = RowsOfRun(Plan(11), {.jobs = 2});
  for (const int shards : {1, 2, 3, 11, 20}) {
    const TempFolder folder;
    std::size_t rows = 0;
    Store joined = Store::Create(folder / "joined");
    for (int shard = 1; shard <= shards; ++shard) {
      Store part = Store::Create(folder / std::to_string(shard));
      RunTrials(Plan(11), part, {.jobs = 2, .shard = shard, .shards = shards}, {});
      for (const auto& result : part.ReadAll()) {
        joined.Write(result);
        ++rows;
      }
    }
    EXPECT_EQ(rows, 11u) << shards;
    EXPECT_EQ(Rows(joined), whole) << shards;
  }
}

TEST(RunTrials, ResumeRunsOnlyWhatIsMissing) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  const RunPlan plan = Plan(8);
  for (const int done : {0, 3, 4}) store.Write(Good(plan.trials[static_cast<std::size_t>(done)]));
  std::set<int> ran;
  RunTrials(plan, store, {.jobs = 2, .resume = true}, [&](int, int total, const TrialResult& last) {
    EXPECT_EQ(total, 5);
    ran.insert(last.index);
  });
  EXPECT_EQ(ran, (std::set<int>{1, 2, 5, 6, 7}));
  EXPECT_EQ(Rows(store), RowsOfRun(plan, {}));
}

TEST(RunTrials, ResumeLeavesAFailedTrialAsItIs) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  const RunPlan plan = Plan(2);
  TrialResult crashed = Good(plan.trials[0]);
  crashed.outcome = Outcome::kCrashed;
  store.Write(crashed);
  RunTrials(plan, store, {.resume = true}, {});
  EXPECT_EQ(store.ReadAll().front().outcome, Outcome::kCrashed);
}

TEST(RunTrials, NothingToDoIsDone) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  RunTrials(Plan(0), store, {}, [](int, int, const TrialResult&) { FAIL(); });
  EXPECT_TRUE(store.ReadAll().empty());
}

TEST(RunTrials, ProgressCountsFromOneToTheTotalAfterTheRowIsWritten) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  int expected = 0;
  RunTrials(Plan(7, Staggered), store, {.jobs = 3},
            [&](int done, int total, const TrialResult& last) {
              EXPECT_EQ(done, ++expected);
              EXPECT_EQ(total, 7);
              const auto rows = Store::Open(folder.path()).ReadAll();
              EXPECT_EQ(rows.size(), static_cast<std::size_t>(done));
              EXPECT_TRUE(std::any_of(rows.begin(), rows.end(),
                                      [&](const auto& row) { return row.id == last.id; }));
            });
  EXPECT_EQ(expected, 7);
}

TEST(RunTrials, JobsRunAtTheSameTime) {
  const core::Stopwatch watch;
  RowsOfRun(Plan(6,
                 [](const TrialSpec& spec) {
                   usleep(200000);
                   return Good(spec);
                 }),
            {.jobs = 6});
  EXPECT_LT(watch.Seconds(), 1.0);  // one after the other: 1.2 s
}

TEST(RunTrials, ASegmentationFaultCostsOneTrial) {
  const auto result = RunBad([](const TrialSpec& spec) {
    std::signal(SIGSEGV, SIG_DFL);  // a sanitizer may have its own handler
    raise(SIGSEGV);
    return Good(spec);
  });
  EXPECT_EQ(result.outcome, Outcome::kCrashed);
  EXPECT_THAT(result.detail, HasSubstr("Segmentation fault"));
}

TEST(RunTrials, AnAbortKeepsTheLastLineOfItsMessage) {
  const auto result = RunBad([](const TrialSpec&) -> TrialResult {
    std::fputs("first line\nassertion failed: x > 0\n", stderr);
    std::abort();
  });
  EXPECT_EQ(result.outcome, Outcome::kCrashed);
  EXPECT_THAT(result.detail, HasSubstr("Aborted"));
  EXPECT_THAT(result.detail, HasSubstr("assertion failed: x > 0"));
}

TEST(RunTrials, AnExceptionCostsOneTrialAndIsNamed) {
  const auto result =
      RunBad([](const TrialSpec&) -> TrialResult { throw std::runtime_error("no such luck"); });
  EXPECT_EQ(result.outcome, Outcome::kCrashed);
  EXPECT_THAT(result.detail, HasSubstr("no such luck"));
  EXPECT_EQ(RunBad([](const TrialSpec&) -> TrialResult { throw 3; }).outcome, Outcome::kCrashed);
}

TEST(RunTrials, AnExitWithoutAResultIsACrash) {
  auto result = RunBad([](const TrialSpec&) -> TrialResult { _exit(0); });
  EXPECT_EQ(result.outcome, Outcome::kCrashed);
  EXPECT_THAT(result.detail, HasSubstr("no result"));
  result = RunBad([](const TrialSpec&) -> TrialResult { _exit(7); });
  EXPECT_EQ(result.outcome, Outcome::kCrashed);
  EXPECT_THAT(result.detail, HasSubstr("code 7"));
}

TEST(RunTrials, AHangIsKilledAtItsLimit) {
  const core::Stopwatch watch;
  const auto result = RunBad(
      [](const TrialSpec& spec) {
        for (;;) pause();
        return Good(spec);
      },
      0.3);
  EXPECT_EQ(result.outcome, Outcome::kTimedOut);
  EXPECT_GE(watch.Seconds(), 0.3);
  EXPECT_LT(watch.Seconds(), 2.0);
}

TEST(RunTrials, ABusyLoopThatIgnoresSignalsIsKilledToo) {
  const auto result = RunBad(
      [](const TrialSpec& spec) {
        std::signal(SIGTERM, SIG_IGN);
        std::signal(SIGINT, SIG_IGN);
        for (std::atomic<int> i = 0; i >= 0;) i = 0;
        return Good(spec);
      },
      0.3);
  EXPECT_EQ(result.outcome, Outcome::kTimedOut);
}

// The writing ends of pipes among this process's files.
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

TEST(RunTrials, GarbageInPlaceOfAResultIsACrash) {
  const auto result = RunBad([](const TrialSpec&) -> TrialResult {
    // The runner may stop reading before all is written.
    std::signal(SIGPIPE, SIG_IGN);
    for (const int fd : PipesForWriting()) {
      for (int i = 0; i < 1000; ++i) {
        if (write(fd, "{\"id\": \xff garbage", 16) < 0) break;
      }
    }
    _exit(0);
  });
  EXPECT_EQ(result.outcome, Outcome::kCrashed);
  EXPECT_THAT(result.detail, HasSubstr("no result"));
}

TEST(RunTrials, AProcessThatClosesItsPipeAndStaysIsKilled) {
  const core::Stopwatch watch;
  const auto result = RunBad([](const TrialSpec& spec) {
    for (const int fd : PipesForWriting()) close(fd);
    for (;;) pause();
    return Good(spec);
  });
  EXPECT_EQ(result.outcome, Outcome::kTimedOut);
  EXPECT_LT(watch.Seconds(), 10.0);
}

TEST(RunTrials, WhatATrialPrintsDoesNotMixWithResults) {
  testing::internal::CaptureStdout();
  const auto result = RunBad([](const TrialSpec& spec) {
    std::cout << "noise" << std::endl;
    std::puts("noise");
    std::fflush(stdout);
    return Good(spec);
  });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(Row(result), Row(Good({"mug", 1})));
}

TEST(RunTrials, AResultLargerThanAPipeComesThrough) {
  const auto result = RunBad([](const TrialSpec& spec) {
    TrialResult large = Good(spec);
    large.log = std::string(3000000, 'x');
    return large;
  });
  EXPECT_EQ(result.log.size(), 3000000u);
}

TEST(RunTrials, AFullDiskEndsTheRunAndLeavesNoProcessBehind) {
  const TempFolder folder;
  const int code = InChild([&] {
    Store store = Store::Create(folder.path());
    testing_support::LimitFileSize(400000);
    try {
      RunTrials(Plan(100,
                     [](const TrialSpec& spec) {
                       TrialResult large = Good(spec);
                       large.log = std::string(50000, 'x');
                       return large;
                     }),
                store, {.jobs = 3}, {});
    } catch (const core::RunError&) {
      return NoChildIsLeft() ? 10 : 11;
    }
    return 1;
  });
  EXPECT_EQ(code, 10);
  EXPECT_GT(Store::Open(folder.path()).ReadAll().size(), 1u);
}

// Running or sleeping; a zombie, which waits for somebody to collect it, is not.
bool Lives(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (!std::getline(in, line)) return false;
  return line.substr(line.rfind(')') + 2, 1) != "Z";
}

TEST(RunTrials, AKilledRunTakesItsTrialsAlong) {
  const TempFolder folder;
  const pid_t run = fork();
  if (run == 0) {
    Store store = Store::Create(folder.path());
    RunTrials(Plan(1,
                   [&](const TrialSpec& spec) {
                     folder.Write("part", std::to_string(getpid()));
                     std::filesystem::rename(folder / "part", folder / "pid");
                     for (;;) pause();
                     return Good(spec);
                   }),
              store, {}, {});
    _exit(0);
  }
  const core::Stopwatch watch;
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

}  // namespace
}  // namespace rangegrasp::experiment
