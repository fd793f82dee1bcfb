#pragma once

#include <vector>

#include "sim/friction.h"
#include "sim/internal/contacts.h"

namespace rangegrasp::sim::internal {

/// The glove's friction: each of the hand's geoms has the static coefficient on what it touches
/// until a contact with it slides, then the kinetic one until it sticks again. Each object has its
/// own pair (World::glove_friction). The engine knows one coefficient a geom: where a geom touches
/// several things it is the one of what it presses hardest.
class Glove {
 public:
  /// @param target  whose pair a geom has that has touched nothing yet
  Glove(const World& world, const HandGeoms& hand, int target);
  /// Once before each step.
  void Tick(World& world);
  bool Slides() const { return slides_; }  ///< any fingertip on anything
  /// Of the fastest contact with a distal pad [m/s]; 0 where nothing touches one.
  double PadSpeed() const { return pad_speed_m_s_; }

 private:
  // Of a geom of the hand with one object, or with the scene.
  struct Contact {
    SlipState state;
    double speed_m_s = -1.0;  ///< of the fastest contact; negative if there is none
    double pressure_N = 0.0;
  };
  Contact& ContactOf(std::size_t part, int object);
  void ReadContacts(const World& world);

  const HandGeoms* hand_;
  std::vector<int> object_of_body_;   // by root body; the scene's is -1
  std::vector<std::size_t> part_of_;  // by geom: its place among the hand's
  int objects_;                       // with the scene, which stands first
  std::vector<Contact> contacts_;     // a row for each of the hand's geoms
  std::vector<int> touched_;          // by the hand's geoms: the last one that was pressed
  bool slides_ = false;
  double pad_speed_m_s_ = 0.0;
};

}  // namespace rangegrasp::sim::internal
