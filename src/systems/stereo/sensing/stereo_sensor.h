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

struct StereoSetup {
  sensing::StereoCameraOptions camera;  ///< true options; only for taking the pictures
  StereoCalibration calibration;        ///< as the robot knows it
  /// If given, it computes the calibration when it is first needed.
  std::function<StereoCalibration()> calibrate;
  ReconstructOptions reconstruct;
  bool color = false;  ///< samples have the left picture's colors
};

struct StereoLook {
  sensing::StereoShot shot;
  Reconstruction made;
  sensing::ScanTruth truth;  ///< in the layout of made.view's image
};

/// The stereo camera on the head of the scanner (section 5.3): takes two pictures and reconstructs
/// them with its calibration.
class StereoSensor : public trial::Sensor {
 public:
  /// @throws base::InputError for a calibration that does not fit; std::invalid_argument for
  /// options that are out of range.
  StereoSensor(StereoSetup setup, const base::Pose& X_WScanner);

  void Prepare() const override;
  void Rehearse(const sim::World& world) const override;
  bool Rehearses() const override { return true; }
  bool WritesLook() const override { return true; }
  /// A folder next to the cloud holds the pictures, the disparities and the calibration.
  std::string WriteLook(const sim::World& world, base::Rng& rng,
                        const std::filesystem::path& cloud) const override;

  trial::Sensed Sense(const sim::World& world, base::Rng& rng) const override;
  /// The same with all intermediate results.
  StereoLook Look(const sim::World& world, base::Rng& rng) const;

  /// Includes the calibration.
  const StereoSetup& setup() const;

 private:
  mutable StereoSetup setup_;
  base::Pose X_WScanner_;
  mutable std::optional<Rectifier> rectifier_;  // if set, the sensor is prepared
  sensing::StereoCamera camera_;
};

/// Reads the keys below `stereo` of grasping experiments. @throws base::InputError
void ReadKeys(base::YamlMap& map, trial::Options& options);

/// The types of sensor files with a stereo camera.
inline constexpr const char* kStereoCamera = "stereo_camera";
inline constexpr const char* kLaserAndStereo = "laser_and_stereo";

/// The files that a sensor of both kinds refers to as `laser` and `stereo`.
struct BothFiles {
  std::filesystem::path laser, stereo;
};
/// @throws base::InputError naming the file.
BothFiles ReadBoth(const std::filesystem::path& sensor_file);

/// The file of an experiment's stereo camera; empty if it has none.
std::filesystem::path CameraFileOf(const trial::Options& options);

/// The stereo sensor of a cell; `camera` is the camera's file.
std::unique_ptr<StereoSensor> StereoOf(const trial::Cell& cell,
                                       const std::filesystem::path& camera);

/// The stereo samples that fill gaps where the laser's light does not return (section 7.2, figure
/// 7.1): no returned laser ray passes them within the angle from one profile or sample to the next,
/// and the geometrical filter (section 4.2.2) keeps them. O(n log n).
/// @param laser, stereo  in the same frame
/// @return one per sample of `stereo`; if the laser measured nothing, all that the filter keeps
std::vector<bool> FillsAbsorbed(const geometry::View& laser, const geometry::View& stereo);

/// Both sensors observe the world as each would alone, with the same random stream. The observation
/// has two views: the laser's, and those samples of the stereo camera that FillsAbsorbed selects.
std::unique_ptr<trial::Sensor> MakeLaserAndStereo(std::unique_ptr<trial::Sensor> laser,
                                                  std::unique_ptr<trial::Sensor> stereo);

}  // namespace rangegrasp::stereo
