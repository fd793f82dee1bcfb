// Tests progress on a terminal and in a pipe or a file.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/file.h"
#include "base/units.h"
#include "cli/command.h"
#include "cli/output.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::RunProgram;
using testing_support::TempFolder;

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

TEST(StepLine, OfALargeMeshTellsWhatItsPartsAreAt) {
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
  EXPECT_THAT(text, HasSubstr("rod.off: segmenting 60000 triangles"));
  EXPECT_THAT(text, HasSubstr(" \x1b[K\r\x1b[K"));  // the line is removed
}

}  // namespace
}  // namespace rangegrasp
