#include "stereo/sensing/laser_and_stereo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "error_of.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "stereo/sensing/stereo_of_cell.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

using ::testing::HasSubstr;

// A cube that stands alone, seen by each sensor and by both, by a calibration without error.
struct Looks {
  explicit Looks(const std::string& object)
      : spec{object, 0, TrialSeed(11, object, 0)}, arranged(*ArrangeTrial(cell, spec)) {}

  std::unique_ptr<Sensor> Laser() const {
    return MakeLineScanner(cell.scanner, cell.robot.X_WScanner);
  }
  std::unique_ptr<Sensor> Stereo() const {
    StereoSetup setup;
    const sensing::StereoCameraOptions& camera = setup.camera;
    const base::Pose& X_WS = cell.robot.X_WScanner;
    setup.calibration.camera = sensing::LensOf(camera);
    setup.calibration.X_WL = X_WS * sensing::CameraInHead(camera, camera.left_pan_rad);
    setup.calibration.X_WR = X_WS * sensing::CameraInHead(camera, camera.right_pan_rad);
    setup.reconstruct.table_W = cell.TablePlane();
    return std::make_unique<StereoSensor>(setup, X_WS);
  }
  Sensed By(const Sensor& sensor) const {
    base::Rng rng = StageStream(spec.seed, "scan");
    return sensor.Sense(arranged.world, rng);
  }
  Sensed ByBoth() const { return By(*MakeLaserAndStereo(Laser(), Stereo())); }

  experiment::Experiment experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_and_stereo_single.yaml",
                                 experiment::AllKinds(), {});
  const Cell& cell = CellOf(*experiment.task);
  TrialSpec spec;
  Arrangement arranged;
};

// Measured samples of the cube that stand clear of the table, of a view.
int OfCube(const Sensed& sensed, std::size_t view) {
  int count = 0;
  const auto& points = sensed.observation.views[view].image.points_C;
  for (std::size_t i = 0; i < points.size(); ++i) {
    count += sensed.truth[view].label[i] == 1 && points[i].z() > 0.01 ? 1 : 0;
  }
  return count;
}

TEST(LaserAndStereo, ABlackCubeIsSeenByStereoAlone) {
  const Looks looks("black_cube");
  EXPECT_EQ(OfCube(looks.By(*looks.Laser()), 0), 0);
  const int stereo = OfCube(looks.By(*looks.Stereo()), 0);
  EXPECT_GT(stereo, 300);  // a face of 60 mm at 2 mm a sample is 900
  const Sensed both = looks.ByBoth();
  ASSERT_EQ(both.observation.views.size(), 2U);
  EXPECT_EQ(OfCube(both, 0), 0);
  EXPECT_GT(OfCube(both, 1), stereo / 2);  // a border of one gap round it is left out
  EXPECT_LE(OfCube(both, 1), stereo);
}

TEST(LaserAndStereo, OfAWhiteCubeTheLasersSamplesOutweigh) {
  const Looks looks("white_cube");
  const int laser = OfCube(looks.By(*looks.Laser()), 0);
  EXPECT_GT(laser, 500);
  const Sensed both = looks.ByBoth();
  EXPECT_EQ(OfCube(both, 0), laser);
  EXPECT_LT(OfCube(both, 1), laser / 2);
}

TEST(LaserAndStereo, EachLooksAsItWouldAlone) {
  const Looks looks("black_cube");
  const Sensed laser = looks.By(*looks.Laser()), stereo = looks.By(*looks.Stereo());
  const Sensed both = looks.ByBoth();
  const auto same = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return a == b || (!a.allFinite() && !b.allFinite());
  };
  const auto& filled = both.observation.views[1].image.points_C;
  const auto& alone = stereo.observation.views[0].image.points_C;
  for (std::size_t i = 0; i < filled.size(); ++i) {
    EXPECT_TRUE(!filled[i].allFinite() || filled[i] == alone[i]) << i;
  }
  EXPECT_TRUE(std::ranges::equal(both.observation.views[0].image.points_C,
                                 laser.observation.views[0].image.points_C, same));
}

TEST(SensorFiles, OfBothAreNamedInItsFile) {
  const std::filesystem::path sensors = RANGEGRASP_SOURCE_DIR "/models/sensors";
  EXPECT_EQ(ReadSensorType(sensors / "laser_and_stereo.yaml"), "laser_and_stereo");
  EXPECT_EQ(ReadSensorType(sensors / "stereo_camera.yaml"), "stereo_camera");
  EXPECT_EQ(ReadSensorType(sensors / "line_scanner.yaml"), kLineScanner);
  const stereo::BothFiles both = stereo::ReadBoth(sensors / "laser_and_stereo.yaml");
  EXPECT_EQ(both.laser, sensors / "line_scanner.yaml");
  EXPECT_EQ(both.stereo, sensors / "stereo_camera.yaml");
  const testing_support::TempFolder folder;
  const auto file = folder.Write("a.yaml", "type: laser_and_stereo\nlaser: b.yaml\n");
  EXPECT_THAT(testing_support::ErrorOf([&] { stereo::ReadBoth(file); }), HasSubstr("stereo"));
}

}  // namespace
}  // namespace rangegrasp::trial
