#include "base/process/feed.h"

#include <gmock/gmock.h>

#include "base/file.h"
#include "base/stopwatch.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::process {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing_support::ErrorOf;

class FeedShell : public testing::Test {
 protected:
  Program Shell(const std::string& script, double limit_s = 20.0) const {
    Program program;
    program.command = {"/bin/sh", "-c", script};
    program.folder = folder_.path();
    program.limit_s = limit_s;
    return program;
  }
  static void WriteMuch(Feed& feed) {
    const std::vector<std::uint8_t> bytes(1 << 20, 'x');  // more than a pipe holds
    for (int i = 0; i < 4; ++i) feed.Write(bytes);
  }

  testing_support::TempFolder folder_;
};

TEST_F(FeedShell, HandsAllBytesOver) {
  Feed feed(Shell("echo out; cat > all"), "film");
  WriteMuch(feed);
  feed.Finish();
  EXPECT_EQ(base::ReadFile(folder_ / "all").size(), 4u << 20);
}

TEST_F(FeedShell, AProgramThatEndsBeforeItHasAllIsAnErrorWithItsLastWords) {
  Feed feed(Shell("head -c 100 >/dev/null; echo 'No space left on device' >&2; exit 1"), "film");
  EXPECT_THAT(ErrorOf<base::RunError>([&] { WriteMuch(feed); }),
              AllOf(HasSubstr("film: /bin/sh ended with code 1 before it had all"),
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
              HasSubstr("takes nothing more for 0.3 s"));
  Feed endless(Shell("cat >/dev/null; sleep 60", 0.3), "film");
  endless.Write(std::vector<std::uint8_t>{1});
  EXPECT_THAT(ErrorOf<base::RunError>([&] { endless.Finish(); }), HasSubstr("does not end"));
  EXPECT_LT(watch.Seconds(), 20.0);
}

}  // namespace
}  // namespace rangegrasp::process
