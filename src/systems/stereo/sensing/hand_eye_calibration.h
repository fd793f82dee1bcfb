#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "base/image/image.h"
#include "base/units.h"
#include "stereo/hand_eye.h"
#include "stereo/sensing/stereo_camera_options.h"

namespace rangegrasp::trial {

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
  stereo::HandEyeRecord record;
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

}  // namespace rangegrasp::trial
