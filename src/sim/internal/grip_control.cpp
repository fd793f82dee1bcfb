#include "sim/internal/grip_control.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::sim::internal {
namespace {

// Of the pre-shape, in the air, a share of the motor's damping: the hand follows the ramp by 0.09
// rad, and the passive fingers' springs (two of 0.1 Nm/rad, over 0.75 rad) move it by 1 mrad. A
// motor without damping has the least one.
constexpr double kPositionRate_1_s = 25.0;
constexpr double kLeastPositionGain_Nm_rad = 15.0;
// While the hand moves, the motor's current is limited to this share of the first grip: what it
// meets is shoved with 10 N, and not with what the motor has.
constexpr double kMovingShare = 0.25;
// What a side must press to feel it: a twentieth of the weakest grip, above what the fingers'
// blow on the air gives, which is none. Larger shoves light objects further before the grip.
constexpr double kFelt_N = 0.5;
// The motor stalls that turns slowly for this long: long enough for the start, when it turns slowly
// too.
constexpr double kStallTime_s = 0.06;
// The force rises from touch to the first grip of 40 N in 0.12 s. Faster is a blow.
constexpr double kForceRate_N_s = 250.0;
// The first grip stands this long before slip is listened to: closing itself slides.
constexpr double kFirstGripHold_s = 0.05;
// One detection of slip in this time at most, so that a force has time to act before the next.
constexpr double kSlipPeriod_s = 0.04;

}  // namespace

void GripControl::Preshape(double from_rad, double to_rad) {
  mode_ = Mode::kPreshape;
  target_rad_ = to_rad;
  commanded_rad_ = from_rad;
}

void GripControl::Close(bool firm) {
  mode_ = Mode::kClosing;
  first_force_N_ = firm ? drive_.max_force_N : drive_.first_force_N;
  stalled_s_ = 0.0;
  force_N_ = 0.0;
}

void GripControl::Open() {
  mode_ = Mode::kOpening;
  force_N_ = 0.0;
}

bool GripControl::Gripping() const {
  return mode_ == Mode::kGripping && gripping_s_ >= kFirstGripHold_s;
}

double GripControl::Tick(const HandReading& reading) {
  const double step_rad = options_.closing_speed_rad_s * timestep_s_;
  switch (mode_) {
    case Mode::kPreshape:
      commanded_rad_ += std::clamp(target_rad_ - commanded_rad_, -step_rad, step_rad);
      return std::max(kLeastPositionGain_Nm_rad, kPositionRate_1_s * drive_.damping_Nm_s) *
             (commanded_rad_ - reading.angle_rad);
    case Mode::kClosing:
      return TickClosing(reading);
    case Mode::kGripping:
      return TickGripping(reading.slips);
    case Mode::kOpening:
      break;
  }
  return -MovingTorque(-reading.speed_rad_s);
}

double GripControl::moving_force_N() const { return kMovingShare * drive_.first_force_N; }

// Runs free at the closing speed, and stalls at the limit of the current.
double GripControl::MovingTorque(double speed_rad_s) const {
  const double limit_Nm = moving_force_N() * drive_.torque_per_force_Nm_N;
  const double free_Nm = drive_.damping_Nm_s * options_.closing_speed_rad_s;
  return std::min(limit_Nm + drive_.damping_Nm_s * std::max(0.0, speed_rad_s),
                  std::max(limit_Nm, free_Nm));
}

double GripControl::TickClosing(const HandReading& reading) {
  const bool both_sides = reading.thumb_N > kFelt_N && reading.fingers_N > kFelt_N;
  if (both_sides || Stalls(reading.speed_rad_s)) {
    mode_ = Mode::kGripping;
    force_N_ = std::min(first_force_N_, moving_force_N());
    gripping_s_ = since_slip_s_ = 0.0;
  }
  return MovingTorque(reading.speed_rad_s);
}

bool GripControl::Stalls(double speed_rad_s) {
  stalled_s_ = std::abs(speed_rad_s) < drive_.stall_speed_rad_s ? stalled_s_ + timestep_s_ : 0.0;
  return stalled_s_ > kStallTime_s;
}

double GripControl::TickGripping(bool slips) {
  if (force_N_ < first_force_N_) {
    force_N_ = std::min(first_force_N_, force_N_ + kForceRate_N_s * timestep_s_);
  } else {
    gripping_s_ += timestep_s_;
    since_slip_s_ += timestep_s_;
    if (options_.slip_control && slips && Gripping() && since_slip_s_ >= kSlipPeriod_s) {
      force_N_ += options_.slip_gain_N;
      ++slips_heard_;
      since_slip_s_ = 0.0;
    }
  }
  force_N_ = std::clamp(force_N_, options_.min_force_N, drive_.max_force_N);
  return force_N_ * drive_.torque_per_force_Nm_N;
}

double Ratchet(double lower_rad, double upper_rad, double angle_rad, double backlash_rad) {
  return std::max(lower_rad, std::min(angle_rad - backlash_rad, upper_rad));
}

}  // namespace rangegrasp::sim::internal
