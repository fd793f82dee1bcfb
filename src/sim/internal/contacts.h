#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "base/rng.h"
#include "sim/execute.h"
#include "sim/surfaces.h"

namespace rangegrasp::sim::internal {

/// Tangential speed of a contact [m/s]; negative if the contact cannot bear load.
double SlipSpeed(const mjModel* model, const mjData* data, const mjContact& contact);

/// The hand's collision geoms and their roles.
class HandGeoms {
 public:
  /// @throws base::InputError naming the body or tuple that the scene lacks ("hand", "hand_joints",
  /// "fingertips"), or a grip sensor that is not a touch sensor.
  explicit HandGeoms(const mjModel* model);

  bool IsHand(int geom) const { return geom >= 0 && hand_[geom]; }  ///< -1: a contact's flex
  bool IsTip(int geom) const { return tip_[geom]; }
  bool IsThumbBody(int body) const { return thumb_body_[body]; }
  /// Distal pads: geoms of bodies with touch sensors of "grip_sensors"; without these, no feeling.
  bool IsPad(int geom) const { return pad_[geom]; }
  const std::vector<int>& touch_sensors() const { return touch_sensors_; }
  const std::vector<int>& all() const { return all_; }
  int body() const { return body_; }  ///< root body of the hand

  /// Minimum distance between the thumb's and the fingers' tips [m] at the geoms' present poses.
  double Gap(const mjModel* model, mjData* data) const;

 private:
  int body_;
  std::vector<char> hand_, tip_, pad_;  // by geom
  std::vector<char> thumb_body_;        // by body
  std::vector<int> touch_sensors_, all_;
};

/// Contacts of an object.
struct Touch {
  bool hand = false, other = false;
  double deepest_m = 0.0;  ///< penetration of the hand's deepest contact
};
/// A contact of the hand with an object, at the middle between the two surfaces.
struct ContactPoint {
  Eigen::Vector3d point_W, normal_W;
};
std::vector<ContactPoint> ContactsOf(const World& world, const HandGeoms& hand, int object);
/// Sum of the normal forces of the hand's contacts with an object [N].
double PressureOn(const World& world, const HandGeoms& hand, int object);
Touch TouchOf(const World& world, const HandGeoms& hand, int object);
/// Penetration of the deepest contact, except those of the hand with an object or with itself [m].
double DeepestElsewhere(const World& world, const HandGeoms& hand, int object);

/// The glove's friction. Each geom of the hand has the static coefficient on what it touches until
/// a contact with it slides, then the kinetic one until it sticks again, from the object's pair
/// (World::glove_friction). The engine has one coefficient per geom: that of the object that it
/// presses hardest.
class Glove {
 public:
  /// @param target  its friction pair applies to a geom that has touched nothing yet
  Glove(const World& world, const HandGeoms& hand, int target);
  /// To be called once before each step.
  void Tick(World& world);
  bool Slides() const { return slides_; }  ///< whether any fingertip slides
  /// Speed of the fastest contact with a distal pad [m/s]; 0 if nothing touches one.
  double PadSpeed() const { return pad_speed_m_s_; }
  /// Sum of all contact forces on the hand [N]; the grip's own forces cancel out.
  const Eigen::Vector3d& Load_W() const { return load_W_; }

 private:
  // Contact of a geom of the hand with one object, or with the scene.
  struct Contact {
    SlipState state;
    double speed_m_s = -1.0;  ///< speed of the fastest contact; negative if there is no contact
    double pressure_N = 0.0;
  };
  Contact& ContactOf(std::size_t part, int object) {
    return contacts_[part * objects_ + object + 1];
  }
  void ReadContacts(const World& world);

  const HandGeoms* hand_;
  std::vector<int> object_of_body_;   // by root body; -1 for the scene
  std::vector<std::size_t> part_of_;  // index among the hand's geoms, by geom
  int objects_;                       // number including the scene, which is first
  std::vector<Contact> contacts_;     // one row per geom of the hand
  std::vector<int> touched_;          // last pressed object, by geom of the hand
  bool slides_ = false;
  double pad_speed_m_s_ = 0.0;
  Eigen::Vector3d load_W_ = Eigen::Vector3d::Zero();
};

/// Slip sensors of the distal pads. They read the speed of sliding along a pad with noise at a
/// fixed period, and report it after the delay.
class SlipSensor {
 public:
  SlipSensor(const HandControlOptions& options, base::Rng rng) : options_(options), rng_(rng) {}

  /// To be called once per time step.
  /// @param speed_m_s  speed of the fastest contact with a pad; 0 if none slides
  /// @return whether the newest reading that has arrived indicates a slip.
  bool Tick(double time_s, double speed_m_s);

 private:
  struct Reading {
    double time_s;
    bool slips;
  };

  HandControlOptions options_;
  base::Rng rng_;
  std::deque<Reading> underway_;
  double next_s_ = 0.0;
  bool heard_ = false;
};

}  // namespace rangegrasp::sim::internal
