#pragma once

#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"

namespace rangegrasp::robot {

/// The hand as a caliper: one closing number moves all driven fingers; shapes and tool centres at
/// each closing. Sampled once from the hand's MJCF.
struct HandModel {
  /// One state of the hand, in its root body's frame H.
  struct State {
    double closing = 0.0;  ///< 0 open .. 1 closed (pads touch, or the end of the drives' way)
    double gap_m = 0.0;    ///< shortest distance from the thumb's to the fingers' last segments
    std::vector<geometry::Shape> shapes;  ///< all collision shapes of the hand (X_BS is X_HS here)
    std::vector<char>
        is_finger;  ///< one a shape: true for the pads and segments that may touch what is grasped
    std::vector<char> is_thumb;    ///< one a shape
    Eigen::Vector3d thumb_pad_H;   ///< the point of the thumb that meets the fingers when closed
    Eigen::Vector3d finger_pad_H;  ///< the mean of the fingers' points that meet the thumb
    /// The published tool centres: between the thumb's tip and the index finger's (cylindrical and
    /// rim grasps); between the thumb's and the middle of the index and the little finger's (power
    /// grasps). They move as the hand closes.
    Eigen::Vector3d tip_center_H;
    Eigen::Vector3d power_center_H;
  };
  std::vector<State> states;  ///< ascending closing, 24 of them
  /// Tool centre of the cylindrical and the rim grasp, of the open hand, pitch 0.
  base::Pose X_HG_tip = base::Pose::Identity();
  base::Pose X_HG_power = base::Pose::Identity();  ///< the same of the power grasp
  /// Held level, its approach straight: a hand without a pitch at which it was measured to hold
  /// best.
  bool level = false;
  double depth_m = 0.0;  ///< from the palm's front to the line of the tips

  double MaxGap() const { return states.front().gap_m; }
  /// The position of the state whose gap is nearest above gap_m (of the open one if none is).
  std::size_t IndexAtGap(double gap_m) const;
  const State& AtGap(double gap_m) const { return states[IndexAtGap(gap_m)]; }
};

/// @throws std::invalid_argument if there are no states, or they differ in their number of shapes.
void CheckStates(const HandModel& hand);

}  // namespace rangegrasp::robot
