#include "sim/internal/contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "robot/mjcf/hand_file.h"
#include "sim/internal/kinematics.h"
#include "sim/internal/names.h"
#include "sim/internal/visual.h"

namespace rangegrasp::sim::internal {
namespace {

constexpr double kFarApart_m = 1.0;  // beyond any hand: the engine looks no further

}  // namespace

double SlipSpeed(const mjModel* model, const mjData* data, const mjContact& contact) {
  if (contact.efc_address < 0 || contact.dim < 3) return -1.0;
  const mjtNum* v = data->efc_vel + contact.efc_address;
  if (model->opt.cone == mjCONE_ELLIPTIC) return std::hypot(v[1], v[2]);
  // Rows of a pyramid: normal +- friction * tangent.
  return std::hypot((v[0] - v[1]) / (2 * contact.friction[0]),
                    (v[2] - v[3]) / (2 * contact.friction[1]));
}

double NormalForce(const mjModel* model, const mjData* data, int i) {
  mjtNum force[6] = {0};
  mj_contactForce(model, data, i, force);
  return force[0];
}

HandGeoms::HandGeoms(const mjModel* model) : body_(Find(model, mjOBJ_BODY, "hand")) {
  const auto n = static_cast<std::size_t>(model->ngeom);
  hand_.assign(n, 0);
  tip_.assign(n, 0);
  thumb_.assign(n, 0);
  for (const int geom : TupleOf(model, mjOBJ_GEOM, "fingertips"))
    tip_[static_cast<std::size_t>(geom)] = 1;
  pad_.assign(n, 0);
  if (TryFind(model, mjOBJ_TUPLE, "grip_sensors") >= 0) {
    touch_sensors_ = TupleOf(model, mjOBJ_SENSOR, "grip_sensors");
  }
  std::set<int> pad_bodies;
  for (const int sensor : touch_sensors_) {
    if (model->sensor_type[sensor] != mjSENS_TOUCH) {
      throw base::InputError(fmt::format("tuple \"grip_sensors\": sensor \"{}\" is no touch sensor",
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
    hand_[static_cast<std::size_t>(geom)] = 1;
    pad_[static_cast<std::size_t>(geom)] = pad_bodies.contains(model->geom_bodyid[geom]);
    thumb_[static_cast<std::size_t>(geom)] = IsThumbBody(model->geom_bodyid[geom]);
  }
}

double HandGeoms::Gap(const mjModel* model, mjData* data) const {
  double gap = kFarApart_m;
  for (const int a : all_) {
    if (!IsTip(a) || !IsThumb(a)) continue;
    for (const int b : all_) {
      if (IsTip(b) && !IsThumb(b))
        gap = std::min(gap, mj_geomDistance(model, data, a, b, gap, nullptr));
    }
  }
  return gap;
}

std::vector<ContactPoint> ContactsOf(const mjModel* model, const mjData* data,
                                     const HandGeoms& hand, int object_body) {
  std::vector<ContactPoint> contacts;
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    if (contact.efc_address < 0) continue;
    for (const int side : {0, 1}) {
      if (model->body_rootid[model->geom_bodyid[contact.geom[side]]] != object_body) continue;
      if (!hand.IsHand(contact.geom[1 - side])) continue;
      contacts.push_back({Vec3(contact.pos), Vec3(contact.frame)});
    }
  }
  return contacts;
}

double PressureOn(const mjModel* model, const mjData* data, const HandGeoms& hand,
                  int object_body) {
  double pressure_N = 0.0;
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    for (const int side : {0, 1}) {
      if (contact.geom[side] < 0 || contact.geom[1 - side] < 0) continue;
      const bool of_object =
          model->body_rootid[model->geom_bodyid[contact.geom[side]]] == object_body;
      if (of_object && hand.IsHand(contact.geom[1 - side]))
        pressure_N += NormalForce(model, data, i);
    }
  }
  return pressure_N;
}

Touch TouchOf(const mjModel* model, const mjData* data, const HandGeoms& hand, int object_body) {
  Touch touch;
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    if (contact.efc_address < 0) continue;
    for (const int side : {0, 1}) {
      if (model->body_rootid[model->geom_bodyid[contact.geom[side]]] != object_body) continue;
      if (hand.IsHand(contact.geom[1 - side])) {
        touch.hand = true;
        touch.deepest_m = std::max(touch.deepest_m, -contact.dist);
      } else if (model->body_rootid[model->geom_bodyid[contact.geom[1 - side]]] != object_body) {
        touch.other = true;
      }
    }
  }
  return touch;
}

}  // namespace rangegrasp::sim::internal
