#include "stereo/sensing/stereo_of_cell.h"

#include "stereo/sensing/stereo_calibration.h"

namespace rangegrasp::stereo {

void ReadKeys(base::YamlMap map, Keys& keys) {
  map.ReadPath("calibration", keys.calibration,
               "of the camera; without it, it is calibrated before the first trial");
  ReadReconstructOptions(map, keys.reconstruct);
}

BothFiles ReadBoth(const std::filesystem::path& sensor_file) {
  BothFiles files;
  auto map = base::YamlMap::FromFile(sensor_file);
  std::string type;
  map.Read("type", type);
  for (const char* key : {"laser", "stereo"}) map.Require(key);
  map.ReadPath("laser", files.laser, "file of the line scanner");
  map.ReadPath("stereo", files.stereo, "file of the stereo camera");
  map.Finish();
  return files;
}

std::filesystem::path CameraFileOf(const trial::Options& options) {
  if (options.sensor_type == kStereoCamera) return options.sensor;
  return options.sensor_type == kLaserAndStereo ? ReadBoth(options.sensor).stereo
                                                : std::filesystem::path();
}

std::unique_ptr<trial::StereoSensor> StereoOf(const trial::Cell& cell,
                                              const std::filesystem::path& camera) {
  const trial::Options& options = cell.options;
  const Keys keys = trial::Of<Keys>(options, kKeys);
  trial::StereoSetup setup;
  setup.camera = sensing::ReadStereoCamera(camera);
  if (keys.calibration.empty()) {
    const trial::CalibrationSetup calibration{
        .scene = options.scene,
        .camera = setup.camera,
        .scanner = cell.scanner,
        .seed = base::DeriveSeed(options.seed, "calibration")};
    setup.calibrate = [calibration] { return trial::CalibrateApart(calibration); };
  } else {
    setup.calibration = ReadStereoCalibration(keys.calibration);
  }
  setup.reconstruct = keys.reconstruct;
  setup.color = options.color;
  setup.reconstruct.table_W = cell.TablePlane();
  setup.reconstruct.volume = {
      .X_WV = cell.robot.X_WWorkspace,
      .radius_m = cell.robot.workspace_radius_m + options.workspace_margin_m,
      .height_m = keys.reconstruct.volume_height_m};
  return std::make_unique<trial::StereoSensor>(std::move(setup), cell.robot.X_WScanner);
}

}  // namespace rangegrasp::stereo
