#include "experiment/merge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "error_of.h"
#include "experiment/sample_record.h"
#include "experiment/store.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::TempFolder;

class MergeTest : public testing::Test {
 protected:
  // Of 40 cases of two groups those whose number leaves a rest, in a folder of that name.
  std::filesystem::path Shard(int rest, int of, const std::string& seed = "1") {
    const auto folder = folder_ / ("shard" + std::to_string(rest));
    Store store = Store::Create(folder);
    store.WriteStamp({{{"experiment", "demo"}, {"seed", seed}, {"cases", "40"}}, {}, {}});
    for (int i = rest; i < 40; i += of) {
      Record record = SampleRecord(i % 3 == 0 ? "mug" : "ball", i);
      record.which.position = i;
      store.Write(record);
    }
    return folder;
  }
  static std::string Error(const std::vector<std::filesystem::path>& shards,
                           const std::filesystem::path& out) {
    return testing_support::MessageOf([&] { Merge(shards, out); });
  }

  TempFolder folder_;
};

TEST_F(MergeTest, TheShardsOfARunAreTheRun) {
  const auto whole = Store::Open(Shard(0, 1)).ReadAll();
  std::filesystem::rename(folder_ / "shard0", folder_ / "whole");
  const auto merged = Merge({Shard(2, 3), Shard(0, 3), Shard(1, 3)}, folder_ / "out");
  EXPECT_EQ(merged.cases, 40u);
  const auto joined = Store::Open(folder_ / "out").ReadAll();
  ASSERT_EQ(joined.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(Row(joined[i]), Row(whole[i]));
    EXPECT_EQ(joined[i].result.seconds, whole[i].result.seconds);
  }
  EXPECT_EQ(Store::Open(folder_ / "out").ReadStamp(), Store::Open(folder_ / "whole").ReadStamp());
}

TEST_F(MergeTest, WhereCasesAreMissingItSaysSoOrWritesNothing) {
  const std::vector<std::filesystem::path> shards = {Shard(0, 3), Shard(1, 3)};
  EXPECT_EQ(Merge(shards, folder_ / "strict", true).cases, 27u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "strict"));
  const auto merged = Merge(shards, folder_ / "some");
  EXPECT_EQ(merged.cases, 27u);
  EXPECT_EQ(merged.expected, 40u);
  // And is completed by the shard that was forgotten.
  EXPECT_EQ(Merge({folder_ / "some", Shard(2, 3)}, folder_ / "all", true).cases, 40u);
  EXPECT_TRUE(Store::Exists(folder_ / "all"));
}

TEST_F(MergeTest, WhatDoesNotBelongTogetherIsRefusedAndNothingIsWritten) {
  const auto out = folder_ / "out";
  const auto first = Shard(0, 3);
  EXPECT_THAT(Error({first, Shard(1, 3, "2")}, out), HasSubstr("another seed"));
  std::filesystem::copy(first, folder_ / "copy");
  EXPECT_THAT(Error({first, folder_ / "copy"}, out), HasSubstr("is in another of the folders too"));
  EXPECT_FALSE(Store::Exists(out));
  EXPECT_THAT(Error({first}, first), HasSubstr("holds results already"));
}

TEST(Cursor, GivesAllRecordsInTheOrderOfTheirIds) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  for (const int i : {5, 3, 9, 0}) store.Write(SampleRecord("mug", i));
  Store::Cursor cursor(store);
  std::vector<Record> seen;
  while (auto record = cursor.Next()) seen.push_back(std::move(*record));
  ASSERT_EQ(seen.size(), 4u);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const Record expected = SampleRecord("mug", (std::array{0, 3, 5, 9})[k]);
    EXPECT_EQ(Row(seen[k]), Row(expected));
    EXPECT_EQ(seen[k].result.seconds, expected.result.seconds);
  }
  EXPECT_EQ(store.Ids(),
            (std::unordered_set<std::string>{"mug-0000", "mug-0003", "mug-0005", "mug-0009"}));
}

}  // namespace
}  // namespace rangegrasp::experiment
