#pragma once

#include <mujoco/mujoco.h>

#include <vector>

namespace rangegrasp::sim::internal {

/// Tangential speed of a contact [m/s]; negative if it is none that can bear load.
double SlipSpeed(const mjModel* model, const mjData* data, const mjContact& contact);
/// Normal force of contact number i [N].
double NormalForce(const mjModel* model, const mjData* data, int i);

/// The hand's collision geoms and what they are.
class HandGeoms {
 public:
  /// @throws core::InputError naming the body or tuple that the scene lacks ("hand", "hand_joints",
  /// "fingertips").
  explicit HandGeoms(const mjModel* model);

  bool IsHand(int geom) const { return hand_[static_cast<std::size_t>(geom)]; }
  bool IsTip(int geom) const { return tip_[static_cast<std::size_t>(geom)]; }
  bool IsThumb(int geom) const { return thumb_[static_cast<std::size_t>(geom)]; }
  const std::vector<int>& all() const { return all_; }
  int body() const { return body_; }  ///< root body of the hand

  /// Minimum distance between the thumb's and the fingers' tips [m] at the geoms' present poses.
  double Gap(const mjModel* model, mjData* data) const;

 private:
  int body_;
  std::vector<char> hand_, tip_, thumb_;
  std::vector<int> all_;
};

/// What touches an object.
struct Touch {
  bool hand = false;
  bool other = false;      ///< anything but the hand
  double deepest_m = 0.0;  ///< penetration at the hand's contacts
};
Touch TouchOf(const mjModel* model, const mjData* data, const HandGeoms& hand, int object_body);

}  // namespace rangegrasp::sim::internal
