#include "sim/internal/glove.h"

#include <mujoco/mujoco.h>

#include <algorithm>

namespace rangegrasp::sim::internal {

Glove::Glove(const World& world, const HandGeoms& hand, int target)
    : hand_(&hand),
      object_of_body_(static_cast<std::size_t>(world.model()->nbody), -1),
      part_of_(static_cast<std::size_t>(world.model()->ngeom), 0),
      objects_(world.objects() + 1),
      contacts_(hand.all().size() * static_cast<std::size_t>(objects_)),
      touched_(hand.all().size(), target) {
  for (int object = 0; object < world.objects(); ++object) {
    object_of_body_[static_cast<std::size_t>(world.object_body(object))] = object;
  }
  for (std::size_t part = 0; part < hand.all().size(); ++part) {
    part_of_[static_cast<std::size_t>(hand.all()[part])] = part;
  }
}

Glove::Contact& Glove::ContactOf(std::size_t part, int object) {
  return contacts_[part * static_cast<std::size_t>(objects_) +
                   static_cast<std::size_t>(object + 1)];
}

void Glove::ReadContacts(const World& world) {
  for (Contact& contact : contacts_) {
    contact.speed_m_s = -1.0;
    contact.pressure_N = 0.0;
  }
  const mjModel* model = world.model();
  const mjData* data = world.data();
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& met = data->contact[i];
    for (const int side : {0, 1}) {
      const int geom = met.geom[side];
      const int other = met.geom[1 - side];
      if (geom < 0 || other < 0 || !hand_->IsHand(geom) || hand_->IsHand(other)) continue;
      const int root = model->body_rootid[model->geom_bodyid[other]];
      Contact& contact = ContactOf(part_of_[static_cast<std::size_t>(geom)],
                                   object_of_body_[static_cast<std::size_t>(root)]);
      contact.speed_m_s = std::max(contact.speed_m_s, SlipSpeed(model, data, met));
      contact.pressure_N += NormalForce(model, data, i);
    }
  }
}

void Glove::Tick(World& world) {
  ReadContacts(world);
  slides_ = false;
  pad_speed_m_s_ = 0.0;
  for (std::size_t part = 0; part < hand_->all().size(); ++part) {
    const int geom = hand_->all()[part];
    double hardest_N = 0.0;
    for (int object = -1; object + 1 < objects_; ++object) {
      Contact& contact = ContactOf(part, object);
      contact.state.Update(contact.speed_m_s);
      slides_ =
          slides_ || (contact.state.sliding && contact.speed_m_s >= 0.0 && hand_->IsTip(geom));
      if (hand_->IsPad(geom)) pad_speed_m_s_ = std::max(pad_speed_m_s_, contact.speed_m_s);
      if (contact.pressure_N <= hardest_N) continue;
      hardest_N = contact.pressure_N;
      touched_[part] = object;
    }
    const int object = touched_[part];
    world.model()->geom_friction[3 * geom] =
        ContactOf(part, object).state.Coefficient(world.glove_friction(object));
  }
}

}  // namespace rangegrasp::sim::internal
