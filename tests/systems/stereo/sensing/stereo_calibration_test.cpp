#include "stereo/sensing/stereo_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "error_of.h"
#include "sim/world.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp::trial {
namespace {

using ::testing::HasSubstr;
using testing_support::ErrorOf;

const std::string kStereoCalibrationScene = RANGEGRASP_SOURCE_DIR "/scenes/tabletop.xml";

/// A quarter of the default's pixels, the same view; a scanner whose own place is known, so that
/// what is found can be compared with the truth.
CalibrationSetup SmallSetup() {
  CalibrationSetup setup;
  setup.scene = kStereoCalibrationScene;
  setup.camera.width = 800;
  setup.camera.height = 600;
  setup.camera.focal_px = 1000.0;
  setup.camera.shadow_px = 1024;
  setup.scanner.calibration_sigma_m = 0.0;
  setup.scanner.calibration_sigma_rad = 0.0;
  setup.views = 8;
  setup.seed = 11;
  return setup;
}

// Pictures and scans alone lead to the camera and its places, and to the same ones each time.
TEST(CalibrateApart, FindsTheSimulatedCamera) {
  const CalibrationSetup setup = SmallSetup();
  const stereo::StereoCalibration found = CalibrateApart(setup);
  EXPECT_LT(found.reprojection_px, 0.3);
  EXPECT_LT(found.registration_m, 0.0015);
  const stereo::Camera lens = sensing::LensOf(setup.camera);
  EXPECT_NEAR(found.camera.fx, lens.fx, 0.002 * lens.fx);
  EXPECT_NEAR(found.camera.k1, lens.k1, 0.02);
  const base::Pose X_WS = sim::World(kStereoCalibrationScene, {}, {}).SitePose("scanner");
  const base::Pose X_WL = X_WS * sensing::CameraInHead(setup.camera, setup.camera.left_pan_rad);
  // The workspace lies 0.7 m ahead: what matters is where a point there comes to lie.
  const Eigen::Vector3d there(0.0, 0.0, 0.7);
  EXPECT_LT((found.X_WL * there - X_WL * there).norm(), 0.001);
  const stereo::StereoCalibration again = CalibrateApart(setup);
  EXPECT_EQ(again.camera, found.camera);
  EXPECT_EQ(again.X_WR.matrix(), found.X_WR.matrix());
}

TEST(CalibrateApart, HandsOverTheReason) {
  CalibrationSetup setup = SmallSetup();
  setup.views = 2;  // of which it takes twice as many before it gives up
  EXPECT_THAT(ErrorOf([&] { CalibrateApart(setup); }), HasSubstr("4 views of the chessboard"));
}

}  // namespace
}  // namespace rangegrasp::trial
