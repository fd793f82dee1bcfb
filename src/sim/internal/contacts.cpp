#include "sim/internal/contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "robot/mjcf/hand.h"
#include "sim/internal/engine.h"

namespace rangegrasp::sim::internal {
namespace {

// Period of the readings: 5 of them in the time after which a force may be raised again.
constexpr double kPeriod_s = 0.008;
// A contact of the engine yields by force over mass. Below this mass the glove yields by the force
// alone, as on this mass: 100 N would press it 2 mm into 20 g. All shipped objects are heavier.
constexpr double kLight_kg = 0.1;
// A time step may end a rounding error before a reading is due.
constexpr double kRounding_s = 1e-9;

// Root body of a contact's geom; -1 for a flex, which has no geom.
int RootOfGeom(const mjModel* model, int geom) {
  return geom < 0 ? -1 : model->body_rootid[model->geom_bodyid[geom]];
}

// Calls `of` with the number of each load-bearing contact of an object, and the other geom (-1: a
// flex).
template <class Function>
void ForContactsOf(const World& world, int object, const Function& of) {
  const mjModel* model = world.model();
  const mjData* data = world.data();
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    if (contact.efc_address < 0) continue;
    for (const int side : {0, 1}) {
      if (RootOfGeom(model, contact.geom[side]) != world.object_body(object)) continue;
      of(i, contact.geom[1 - side]);
    }
  }
}

// Force of contact i on its second geom, in the contact's frame, whose x is the normal [N]; the
// first geom receives the opposite force.
Eigen::Vector3d ContactForce(const mjModel* model, const mjData* data, int i) {
  mjtNum force[6] = {0};
  mj_contactForce(model, data, i, force);
  return Vec3(force);
}

}  // namespace

double SlipSpeed(const mjModel* model, const mjData* data, const mjContact& contact) {
  if (contact.efc_address < 0 || contact.dim < 3) return -1.0;
  const mjtNum* v = data->efc_vel + contact.efc_address;
  if (model->opt.cone == mjCONE_ELLIPTIC) return std::hypot(v[1], v[2]);
  // Rows of a pyramidal cone: normal +- friction * tangent.
  return std::hypot((v[0] - v[1]) / (2 * contact.friction[0]),
                    (v[2] - v[3]) / (2 * contact.friction[1]));
}

HandGeoms::HandGeoms(const mjModel* model) : body_(Find(model, mjOBJ_BODY, "hand")) {
  for (auto* of : {&hand_, &tip_, &pad_}) of->assign(model->ngeom, 0);
  for (const int geom : TupleOf(model, mjOBJ_GEOM, "fingertips")) tip_[geom] = 1;
  if (TryFind(model, mjOBJ_TUPLE, "grip_sensors") >= 0) {
    touch_sensors_ = TupleOf(model, mjOBJ_SENSOR, "grip_sensors");
  }
  std::set<int> pad_bodies;
  for (const int sensor : touch_sensors_) {
    if (model->sensor_type[sensor] != mjSENS_TOUCH) {
      throw base::InputError(
          fmt::format("tuple \"grip_sensors\": sensor \"{}\" is not a touch sensor",
                      mj_id2name(model, mjOBJ_SENSOR, sensor)));
    }
    pad_bodies.insert(model->site_bodyid[model->sensor_objid[sensor]]);
  }
  const int thumb = mjcf::ThumbRoot(model);
  for (int body = 0; body < model->nbody; ++body) {
    thumb_body_.push_back(InSubtree(model, body, thumb));
  }
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!Collides(model, geom) || !InSubtree(model, model->geom_bodyid[geom], body_)) continue;
    all_.push_back(geom);
    hand_[geom] = 1;
    pad_[geom] = pad_bodies.contains(model->geom_bodyid[geom]);
  }
}

double HandGeoms::Gap(const mjModel* model, mjData* data) const {
  const auto of_thumb = [&](int geom) { return IsThumbBody(model->geom_bodyid[geom]); };
  double gap = mjcf::kFarApart_m;
  for (const int a : all_) {
    for (const int b : all_) {
      if (!IsTip(a) || !IsTip(b) || !of_thumb(a) || of_thumb(b)) continue;
      gap = std::min(gap, mj_geomDistance(model, data, a, b, gap, nullptr));
    }
  }
  return gap;
}

std::vector<ContactPoint> ContactsOf(const World& world, const HandGeoms& hand, int object) {
  std::vector<ContactPoint> contacts;
  ForContactsOf(world, object, [&](int i, int other) {
    if (!hand.IsHand(other)) return;
    const mjContact& contact = world.data()->contact[i];
    contacts.push_back({Vec3(contact.pos), Vec3(contact.frame)});
  });
  return contacts;
}

double PressureOn(const World& world, const HandGeoms& hand, int object) {
  double pressure_N = 0.0;
  ForContactsOf(world, object, [&](int i, int other) {
    if (hand.IsHand(other)) pressure_N += ContactForce(world.model(), world.data(), i).x();
  });
  return pressure_N;
}

Touch TouchOf(const World& world, const HandGeoms& hand, int object) {
  Touch touch;
  const mjModel* model = world.model();
  ForContactsOf(world, object, [&](int i, int other) {
    if (hand.IsHand(other)) {
      touch.hand = true;
      touch.deepest_m = std::max(touch.deepest_m, -world.data()->contact[i].dist);
    } else if (RootOfGeom(model, other) != world.object_body(object)) {
      touch.other = true;
    }
  });
  return touch;
}

double DeepestElsewhere(const World& world, const HandGeoms& hand, int object) {
  double deepest_m = 0.0;
  const mjModel* model = world.model();
  const auto is_held = [&](int geom) {
    return hand.IsHand(geom) || RootOfGeom(model, geom) == world.object_body(object);
  };
  for (int i = 0; i < world.data()->ncon; ++i) {
    const mjContact& contact = world.data()->contact[i];
    const bool of_hand = hand.IsHand(contact.geom[0]) || hand.IsHand(contact.geom[1]);
    const bool of_grip = of_hand && is_held(contact.geom[0]) && is_held(contact.geom[1]);
    if (contact.efc_address < 0 || of_grip) continue;
    deepest_m = std::max(deepest_m, -contact.dist);
  }
  return deepest_m;
}

Glove::Glove(const World& world, const HandGeoms& hand, int target)
    : hand_(&hand),
      object_of_body_(world.model()->nbody, -1),
      part_of_(world.model()->ngeom, 0),
      objects_(world.objects() + 1),
      contacts_(hand.all().size() * objects_),
      touched_(hand.all().size(), target) {
  for (int object = 0; object < world.objects(); ++object) {
    object_of_body_[world.object_body(object)] = object;
  }
  for (std::size_t part = 0; part < hand.all().size(); ++part) part_of_[hand.all()[part]] = part;
}

void Glove::ReadContacts(const World& world) {
  for (Contact& contact : contacts_) contact = {.state = contact.state};
  load_W_.setZero();
  const mjModel* model = world.model();
  const mjData* data = world.data();
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& met = data->contact[i];
    for (const int side : {0, 1}) {
      const int geom = met.geom[side];
      const int other = met.geom[1 - side];
      if (geom < 0 || other < 0 || !hand_->IsHand(geom) || hand_->IsHand(other)) continue;
      const int root = model->body_rootid[model->geom_bodyid[other]];
      Contact& contact = ContactOf(part_of_[geom], object_of_body_[root]);
      contact.speed_m_s = std::max(contact.speed_m_s, SlipSpeed(model, data, met));
      const Eigen::Vector3d force = ContactForce(model, data, i);
      contact.pressure_N += force.x();
      mjtNum force_W[3];
      mju_mulMatTVec3(force_W, met.frame, force.data());
      load_W_ += (side == 1 ? 1.0 : -1.0) * Vec3(force_W);
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
    const double mass_kg = object < 0 ? kLight_kg : world.ObjectMass(object);
    world.ScaleSoftness(geom, std::min(1.0, mass_kg / kLight_kg));
  }
}

bool SlipSensor::Tick(double time_s, double speed_m_s) {
  if (time_s + kRounding_s >= next_s_) {
    const double noisy_m_s = speed_m_s + options_.slip_noise_m_s * rng_.Normal();
    underway_.push_back({time_s, noisy_m_s > options_.slip_threshold_m_s});
    next_s_ = time_s + kPeriod_s;
  }
  while (!underway_.empty() &&
         underway_.front().time_s + options_.slip_delay_s <= time_s + kRounding_s) {
    heard_ = underway_.front().slips;
    underway_.pop_front();
  }
  return heard_;
}

}  // namespace rangegrasp::sim::internal
