#include "stereo/sensing/stereo_sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/quantile.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

// A pair of a salt box that stands alone, by a calibration without error: it takes seconds to make
// one, and is no part of what is asked here.
struct Seen {
  experiment::Experiment experiment = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", experiment::AllKinds(), {});
  const Cell& cell = CellOf(*experiment.task);
  TrialSpec spec{"salt_cuboid", 0, TrialSeed(11, "salt_cuboid", 0)};
  Arrangement arranged = *ArrangeTrial(cell, spec);
  StereoSensor sensor{Setup(), cell.robot.X_WScanner};
  StereoLook look = Look();

  StereoSetup Setup() const {
    StereoSetup setup;
    const sensing::StereoCameraOptions& camera = setup.camera;
    const base::Pose& X_WS = cell.robot.X_WScanner;
    setup.calibration.camera = sensing::LensOf(camera);
    setup.calibration.X_WL = X_WS * sensing::CameraInHead(camera, camera.left_pan_rad);
    setup.calibration.X_WR = X_WS * sensing::CameraInHead(camera, camera.right_pan_rad);
    setup.reconstruct.table_W = cell.TablePlane();
    return setup;
  }
  StereoLook Look() const {
    base::Rng rng = StageStream(spec.seed, "scan");
    return sensor.Look(arranged.world, rng);
  }
};

const Seen& TheLook() {
  static const Seen seen;
  return seen;
}

TEST(StereoSensor, PutsThePrintOfABoxWhereItIs) {
  const auto& look = TheLook().look;
  const auto& view = look.made.view;
  ASSERT_EQ(look.truth.label.size(), view.image.points_C.size());
  std::vector<double> errors_m;
  int seen = 0;
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    if (look.truth.label[i] != 1) continue;
    ++seen;
    if (!(view.noise_m[i] > 0.0F)) continue;
    errors_m.push_back(std::abs((view.image.points_C[i] - view.image.origins_C.front()).norm() -
                                look.truth.true_range_m[i]));
  }
  ASSERT_GT(seen, 500);
  EXPECT_GT(static_cast<double>(errors_m.size()), 0.8 * seen);
  // The pan's own error moves the whole cloud by a millimetre or two (docs/results.md).
  EXPECT_LT(base::MedianOf(errors_m), 0.005);
}

TEST(StereoSensor, TellsTheTableByItsColour) {
  const auto& look = TheLook().look;
  int on_table = 0, right = 0;
  for (std::size_t i = 0; i < look.made.view.noise_m.size(); ++i) {
    if (look.made.view.noise_m[i] != 0.0F) continue;
    ++on_table;
    right += look.truth.label[i] == 0 ? 1 : 0;
  }
  ASSERT_GT(on_table, 5000);
  EXPECT_GT(static_cast<double>(right), 0.98 * on_table);
}

TEST(StereoSensor, SeesTheSameTwice) {
  const StereoLook again = TheLook().Look();
  const StereoLook& before = TheLook().look;
  EXPECT_EQ(again.shot.photos.left.rgb, before.shot.photos.left.rgb);
  EXPECT_EQ(again.shot.photos.right.rgb, before.shot.photos.right.rgb);
  EXPECT_EQ(again.truth.label, before.truth.label);
}

}  // namespace
}  // namespace rangegrasp::trial
