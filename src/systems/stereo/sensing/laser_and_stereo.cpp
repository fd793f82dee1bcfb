#include "stereo/sensing/laser_and_stereo.h"

#include <limits>
#include <utility>

#include "stereo/fill_absorbed.h"

namespace rangegrasp::trial {
namespace {

// What is left out was not measured, for the judge too.
void LeaveOut(const std::vector<bool>& kept, geometry::View& view, sensing::ScanTruth& truth) {
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i]) continue;
    view.image.points_C[i].setConstant(std::numeric_limits<double>::quiet_NaN());
    if (!view.noise_m.empty()) view.noise_m[i] = std::numeric_limits<float>::quiet_NaN();
    truth.state[i] = sensing::SampleState::kDropout;
  }
}

class LaserAndStereo : public Sensor {
 public:
  LaserAndStereo(std::unique_ptr<Sensor> laser, std::unique_ptr<Sensor> stereo)
      : laser_(std::move(laser)), stereo_(std::move(stereo)) {}

  void Prepare() const override { stereo_->Prepare(); }
  void Rehearse(const sim::World& world) const override { stereo_->Rehearse(world); }
  bool Rehearses() const override { return true; }

  Sensed Sense(const sim::World& world, base::Rng& rng) const override {
    base::Rng same = rng;
    Sensed sensed = laser_->Sense(world, rng);
    Sensed filling = stereo_->Sense(world, same);
    geometry::View& view = filling.observation.views.front();
    LeaveOut(perception::FillsAbsorbed(sensed.observation.views.front(), view), view,
             filling.truth.front());
    sensed.observation.views.push_back(std::move(view));
    sensed.truth.push_back(std::move(filling.truth.front()));
    return sensed;
  }

 private:
  std::unique_ptr<Sensor> laser_, stereo_;
};

}  // namespace

std::unique_ptr<Sensor> MakeLaserAndStereo(std::unique_ptr<Sensor> laser,
                                           std::unique_ptr<Sensor> stereo) {
  return std::make_unique<LaserAndStereo>(std::move(laser), std::move(stereo));
}

}  // namespace rangegrasp::trial
