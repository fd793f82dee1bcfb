#include "report/film/internal/recorder.h"

#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "base/image/image.h"
#include "experiment/experiment.h"
#include "sim/render.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

constexpr int kWidth_px = 960;
constexpr int kHeight_px = 720;

// True if all corners are in front of the camera and within the picture.
bool IsInPicture(const std::vector<Eigen::Vector3d>& corners_W, const sim::PinholeView& view) {
  for (const Eigen::Vector3d& corner_W : corners_W) {
    const Eigen::Vector2d pixel = PixelOf(view, corner_W);
    if ((view.X_WC.inverse() * corner_W).z() <= 0.0 || pixel.minCoeff() < 0.0 ||
        pixel.x() > kWidth_px - 1 || pixel.y() > kHeight_px - 1) {
      return false;
    }
  }
  return true;
}

struct Shown {
  const char* object;
  std::uint64_t seed;
};
class RecordedTrial : public testing::TestWithParam<Shown> {};
INSTANTIATE_TEST_SUITE_P(ObjectsAndSeeds, RecordedTrial,
                         testing::Values(Shown{"coffee_cup", 11}, Shown{"cleaner", 12},
                                         Shown{"melba_toast", 13}, Shown{"sweets_prism", 14},
                                         Shown{"salt_cylinder", 15}));

TEST_P(RecordedTrial, ObjectAndHandAreWholeInEachPictureAndAllStandOnOneSheet) {
  const auto e =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  const Cell& cell = CellOf(*e.task);
  const testing_support::TempFolder folder;
  experiment::ReplayOptions options;
  options.folder = folder.path();
  options.snapshots = true;
  const TrialSpec spec{GetParam().object, 0, TrialSeed(GetParam().seed, GetParam().object, 0)};
  const auto recorder = report::MakeRecorder(cell, "trial", options);
  std::set<std::string> moments;
  recorder->OnView(
      [&](const std::string& moment, const sim::World& world, const sim::PinholeView& view) {
        std::vector<Eigen::Vector3d> corners_W;
        AddObjectCorners(world, 0, corners_W);
        EXPECT_TRUE(IsInPicture(corners_W, view)) << moment;
        if (moment != "start") AddHandCorners(world, corners_W);
        EXPECT_TRUE(IsInPicture(corners_W, view)) << moment << ": the hand";
        moments.insert(moment);
      });
  RunTrial(cell, spec, &recorder->detector(), recorder->Observer());
  recorder->Finish();
  for (const char* moment : {"start", "closed", "lifted", "end"}) {
    EXPECT_TRUE(moments.contains(moment)) << moment;
  }
  const auto sheet = image::ReadPng<image::Image>(folder / "trial_sheet.png");
  EXPECT_EQ(sheet.width, 3 * 480);
}

TEST(Recorder, AnUnknownCameraIsToldBeforeTheTrial) {
  const auto e =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  experiment::ReplayOptions options;
  options.snapshots = true;
  options.camera = "nowhere";
  EXPECT_THROW(report::MakeRecorder(CellOf(*e.task), "trial", options), base::InputError);
  options.camera = "overview";
  EXPECT_NO_THROW(report::MakeRecorder(CellOf(*e.task), "trial", options));
}

TEST(Recorder, EachPictureOfARepeatedMomentIsKept) {
  const auto e =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  const testing_support::TempFolder folder;
  experiment::ReplayOptions options;
  options.folder = folder.path();
  options.snapshots = true;
  auto arranged = ArrangeTrial(CellOf(*e.task), {"spread", 0, 11});
  const auto recorder = report::MakeRecorder(CellOf(*e.task), "trial", options);
  for (const char* moment : {"pregrasp", "pregrasp", "lifted"}) {
    recorder->Take(moment, arranged->world);
  }
  recorder->Finish();
  for (const char* name : {"pregrasp", "pregrasp_2", "lifted", "sheet"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / fmt::format("trial_{}.png", name))) << name;
  }
}

}  // namespace
}  // namespace rangegrasp::trial
