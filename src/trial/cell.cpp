#include "trial/cell.h"

#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

// Any cell has the line scanner: objects lie in its view, so that all sensors see the same
// arrangements.
sensing::LineScannerOptions ScannerOf(const Options& options) {
  const std::filesystem::path file = FindSensor(options.sensor_type)->laser(options.sensor);
  sensing::LineScannerOptions scanner;
  if (!file.empty()) scanner = sensing::ReadLineScanner(file);
  scanner.color = scanner.color || options.color;
  return scanner;
}

}  // namespace

Cell::Cell(Options o)
    : options(std::move(o)),
      robot(robot::Robot::Load(options.scene)),
      scanner(ScannerOf(options)),
      arranger(MakeArranger(options, robot, scanner)),
      sensor(FindSensor(options.sensor_type)->make(*this)),
      detector(MakeDetector(options, robot)),
      mover(grasp::MakePlannedMover(options, options.grasp.friction_cone_rad, robot)) {}

void Cell::Hide(const std::filesystem::path& folder) {
  const DetectorKind& kind = *FindDetector(options.detector);
  if (!kind.hide) return;
  kind.hide(std::filesystem::absolute(folder), options);
  detector = MakeDetector(options, robot);  // it keeps options of its own
}

geometry::Plane Cell::TablePlane() const {
  const Eigen::Vector3d up_W = robot.X_WWorkspace.linear().col(2);
  return {up_W, -up_W.dot(robot.X_WWorkspace.translation())};
}

}  // namespace rangegrasp::trial
