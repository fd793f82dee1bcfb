#include "experiment/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <set>

#include "base/error.h"
#include "error_of.h"
#include "experiment/child.h"
#include "experiment/sample_record.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::InChild;
using testing_support::LimitFileSize;
using testing_support::TempFolder;

void ExpectSame(const std::vector<Record>& a, const std::vector<Record>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(Row(a[i]), Row(b[i]));
    EXPECT_EQ(a[i].result.seconds, b[i].result.seconds);
  }
}

TEST(Store, RoundTripsEveryFieldExactly) {
  const TempFolder folder;
  std::vector<Record> written;
  for (int i = 0; i < 30; ++i) written.push_back(SampleRecord("mug", i));
  written[3].which.seed = ~std::uint64_t{0};
  written[4].result.detail = std::string("nul \0, quote ' and \" and \xff", 27);
  written[5].result.seconds.clear();
  written[6].result.data = std::string(200000, 'x');
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

// A writer in a process of its own is killed after about `delay_us`: what it had acknowledged on a
// pipe must be there, and every row whole.
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
      result.result.data = std::string(10000, 'x');
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
  // A folder that exists but takes no files, whoever asks.
  EXPECT_THAT(ErrorOf<base::InputError>([] { Store::Create("/proc/self"); }),
              HasSubstr("/proc/self/results.sqlite"));
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

TEST(Store, ADatabaseOfSomethingElseIsAnInputError) {
  const TempFolder folder;
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "results.sqlite").c_str(), &db), SQLITE_OK);
  sqlite3_exec(db, "CREATE TABLE other(x)", nullptr, nullptr, nullptr);
  sqlite3_close(db);
  EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(folder.path()); }),
              HasSubstr("no such table"));
}

TEST(Store, AFolderWithoutResultsIsAnInputErrorThatSaysWhatToGive) {
  const TempFolder folder;
  EXPECT_FALSE(Store::Exists(folder.path()));
  for (const auto& bad : {folder.path(), folder / "missing"}) {
    EXPECT_THAT(ErrorOf<base::InputError>([&] { Store::Open(bad); }),
                testing::AllOf(HasSubstr(bad.string()), HasSubstr("no results here")));
  }
}

}  // namespace
}  // namespace rangegrasp::experiment
