#include "experiment/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>

#include "base/error.h"
#include "error_of.h"
#include "experiment/child.h"
#include "experiment/sample_record.h"
#include "experiment/statistics.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::InChild;
using testing_support::LimitFileSize;
using testing_support::MessageOf;
using testing_support::TempFolder;

void ExpectSame(const std::vector<Record>& a, const std::vector<Record>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(Row(a[i]), Row(b[i]));
    EXPECT_EQ(a[i].result.seconds, b[i].result.seconds);
  }
}

void RunSql(const std::filesystem::path& folder, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "results.sqlite").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(db);
  sqlite3_close(db);
}

TEST(FolderLock, RefusesASecondWriterWithTheHoldersNameUntilTheFirstEnds) {
  const TempFolder folder;
  const auto second = [&] { return MessageOf([&] { FolderLock lock(folder.path()); }); };
  {
    const FolderLock first(folder.path());
    EXPECT_EQ(InChild([&] {
                const std::string holder = "process " + std::to_string(getppid()) + " on ";
                for (int i = 0; i < 100; ++i) {
                  if (second().find(holder) == std::string::npos) return 1;
                }
                return 0;
              }),
              0);
  }
  EXPECT_EQ(InChild([&] { return second().empty() ? 0 : 1; }), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// A killed run leaves its file, but no lock.
TEST(FolderLock, EndsWithItsProcess) {
  const TempFolder folder;
  EXPECT_EQ(InChild([&] {
              FolderLock lock(folder.path());
              return std::raise(SIGKILL);
            }),
            200 + SIGKILL);
  EXPECT_TRUE(std::filesystem::exists(folder / "run.lock"));
  EXPECT_EQ(MessageOf([&] { FolderLock lock(folder.path()); }), "");
}

TEST(Store, RoundTripsEveryFieldExactly) {
  const TempFolder folder;
  std::vector<Record> written;
  for (int i = 0; i < 30; ++i) written.push_back(SampleRecord("mug", i));
  written[3].which.seed = ~std::uint64_t{0};
  written[4].result.detail = std::string("nul \0, quote ' and \" and \xff", 27);
  written[5].result.seconds.clear();
  written[6].result.data = LargeData(200000);
  {
    Store store = Store::Create(folder / "a/b");
    for (const auto& result : written) store.Write(result);
    ExpectSame(store.ReadAll(), written);
  }
  ExpectSame(Store::Open(folder / "a/b").ReadAll(), written);
}

TEST(Store, AllComeBackInTheOrderOfTheirPositions) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  for (const int i : {2, 0, 1}) store.Write(SampleRecord("mug", i));
  store.Write(SampleRecord("ball", 7));
  std::vector<std::string> ids;
  for (const auto& record : store.ReadAll()) ids.push_back(record.which.id);
  EXPECT_EQ(ids, (std::vector<std::string>{"mug-0000", "mug-0001", "mug-0002", "ball-0007"}));
  EXPECT_EQ(store.Count(), 4);
}

TEST(Store, ACaseOfTheSameIdIsReplacedWhole) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  Record result = SampleRecord("mug", 0);
  store.Write(result);
  result.result.detail = "again";
  result.result.seconds = {{"only", 2.0}};
  store.Write(result);
  ExpectSame(store.ReadAll(), {result});
}

TEST(Store, KeepsItsStamp) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  EXPECT_EQ(store.ReadStamp(), Stamp{});
  store.WriteStamp({{{"seed", "1"}, {"old", "x"}}, {{"version", "1"}}, {}});
  const Stamp stamp{{{"seed", "2"}}, {{"seed", "x"}}, {{"reference", "a,b\n1,2\n"}}};
  store.WriteStamp(stamp);
  EXPECT_EQ(Store::Open(folder.path()).ReadStamp(), stamp);
}

TEST(Store, RemoveTakesTheResultsAndNothingElse) {
  const TempFolder folder;
  { Store::Create(folder.path()).Write(SampleRecord("mug", 0)); }
  folder.Write("notes.txt", "mine");
  folder.Write("results.sqlite-wal", "left by a run that was killed");
  folder.Write("results.sqlite-shm", "");
  Store::Remove(folder.path());
  EXPECT_FALSE(Store::Exists(folder.path()));
  EXPECT_TRUE(std::filesystem::exists(folder / "notes.txt"));
  const auto names = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(names), end(names)), 1);
}

TEST(Store, MayBeReadWhileItIsWritten) {
  const TempFolder folder;
  Store writer = Store::Create(folder.path());
  writer.Write(SampleRecord("mug", 0));
  const Store reader = Store::Open(folder.path());
  EXPECT_EQ(reader.ReadAll().size(), 1u);
  writer.Write(SampleRecord("mug", 1));
  EXPECT_EQ(reader.ReadAll().size(), 2u);
}

// Kills a writer in a child process after about `delay_us`. All rows that it had acknowledged on a
// pipe must be there, and every row must be complete.
void KillWriterAfter(useconds_t delay_us, const std::filesystem::path& folder) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const pid_t pid = fork();
  if (pid == 0) {
    Store store = Store::Create(folder);
    for (int i = 0; i < 9999; ++i) {
      store.Write(SampleRecord("mug", i));
      if (write(ends[1], "x", 1) != 1) _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  std::size_t acknowledged = 0;
  std::array<char, 4096> buffer{};
  ASSERT_EQ(read(ends[0], buffer.data(), 1), 1);
  usleep(delay_us);
  kill(pid, SIGKILL);
  acknowledged = 1;
  for (ssize_t n = 0; (n = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    acknowledged += static_cast<std::size_t>(n);
  }
  close(ends[0]);
  waitpid(pid, nullptr, 0);

  Store store = Store::Create(folder);
  const auto rows = store.ReadAll();
  EXPECT_GE(rows.size(), acknowledged);
  EXPECT_LE(rows.size(), acknowledged + 1);
  std::vector<Record> expected;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    expected.push_back(SampleRecord("mug", static_cast<int>(i)));
  }
  ExpectSame(rows, expected);
  store.Write(SampleRecord("next", 0));
  EXPECT_EQ(store.ReadAll().size(), rows.size() + 1);
}

TEST(Store, AKilledWriterLosesNothingThatItHadFinished) {
  const TempFolder folder;
  for (useconds_t i = 0; i < 20; ++i) {
    KillWriterAfter(i * 1700, folder / std::to_string(i));
  }
}

TEST(Store, AFullDiskIsARunErrorAndKeepsTheRowsBefore) {
  const TempFolder folder;
  const int code = InChild([&] {
    Store store = Store::Create(folder.path());
    store.Write(SampleRecord("mug", 0));
    LimitFileSize(300000);
    for (int i = 1; i < 1000; ++i) {
      Record result = SampleRecord("mug", i);
      result.result.data = LargeData(10000);
      try {
        store.Write(result);
      } catch (const base::RunError& e) {
        const bool named = std::string(e.what()).find("results.sqlite") != std::string::npos;
        return named ? 10 + (static_cast<int>(store.ReadAll().size()) == i ? 0 : 1) : 12;
      }
    }
    return 1;
  });
  EXPECT_EQ(code, 10);
  const auto rows = Store::Open(folder.path()).ReadAll();
  ASSERT_GT(rows.size(), 3u);
  EXPECT_EQ(Row(rows[0]), Row(SampleRecord("mug", 0)));
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_EQ(rows[i].result.data.size(), 10000u);
}

TEST(Store, AFolderThatCannotBeMadeOrWrittenIsAnInputErrorThatNamesIt) {
  const TempFolder folder;
  folder.Write("file", "");
  for (const std::filesystem::path& bad :
       {folder / "file", folder / "file/below", std::filesystem::path("/proc/rangegrasp")}) {
    EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Create(bad); }), HasSubstr(bad.string()));
  }
  // A folder that exists but takes no files from any user.
  EXPECT_THAT(ErrorOf<base::InputError>([] { Store::Create("/proc/self"); }),
              HasSubstr("/proc/self/results.sqlite"));
}

TEST(Store, TooManyOpenFilesAreNamedAndNotTheFolder) {
  const TempFolder folder;
  EXPECT_EQ(InChild([&] {
              const rlimit none_more{STDERR_FILENO + 1, STDERR_FILENO + 1};
              if (setrlimit(RLIMIT_NOFILE, &none_more) != 0) return 2;
              const std::string what = MessageOf([&] { Store::Create(folder.path()); });
              return what.find("Too many open files") == std::string::npos ? 1 : 0;
            }),
            0);
}

TEST(Store, AFileThatIsNoDatabaseIsAnInputError) {
  const TempFolder folder;
  const auto file = folder.Write("results.sqlite", std::string(5000, 'x'));
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder.path()); }),
              HasSubstr(file.string()));
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Create(folder.path()); }),
              HasSubstr(file.string()));
  folder.Write("empty/results.sqlite", "");
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder / "empty"); }),
              HasSubstr("no results"));
}

TEST(Store, ANamedPipeIsNoStore) {
  const TempFolder folder;
  ASSERT_EQ(mkfifo((folder / "results.sqlite").c_str(), 0600), 0);
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder.path()); }),
              HasSubstr("results.sqlite: is a named pipe"));
}

TEST(Store, ADatabaseOfSomethingElseIsAnInputError) {
  const TempFolder folder;
  RunSql(folder.path(), "CREATE TABLE other(x)");
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder.path()); }),
              HasSubstr("no such table"));
}

// The code in the schema of untrusted results is not run.
TEST(Store, ViewsAndTriggersOfADatabaseDoNotRun) {
  const TempFolder folder;
  for (const char* name : {"view", "trigger"}) {
    Store::Create(folder / name).Write(SampleRecord("mug", 0));
  }
  RunSql(folder / "view",
         "DROP TABLE cases; CREATE VIEW cases AS SELECT 'mug-0' AS id, '' AS outcome");
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder / "view").Ids(); }),
              HasSubstr("view \"cases\" prohibited"));
  RunSql(folder / "trigger",
         "CREATE TRIGGER t AFTER INSERT ON cases BEGIN DELETE FROM cases WHERE id = 'mug-0'; END");
  Store store = Store::Create(folder / "trigger");
  store.Write(SampleRecord("mug", 1));
  EXPECT_EQ(store.Count(), 2);
}

TEST(Store, ATruncatedDatabaseIsDamagedAndNoFullDisk) {
  const TempFolder folder;
  {
    Store store = Store::Create(folder.path());
    for (int i = 0; i < 200; ++i) store.Write(SampleRecord("mug", i));
  }
  std::filesystem::resize_file(folder / "results.sqlite", 20000);
  const std::string message = MessageOf([&] { Store::Open(folder.path()).ReadAll(); });
  EXPECT_THAT(message, HasSubstr("results.sqlite"));
  EXPECT_THAT(message, HasSubstr("damaged"));
  EXPECT_THAT(message, testing::Not(HasSubstr("full")));
}

TEST(Store, ADamagedRecordIsNamed) {
  const std::pair<const char*, const char*> changes[] = {
      {"seed = 'x'", "seed 'x'"},
      {"params = '{\"a\": '", "parameters"},
      {"params = '{\"a\": null}'", "'a' is null"},
      {"data = substr(data, 2)", "data are damaged"},
      {"data = '{\"a\": 1e999}'", "data are damaged"},
      {"data = '[1]'", "data are damaged"}};
  for (const auto& [change, what] : changes) {
    const TempFolder folder;
    Store::Create(folder.path()).Write(SampleRecord("mug", 0));
    RunSql(folder.path(), std::string("UPDATE cases SET ") + change);
    EXPECT_THAT(ErrorOf([&] { Store::Open(folder.path()).ReadAll(); }),
                testing::AllOf(HasSubstr("results.sqlite: case mug-0"), HasSubstr(what)));
  }
}

// As on a read-only medium, or in another user's folder.
TEST(Store, IsReadWhereNothingCanBeWritten) {
  const TempFolder folder;
  const auto there = folder / "50%#?";
  Store::Create(there).Write(SampleRecord("mug", 0));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(there), {}), 1);  // one file
  const auto rows_of_another_user = [&] {
    return InChild([&] {
      if (geteuid() == 0 && seteuid(65534) != 0) return -1;
      return Store::Open(there).Count();
    });
  };
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  std::filesystem::permissions(there, std::filesystem::perms(0555));
  EXPECT_EQ(rows_of_another_user(), 1);
  // As left by programs that did not reset the WAL journal mode.
  std::filesystem::permissions(there, std::filesystem::perms(0755));
  RunSql(there, "PRAGMA journal_mode=WAL; UPDATE cases SET outcome = 'x'");
  std::filesystem::permissions(there, std::filesystem::perms(0555));
  EXPECT_EQ(rows_of_another_user(), 1);
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  std::filesystem::permissions(there, std::filesystem::perms(0755));
}

TEST(Store, AFolderWithoutResultsIsAnInputErrorThatSaysWhatToGive) {
  const TempFolder folder;
  EXPECT_FALSE(Store::Exists(folder.path()));
  for (const auto& bad : {folder.path(), folder / "missing"}) {
    EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(bad); }),
                testing::AllOf(HasSubstr(bad.string()), HasSubstr("no results here")));
  }
}

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

TEST(Store, AFolderOfSeveralSeedsIsRefusedWithTheFoldersOfItsSeeds) {
  const TempFolder folder;
  for (const std::uint64_t seed : {10u, 2u}) {
    Fill(SeedFolder(folder.path(), seed), seed, StampOf(std::to_string(seed)));
  }
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder.path()); }),
              HasSubstr("give the folder of one seed: " + (folder / "seed-2").string() + " or " +
                        (folder / "seed-10").string()));
}

TEST(ReadResults, SeedsOfDifferentCommitsNameAllOfThem) {
  TempFolder folder;
  const auto fill = [&](std::uint64_t seed, const std::map<std::string, std::string>& build) {
    Stamp stamp = StampOf(std::to_string(seed));
    stamp.build = build;
    Fill(SeedFolder(folder.path(), seed), seed, stamp);
  };
  fill(1, {{"commit", "aa"}});
  fill(2, {{"commit", "bb"}, {"resumed_with", "aa,cc"}});
  fill(3, {{"commit", "bb"}});
  const auto build = ReadResults(folder.path()).stamp.build;
  EXPECT_EQ(build.at("commit"), "aa");
  EXPECT_EQ(build.at("resumed_with"), "bb,cc");
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
  EXPECT_NE(ErrorOf([&] { ReadResults(folder.path()); }).find("experiment files differ"),
            std::string::npos);
}

// Hazards are drawn: the first one is a mat end with one seed and an obstacle with the next seed.
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

TEST(ReadResults, ASeedsIncompleteStampIsNamedWithItsFolder) {
  for (const std::uint64_t damaged : {1u, 2u}) {
    TempFolder folder;
    for (const std::uint64_t seed : {1u, 2u}) {
      Stamp stamp = StampOf(std::to_string(seed));
      if (seed == damaged) stamp.identity.erase("seed");
      Fill(SeedFolder(folder.path(), seed), seed, stamp);
    }
    EXPECT_THAT(ErrorOf([&] { ReadResults(folder.path()); }),
                testing::StartsWith(SeedFolder(folder.path(), damaged).string() +
                                    ": the results have no stamp 'seed'"));
  }
}

TEST(ReadResults, NoResultsAreAnError) {
  TempFolder folder;
  EXPECT_NE(ErrorOf([&] { ReadResults(folder.path()); }).find(folder.path().string()),
            std::string::npos);
}

class MergeTest : public testing::Test {
 protected:
  // A folder with those of 40 cases of two groups whose number modulo `of` is `rest`.
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
  ExpectSame(Store::Open(folder_ / "out").ReadAll(), whole);
  EXPECT_EQ(Store::Open(folder_ / "out").ReadStamp(), Store::Open(folder_ / "whole").ReadStamp());
}

TEST_F(MergeTest, WhereCasesAreMissingItSaysSoOrWritesNothing) {
  const std::vector<std::filesystem::path> shards = {Shard(0, 3), Shard(1, 3)};
  EXPECT_EQ(Merge(shards, folder_ / "strict", true).cases, 27u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "strict"));
  const auto merged = Merge(shards, folder_ / "some");
  EXPECT_EQ(merged.cases, 27u);
  EXPECT_EQ(merged.expected, 40u);
  // The missing shard completes it.
  EXPECT_EQ(Merge({folder_ / "some", Shard(2, 3)}, folder_ / "all", true).cases, 40u);
  EXPECT_TRUE(Store::Exists(folder_ / "all"));
}

TEST_F(MergeTest, WhatAKilledMergeLeftDoesNotMatter) {
  const std::vector<std::filesystem::path> shards = {Shard(0, 1)};
  Merge(shards, folder_ / "out");
  std::filesystem::rename(folder_ / "out/results.sqlite",
                          folder_ / "out/results.sqlite.unfinished");
  EXPECT_EQ(Merge(shards, folder_ / "out").cases, 40u);
  EXPECT_EQ(Store::Open(folder_ / "out").Count(), 40);
}

TEST_F(MergeTest, WhatDoesNotBelongTogetherIsRefusedAndNothingIsWritten) {
  const auto out = folder_ / "out";
  const auto first = Shard(0, 3);
  EXPECT_THAT(Error({first, Shard(1, 3, "2")}, out),
              HasSubstr("(seed 2 instead of 1); `merge` joins shards"));
  std::filesystem::copy(first, folder_ / "copy");
  EXPECT_THAT(Error({first, folder_ / "copy"}, out),
              HasSubstr("is also in another of the folders"));
  EXPECT_FALSE(Store::Exists(out));
  EXPECT_THAT(Error({first}, first), HasSubstr("already contains results"));
  Store::Create(first).WriteStamp({{{"experiment", "demo"}, {"cases", "many"}}, {}, {}});
  EXPECT_THAT(Error({first}, out), HasSubstr("shard0: the number of cases is 'many'"));
}

TEST(Cursor, GivesAllRecordsInTheOrderOfTheirIds) {
  const TempFolder folder;
  Store store = Store::Create(folder.path());
  for (const int i : {5, 3, 9, 0}) store.Write(SampleRecord("mug", i));
  Store::Cursor cursor(store);
  std::vector<Record> seen, expected;
  while (auto record = cursor.Next()) seen.push_back(std::move(*record));
  for (const int i : {0, 3, 5, 9}) expected.push_back(SampleRecord("mug", i));
  ExpectSame(seen, expected);
  EXPECT_EQ(store.Ids(),
            (std::unordered_set<std::string>{"mug-0000", "mug-0003", "mug-0005", "mug-0009"}));
}

}  // namespace

}  // namespace rangegrasp::experiment
