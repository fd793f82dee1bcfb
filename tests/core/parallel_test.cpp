#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace rangegrasp::core {
namespace {

TEST(ForEach, RunsEveryTaskOnceForAnyNumberOfThreads) {
  for (const int jobs : {1, 2, 7, 100}) {
    std::vector<int> runs(57, 0);
    ForEach(57, jobs, {}, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(runs, std::vector<int>(57, 1)) << jobs;
  }
}

TEST(ForEach, NothingToDoIsDone) {
  ForEach(0, 4, {}, [](int) { FAIL(); });
}

TEST(ForEach, ProgressCountsUpToTheTotal) {
  std::vector<int> counts;
  std::atomic<int> ended{0};
  ForEach(
      20, 3,
      [&](int done, int total) {
        EXPECT_EQ(total, 20);
        counts.push_back(done);
      },
      [&](int i) {
        // The first one ends after others.
        while (i == 0 && ended < 5) std::this_thread::yield();
        ++ended;
      });
  ASSERT_EQ(counts.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(counts[static_cast<std::size_t>(i)], i + 1);
}

TEST(ForEach, ThrowsWhatTheFirstFailingTaskThrew) {
  for (const int jobs : {1, 4}) {
    try {
      ForEach(50, jobs, {}, [](int i) {
        if (i >= 10) throw std::runtime_error(std::to_string(i));
      });
      FAIL();
    } catch (const std::runtime_error& e) {
      EXPECT_EQ(std::string(e.what()), "10");
    }
  }
}

TEST(ForEach, TheFirstFailingTaskCountsThoughALaterOneFailsAfterIt) {
  std::atomic<bool> second_runs{false};
  std::atomic<bool> first_threw{false};
  try {
    ForEach(2, 2, {}, [&](int i) {
      if (i == 0) {
        while (!second_runs) std::this_thread::yield();
        first_threw = true;
        throw std::runtime_error("0");
      }
      second_runs = true;
      while (!first_threw) std::this_thread::yield();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until it has been caught
      throw std::runtime_error("1");
    });
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "0");
  }
}

TEST(ForEach, NothingBeginsAfterAFailure) {
  int begun = 0;
  EXPECT_THROW(ForEach(50, 1, {},
                       [&](int i) {
                         ++begun;
                         if (i == 10) throw std::runtime_error("10");
                       }),
               std::runtime_error);
  EXPECT_EQ(begun, 11);
}

}  // namespace
}  // namespace rangegrasp::core
