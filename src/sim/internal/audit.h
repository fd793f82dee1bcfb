#pragma once

#include <vector>

#include "core/frames.h"
#include "sim/execute.h"
#include "sim/internal/contacts.h"
#include "sim/internal/servo.h"

namespace rangegrasp::sim::internal {

/// Pose of the target in the hand's root body.
core::Pose PoseInHand(const World& world, const HandGeoms& hand, int target);

/// Gathers the audit's figures step by step.
class AuditRecorder {
 public:
  AuditRecorder(const World& world, const HandGeoms& hand, const ArmServo& servo, int target);

  /// After each step. Penetration and equality errors count while `holding`: from the closed hand
  /// to its release.
  void Step(bool holding);
  /// The rest after the lift: creep and energy are taken between these two calls.
  void BeginRest();
  void RestStep(bool slides);
  void EndRest();

  /// What was gathered, with the first figure that is out of bounds. What describes a hold is
  /// reported but has no bound where the object was not held after the lift; creep neither where it
  /// was lost in the carry.
  Audit Finish(const AuditBounds& bounds, bool held_after_lift, bool held_after_carry) const;

 private:
  double Energy() const;  ///< of the target, kinetic and potential [J]

  const World* world_;
  const HandGeoms* hand_;
  const ArmServo* servo_;
  int target_;
  int warnings_before_;
  std::vector<double> penetration_;
  Audit audit_;
  core::Pose rest_pose_ = core::Pose::Identity();
  double rest_start_s_ = 0.0;
  double rest_energy_ = 0.0;
  bool slid_at_rest_ = false;
};

}  // namespace rangegrasp::sim::internal
