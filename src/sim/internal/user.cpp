#include "sim/internal/user.h"

#include <mujoco/mujoco.h>

#include <algorithm>

#include "sim/internal/kinematics.h"

namespace rangegrasp::sim::internal {
namespace {

// Of a person's arm that takes something with care; the object follows it within centimetres.
constexpr double kStiffness_N_m = 250.0;
constexpr double kTurnStiffness_Nm_rad = 1.0;
// Critical damping of 0.4 kg, and of something 0.2 m long.
constexpr double kDamping_N_s_m = 20.0;
constexpr double kTurnDamping_Nm_s_rad = 0.03;
// Of the way that the object is drawn; it hangs behind the person's hand.
constexpr double kDone = 0.8;

}  // namespace

User::User(World& world, int object, const Eigen::Vector3d& direction_W, const UserOptions& options)
    : world_(world),
      object_(object),
      direction_W_(direction_W),
      options_(options),
      start_W_(world.ObjectCenterOfMass(object)),
      R_WO_(world.ObjectPose(object).linear()) {}

User::~User() {
  std::fill_n(world_.data()->xfrc_applied + 6 * world_.object_body(object_), 6, 0.0);
}

double User::Drawn() const {
  return (world_.ObjectCenterOfMass(object_) - start_W_).dot(direction_W_);
}

bool User::Done() const { return Drawn() > kDone * options_.draw_m; }

void User::Tick() {
  const Eigen::Vector3d& along = direction_W_;
  const double dt = world_.physics().timestep_s;
  // The force rises at its rate until it is the stated one; then the hand goes where the object
  // goes.
  const double rate_m_s = options_.force_N / options_.rise_s / kStiffness_N_m;
  const double most_m = Drawn() + options_.force_N / kStiffness_N_m;
  drawn_to_m_ = std::min({drawn_to_m_ + rate_m_s * dt, most_m, options_.draw_m});

  double velocity[6];  // turning, then moving, in W
  const int body = world_.object_body(object_);
  mj_objectVelocity(world_.model(), world_.data(), mjOBJ_BODY, body, velocity, 0);
  const Eigen::Vector3d goal_W = start_W_ + drawn_to_m_ * along;
  Eigen::Vector3d force_W = kStiffness_N_m * (goal_W - world_.ObjectCenterOfMass(object_)) -
                            kDamping_N_s_m * Vec3(velocity + 3) -
                            world_.ObjectMass(object_) * Vec3(world_.model()->opt.gravity);
  pull_N_ = force_W.dot(along);
  if (pull_N_ > options_.force_N) force_W += (options_.force_N - pull_N_) * along;
  pull_N_ = std::min(pull_N_, options_.force_N);
  const Eigen::AngleAxisd turned(R_WO_ * world_.ObjectPose(object_).linear().transpose());
  const Eigen::Vector3d torque_W = kTurnStiffness_Nm_rad * turned.angle() * turned.axis() -
                                   kTurnDamping_Nm_s_rad * Vec3(velocity);
  mjtNum* applied = world_.data()->xfrc_applied + 6 * body;
  for (int k = 0; k < 3; ++k) {
    applied[k] = force_W[k];
    applied[3 + k] = torque_W[k];
  }
}

}  // namespace rangegrasp::sim::internal
