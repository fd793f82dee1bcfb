#include "base/image/offscreen_context.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "base/image/open_gl.h"

constexpr GLenum GL_SCISSOR_TEST = 0x0C11;  // from OpenGL 1.1; used only in these tests

namespace rangegrasp::image {
namespace {

void Clear(float red, float green, float blue, int x, int y, int width, int height) {
  Gl().enable(GL_SCISSOR_TEST);
  Gl().scissor(x, y, width, height);
  Gl().clear_color(red, green, blue, 1.0F);
  Gl().clear(GL_COLOR_BUFFER_BIT);
}

// OpenGL counts rows from the bottom; a picture counts them from the top.
TEST(OffscreenContext, RowsCountFromTheTop) {
  OffscreenContext context(3, 2);
  Clear(0, 0, 1, 0, 0, 3, 2);
  Clear(1, 0, 0, 2, 1, 1, 1);
  const Image picture = context.Picture();
  EXPECT_EQ(picture.width, 3);
  EXPECT_EQ(picture.height, 2);
  ASSERT_EQ(picture.rgb.size(), 18U);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const bool red = x == 2 && y == 0;
      EXPECT_EQ(picture.At(x, y)[0], red ? 255 : 0) << x << " " << y;
      EXPECT_EQ(picture.At(x, y)[2], red ? 0 : 255) << x << " " << y;
    }
  }
}

TEST(OffscreenContext, OversamplingTakesTheMean) {
  OffscreenContext context(4, 4);
  Clear(0, 0, 0, 0, 0, 4, 4);
  Clear(1, 1, 1, 0, 3, 1, 1);  // a quarter of the top left pixel
  const Image picture = context.Picture(2);
  ASSERT_EQ(picture.rgb.size(), 12U);
  EXPECT_EQ(picture.At(0, 0)[0], 255 / 4);
  EXPECT_EQ(picture.At(1, 0)[0], 0);
  EXPECT_EQ(picture.At(0, 1)[0], 0);
}

TEST(OffscreenContext, SeveralAreDrawnInTurn) {
  OffscreenContext first(2, 2);
  OffscreenContext second(2, 2);
  first.MakeCurrent();
  Clear(1, 0, 0, 0, 0, 2, 2);
  second.MakeCurrent();
  Clear(0, 1, 0, 0, 0, 2, 2);
  EXPECT_EQ(second.Picture().rgb[1], 255);
  first.MakeCurrent();
  EXPECT_EQ(first.Picture().rgb[0], 255);
  EXPECT_EQ(first.Picture().rgb[1], 0);
}

TEST(OffscreenContext, NeedsAPositiveSize) {
  EXPECT_THROW(OffscreenContext(0, 2), std::invalid_argument);
  EXPECT_THROW(OffscreenContext(2, -1), std::invalid_argument);
}

int Threads() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

// Processes that are forked after this process has used contexts create contexts, too.
TEST(OffscreenContext, LeavesNoThreadThatDraws) {
  ASSERT_TRUE(DrawBeforeForking());
  const int before = Threads();
  const OffscreenContext context(64, 64);
  Gl().clear(GL_COLOR_BUFFER_BIT);
  const Image picture = context.Picture();
  EXPECT_EQ(Threads(), before);
}

TEST(OffscreenContext, OfTheProcessThatWasForkedDrawsInTheNewOne) {
  ASSERT_TRUE(DrawBeforeForking());
  const OffscreenContext context(2, 2);
  Clear(1, 0, 0, 0, 0, 2, 2);
  const pid_t forked = fork();
  if (forked == 0) {
    alarm(20);  // waiting for a thread of the parent process would never end
    Clear(0, 1, 0, 0, 0, 1, 2);
    const Image picture = context.Picture();
    _exit(picture.At(0, 0)[1] == 255 && picture.At(1, 0)[0] == 255 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(forked, &status, 0), forked);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(DrawBeforeForking, IsRefusedWhereThreadsAreAskedFor) {
  setenv("LP_NUM_THREADS", "2", /*overwrite=*/1);
  EXPECT_FALSE(DrawBeforeForking());
  unsetenv("LP_NUM_THREADS");
}

}  // namespace
}  // namespace rangegrasp::image
