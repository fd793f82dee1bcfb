#include "base/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "base/error.h"
#include "base/rng.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::base {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;
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
    EXPECT_THAT(ErrorOf([&] { ReadNonEmptyFile(folder / name); }),
                HasSubstr((folder / name).string()));
  }
}

// Opening a named pipe would wait for a writer.
TEST(ReadFile, RefusesANamedPipeButReadsAnOpenOne) {
  const TempFolder folder;
  const auto named = folder / "named.csv";
  ASSERT_EQ(mkfifo(named.c_str(), 0600), 0);
  EXPECT_THAT(ErrorOf([&] { ReadFile(named); }), HasSubstr("named.csv: is a named pipe"));
  EXPECT_THAT(ErrorOf([&] { CheckReadable(named); }), HasSubstr("named.csv: is a named pipe"));
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  ASSERT_EQ(write(ends[1], "abc", 3), 3);
  close(ends[1]);
  EXPECT_EQ(ReadFile("/dev/fd/" + std::to_string(ends[0])), "abc");  // `<(command)` of a shell
  close(ends[0]);
}

TEST(ReadFile, RefusesAFileThatWouldFillTheMemory) {
  const TempFolder folder;
  const auto file = folder.Write("large.ply", "");
  std::filesystem::resize_file(file, (std::uintmax_t{2} << 30U) + 1);  // sparse
  EXPECT_THAT(ErrorOf([&] { ReadFile(file); }),
              HasSubstr("large.ply: has more than 2147483648 bytes"));
}

TEST(ReadFile, NamesALinkToItselfWithTheReason) {
  const TempFolder folder;
  std::filesystem::create_symlink("loop", folder / "loop");
  EXPECT_THAT(ErrorOf([&] { ReadFile(folder / "loop"); }),
              HasSubstr("loop: cannot be opened for reading: Too many levels of symbolic links"));
}

TEST(TextOf, NamesThePathAndTheReason) {
  const auto reason = std::make_error_code(std::errc::permission_denied);
  EXPECT_EQ(TextOf(std::filesystem::filesystem_error("status", "a/b", reason)),
            "a/b: Permission denied");
}

TEST(WriteFile, MakesFoldersAndReplacesTheWholeFile) {
  const TempFolder folder;
  const auto file = folder / "a/b/c";
  WriteFile(file, "long text");
  WriteFile(file, std::string("x\0y", 3));
  EXPECT_EQ(ReadFile(file), std::string("x\0y", 3));
  const auto names = std::filesystem::directory_iterator(file.parent_path());
  EXPECT_EQ(std::distance(begin(names), end(names)), 1);  // no temporary file is left
}

TEST(WriteFile, TellsAFullDiskAndKeepsTheDevice) {
  EXPECT_THROW(WriteFile("/dev/full", std::string(100000, 'x')), RunError);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

// Limits files to 1000 bytes during its lifetime. A process that writes more is killed by SIGXFSZ
// while it writes; if it ignores the signal, the write fails with an error.
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

TEST(CsvTable, ReadsQuotedCellsAndBothLineEnds) {
  const auto table = CsvTable::Parse("a,b\r\n\"x, \"\"y\"\"\",1.5\n\n\"two\nlines\",\n", "t.csv");
  EXPECT_THAT(table.header(), testing::ElementsAre("a", "b"));
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.Cell(0, 0), "x, \"y\"");
  EXPECT_EQ(table.Number(0, table.Column("b")), 1.5);
  EXPECT_EQ(table.Cell(1, 0), "two\nlines");
  EXPECT_EQ(table.OptionalNumber(1, 1), std::nullopt);
}

TEST(CsvTable, NamesTheLineThatIsNotUtf8) {
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("a,b\n1,2\ncaf\xe9,3\n", "t.csv"); }),
              HasSubstr("t.csv:3: is not UTF-8"));
}

TEST(CsvTable, NamesFileLineColumnAndCell) {
  const auto table = CsvTable::Parse("name,n\nx,1\ny,one\n", "t.csv");
  EXPECT_THAT(ErrorOf([&] { table.Number(1, 1); }), HasSubstr("t.csv:3: column 'n': 'one' must"));
  EXPECT_THAT(ErrorOf([&] { table.Column("nam"); }), HasSubstr("nearest: name"));
  // The file has the columns; the program asks for one.
  EXPECT_THAT(ErrorOf([&] { table.Column("nam"); }),
              HasSubstr("t.csv: lacks the column 'nam'; its columns are name, n"));
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("a,b\n1\n", "t.csv"); }), HasSubstr("t.csv:2: has 1"));
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("a\n\"x\n\n", "t.csv"); }),
              HasSubstr("t.csv:2: missing closing quote"));
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("", "t.csv"); }), HasSubstr("t.csv: is empty"));
}

TEST(CsvTable, ANumberIsAWholeCellAndFinite) {
  for (const std::string bad : {"1.5x", "1 ", "1,5", "inf", "-inf", "nan", "1e999", ""}) {
    const auto table = CsvTable::Parse("n,m\n" + CsvLine({bad, "x"}), "t.csv");
    EXPECT_THAT(ErrorOf([&] { table.Number(0, 0); }), HasSubstr("t.csv:2: column 'n'")) << bad;
  }
  const auto table = CsvTable::Parse("n,m\n-1.5e2,0\n", "t.csv");
  EXPECT_EQ(table.Number(0, 0), -150.0);
  EXPECT_EQ(table.Number(0, 1), 0.0);
}

TEST(CsvLine, IsReadBackTheSame) {
  const std::string letters = "ab,\"\n\r ;";
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Rng rng(seed);
    std::vector<std::string> cells(1 + rng.Index(4));
    for (std::string& cell : cells) {
      for (std::size_t n = rng.Index(6); n > 0; --n) cell += letters[rng.Index(letters.size())];
    }
    cells.push_back("end");  // because a line with one empty cell does not count as a row
    const std::vector<std::string> names(cells.size(), "n");
    const auto table = CsvTable::Parse(CsvLine(names) + CsvLine(cells), "t.csv");
    ASSERT_EQ(table.rows(), 1u) << seed;
    for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(table.Cell(0, i), cells[i]) << seed;
  }
}

TEST(Fnv1a, MatchesThePublishedVectors) {
  // From Noll's test suite for 64-bit FNV-1a.
  EXPECT_EQ(Fnv1a(""), 0xcbf29ce484222325u);
  EXPECT_EQ(Fnv1a("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(Fnv1a("b"), 0xaf63df4c8601f1a5u);
  EXPECT_EQ(Fnv1a("fo"), 0x08985907b541d342u);
  EXPECT_EQ(Fnv1a("foobar"), 0x85944171f73967e8u);
}

TEST(Fnv1a, GoesOnFromAState) { EXPECT_EQ(Fnv1a("bar", Fnv1a("foo")), Fnv1a("foobar")); }

TEST(Fnv1a, TakesEveryByteAsUnsigned) {
  // From the definition: (basis xor 0xff) * prime modulo 2^64.
  EXPECT_EQ(Fnv1a("\xff"), (0xcbf29ce484222325u ^ 0xffu) * 0x100000001b3u);
  EXPECT_NE(Fnv1a(std::string_view("\0", 1)), Fnv1a(""));
}

TEST(Hex, WritesSixteenDigits) {
  EXPECT_EQ(Hex(0), "0000000000000000");
  EXPECT_EQ(Hex(0xdeadbeefu), "00000000deadbeef");
  EXPECT_EQ(Hex(~std::uint64_t{0}), "ffffffffffffffff");
}

}  // namespace
}  // namespace rangegrasp::base
