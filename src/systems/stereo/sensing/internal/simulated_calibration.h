#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "base/image/image.h"
#include "base/rng.h"
#include "base/units.h"
#include "sensing/line_scanner_options.h"
#include "stereo/calibrate.h"
#include "stereo/calibrate_hand_eye.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp::stereo {

/// What a scene's stereo camera is calibrated with.
struct CalibrationSetup {
  std::filesystem::path scene;
  sensing::StereoCameraOptions camera;
  sensing::LineScannerOptions scanner;
  int views = 16;  ///< of the chessboard
  std::uint64_t seed = 1;
};

/// Simulates what a person does who calibrates: a chessboard is held at one place after the other,
/// photographed from both turns, and scanned. What the laser measured of the board is what differs
/// from a scan without it. The scanner's own calibration is off by one draw for the whole record:
/// the calibration that comes of it inherits that. A view in which the board is not found is taken
/// again elsewhere; at most as many as setup.views may be refused. If the views are too much alike,
/// up to twice as many calibrate. The same setup gives the same bytes.
/// @param look_on  is given each view; may be empty.
/// @throws base::InputError as sim::World, FindBoard, if too many views are refused, and
///         CalibrateStereo; base::RunError if no place is found in which both pictures show the
///         board whole.
CalibrationResult CalibrateSimulated(const CalibrationSetup& setup,
                                     const ChessboardOptions& chessboard,
                                     const std::function<void(const BoardView&)>& look_on = {});

/// CalibrateSimulated in a process of its own, so that no thread of the renderer's stays in this
/// one, from which trials are forked.
/// @throws base::InputError with the reason why the chessboards do not calibrate.
StereoCalibration CalibrateApart(const CalibrationSetup& setup);

/// How the camera on the hand is shown a chessboard that lies on the table.
struct HandEyeSetup {
  std::filesystem::path scene;  ///< with a site "wrist_scanner" on the arm's last link
  sensing::StereoCameraOptions camera;
  int views = 25;
  double min_distance_m = 0.42;  ///< of the camera from the board's middle
  double max_distance_m = 0.55;
  double max_lean_rad = base::Deg(40.0);  ///< of the line of sight from straight down
  double max_roll_rad = base::Deg(25.0);  ///< of the pictures about it
  /// Of where the arm says that its hand is: its repeatability, one draw a picture.
  double arm_sigma_m = 0.0001;
  double arm_sigma_rad = base::Deg(0.02);
  std::uint64_t seed = 1;
};

struct HandEyeSimulation {
  HandEyeRecord record;
  std::vector<image::Image> pictures;        ///< as many as record.X_WH
  base::Pose X_HS = base::Pose::Identity();  ///< as it is, for the scorer
};

/// Simulates what a person does who calibrates: the chessboard is laid in the middle of the table,
/// the arm goes from one place to the next from where the camera sees it whole, on planned ways and
/// by its servos, rests, and takes a picture. The same setup gives the same bytes.
/// @param is_good  whether a picture will do; if not (the arm's shadow lies on the board), another
/// one is taken elsewhere. Of all pictures half at most may be such.
/// @throws base::InputError if the scene has no such site; base::RunError if the arm reaches fewer
/// places than views, or too few pictures are good.
HandEyeSimulation SimulateHandEye(const HandEyeSetup& setup,
                                  const std::function<bool(const image::Image&)>& is_good);

}  // namespace rangegrasp::stereo
