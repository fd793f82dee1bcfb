#include "trial/cell.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/stopwatch.h"
#include "base/words.h"
#include "geometry/view_images.h"
#include "sensing/range_sensor.h"
#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

// Every cell has a line scanner: objects are arranged in its view, so that all sensors see the same
// arrangements.
sensing::LineScannerOptions ScannerOf(const Options& options) {
  const std::filesystem::path file = FindSensor(options.sensor_type)->laser(options.sensor);
  sensing::LineScannerOptions scanner;
  if (!file.empty()) scanner = sensing::ReadLineScanner(file);
  scanner.color = scanner.color || options.color;
  return scanner;
}

Sensed SensedOf(sensing::Scan scan) {
  Sensed sensed;
  sensed.observation.views.push_back(std::move(scan.view));
  sensed.truth.push_back(std::move(scan.truth));
  return sensed;
}

class LineScanner : public Sensor {
 public:
  explicit LineScanner(const Cell& cell) : cell_(cell) {}

  Sensed Sense(const sim::World& world, base::Rng& rng) const override {
    return SensedOf(
        sensing::ScanScene(world.VisualMeshes(), cell_.robot.X_WScanner, cell_.scanner, rng));
  }

 private:
  const Cell& cell_;
};

class DepthCamera : public Sensor {
 public:
  explicit DepthCamera(const sensing::DepthCameraOptions& options) : sensor_(options) {}

  Sensed Sense(const sim::World& world, base::Rng& rng) const override {
    return SensedOf(
        sensing::ScanScene(world.VisualMeshes(), sensing::PoseIn(world, sensor_), sensor_, rng));
  }

  bool WritesLook() const override { return true; }
  /// Writes the pictures next to the cloud.
  std::string WriteLook(const sim::World& world, base::Rng& rng,
                        const std::filesystem::path& cloud) const override {
    const auto meshes = world.VisualMeshes();
    base::Stopwatch watch;
    const sensing::Scan scan =
        sensing::ScanScene(meshes, sensing::PoseIn(world, sensor_), sensor_, rng);
    const double seconds = watch.Seconds();
    geometry::WriteCloud(cloud, scan.view.image, TruthFields(scan.view, scan.truth));
    const auto written =
        geometry::WriteImages(scan.view, cloud.parent_path(), cloud.stem().string());
    const auto points = std::ranges::count(scan.truth.state, sensing::SampleState::kMeasured);
    return fmt::format("{} of {} x {} pixels, {:.0f} ms{}", base::Counted(points, "point"),
                       scan.view.image.samples, scan.view.image.profiles, seconds * 1e3,
                       written ? "; pictures: " + written->depth + " " + written->color : "");
  }

 private:
  sensing::RangeSensor sensor_;
};

}  // namespace

Cell::Cell(Options o)
    : options(std::move(o)),
      robot(robot::Robot::Load(options.scene)),
      scanner(ScannerOf(options)),
      arranger(MakeArranger(options, robot, scanner)),
      sensor(FindSensor(options.sensor_type)->make(*this)),
      detector(MakeDetector(options, robot)) {}

void Cell::Hide(const std::filesystem::path& folder) {
  const DetectorKind& kind = *FindDetector(options.detector);
  if (!kind.hide) return;
  kind.hide(std::filesystem::absolute(folder), options);
  detector = MakeDetector(options, robot);  // a detector keeps a copy of its options
}

geometry::Plane Cell::TablePlane() const {
  const Eigen::Vector3d up_W = robot.X_WWorkspace.linear().col(2);
  return {up_W, -up_W.dot(robot.X_WWorkspace.translation())};
}

std::unique_ptr<Sensor> MakeLineScanner(const Cell& cell) {
  return std::make_unique<LineScanner>(cell);
}

std::unique_ptr<Sensor> MakeDepthCamera(const Cell& cell) {
  auto options = sensing::ReadDepthCamera(cell.options.sensor);
  options.color = options.color || cell.options.color;
  return std::make_unique<DepthCamera>(options);
}

std::vector<geometry::CloudField> TruthFields(const geometry::View& view,
                                              const sensing::ScanTruth& truth) {
  std::vector<geometry::CloudField> fields = {{"label", truth.label}, {"state", {}}};
  for (const auto s : truth.state) fields[1].values.push_back(static_cast<std::uint32_t>(s));
  if (!view.colors.empty()) fields.push_back(geometry::ColorField(view.colors));
  return fields;
}

}  // namespace rangegrasp::trial
