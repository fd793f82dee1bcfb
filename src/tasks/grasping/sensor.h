#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/rng.h"
#include "geometry/observation.h"
#include "sensing/line_scanner_options.h"
#include "sensing/scan_truth.h"
#include "sensing/stereo_camera.h"
#include "sim/world.h"
#include "stereo/camera.h"
#include "stereo/reconstruct.h"

namespace rangegrasp::tasks::grasping {

/// What a sensor measured, and beside it what only the judge may read.
struct Sensed {
  geometry::Observation observation;
  std::vector<sensing::ScanTruth> truth;  ///< one a view, in the layout of its image
};

/// Stage 2: looks at a settled world.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual Sensed Sense(const sim::World& world, core::Rng& rng) const = 0;
  /// What it does once before it looks, and does at its first look if it was not asked to.
  virtual void Prepare() const {}
  /// Looks at a world for nothing but that later looks at such things are faster, those of
  /// processes that are forked from this one, too.
  virtual void Rehearse(const sim::World&) const {}
};

/// The line scanner at its site. @param options  must outlive it
std::unique_ptr<Sensor> MakeLineScanner(const sensing::LineScannerOptions& options,
                                        const core::Pose& X_WScanner);

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
  /// @throws core::InputError for a calibration that does not fit; std::invalid_argument for
  /// options that are out of range.
  StereoSensor(StereoSetup setup, const core::Pose& X_WScanner);
  ~StereoSensor() override;

  void Prepare() const override;
  void Rehearse(const sim::World& world) const override;

  Sensed Sense(const sim::World& world, core::Rng& rng) const override;
  /// The same with all that lies between.
  StereoLook Look(const sim::World& world, core::Rng& rng) const;

  const stereo::Rectifier& rectifier() const;
  /// With the calibration in it.
  const StereoSetup& setup() const;

 private:
  mutable StereoSetup setup_;
  core::Pose X_WScanner_;
  mutable std::optional<stereo::Rectifier> rectifier_;  // with it, the sensor is prepared
  sensing::StereoCamera camera_;
};

}  // namespace rangegrasp::tasks::grasping
