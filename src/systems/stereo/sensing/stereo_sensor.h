#pragma once

#include <functional>
#include <optional>

#include "stereo/camera.h"
#include "stereo/reconstruct.h"
#include "stereo/sensing/stereo_camera.h"
#include "trial/sensor.h"

namespace rangegrasp::trial {

/// What a stereo camera makes its observations with, and from.
struct StereoSetup {
  sensing::StereoCameraOptions camera;    ///< as it is; for the pictures alone
  stereo::StereoCalibration calibration;  ///< as the robot knows it
  /// Where there is one, it gives the calibration, when that is needed first.
  std::function<stereo::StereoCalibration()> calibrate;
  stereo::ReconstructOptions reconstruct;
  bool color = false;  ///< samples have the left picture's colors
};

/// A pair of pictures and what became of it.
struct StereoLook {
  sensing::StereoShot shot;
  stereo::Reconstruction made;
  sensing::ScanTruth truth;  ///< in the layout of made.view's image
};

/// The stereo camera on the head of the scanner (section 5.3): two pictures, and their
/// reconstruction by its calibration.
class StereoSensor : public Sensor {
 public:
  /// @throws base::InputError for a calibration that does not fit; std::invalid_argument for
  /// options that are out of range.
  StereoSensor(StereoSetup setup, const base::Pose& X_WScanner);
  ~StereoSensor() override;

  void Prepare() const override;
  void Rehearse(const sim::World& world) const override;
  bool Rehearses() const override { return true; }
  /// A folder beside the cloud holds the pictures, the disparities and the calibration.
  std::string WriteLook(const sim::World& world, base::Rng& rng,
                        const std::filesystem::path& cloud) const override;

  Sensed Sense(const sim::World& world, base::Rng& rng) const override;
  /// The same with all that lies between.
  StereoLook Look(const sim::World& world, base::Rng& rng) const;

  const stereo::Rectifier& rectifier() const;
  /// With the calibration in it.
  const StereoSetup& setup() const;

 private:
  mutable StereoSetup setup_;
  base::Pose X_WScanner_;
  mutable std::optional<stereo::Rectifier> rectifier_;  // with it, the sensor is prepared
  sensing::StereoCamera camera_;
};

}  // namespace rangegrasp::trial
