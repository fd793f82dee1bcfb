#include "core/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "temp_folder.h"

namespace rangegrasp::core {
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
}  // namespace rangegrasp::core
