// Films of trials, made by ffmpeg or by a fake ffmpeg.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "base/process/program.h"
#include "cli/command.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

// The output of ffprobe for a film.
nlohmann::json Probed(const std::string& file) {
  setenv("FILM", file.c_str(), 1);  // so that its name needs no quoting
  FILE* pipe = popen("ffprobe -v error -show_streams -show_format -of json \"$FILM\"", "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  EXPECT_EQ(pclose(pipe), 0) << file;
  return nlohmann::json::parse(text);
}

class VideoTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    const Ran ran = RunProgram({"run", RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml",
                                "--objects", "dextrose,salt_cuboid", "--trials", "1", "--seed",
                                "11", "--out", (*shared_ / "run").string()});
    ASSERT_EQ(ran.code, 0) << ran.err;
  }
  static void TearDownTestSuite() { delete shared_; }

  static Ran Film(const std::vector<std::string>& ids, const std::string& file) {
    std::vector<std::string> arguments = {"trial", (*shared_ / "run").string()};
    arguments.insert(arguments.end(), ids.begin(), ids.end());
    arguments.insert(arguments.end(), {"--json", "--video", file});
    testing_support::Command command(arguments);
    const int code = command.Wait(580.0);
    return {code, command.Out(), command.Err()};
  }
  // Runs something with a script as ffmpeg.
  template <typename Call>
  Ran WithFfmpeg(const std::string& script, const Call& call) {
    const auto fake = folder_.Write("bin/ffmpeg", "#!/bin/sh\n" + script);
    std::filesystem::permissions(fake, std::filesystem::perms::owner_all);
    const std::string path = getenv("PATH");
    setenv("PATH", (fake.parent_path().string() + ":" + path).c_str(), 1);
    Ran ran = call();
    setenv("PATH", path.c_str(), 1);
    return ran;
  }
  // A trial in which nothing moves, since its detector fails.
  std::string StillRun() {
    const std::string run = (folder_ / "still").string();
    const Ran ran = RunProgram({"run", RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml",
                                "--objects", "dextrose", "--trials", "1", "--seed", "11", "--set",
                                "detector.command=[/bin/false]", "--out", run});
    EXPECT_EQ(ran.code, 1) << ran.err;
    return run;
  }

  static inline TempFolder* shared_ = nullptr;
  TempFolder folder_;
};
using WholeFilm = VideoTest;

TEST_F(WholeFilm, LastsAsLongAsTheExecution) {
  if (!process::Find("ffprobe")) GTEST_SKIP() << "ffmpeg is not installed";
  const std::string file = (folder_ / "it's a film.mp4").string();
  const Ran ran = Film({"dextrose-0000"}, file);
  ASSERT_EQ(ran.code, 0) << ran.err;
  const double simulated_s = nlohmann::json::parse(ran.out)["data"]["log"]["simulated_s"];
  const auto film = Probed(file);
  EXPECT_EQ(film["streams"][0]["codec_type"], "video");
  EXPECT_EQ(film["streams"][0]["width"], 1280);
  EXPECT_EQ(film["streams"][0]["height"], 720);
  // The length may be off by a frame.
  EXPECT_NEAR(std::stod(film["format"]["duration"].get<std::string>()), simulated_s, 0.1);
}

// A failing detector ends a trial before anything moves. The film shows the trial's start for 2 s.
TEST_F(VideoTest, IsMadeAlsoWhereNothingMoves) {
  if (!process::Find("ffprobe")) GTEST_SKIP() << "ffmpeg is not installed";
  const std::string run = StillRun();
  const std::string file = (folder_ / "still.mp4").string();
  const Ran ran = RunProgram({"trial", run, "dextrose-0000", "--run-detector", "--video", file});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_NEAR(std::stod(Probed(file)["format"]["duration"].get<std::string>()), 2.0, 0.1);
}

TEST_F(VideoTest, AnFfmpegThatDiesIsToldAndLeavesNoFile) {
  const std::string file = (folder_ / "film.mp4").string();
  const Ran full = WithFfmpeg(
      "head -c 1000000 >/dev/null; echo 'film.mp4: No space left on device' >&2; exit 1\n",
      [&] { return Film({"dextrose-0000"}, file); });
  EXPECT_EQ(full.code, 1);
  EXPECT_THAT(full.err, HasSubstr("ended with code 1"));
  EXPECT_THAT(full.err, HasSubstr("No space left on device"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_F(VideoTest, TheWaitIsAnnouncedAndTheFileInItsNewFolderIsNamedAtTheEnd) {
  const std::string run = StillRun();
  const std::string file = (folder_ / "new/film.mp4").string();
  const Ran ran = WithFfmpeg("cat >/dev/null; for last; do :; done; echo film >\"$last\"\n", [&] {
    return RunProgram({"trial", run, "dextrose-0000", "--run-detector", "--video", file});
  });
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, testing::ContainsRegex("drawing the video: two minutes"));
  EXPECT_THAT(ran.err, testing::EndsWith("info: video in " + file + "\n"));
}

TEST_F(VideoTest, WithoutFfmpegThePackageIsNamed) {
  const std::string path = getenv("PATH");
  setenv("PATH", folder_.path().c_str(), 1);
  const Ran ran = Film({"dextrose-0000"}, (folder_ / "film.mp4").string());
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("Debian package ffmpeg"));
}

TEST_F(VideoTest, ShowsOneTrial) {
  testing_support::ExpectRefusal(
      Film({"dextrose-0000", "salt_cuboid-0000"}, (folder_ / "film.mp4").string()), "give one id");
}

TEST_F(VideoTest, AFileOfAnotherEndingIsRefusedBeforeAnythingIsRun) {
  testing_support::ExpectRefusal(Film({"dextrose-0000"}, (folder_ / "film.gif").string()), ".mp4");
}

}  // namespace
}  // namespace rangegrasp
