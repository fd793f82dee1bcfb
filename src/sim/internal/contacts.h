#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

namespace rangegrasp::sim::internal {

/// Tangential speed of a contact [m/s]; negative if it is none that can bear load.
double SlipSpeed(const mjModel* model, const mjData* data, const mjContact& contact);
/// Normal force of contact number i [N].
double NormalForce(const mjModel* model, const mjData* data, int i);

/// The hand's collision geoms and what they are.
class HandGeoms {
 public:
  /// @throws base::InputError naming the body or tuple that the scene lacks ("hand", "hand_joints",
  /// "fingertips"), or a
  /// grip sensor that is no touch sensor.
  explicit HandGeoms(const mjModel* model);

  bool IsHand(int geom) const { return hand_[static_cast<std::size_t>(geom)]; }
  bool IsTip(int geom) const { return tip_[static_cast<std::size_t>(geom)]; }
  bool IsThumb(int geom) const { return thumb_[static_cast<std::size_t>(geom)]; }
  bool IsThumbBody(int body) const { return thumb_body_[static_cast<std::size_t>(body)]; }
  /// The distal pads: the geoms of the bodies whose touch sensors "grip_sensors" names. A hand
  /// without them feels nothing.
  bool IsPad(int geom) const { return pad_[static_cast<std::size_t>(geom)]; }
  const std::vector<int>& touch_sensors() const { return touch_sensors_; }
  const std::vector<int>& all() const { return all_; }
  int body() const { return body_; }  ///< root body of the hand

  /// Minimum distance between the thumb's and the fingers' tips [m] at the geoms' present poses.
  double Gap(const mjModel* model, mjData* data) const;

 private:
  int body_;
  std::vector<char> hand_, tip_, thumb_, pad_;
  std::vector<char> thumb_body_;  // by body
  std::vector<int> touch_sensors_;
  std::vector<int> all_;
};

/// What touches an object.
struct Touch {
  bool hand = false;
  bool other = false;      ///< anything but the hand
  double deepest_m = 0.0;  ///< penetration at the hand's contacts
};
/// A contact of the hand with an object: in the middle between the two surfaces.
struct ContactPoint {
  Eigen::Vector3d point_W;
  Eigen::Vector3d normal_W;
};
std::vector<ContactPoint> ContactsOf(const mjModel* model, const mjData* data,
                                     const HandGeoms& hand, int object_body);
/// Sum of the normal forces of the hand's contacts with an object [N].
double PressureOn(const mjModel* model, const mjData* data, const HandGeoms& hand, int object_body);
Touch TouchOf(const mjModel* model, const mjData* data, const HandGeoms& hand, int object_body);

}  // namespace rangegrasp::sim::internal
