#include "tasks/grasping/trial.h"

#include <gtest/gtest.h>

#include <set>

namespace rangegrasp::tasks::grasping {
namespace {

TEST(TrialId, IsTheObjectAndFourDigits) {
  EXPECT_EQ(TrialId({"coffee_cup", 3, 0}), "coffee_cup-0003");
  EXPECT_EQ(TrialId({"mug", 99999, 0}), "mug-99999");
}

TEST(TrialSeed, DiffersForEveryExperimentSeedObjectAndIndex) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const char* object : {"a", "b", "ab", "trial", "coffee_cup"}) {
      for (int i = 0; i < 100; ++i) seeds.insert(TrialSeed(seed, object, i));
    }
  }
  EXPECT_EQ(seeds.size(), 20u * 5u * 100u);
}

TEST(TrialSeed, NeverChanges) {
  // Recorded results name these; printed by TrialSeed itself at version 0.1.0.
  EXPECT_EQ(TrialSeed(1, "coffee_cup", 0), 15921461307951582903u);
  EXPECT_EQ(TrialSeed(1, "coffee_cup", 3), 11851043196888414831u);
  EXPECT_EQ(TrialSeed(2, "cleaner", 9), 1637833297759159178u);
}

}  // namespace
}  // namespace rangegrasp::tasks::grasping
