#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "base/rng.h"
#include "sensing/line_scanner_options.h"
#include "stereo/calibrate.h"
#include "stereo/sensing/stereo_camera_options.h"

namespace rangegrasp::sensing {

/// How a chessboard is held before camera and scanner.
struct ChessboardRecordOptions {
  int views = 16;
  double min_distance_m = 0.50;  ///< of the board's middle from the camera: as far as the things
  double max_distance_m = 0.85;  ///< that will be seen: the turn found is good no further
  double max_tilt_rad = base::Deg(38.0);  ///< of the board from facing the camera
  double margin_px = 12.0;                ///< that its corners keep from the pictures' edges
  double clearance_m = 0.01;              ///< that it keeps from table and arm
  double min_change_m = 0.015;  ///< by which the scan must differ from that without the board
};

/// Simulates what a person does who calibrates: a chessboard is held at one place after the other,
/// photographed from both turns, and scanned. What the laser measured of the board is what differs
/// from a scan without it. The scanner's own calibration is off by one draw for the whole record:
/// the calibration that comes of it inherits that.
class ChessboardRecorder {
 public:
  /// @param scene       with a site "scanner".
  /// @param chessboard  its MJCF: printed on the face z > 0.
  /// @throws base::InputError as sim::World; std::invalid_argument as both sensors' CheckOptions.
  ChessboardRecorder(const std::filesystem::path& scene, const std::filesystem::path& chessboard,
                     const StereoCameraOptions& camera, const LineScannerOptions& scanner,
                     const ChessboardRecordOptions& options, std::uint64_t seed);
  ~ChessboardRecorder();

  /// The next place of the board; depends on the arguments and the number of calls.
  /// @throws base::RunError if no place is found in which both pictures show the board whole.
  stereo::BoardView Next();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The whole of it: views, what is found of them, the calibration. A view in which the board is not
/// found is taken again elsewhere, as a person would.
/// @param views    that calibrate; if they are too much alike, up to twice as many do. So many at
/// most
///                 may be refused.
/// @param look_on  is given each view; may be empty.
/// @throws base::InputError as stereo::FindBoard, if too many views are refused, and as
/// stereo::CalibrateStereo.
stereo::CalibrationResult CalibrateSimulated(
    ChessboardRecorder& recorder, int views, const StereoCameraOptions& camera,
    const stereo::ChessboardOptions& chessboard,
    const std::function<void(const stereo::BoardView&)>& look_on = {});

}  // namespace rangegrasp::sensing
