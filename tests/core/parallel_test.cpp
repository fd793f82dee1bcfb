#include "core/parallel.h"

#include <gtest/gtest.h>

#include <stdexcept>
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
  ForEach(
      20, 3,
      [&](int done, int total) {
        EXPECT_EQ(total, 20);
        counts.push_back(done);
      },
      [](int) {});
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

}  // namespace
}  // namespace rangegrasp::core
