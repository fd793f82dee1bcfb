#pragma once

#include <string>
#include <vector>

#include "base/frames.h"
#include "sim/execute.h"
#include "sim/internal/contacts.h"
#include "sim/internal/servo.h"

namespace rangegrasp::sim::internal {

/// Pose of the target in the hand's root body.
base::Pose PoseInHand(const World& world, const HandGeoms& hand, int target);

/// Gathers the audit's figures step by step.
class AuditRecorder {
 public:
  AuditRecorder(const World& world, const HandGeoms& hand, const ArmServo& servo, int target);

  /// Another object, before anything was held.
  void SetTarget(int target) { target_ = target; }
  /// After each step. Penetration and equality errors count while `holding`: from the closed hand
  /// to its release.
  /// @param free_motion  what the arm was commanded to, where it moves freely; else null
  void Step(bool holding, const JointCommand* free_motion);
  /// The rest after the lift: creep and energy are taken between these two calls.
  void BeginRest();
  /// @param disturbed  a fingertip slides, or the grip changes: the rest begins anew
  /// @return for how long it has lasted [s]
  double RestStep(bool disturbed);
  /// @param unrest_s  that went before
  void EndRest(double unrest_s);

  /// At the end of a hold. @param felt_N  by the pads of the side pressed less
  void RecordGrip(double felt_N, double strongest_N);

  /// What was gathered, with the first figure that is out of bounds.
  Audit Finish(const AuditBounds& bounds, bool held_after_lift, bool held_after_carry) const;
  /// Joints of the arm that came near their range's ends, or whose drives were at their limits.
  std::vector<std::string> JointsAtLimits() const;

 private:
  /// A contact of the hand with the target when the rest began, in the hand and in the object.
  struct RestingContact {
    Eigen::Vector3d point_H, normal_H, point_O;
  };

  double Energy() const;  ///< of the target, kinetic and potential [J]
  void LookAtJoints();
  double Thickness() const;  ///< of what the resting contacts hold; 0 if they are on one side [m]

  const World* world_;
  const HandGeoms* hand_;
  const ArmServo* servo_;
  int target_;
  int warnings_before_;
  SolverCounts solver_before_;
  std::vector<double> penetration_, elsewhere_;  // by step
  Audit audit_;
  std::vector<double> levers_;  // by equality
  std::vector<char> at_limit_;  // by the arm's joints
  base::Pose rest_pose_ = base::Pose::Identity();
  std::vector<RestingContact> rest_contacts_;
  double thickness_m_ = 0.0, rest_start_s_ = 0.0, rest_energy_ = 0.0;
};

}  // namespace rangegrasp::sim::internal
