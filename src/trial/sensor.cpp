#include "trial/sensor.h"

#include "sensing/line_scanner.h"

namespace rangegrasp::trial {
namespace {

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

std::unique_ptr<Sensor> MakeLineScanner(const sensing::LineScannerOptions& options,
                                        const base::Pose& X_WScanner) {
  return std::make_unique<LineScanner>(options, X_WScanner);
}

}  // namespace rangegrasp::trial
