#include "stereo/sensing/stereo_calibration.h"

#include <nlohmann/json.hpp>

#include "base/data_folder.h"
#include "base/error.h"
#include "experiment/runner.h"
#include "stereo/sensing/chessboard_recorder.h"

namespace rangegrasp::trial {
namespace {

using nlohmann::json;

constexpr double kLimit_s = 600.0;  // sixteen views take ten seconds
constexpr char kCalibrated[] = "calibrated";

json JsonOf(const base::Pose& pose) {
  json values = json::array();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) values.push_back(pose.matrix()(i, j));
  }
  return values;
}

base::Pose PoseOf(const json& values) {
  base::Pose pose = base::Pose::Identity();
  std::size_t next = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) pose.matrix()(i, j) = values.at(next++).get<double>();
  }
  return pose;
}

json JsonOf(const stereo::StereoCalibration& c) {
  const stereo::Camera& camera = c.camera;
  return {{"size", {camera.width, camera.height}},
          {"lens",
           {camera.fx, camera.fy, camera.cx, camera.cy, camera.k1, camera.k2, camera.p1, camera.p2,
            camera.k3}},
          {"left", JsonOf(c.X_WL)},
          {"right", JsonOf(c.X_WR)},
          {"residuals", {c.reprojection_px, c.registration_m}}};
}

stereo::StereoCalibration CalibrationOf(const json& from) {
  stereo::StereoCalibration c;
  c.camera.width = from.at("size").at(0);
  c.camera.height = from.at("size").at(1);
  std::size_t next = 0;
  for (double* value : {&c.camera.fx, &c.camera.fy, &c.camera.cx, &c.camera.cy, &c.camera.k1,
                        &c.camera.k2, &c.camera.p1, &c.camera.p2, &c.camera.k3}) {
    *value = from.at("lens").at(next++);
  }
  c.X_WL = PoseOf(from.at("left"));
  c.X_WR = PoseOf(from.at("right"));
  c.reprojection_px = from.at("residuals").at(0);
  c.registration_m = from.at("residuals").at(1);
  return c;
}

experiment::Result Calibrate(const CalibrationSetup& setup) {
  experiment::Result result;
  try {
    sensing::ChessboardRecorder recorder(setup.scene, ChessboardModel(), setup.camera,
                                         setup.scanner, {}, setup.seed);
    const auto found = sensing::CalibrateSimulated(recorder, setup.views, setup.camera, {});
    result.outcome = kCalibrated;
    result.data = JsonOf(found.calibration).dump();
  } catch (const base::InputError& error) {
    result.outcome = "refused";
    result.detail = error.what();
  }
  return result;
}

}  // namespace

std::filesystem::path ChessboardModel() {
  return base::DataFolder() / "models" / "calibration" / "chessboard" / "chessboard.xml";
}

stereo::StereoCalibration CalibrateApart(const CalibrationSetup& setup) {
  const experiment::Case which{.id = "stereo_calibration", .group = "", .seed = setup.seed};
  const experiment::Result result = experiment::RunApart(
      which, kLimit_s, [&setup](const experiment::Case&) { return Calibrate(setup); });
  if (result.outcome != kCalibrated) {
    throw base::InputError("the stereo camera's calibration: " + result.detail);
  }
  return CalibrationOf(json::parse(result.data));
}

}  // namespace rangegrasp::trial
