#include "base/process/ask.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "base/file.h"
#include "base/stopwatch.h"
#include "temp_folder.h"

namespace rangegrasp::process {
namespace {

class AskShell : public ::testing::Test {
 protected:
  Program Shell(const std::string& script) const {
    Program program;
    program.command = {"/bin/sh", "-c", script};
    program.folder = folder_.path();
    program.limit_s = 20.0;
    return program;
  }
  Reply AskFor(const std::string& script) const { return Ask(Shell(script), "question"); }

  testing_support::TempFolder folder_;
};

// Whether a process of the number in a file ends soon.
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
    Program program = Shell(script);
    program.limit_s = 0.5;
    const base::Stopwatch watch;
    const Reply reply = Ask(program, "");
    EXPECT_FALSE(reply.line) << script;
    EXPECT_FALSE(reply.failure.empty()) << script;
    EXPECT_LT(watch.Seconds(), 8.0) << script;  // the guard has 5 s, where machines are busy
  }
}

TEST_F(AskShell, RefusesAnEndlessLine) {
  Program program = Shell("yes | tr -d '\\n'");
  program.max_answer_bytes = 1000;
  EXPECT_EQ(Ask(program, "").failure, "an answer of more than 1000 bytes in one line");
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

}  // namespace
}  // namespace rangegrasp::process
