#pragma once

#include <string>
#include <vector>

#include "base/frames.h"
#include "sim/execute.h"
#include "sim/internal/contacts.h"
#include "sim/internal/servo.h"

namespace rangegrasp::sim::internal {

/// Pose of the target in the frame of the hand's root body.
base::Pose PoseInHand(const World& world, const HandGeoms& hand, int target);

/// Collects the audit's figures step by step.
class AuditRecorder {
 public:
  AuditRecorder(const World& world, const HandGeoms& hand, const ArmServo& servo, int target);

  /// Changes the target, before anything was held.
  void SetTarget(int target) { target_ = target; }
  /// To be called after each step. Penetration and equality errors count while `holding`: from the
  /// closed hand to its release.
  /// @param free_motion  the arm's command while it moves freely; else null
  void Step(bool holding, const JointCommand* free_motion);
  /// Starts the rest after the lift. Creep and energy are measured from here to EndRest.
  void BeginRest();
  /// @param disturbed  a fingertip slides or the grip changes; the rest then restarts
  /// @return duration of the rest so far [s]
  double RestStep(bool disturbed);
  /// @param unrest_s  time before the rest
  void EndRest(double unrest_s);

  /// To be called at the end of a hold.
  /// @param felt_N  force on the pads of the less loaded side
  void RecordGrip(double felt_N, double strongest_N);

  /// The collected figures, with the first one that is out of bounds.
  Audit Finish(const AuditBounds& bounds, bool held_after_lift, bool held_after_carry) const;
  /// Joints of the arm that came near an end of their range, or whose drives were at their limits.
  std::vector<std::string> JointsAtLimits() const;

 private:
  /// A contact of the hand with the target when the rest began, in the frames of hand and object.
  struct RestingContact {
    Eigen::Vector3d point_H, normal_H, point_O;
  };

  double Energy() const;  ///< kinetic and potential energy of the target [J]
  void LookAtJoints();
  double Thickness() const;  ///< between the resting contacts; 0 if they are on one side [m]

  const World* world_;
  const HandGeoms* hand_;
  const ArmServo* servo_;
  int target_;
  int warnings_before_;
  SolverCounts solver_before_;
  std::vector<double> penetration_, elsewhere_;  // by step
  Audit audit_;
  std::vector<double> levers_;  // by equality constraint
  std::vector<char> at_limit_;  // by joint of the arm
  base::Pose rest_pose_ = base::Pose::Identity();
  std::vector<RestingContact> rest_contacts_;
  double thickness_m_ = 0.0, rest_start_s_ = 0.0, rest_energy_ = 0.0;
};

}  // namespace rangegrasp::sim::internal
