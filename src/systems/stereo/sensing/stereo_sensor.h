#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/yaml_map.h"
#include "geometry/observation.h"
#include "stereo/camera.h"
#include "stereo/reconstruct.h"
#include "stereo/sensing/stereo_camera.h"
#include "trial/cell.h"

namespace rangegrasp::stereo {

/// What a stereo camera makes its observations with, and from.
struct StereoSetup {
  sensing::StereoCameraOptions camera;  ///< as it is; for the pictures alone
  StereoCalibration calibration;        ///< as the robot knows it
  /// If given, it makes the calibration when that is needed first.
  std::function<StereoCalibration()> calibrate;
  ReconstructOptions reconstruct;
  bool color = false;  ///< samples have the left picture's colors
};

struct StereoLook {
  sensing::StereoShot shot;
  Reconstruction made;
  sensing::ScanTruth truth;  ///< in the layout of made.view's image
};

/// The stereo camera on the head of the scanner (section 5.3): two pictures, and their
/// reconstruction by its calibration.
class StereoSensor : public trial::Sensor {
 public:
  /// @throws base::InputError for a calibration that does not fit; std::invalid_argument for
  /// options that are out of range.
  StereoSensor(StereoSetup setup, const base::Pose& X_WScanner);

  void Prepare() const override;
  void Rehearse(const sim::World& world) const override;
  bool Rehearses() const override { return true; }
  /// A folder next to the cloud holds the pictures, the disparities and the calibration.
  std::string WriteLook(const sim::World& world, base::Rng& rng,
                        const std::filesystem::path& cloud) const override;

  trial::Sensed Sense(const sim::World& world, base::Rng& rng) const override;
  /// The same with all that lies between.
  StereoLook Look(const sim::World& world, base::Rng& rng) const;

  const Rectifier& rectifier() const;
  /// With the calibration in it.
  const StereoSetup& setup() const;

 private:
  mutable StereoSetup setup_;
  base::Pose X_WScanner_;
  mutable std::optional<Rectifier> rectifier_;  // with it, the sensor is prepared
  sensing::StereoCamera camera_;
};

/// Reads the keys below `stereo` of grasping experiments. @throws base::InputError
void ReadKeys(base::YamlMap& map, trial::Options& options);

/// The types of sensor files that hold a stereo camera.
inline constexpr const char* kStereoCamera = "stereo_camera";
inline constexpr const char* kLaserAndStereo = "laser_and_stereo";

/// The files that a sensor of both kinds names as `laser` and `stereo`.
struct BothFiles {
  std::filesystem::path laser, stereo;
};
/// @throws base::InputError naming the file.
BothFiles ReadBoth(const std::filesystem::path& sensor_file);

/// The file of an experiment's stereo camera; empty if it has none.
std::filesystem::path CameraFileOf(const trial::Options& options);

/// The stereo camera of a cell. @param camera  its file
std::unique_ptr<StereoSensor> StereoOf(const trial::Cell& cell,
                                       const std::filesystem::path& camera);

/// The stereo samples that fill what a laser is blind to because its light does not come back
/// (section 7.2, figure 7.1): no ray of the laser that came back passes by them, within the angle
/// from one profile or sample to the next, and the geometrical filter (section 4.2.2) keeps them.
/// O(n log n).
/// @param laser, stereo  in one frame
/// @return one a sample of `stereo`; all that were measured if the laser measured nothing
std::vector<bool> FillsAbsorbed(const geometry::View& laser, const geometry::View& stereo);

/// Both look at the world, each as it would alone, from the same stream. The observation has two
/// views: the laser's, and of the stereo camera's what FillsAbsorbed.
std::unique_ptr<trial::Sensor> MakeLaserAndStereo(std::unique_ptr<trial::Sensor> laser,
                                                  std::unique_ptr<trial::Sensor> stereo);

}  // namespace rangegrasp::stereo
