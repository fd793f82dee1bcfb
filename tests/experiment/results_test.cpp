#include "experiment/results.h"

#include <gtest/gtest.h>

#include "error_of.h"
#include "experiment/compare.h"
#include "experiment/sample_record.h"
#include "experiment/store.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing_support::ErrorOf;
using testing_support::TempFolder;

Stamp StampOf(const std::string& seed, const std::string& hash = "aa") {
  return {
      {{"experiment", "demo"}, {"experiment_hash", hash}, {"seed", seed}, {"cases", "2"}}, {}, {}};
}

void Fill(const std::filesystem::path& folder, std::uint64_t seed, const Stamp& stamp) {
  Store store = Store::Create(folder);
  store.WriteStamp(stamp);
  for (int i = 0; i < 2; ++i) store.Write(SampleRecord("box", i, seed));
}

TEST(ReadResults, PoolsTheSeedsOfAFolderInTheirOrder) {
  TempFolder folder;
  for (const std::uint64_t seed : {10u, 2u}) {
    Fill(SeedFolder(folder.path(), seed), seed, StampOf(std::to_string(seed)));
  }
  const Results results = ReadResults(folder.path());
  EXPECT_EQ(results.stamp.identity.at("seed"), "2,10");
  EXPECT_EQ(results.stamp.identity.at("cases"), "4");
  ASSERT_EQ(results.records.size(), 4u);
  EXPECT_EQ(Row(results.records[1]), Row(SampleRecord("box", 1, 2)));
  EXPECT_EQ(Row(results.records[2]), Row(SampleRecord("box", 0, 10)));
}

TEST(ReadResults, ACaseOfOneSeedIsPairedWithThatOfTheSameSeed) {
  TempFolder folder;
  for (const std::uint64_t seed : {1u, 2u}) {
    Fill(SeedFolder(folder.path(), seed), seed, StampOf(std::to_string(seed)));
  }
  const auto records = ReadResults(folder.path()).records;
  EXPECT_EQ(Compare(records, records, "delivered").pairs, 4);
  EXPECT_EQ(Compare(records, {SampleRecord("box", 0, 3)}, "delivered").pairs, 0);
}

TEST(ReadResults, AFolderWithAStoreIsThatStore) {
  TempFolder folder;
  Fill(folder.path(), 1, StampOf("1"));
  Fill(SeedFolder(folder.path(), 2), 2, StampOf("2"));
  EXPECT_EQ(ReadResults(folder.path()).stamp.identity.at("seed"), "1");
}

TEST(ReadResults, SeedsOfDifferentExperimentsAreNotPooled) {
  TempFolder folder;
  Fill(SeedFolder(folder.path(), 1), 1, StampOf("1"));
  Fill(SeedFolder(folder.path(), 2), 2, StampOf("2", "bb"));
  EXPECT_NE(ErrorOf([&] { ReadResults(folder.path()); }).find("experiment_hash"),
            std::string::npos);
}

// Hazards are drawn: the first of one seed is a mat end, of the next one an obstacle.
TEST(ReadResults, SeedsMayDrawTheirGroupsInAnotherOrderButNoOtherGroups) {
  TempFolder folder;
  const auto fill = [&](std::uint64_t seed, const char* groups) {
    Stamp stamp = StampOf(std::to_string(seed));
    stamp.identity["groups"] = groups;
    Fill(SeedFolder(folder.path(), seed), seed, stamp);
  };
  fill(1, "mat_end,obstacle");
  fill(2, "obstacle,mat_end");
  const Results results = ReadResults(folder.path());
  EXPECT_EQ(results.records.size(), 4u);
  EXPECT_EQ(results.stamp.identity.at("groups"), "mat_end,obstacle");
  fill(3, "obstacle");
  EXPECT_NE(ErrorOf([&] { ReadResults(folder.path()); }).find("groups"), std::string::npos);
}

TEST(ReadResults, NoResultsAreAnError) {
  TempFolder folder;
  EXPECT_NE(ErrorOf([&] { ReadResults(folder.path()); }).find(folder.path().string()),
            std::string::npos);
}

}  // namespace
}  // namespace rangegrasp::experiment
