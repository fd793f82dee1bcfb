#include "base/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "base/error.h"
#include "temp_folder.h"

namespace rangegrasp::base {
namespace {

using testing_support::TempFolder;

TEST(ReadFile, GivesEveryByte) {
  const TempFolder folder;
  const std::string bytes("a\0\r\n\xff", 5);
  EXPECT_EQ(ReadFile(folder.Write("bytes", bytes)), bytes);
  EXPECT_EQ(ReadFile(folder.Write("empty", "")), "");
}

TEST(ReadFile, NamesTheFileThatItCannotRead) {
  const TempFolder folder;
  folder.Write("empty", "");
  for (const char* name : {"missing", "empty", "."}) {
    try {
      ReadNonEmptyFile(folder / name);
      ADD_FAILURE() << name;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr((folder / name).string()));
    }
  }
}

TEST(WriteFile, MakesFoldersAndReplacesTheWholeFile) {
  const TempFolder folder;
  const auto file = folder / "a/b/c";
  WriteFile(file, "long text");
  WriteFile(file, std::string("x\0y", 3));
  EXPECT_EQ(ReadFile(file), std::string("x\0y", 3));
  const auto names = std::filesystem::directory_iterator(file.parent_path());
  EXPECT_EQ(std::distance(begin(names), end(names)), 1);  // nothing half-written stays
}

TEST(WriteFile, TellsAFullDiskAndKeepsTheDevice) {
  EXPECT_THROW(WriteFile("/dev/full", std::string(100000, 'x')), RunError);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

// Lets files grow to 1000 bytes as long as it lives. Whoever writes more is killed in the middle of
// it, or is told where the signal is ignored.
class ShortFiles {
 public:
  ShortFiles() {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{1000, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~ShortFiles() { setrlimit(RLIMIT_FSIZE, &before_); }
  ShortFiles(const ShortFiles&) = delete;
  ShortFiles& operator=(const ShortFiles&) = delete;

 private:
  rlimit before_{};
};

TEST(WriteFile, AKilledWriterLeavesTheOldFile) {
  const TempFolder folder;
  const auto file = folder.Write("table.csv", "old");
  const pid_t child = fork();
  if (child == 0) {
    const ShortFiles limit;
    std::signal(SIGXFSZ, SIG_DFL);
    WriteFile(file, std::string(100000, 'x'));
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(ReadFile(file), "old");
}

TEST(WriteFile, AFailedWriteLeavesTheOldFileAloneInItsFolder) {
  const TempFolder folder;
  const auto file = folder.Write("table.csv", "old");
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  {
    const ShortFiles limit;
    EXPECT_THROW(WriteFile(file, std::string(100000, 'x')), RunError);
  }
  std::signal(SIGXFSZ, before);
  EXPECT_EQ(ReadFile(file), "old");
  const auto names = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(names), end(names)), 1);
}

TEST(WriteFile, TellsAFolderThatCannotBe) {
  const TempFolder folder;
  folder.Write("file", "x");
  EXPECT_THROW(WriteFile(folder / "file/inner/x", "y"), InputError);
}

TEST(EndingOf, IsInSmallLettersAndOfTheNameAlone) {
  EXPECT_EQ(EndingOf("a.b/Cup.PLY"), ".ply");
  EXPECT_EQ(EndingOf("a.b/cup"), "");
  EXPECT_EQ(EndingOf("cup.tar.gz"), ".gz");
}

}  // namespace
}  // namespace rangegrasp::base
