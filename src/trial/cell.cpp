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

class LineScanner : public Sensor {
 public:
  LineScanner(const sensing::LineScannerOptions& options, const base::Pose& X_WScanner)
      : options_(options), X_WScanner_(X_WScanner) {}

  Sensed Sense(const sim::World& world, base::Rng& rng) const override {
    sensing::Scan scan = sensing::ScanScene(world.VisualMeshes(), X_WScanner_, options_, rng);
    Sensed sensed;
    sensed.observation.views.push_back(std::move(scan.view));
    sensed.truth.push_back(std::move(scan.truth));
    return sensed;
  }

 private:
  const sensing::LineScannerOptions& options_;
  base::Pose X_WScanner_;
};

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

std::unique_ptr<Sensor> MakeLineScanner(const sensing::LineScannerOptions& options,
                                        const base::Pose& X_WScanner) {
  return std::make_unique<LineScanner>(options, X_WScanner);
}

std::vector<geometry::CloudField> TruthFields(const geometry::View& view,
                                              const sensing::ScanTruth& truth) {
  geometry::CloudField label{"label", truth.label};
  geometry::CloudField state{"state", {}};
  for (const auto s : truth.state) state.values.push_back(static_cast<std::uint32_t>(s));
  std::vector<geometry::CloudField> fields = {label, state};
  if (!view.colors.empty()) fields.push_back(geometry::ColorField(view.colors));
  return fields;
}

}  // namespace rangegrasp::trial
