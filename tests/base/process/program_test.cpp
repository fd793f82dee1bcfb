#include "base/process/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "base/file.h"
#include "base/stopwatch.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::process {
namespace {

class AskShell : public ::testing::Test {
 protected:
  Program Shell(const std::string& script, double limit_s = 20.0) const {
    Program program;
    program.command = {"/bin/sh", "-c", script};
    program.folder = folder_.path();
    program.limit_s = limit_s;
    return program;
  }
  Reply AskFor(const std::string& script) const { return Ask(Shell(script), "question"); }

  testing_support::TempFolder folder_;
};

// True if the process whose id is in the file ends soon.
bool Ends(const std::filesystem::path& file) {
  const base::Stopwatch watch;
  while (watch.Seconds() < 10.0) {
    pid_t pid = 0;
    std::ifstream(file) >> pid;
    if (pid > 0 && kill(pid, 0) != 0) return true;
    usleep(1000);
  }
  return false;
}

TEST_F(AskShell, HandsTheQuestionOverAndTheAnswerBack) {
  const Reply reply = AskFor("read line; pwd; echo \"second line\"; echo $line >&2");
  EXPECT_EQ(reply.line, std::filesystem::canonical(folder_.path()).string());
  EXPECT_EQ(AskFor("cat").line, "question");
  EXPECT_EQ(AskFor("printf 'no end of line'").line, "no end of line");
}

TEST_F(AskShell, SaysHowAProgramFailed) {
  const Reply code = AskFor("echo one >&2; printf 'two\\377' >&2; printf cut; exit 3");
  EXPECT_FALSE(code.line);
  EXPECT_EQ(code.failure, "ended with code 3 without an answer");
  EXPECT_EQ(code.last_words, "one | two?");
  EXPECT_EQ(AskFor("kill -SEGV $$").failure, "killed by Segmentation fault without an answer");
  Program program = Shell("");
  program.command = {"/no/such/program"};
  EXPECT_EQ(Ask(program, "").last_words, "cannot be started: No such file or directory");
}

TEST_F(AskShell, WaitsNoLongerThanItsLimit) {
  for (const char* script : {"sleep 100", "exec >&-; sleep 100", "while :; do echo x >&2; done",
                             "trap '' TERM INT HUP; while :; do sleep 1; done"}) {
    const base::Stopwatch watch;
    const Reply reply = Ask(Shell(script, 0.5), "");
    EXPECT_FALSE(reply.line) << script;
    EXPECT_FALSE(reply.failure.empty()) << script;
    EXPECT_LT(watch.Seconds(), 8.0) << script;  // the guard allows 5 s; machines are busy
  }
}

TEST_F(AskShell, RefusesAnEndlessLine) {
  Program program = Shell("yes | tr -d '\\n'");
  program.max_answer_bytes = 1000;
  EXPECT_EQ(Ask(program, "").failure, "sent an answer line of more than 1000 bytes");
  EXPECT_EQ(AskFor("yes").line, "y") << "endless lines after the answer";
}

TEST_F(AskShell, IsNotHeldUpByAQuestionThatNobodyReads) {
  const std::string large(10'000'000, 'x');
  EXPECT_EQ(Ask(Shell("echo done"), large).line, "done");
  EXPECT_EQ(Ask(Shell("exec <&-; sleep 0.1; echo done"), large).line, "done");
  EXPECT_EQ(Ask(Shell("wc -c"), large).line, "10000001");
}

TEST_F(AskShell, LeavesNoProcessBehindEvenIfItLeftItsGroup) {
  AskFor(
      "setsid sh -c 'echo $$ > a; sleep 1000' & sh -c 'echo $$ > b; sleep 1000' & "
      "while [ ! -s a ] || [ ! -s b ]; do sleep 0.01; done; echo done");
  EXPECT_TRUE(Ends(folder_ / "a"));
  EXPECT_TRUE(Ends(folder_ / "b"));
}

TEST_F(AskShell, DiesWithWhoAsked) {
  const pid_t asker = fork();
  if (asker == 0) {
    AskFor("setsid sh -c 'echo $$ > a; sleep 1000' & echo $$ > b; sleep 1000");
    _exit(0);
  }
  while (!std::filesystem::exists(folder_ / "a") || !std::filesystem::exists(folder_ / "b")) {
    usleep(1000);
  }
  kill(asker, SIGKILL);
  waitpid(asker, nullptr, 0);
  EXPECT_TRUE(Ends(folder_ / "a"));
  EXPECT_TRUE(Ends(folder_ / "b"));
}

TEST_F(AskShell, LimitsMemoryAndFiles) {
  Program program = Shell("head -c 2000000 /dev/zero > big; wc -c < big");
  program.max_file_bytes = 1'000'000;
  EXPECT_EQ(Ask(program, "").line, "1000000");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  program.command.back() = "ulimit -v";
  program.max_memory_bytes = 512UL * 1024 * 1024;
  EXPECT_EQ(Ask(program, "").line, "524288");
#endif
}

TEST_F(AskShell, InheritsNoOpenFile) {
  const auto file = folder_.Write("results", "truth");
  std::ifstream open(file);
  EXPECT_EQ(AskFor("ls /proc/self/fd | sort -n | tail -1").line, "3") << "of ls itself";
}

TEST(LastWords, AreOneLineOfAscii) {
  EXPECT_EQ(LastWords("a\r\nb\n\n\xc3\xa9\x1b[31m\n", 100), "a | b | ???[31m");
  EXPECT_EQ(LastWords("0123456789", 4), "...6789");
  EXPECT_EQ(LastWords("", 4), "");
}

TEST(Find, LooksInThePath) {
  EXPECT_TRUE(Find("sh"));
  EXPECT_FALSE(Find("no-such-program-at-all"));
  EXPECT_FALSE(Find("/etc/passwd")) << "it cannot be executed";
}

using testing::AllOf;
using testing::HasSubstr;
using testing_support::ErrorOf;

class FeedShell : public AskShell {
 protected:
  static void WriteMuch(Feed& feed) {
    const std::vector<std::uint8_t> bytes(1 << 20, 'x');  // more than a pipe holds
    for (int i = 0; i < 4; ++i) feed.Write(bytes);
  }
};

TEST_F(FeedShell, HandsAllBytesOver) {
  Feed feed(Shell("echo out; cat > all"), "film");
  WriteMuch(feed);
  feed.Finish();
  EXPECT_EQ(base::ReadFile(folder_ / "all").size(), 4u << 20);
}

TEST_F(FeedShell, AProgramThatEndsBeforeItHasAllIsAnErrorWithItsLastWords) {
  Feed feed(Shell("head -c 100 >/dev/null; echo 'No space left on device' >&2; exit 1"), "film");
  EXPECT_THAT(
      ErrorOf<base::RunError>([&] { WriteMuch(feed); }),
      AllOf(HasSubstr("film: /bin/sh ended with code 1 before it had read all of its input"),
            HasSubstr("No space left on device")));
}

TEST_F(FeedShell, AProgramThatFailsAtItsEndIsAnError) {
  Feed feed(Shell("cat >/dev/null; echo broken >&2; exit 3"), "film");
  WriteMuch(feed);
  EXPECT_THAT(ErrorOf<base::RunError>([&] { feed.Finish(); }),
              HasSubstr("film: /bin/sh ended with code 3: broken"));
}

TEST_F(FeedShell, AKilledProgramIsAnError) {
  Feed feed(Shell("head -c 100 >/dev/null; kill -KILL $$"), "film");
  EXPECT_THAT(ErrorOf<base::RunError>([&] { WriteMuch(feed); }), HasSubstr("killed by Killed"));
}

TEST_F(FeedShell, NothingHangsWhereAProgramTakesNothingOrDoesNotEnd) {
  const base::Stopwatch watch;
  Feed asleep(Shell("sleep 60", 0.3), "film");
  EXPECT_THAT(ErrorOf<base::RunError>([&] { WriteMuch(asleep); }),
              HasSubstr("accepted no more input within 0.3 s"));
  Feed endless(Shell("cat >/dev/null; sleep 60", 0.3), "film");
  endless.Write(std::vector<std::uint8_t>{1});
  EXPECT_THAT(ErrorOf<base::RunError>([&] { endless.Finish(); }), HasSubstr("did not exit"));
  EXPECT_LT(watch.Seconds(), 20.0);
}

class InTheSandbox : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const auto why = WhyNoSandbox()) GTEST_SKIP() << "no sandbox here: " << *why;
  }
  std::string Try(const std::string& script) {
    Program program;
    program.folder = folder_.path();
    program.command = InSandbox({"/bin/sh", "-c", script}, box_);
    const Reply reply = Ask(program, "");
    return reply.line.value_or("failed: " + reply.failure + ": " + reply.last_words);
  }

  OwnFolder folder_;
  testing_support::TempFolder other_;  // an ordinary temporary folder
  Box box_{folder_.path(), {}, {}};
};

TEST_F(InTheSandbox, AProgramWritesItsOwnFolderOnly) {
  EXPECT_EQ(Try("echo hello > own; cat own"), "hello");
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "own"));
  const auto home = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "written_by_a_detector";
  for (const std::string& place :
       {home.string(), (other_ / "x").string(), std::string("/tmp/x"), std::string("/var/tmp/x"),
        std::string("/usr/x"), (folder_.path() / "../x").string()}) {
    EXPECT_EQ(Try("(echo x > " + place + ") 2>/dev/null && echo written || echo refused"),
              "refused")
        << place;
    EXPECT_FALSE(std::filesystem::exists(place)) << place;
  }
}

TEST_F(InTheSandbox, ResultsAndTemporaryFilesCannotBeRead) {
  const testing_support::TempFolder results;
  const auto truth = results.Write("results.sqlite", "truth");
  const std::string see = "cat " + truth.string() + " 2>/dev/null || echo nothing";
  EXPECT_EQ(Try(see), "nothing");
  box_.shown = {results.path()};
  EXPECT_EQ(Try(see), "truth");
  box_.hidden = {results.path()};
  EXPECT_EQ(Try(see), "nothing") << "hidden wins over shown";
}

TEST_F(InTheSandbox, AFileIsShownWhereItsFolderIsNot) {
  const auto program = other_.Write("program.sh", "echo shown");
  const auto secret = other_.Write("secret", "hidden");
  box_.hidden = {other_.path()};
  box_.shown = {other_.path(), program};
  EXPECT_EQ(Try("sh " + program.string()), "shown");
  EXPECT_EQ(Try("cat " + secret.string() + " 2>/dev/null || echo nothing"), "nothing");
}

TEST_F(InTheSandbox, ThereIsNoNetworkAndNobodyElse) {
  // There is only the loopback device, and it is down.
  EXPECT_EQ(Try("tail -n +3 /proc/net/dev | cut -d: -f1 | tr -d ' '"), "lo");
  EXPECT_EQ(Try("wc -l < /proc/net/route"), "1") << "the heading";
  // The first process there is bwrap; the shell's processes follow.
  EXPECT_EQ(Try("ls -d /proc/[0-9]* | head -1"), "/proc/1");
  EXPECT_EQ(Try("kill -0 " + std::to_string(getpid()) + " 2>/dev/null && echo seen || echo not"),
            "not");
  EXPECT_EQ(Try("grep CapEff /proc/self/status | tr -d '\\t'"), "CapEff:0000000000000000");
}

TEST(OwnFolder, GoesWithItsContents) {
  std::filesystem::path path;
  {
    const OwnFolder folder;
    path = folder.path();
    std::ofstream(path / "file") << "x";
    EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms::owner_all);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(OwnFolder, SaysWhichFolderIsNotThere) {
  const char* before = std::getenv("TMPDIR");
  const std::string folder = before ? before : "";
  setenv("TMPDIR", "/no/such/folder", 1);
  EXPECT_THAT(testing_support::ErrorOf<base::RunError>([] { OwnFolder(); }),
              testing::HasSubstr("TMPDIR is '/no/such/folder'"));
  before ? setenv("TMPDIR", folder.c_str(), 1) : unsetenv("TMPDIR");
}

}  // namespace
}  // namespace rangegrasp::process
