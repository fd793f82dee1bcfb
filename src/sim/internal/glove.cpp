#include "sim/internal/glove.h"

#include <algorithm>

namespace rangegrasp::sim::internal {

void Glove::Tick(mjModel* model, const mjData* data) {
  constexpr double kNoContact = -1.0;
  const std::vector<int>& geoms = hand_->all();
  std::vector<double> speed_m_s(static_cast<std::size_t>(model->ngeom), kNoContact);
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    for (const int geom : contact.geom) {
      if (geom < 0 || !hand_->IsHand(geom)) continue;
      double& fastest = speed_m_s[static_cast<std::size_t>(geom)];
      fastest = std::max(fastest, SlipSpeed(model, data, contact));
    }
  }
  slides_ = false;
  for (std::size_t i = 0; i < geoms.size(); ++i) {
    const double speed = speed_m_s[static_cast<std::size_t>(geoms[i])];
    states_[i].Update(speed);
    model->geom_friction[3 * geoms[i]] = states_[i].Coefficient(pair_);
    slides_ = slides_ || (states_[i].sliding && speed >= 0.0 && hand_->IsTip(geoms[i]));
  }
}

}  // namespace rangegrasp::sim::internal
