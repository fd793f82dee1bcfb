#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "base/image/image.h"
#include "sensing/line_scanner_options.h"
#include "stereo/calibrate.h"
#include "stereo/calibrate_hand_eye.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp::stereo {

/// What a scene's camera is calibrated with.
struct CalibrationSetup {
  std::filesystem::path scene;
  sensing::StereoCameraOptions camera;
  sensing::LineScannerOptions scanner = {};  ///< of the stereo camera's calibration alone
  int views = 16;                            ///< of the chessboard
  std::uint64_t seed = 1;
};

/// Simulates what a person does who calibrates: a chessboard is held at one place after the other,
/// photographed from both turns, and scanned. What the laser measured of the board is what differs
/// from a scan without it. The calibration inherits the scanner's own, which is off by one draw for
/// the whole record. A view in which the board is not found is taken again elsewhere; at most as
/// many as setup.views may be refused. If the views are too much alike, up to twice as many
/// calibrate. The same setup gives the same bytes.
/// @param look_on  is given each view; may be empty
/// @throws base::InputError as sim::World, FindBoard and CalibrateStereo; base::RunError if no
/// place is found in which both pictures show the board whole.
CalibrationResult CalibrateSimulated(const CalibrationSetup& setup,
                                     const ChessboardOptions& chessboard,
                                     const std::function<void(const BoardView&)>& look_on = {});

/// CalibrateSimulated in a process of its own: no thread of the renderer's stays in this one, from
/// which trials are forked.
/// @throws base::InputError with the reason why the chessboards do not calibrate.
StereoCalibration CalibrateApart(const CalibrationSetup& setup);

/// All inputs of a calibration.
struct HandEyeViews {
  HandEyeRecord record;
  std::vector<image::Image> pictures;   ///< as many as record.X_WH
  std::optional<base::Pose> X_HS = {};  ///< as it is, for the scorer; of a simulation
};

/// The chessboard is laid in the middle of the table, the arm goes from one place to the next from
/// where the camera sees it whole, on planned ways and by its servos, rests, and takes a picture.
/// The same setup gives the same bytes.
/// @param is_good  of a picture; one that is not (the arm's shadow lies on the board) is taken
/// again elsewhere. Half of all at most may be such.
/// @throws base::InputError if the scene has no site "wrist_scanner" on the arm's last link;
/// base::RunError if the arm reaches fewer places than views, or too few pictures are good.
HandEyeViews SimulateHandEye(const CalibrationSetup& setup,
                             const std::function<bool(const image::Image&)>& is_good);

}  // namespace rangegrasp::stereo
