#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "grasp/hand_profiles.h"

namespace rangegrasp::grasp {

/// What the hand meets when it closes on a surface.
struct Closing {
  std::size_t state = 0;         ///< of the hand, nearest to the contact of both sides
  double gap_m = 0.0;            ///< of the pads when both sides touch
  double drag_m = 0.0;           ///< how far the first side to touch pushes the object, along x_T
  Eigen::Vector3d finger_T;      ///< middle of the fingers' contact
  Eigen::Vector3d thumb_T;       ///< middle of the thumb's contact
  Eigen::Vector3d finger_out_T;  ///< unit normal of the surface there, towards the fingers
  Eigen::Vector3d thumb_out_T;   ///< towards the thumb
  double contact_m2 =
      0.0;  ///< area of the surface within 3 mm of the fingers or the thumb (closing.cpp)
  double finger_spread_m = 0.0;  ///< lateral extent of the fingers' contact: 0 if one point touches
};

/// Closes the hand model on surface samples, as a caliper whose two sides move together: at every
/// state the fingers allow the object to lie at x >= a and the thumb at x <= b, where
///   a = max(finger(y, z) - x), b = min(thumb(y, z) - x)
/// over the samples between the open jaws. Both touch where a and b meet (bisection over the
/// states, then linear between two), and the object has been pushed to there. Samples outside of
/// the open jaws (the far wall of a cup) do not count.
/// @param points_A, normals_A  samples in a frame A whose axes are T's
/// @param origin_A  T's origin in A [m]
/// @param open_state  before closing
/// @return nullopt if one side meets nothing, or the open jaws do not clear the object.
/// O(log(states) n).
std::optional<Closing> CloseOn(HandProfiles& hand, double pitch_rad, std::size_t open_state,
                               std::span<const Eigen::Vector3d> points_A,
                               std::span<const Eigen::Vector3d> normals_A, double sample_area_m2,
                               const Eigen::Vector3d& origin_A);

/// The angle [rad] between a contact's inward normal and the line to the other contact. Two
/// contacts with friction hold a body if both angles are within the friction cone (Nguyen 1988).
struct AntipodalAngles {
  double finger_rad = 0.0;
  double thumb_rad = 0.0;
};
AntipodalAngles Antipodal(const Eigen::Vector3d& finger, const Eigen::Vector3d& finger_out,
                          const Eigen::Vector3d& thumb, const Eigen::Vector3d& thumb_out);

}  // namespace rangegrasp::grasp
