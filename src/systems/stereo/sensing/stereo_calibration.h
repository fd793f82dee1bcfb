#pragma once

#include <cstdint>
#include <filesystem>

#include "sensing/line_scanner_options.h"
#include "stereo/calibrate.h"
#include "stereo/sensing/stereo_camera_options.h"

namespace rangegrasp::trial {

/// What a scene's stereo camera is calibrated with.
struct CalibrationSetup {
  std::filesystem::path scene;
  sensing::StereoCameraOptions camera;
  sensing::LineScannerOptions scanner;
  int views = 16;  ///< of the chessboard
  std::uint64_t seed = 1;
};

/// The chessboard in models/calibration. @throws base::InputError as base::DataFolder.
std::filesystem::path ChessboardModel();

/// Simulates the calibration (sensing/chessboard_recorder.h) in a process of its own, so that no
/// thread of the renderer's stays in this one, from which trials are forked. The same setup gives
/// the same bytes.
/// @throws base::InputError with the reason why the chessboards do not calibrate.
stereo::StereoCalibration CalibrateApart(const CalibrationSetup& setup);

}  // namespace rangegrasp::trial
