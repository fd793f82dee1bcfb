// Tests the output on a terminal and the output to a pipe or a file.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>

#include "base/file.h"
#include "base/units.h"
#include "cli/command.h"
#include "cli/output.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::Command;
using testing_support::RunProgram;
using testing_support::TempFolder;

constexpr const char* kBold = "\x1b[1m";
constexpr const char* kRed = "\x1b[31m";

// The program's output if its stdout is a terminal.
std::string OnTerminal(const std::vector<std::string>& arguments) {
  int master = -1;
  int slave = -1;
  char name[256];
  EXPECT_EQ(openpty(&master, &slave, name, nullptr, nullptr), 0);
  Command command(arguments, name);
  std::string text;
  fcntl(master, F_SETFL, O_NONBLOCK);
  for (bool ends = false; !ends;) {
    ends = !command.Runs();  // reads once more after its end
    char part[4096];
    for (ssize_t n = 0; (n = read(master, part, sizeof part)) > 0;) {
      text.append(part, static_cast<std::size_t>(n));
    }
    usleep(1000);
  }
  EXPECT_EQ(command.Wait(), 0) << command.Err();
  close(slave);
  close(master);
  return std::regex_replace(text, std::regex("\r\n"), "\n");
}

std::string WithoutColors(const std::string& text) {
  return std::regex_replace(text, std::regex("\x1b\\[[0-9;]*m"), "");
}

class TerminalTest : public testing::Test {
 protected:
  void SetUp() override {
    setenv("TERM", "xterm", 1);
    unsetenv("NO_COLOR");
  }
};

TEST_F(TerminalTest, ListsAreInColorOnATerminalAndPlainElsewhere) {
  const std::string plain = RunProgram({"list"}).out;
  EXPECT_THAT(plain, testing::Not(HasSubstr("\x1b")));
  const std::string shown = OnTerminal({"list"});
  EXPECT_THAT(shown, HasSubstr(std::string(kBold) + "kinds of experiments:"));
  EXPECT_EQ(WithoutColors(shown), plain);
}

TEST_F(TerminalTest, NobodyIsGivenColorsWhoDoesNotWantThem) {
  setenv("NO_COLOR", "1", 1);
  EXPECT_THAT(OnTerminal({"list"}), testing::Not(HasSubstr("\x1b")));
  unsetenv("NO_COLOR");
  setenv("TERM", "dumb", 1);
  EXPECT_THAT(OnTerminal({"list"}), testing::Not(HasSubstr("\x1b")));
}

TEST_F(TerminalTest, TablesHaveBoldTitlesAndHeadersAndAreTheSameText) {
  const TempFolder folder;
  const std::string file =
      folder
          .Write("t.yaml", "task: seam\nkind: rates\nsensor: " RANGEGRASP_SOURCE_DIR
                           "/models/sensors/stripe_base.yaml\nseams: 2\n"
                           "profiles_per_seam: 40\n")
          .string();
  const std::string out = folder / "r";
  ASSERT_EQ(RunProgram({"run", file, "--out", out}).code, 0);
  const std::string plain = RunProgram({"table", out}).out;
  const std::string shown = OnTerminal({"table", out});
  EXPECT_EQ(WithoutColors(shown), plain);
  EXPECT_THAT(shown, HasSubstr(std::string(kBold) + "method "));
  EXPECT_THAT(shown, HasSubstr(std::string(kBold) + "Detection rate in %"));
  EXPECT_THAT(shown, testing::Not(HasSubstr(kRed)));
  const std::string markdown = OnTerminal({"table", out, "--format", "markdown"});
  EXPECT_THAT(markdown, testing::Not(HasSubstr("\x1b")));
}

TEST(ProgressBar, OutsideATerminalHasALineAtFirstAndOneForEachTenth) {
  const auto shown = [](double quiet_s) {
    testing::internal::CaptureStderr();
    cli::ProgressBar bar(0, 40, "delivered", quiet_s);
    experiment::Record last;
    last.result.outcome = "delivered";
    for (int done = 1; done <= 40; ++done) bar(done, 40, last);
    return testing::internal::GetCapturedStderr();
  };
  const std::string lines = shown(0.0);
  EXPECT_EQ(std::ranges::count(lines, '\n'), 11);
  EXPECT_EQ(std::ranges::count(lines, '\r'), 0);
  EXPECT_THAT(lines, testing::StartsWith("progress: 1/40, 1 delivered (100 %), "));
  EXPECT_THAT(lines, HasSubstr("\nprogress: 4/40, 4 delivered (100 %), "));
  EXPECT_THAT(lines, HasSubstr("\nprogress: 40/40, 40 delivered (100 %), "));
  EXPECT_EQ(shown(3600.0), "");
}

TEST(ProgressBar, OfStepsWithoutOutcomesShowsTheirNumber) {
  testing::internal::CaptureStderr();
  cli::ProgressBar bar(0, 2, "", /*quiet_s=*/0.0);
  bar(1);
  bar(2);
  EXPECT_THAT(
      testing::internal::GetCapturedStderr(),
      testing::MatchesRegex("progress: 1/2, .* per second, .* s left\nprogress: 2/2, .* left\n"));
}

/// A rod of 60,000 triangles. Its diameters take 3 s on a fast core, longer than the delay before
/// the progress line.
std::string Rod() {
  constexpr int kRings = 300, kAround = 100;
  std::string points, faces;
  for (int i = 0; i <= kRings; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const double turn = 2.0 * base::kPi * j / kAround;
      points += fmt::format("{} {} {}\n", 0.05 * i, std::cos(turn), std::sin(turn));
      const int next = (j + 1) % kAround;
      if (i == kRings) continue;
      const int a = i * kAround + j, b = i * kAround + next;
      faces +=
          fmt::format("3 {} {} {}\n3 {} {} {}\n", a, b, b + kAround, a, b + kAround, a + kAround);
    }
  }
  return fmt::format("OFF\n{} {} 0\n", (kRings + 1) * kAround, 2 * kRings * kAround) + points +
         faces;
}

TEST_F(TerminalTest, PartsOfALargeMeshTellWhatTheyAreAt) {
  const TempFolder folder;
  const std::string file = folder.Write("rod.off", Rod());
  const std::vector<std::string> arguments = {"parts", file, "--method",
                                              "sdf",   "-o", folder / "out"};
  EXPECT_THAT(RunProgram(arguments).err, testing::Not(HasSubstr("segmenting")));
  // util-linux's `script` gives it a terminal for stderr, too.
  const std::string seen = folder / "seen";
  std::string command = RANGEGRASP_BINARY;
  for (const std::string& argument : arguments) command += " " + argument;
  ASSERT_EQ(std::system(("script -qec '" + command + "' " + seen + " > /dev/null").c_str()), 0);
  const std::string text = base::ReadFile(seen);
  EXPECT_THAT(text, testing::ContainsRegex("rod.off: segmenting 60000 triangles, [0-9]+ s"));
  EXPECT_THAT(text, HasSubstr(" s \x1b[K\r\x1b[K"));  // the line is removed
}

}  // namespace
}  // namespace rangegrasp
