#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "base/image/image.h"
#include "sensing/range_sensor.h"
#include "stereo/calibrate.h"
#include "stereo/calibrate_hand_eye.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp::stereo {

struct CalibrationSetup {
  std::filesystem::path scene;
  sensing::StereoCameraOptions camera;
  sensing::LineScannerOptions scanner = {};  ///< only for the stereo camera's calibration
  int views = 16;                            ///< number of chessboard views
  std::uint64_t seed = 1;
};

/// Simulates a person who calibrates: a chessboard is held in one pose after the other,
/// photographed at both pan angles, and scanned. The laser's points on the board are those that
/// differ from a scan without it. The calibration inherits the error of the scanner's own, which is
/// drawn once for the whole record. If the board is not found in a view, another pose is used; at
/// most setup.views views may be rejected. If the views are too similar, up to twice as many are
/// used. The same setup gives the same bytes.
/// @param look_on  called with each view; may be empty
/// @throws base::InputError like sim::World, FindBoard and CalibrateStereo; base::RunError if no
/// pose is found in which both pictures show the whole board.
CalibrationResult CalibrateSimulated(const CalibrationSetup& setup,
                                     const ChessboardOptions& chessboard,
                                     const std::function<void(const BoardView&)>& look_on = {});

/// CalibrateSimulated in a separate process, so that no thread of the renderer remains in this one,
/// from which trials are forked.
/// @throws base::InputError with the reason why the chessboards do not calibrate.
StereoCalibration CalibrateApart(const CalibrationSetup& setup);

struct HandEyeViews {
  HandEyeRecord record;
  std::vector<image::Image> pictures;   ///< as many as record.X_WH
  std::optional<base::Pose> X_HS = {};  ///< true pose, for the scorer; only in simulation
};

/// Simulates a hand-eye calibration: the chessboard lies in the middle of the table. The arm moves
/// along planned paths, by its servos, to poses in which the camera sees the whole board, stops,
/// and takes a picture. The same setup gives the same bytes.
/// @param is_good  whether a picture is usable; another pose replaces an unusable one (e.g. with
/// the arm's shadow on the board). At most half of all pictures may be unusable.
/// @throws base::InputError if the scene has no site "wrist_scanner" on the arm's last link;
/// base::RunError if the arm reaches fewer places than views, or too few pictures are good.
HandEyeViews SimulateHandEye(const CalibrationSetup& setup,
                             const std::function<bool(const image::Image&)>& is_good);

}  // namespace rangegrasp::stereo
