#include "sim/execute.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/linear_algebra.h"
#include "sim/internal/audit.h"
#include "sim/internal/contacts.h"
#include "sim/internal/engine.h"
#include "sim/internal/hand_controller.h"
#include "sim/internal/servo.h"

namespace rangegrasp::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using internal::PoseInHand;
using internal::Vec3;

// A person's arm that takes something carefully; the object follows it within centimetres.
constexpr double kStiffness_N_m = 250.0;
constexpr double kTurnStiffness_Nm_rad = 1.0;
// Critical damping of 0.4 kg, and of an object 0.2 m long.
constexpr double kDamping_N_s_m = 20.0;
constexpr double kTurnDamping_Nm_s_rad = 0.03;
// The forces are constant during a step, so springs and dampers on a light object have to be
// weaker: its frequency and the decay of its motion are at most these.
constexpr double kMaxFrequency_rad_s = 100.0;
constexpr double kMaxDecay_1_s = 300.0;
// Share of the pulling distance at which the pull is done; the object lags behind the hand.
constexpr double kDone = 0.8;

/// A person's hand on an object, modeled as a spring and a damper between the object's centre of
/// mass and a point that moves along a direction. Its force rises to the given value; it carries
/// the object's weight and keeps its orientation. It acts on the robot only through the object.
class User {
 public:
  /// Grasps the object where it is.
  /// @param direction_W  unit
  User(World& world, int object, const Vector3d& direction_W, const UserOptions& options)
      : world_(world),
        object_(object),
        direction_W_(direction_W),
        options_(options),
        start_W_(world.ObjectCenterOfMass(object)),
        R_WO_(world.ObjectPose(object).linear()) {
    const mjtNum* inertia = world.model()->body_inertia + 3 * world.object_body(object);
    const double least_kg_m2 = std::min({inertia[0], inertia[1], inertia[2]});
    const double stiffest_1_s2 = kMaxFrequency_rad_s * kMaxFrequency_rad_s;
    stiffness_ = std::min(kStiffness_N_m, stiffest_1_s2 * world.ObjectMass(object));
    damping_ = std::min(kDamping_N_s_m, kMaxDecay_1_s * world.ObjectMass(object));
    turn_stiffness_ = std::min(kTurnStiffness_Nm_rad, stiffest_1_s2 * least_kg_m2);
    turn_damping_ = std::min(kTurnDamping_Nm_s_rad, kMaxDecay_1_s * least_kg_m2);
  }
  /// Lets go.
  ~User() { std::fill_n(world_.data()->xfrc_applied + 6 * world_.object_body(object_), 6, 0.0); }
  User(const User&) = delete;
  User& operator=(const User&) = delete;

  double pull_N() const { return pull_N_; }  ///< along the direction, at the last tick
  bool Done() const { return Drawn() > kDone * options_.draw_m; }  ///< nearly all the way

  /// To be called once before each step.
  void Tick() {
    const Vector3d& along = direction_W_;
    const double dt = world_.physics().timestep_s;
    // The force rises at its rate to the given value; then the hand moves with the object.
    const double rate_m_s = options_.force_N / options_.rise_s / stiffness_;
    const double most_m = Drawn() + options_.force_N / stiffness_;
    drawn_to_m_ = std::min({drawn_to_m_ + rate_m_s * dt, most_m, options_.draw_m});

    double velocity[6];  // angular, then linear, in W
    const int body = world_.object_body(object_);
    mj_objectVelocity(world_.model(), world_.data(), mjOBJ_BODY, body, velocity, 0);
    const Vector3d goal_W = start_W_ + drawn_to_m_ * along;
    Vector3d force_W = stiffness_ * (goal_W - world_.ObjectCenterOfMass(object_)) -
                       damping_ * Vec3(velocity + 3) -
                       world_.ObjectMass(object_) * Vec3(world_.model()->opt.gravity);
    pull_N_ = force_W.dot(along);
    if (pull_N_ > options_.force_N) force_W += (options_.force_N - pull_N_) * along;
    pull_N_ = std::min(pull_N_, options_.force_N);
    const Eigen::AngleAxisd turned =
        base::TurnOf(R_WO_ * world_.ObjectPose(object_).linear().transpose());
    const Vector3d torque_W =
        turn_stiffness_ * turned.angle() * turned.axis() - turn_damping_ * Vec3(velocity);
    Eigen::Map<Eigen::Vector<mjtNum, 6>>(world_.data()->xfrc_applied + 6 * body) << force_W,
        torque_W;
  }

 private:
  // Distance that the object has moved along the direction [m].
  double Drawn() const { return (world_.ObjectCenterOfMass(object_) - start_W_).dot(direction_W_); }

  World& world_;
  int object_;
  Vector3d direction_W_;
  UserOptions options_;
  Vector3d start_W_;  ///< of the object's centre of mass
  Matrix3d R_WO_;     ///< when the object was grasped
  double stiffness_, damping_, turn_stiffness_, turn_damping_;
  double drawn_to_m_ = 0.0;  ///< position of the person's hand along the direction
  double pull_N_ = 0.0;
};

// Simulated times. Limits end motions that do not end by themselves; larger ones only cost time.
constexpr double kPreshapeLimit_s = 2.0;  // the whole range takes 0.35 s at the closing speed
constexpr double kCloseLimit_s = 2.5;     // the same, with the rise of the force (0.2 s)
constexpr double kOpenLimit_s = 1.0;
constexpr double kRestLimit_s = 3.0;  // for the released object
// Waiting times for the arm, which lags at the end of a motion.
constexpr double kApproachSettle_s = 0.10;
constexpr double kClosedHold_s = 0.15;  // the coupled hand drags the object until both sides grip
constexpr double kLiftSettle_s = 0.30;
constexpr double kCarrySettle_s = 0.10;
// The drives feel a contact if a joint lags its command by this much; free motions lag by at most
// 0.003 rad. The wrist's drives then push with about 20 N at the hand.
constexpr double kFelt_rad = 0.005;
// A change of the force on the resting hand, as the drives feel it, that counts as a pull. A
// swinging object changes it by less than 1 N. With a larger value a gentle person pulls in vain;
// with a smaller one the stiction of real gears matters.
constexpr double kPull_N = 5.0;
// The drives of a stretched arm do not feel a force along the arm, so a lever of this length is
// added in all directions.
constexpr double kMinLever_m = 0.05;
// Pulling an object out of the open hand takes 0.6 s.
constexpr double kDrawLimit_s = 2.0;
// The command of a yielding arm stays this close to its joints, so that it feels nothing yet, and
// each drive gives at most this share of its torque.
constexpr double kGives_rad = 0.004;
constexpr double kGivesShare = 0.9;
// A joint lag of this size in free motion ends the grasp, as a real arm's drives would. It is below
// the audit's bound by what a joint moves in a step or two.
constexpr double kBlocked_rad = 0.008;
// In the lift, which may push neighbors, drives at their limits may lag by this much: 6 deg, or 30
// mm at the hand for the wrist. With a larger lag, the object is stuck.
constexpr double kStuck_rad = 0.1;
// Time in which an arm that was stopped returns to its planned path.
constexpr double kRejoin_s = 1.0;
// The arm lags by at most 3 mrad at the end of a motion, and its servos are critically damped.
constexpr double kMoveSettle_s = 0.3;
// Time over which creep is measured: 200 steps of 2 ms. At its bound, an object creeps 40 um in it.
constexpr double kRest_s = 0.40;
// The target is lost if the hand does not touch it for this long; contacts chatter for less.
constexpr double kLost_s = 0.10;
// An object rests if it is slower than this for this long (as in World::Settle).
constexpr double kRestSpeed_m_s = 0.002;
constexpr double kRestTime_s = 0.2;

class Execution {
 public:
  Execution(World& world, int target, const GraspProgram& program, const HandControlOptions& hand,
            const AuditBounds& bounds, base::Rng rng, const ExecutionObserver& observer)
      : world_(world),
        target_(target),
        program_(program),
        bounds_(bounds),
        observer_(observer),
        hand_(world.model()),
        servo_(world.model()),
        controller_(world, hand_, hand),
        glove_(world, hand_, target),
        slip_sensor_(hand, rng),
        audit_(world, hand_, servo_, target),
        start_s_(world.time_s()),
        command_(internal::StayAt(world.ArmPositions())) {}

  ExecutionLog Run() {
    Grasp();
    if (!blocked_) Lift();
    if (GoesOn(log_.held_after_lift, log_.aperture.feels_object_after_lift)) Carry();
    if (GoesOn(log_.held_after_carry, log_.aperture.feels_object_after_carry)) {
      program_.user ? HandOver() : Deliver();
    }
    if (ByAperture() && holding_) LetGo();
    Finish();
    Moment("end");
    return log_;
  }

 private:
  bool ByAperture() const { return program_.ends_by == EndsBy::kAperture; }
  bool GoesOn(bool held, bool felt) const { return !blocked_ && (ByAperture() ? felt : held); }

  void Grasp() {
    controller_.Preshape(program_.opening_m);
    stage_ = "reach";
    FollowToTheEnd(program_.reach, "reach");
    if (blocked_) return;
    for (double t = 0.0; !controller_.Preshaped() && t < kPreshapeLimit_s; t += Period()) Tick();
    stage_ = "approach";
    if (!Follow(program_.approach, Motion::kGuarded)) {
      log_.stopped_by_contact.emplace_back("approach");
    }
    Wait(kApproachSettle_s);
    Moment("pregrasp");
    log_.tracking_error_m = (HandNow() - HandAt(command_.position)).norm();
    stage_ = "close";
    controller_.Close(program_.firm);
    GiveWayUntil([&] { return controller_.Gripping() || controller_.FullyClosed(); },
                 kCloseLimit_s);
    GiveWayUntil([] { return false; }, kClosedHold_s);
    Moment("closed");
    if (ByAperture()) LookWhatIsHeld();
    closed_pose_ = PoseInHand(world_, hand_, target_);
    up_O_ = world_.ObjectPose(target_).linear().row(2);
    center_before_ = world_.ObjectCenterOfMass(target_);
    holding_ = true;
  }

  // The hand may hold another object than its target; the figures are about the held one.
  void LookWhatIsHeld() {
    double hardest_N = 0.0;
    for (int object = 0; object < world_.objects(); ++object) {
      const double pressure_N = internal::PressureOn(world_, hand_, object);
      if (world_.parked(object) || pressure_N <= hardest_N) continue;
      hardest_N = pressure_N;
      target_ = object;
    }
    audit_.SetTarget(target_);
  }

  void Lift() {
    stage_ = "lift";
    FollowToTheEnd(program_.lift, "lift", Motion::kPushing);
    Wait(kLiftSettle_s);
    if (ByAperture() ? !controller_.FeelsEmpty() : TouchNow().hand) Rest();
    log_.lift_height_m = world_.ObjectCenterOfMass(target_).z() - center_before_.z();
    log_.held_after_lift = !blocked_ && HeldNow();
    log_.aperture.lifted_rad = controller_.Aperture();
    log_.aperture.feels_object_after_lift = !controller_.FeelsEmpty();
    RecordHold();
    carrying_ = true;
    Moment("lifted");
  }

  void Rest() {
    const double start_s = world_.time_s();
    double force_N = controller_.force_N();
    double rest_s = 0.0;
    audit_.BeginRest();
    while (!blocked_ && !lost_ && rest_s < kRest_s &&
           world_.time_s() - start_s < bounds_.unrest_s + kRest_s) {
      Tick();
      rest_s = audit_.RestStep(glove_.Slides() || controller_.force_N() != force_N);
      force_N = controller_.force_N();
    }
    audit_.EndRest(world_.time_s() - start_s - (rest_s < kRest_s ? 0.0 : rest_s));
  }

  void Carry() {
    stage_ = "carry";
    FollowToTheEnd(program_.carry, "carry", Motion::kRejoining);
    Wait(kCarrySettle_s);
    log_.held_after_carry = !blocked_ && HeldNow();
    log_.aperture.carried_rad = controller_.Aperture();
    log_.aperture.feels_object_after_carry = !controller_.FeelsEmpty();
    RecordHold();
    carrying_ = false;
  }

  // An object that is already lost keeps the values from when it was lost.
  void RecordHold() {
    if (lost_) return;
    log_.grip_force_N = controller_.force_N();
    log_.felt_force_N = controller_.FeltForce();
    audit_.RecordGrip(log_.felt_force_N, controller_.strongest_N());
    log_.slips_heard = controller_.slips_heard();
    const base::Pose X_moved = closed_pose_.inverse() * PoseInHand(world_, hand_, target_);
    log_.tilt_in_hand_rad = base::TurnOf(X_moved.linear()).angle();
    log_.slip_in_hand_m = X_moved.translation().norm();
  }

  void RecordLean() {
    const double cosine = world_.ObjectPose(target_).linear().row(2).dot(up_O_);
    log_.lean_rad = std::max(log_.lean_rad, std::acos(std::clamp(cosine, -1.0, 1.0)));
  }

  Vector3d HandNow() { return internal::BodyPose(world_.data(), hand_.body()).translation(); }

  // Position of the hand's root body in W at joint positions; the world's own kinematics stay.
  Vector3d HandAt(const VectorXd& q) {
    const mjModel* model = world_.model();
    const internal::DataPtr copy(mj_makeData(model));
    std::copy_n(world_.data()->qpos, model->nq, copy->qpos);
    internal::SetJoints(model, copy.get(), servo_.joints(), q.data());
    mj_kinematics(model, copy.get());
    return internal::BodyPose(copy.get(), hand_.body()).translation();
  }

  void Deliver() {
    stage_ = "deliver";
    if (!Follow(program_.lower, Motion::kGuarded)) {
      log_.stopped_by_contact.emplace_back("lower");
    }
    GiveWayUntil([this] { return Ended(); }, kCarrySettle_s);
    Moment("delivered");
    LetGo();
    FollowToTheEnd(program_.retreat, "retreat");
    double rest_since_s = world_.time_s();
    for (double t = 0.0; t < kRestLimit_s && world_.time_s() - rest_since_s < kRestTime_s;
         t += Period()) {
      Tick();
      if (world_.ObjectSpeed(target_) >= kRestSpeed_m_s) rest_since_s = world_.time_s();
    }
  }

  // The arm feels the pull in its drives' torques; then the hand lets go.
  void HandOver() {
    stage_ = "hand over";
    const UserOptions& options = *program_.user;
    HandOverLog& log = log_.hand_over.emplace();
    const VectorXd before = servo_.Torques(world_.data());
    const auto pulls = [&] { return FeltForce(before).norm() > kPull_N; };
    for (double t = 0.0; !lost_ && t < options.wait_s; t += Period()) {
      Tick();
      log.early = log.early || pulls();
    }
    Moment("waits");
    if (lost_) return;
    user_.emplace(world_, target_,
                  internal::BodyPose(world_.data(), hand_.body()).linear() * options.direction_H,
                  options);
    const double start_s = world_.time_s();
    while (!log.felt && !lost_ && world_.time_s() - start_s < options.rise_s + options.patience_s) {
      Tick();
      log.felt = pulls();
      log.felt_N = user_->pull_N();
    }
    log.felt_s = world_.time_s() - start_s;
    Moment("pulled");
    if (log.felt) LetGo();
    for (double t = 0.0; log.felt && t < kDrawLimit_s && !user_->Done(); t += Period()) Tick();
    log.taken = user_->Done() && !TouchNow().hand;
    Moment("taken");
    user_.reset();
  }

  // The force f on the hand that best explains the change -J^T f of the drives' torques at rest,
  // where J is the Jacobian of the tool's centre.
  Vector3d FeltForce(const VectorXd& before) const {
    const VectorXd change = servo_.Torques(world_.data()) - before;
    const Eigen::Matrix3Xd J =
        internal::JacobianOf(world_.model(), world_.data(), servo_.joints(), hand_.body(),
                             world_.SitePose("tcp").translation());
    const Matrix3d levers = J * J.transpose() + kMinLever_m * kMinLever_m * Matrix3d::Identity();
    return -base::SolveLdlt<3, 1>(levers, J * change);
  }

  void LetGo() {
    holding_ = false;
    controller_.Open();
    for (double t = 0.0; !controller_.FullyOpen() && t < kOpenLimit_s; t += Period()) Tick();
  }

  void Finish() {
    log_.target = target_;
    const Vector3d center = world_.ObjectCenterOfMass(target_);
    const Vector3d place = world_.SitePose("delivery").translation();
    const internal::Touch touch = TouchNow();
    log_.final_distance_m = (center - place).head<2>().norm();
    log_.at_rest = world_.ObjectSpeed(target_) < kRestSpeed_m_s;
    log_.touched_by_hand = touch.hand;
    // Contacts of a sleeping object are not listed. An object that is at rest over the table and
    // free of the hand therefore rests on the table, if there is one below it.
    log_.on_support =
        log_.at_rest && !touch.hand && center.z() > place.z() && world_.OverTable(center);
    log_.simulated_s = world_.time_s() - start_s_;
    log_.joints_at_limits = audit_.JointsAtLimits();
    log_.audit = audit_.Finish(bounds_, log_.held_after_lift, log_.held_after_carry);
  }

  // An arm that was stopped keeps its offset from the plan, or it would push once more against the
  // obstacle; only kRejoining returns to the plan.
  enum class Motion {
    kFree,       // nothing may be in the way
    kRejoining,  // the same
    kPushing,    // neighbors may be in the way and are pushed aside
    kGuarded,    // ends when it touches something
  };
  // By Motion.
  static constexpr double kLimit_rad[] = {kBlocked_rad, kBlocked_rad, kStuck_rad, kFelt_rad};

  // @return false if the drives felt an obstacle.
  bool Follow(const base::JointTrajectory& trajectory, Motion motion) {
    if (trajectory.positions.empty()) return true;
    const bool rejoins = motion == Motion::kRejoining;
    const bool moves_freely = rejoins || motion == Motion::kFree;
    const VectorXd offset = command_.position - trajectory.positions.front();
    const double start = world_.time_s();
    const double duration = trajectory.Duration();
    while (!Ended() && world_.time_s() - start < duration) {
      const double t = world_.time_s() - start + Period();
      command_ = internal::CommandAt(trajectory, t);
      command_.position += (rejoins ? std::max(0.0, 1.0 - t / kRejoin_s) : 1.0) * offset;
      Tick(moves_freely);
      const VectorXd lags_rad = servo_.Lags(world_.data(), command_);
      const double lag_rad = lags_rad.maxCoeff();
      if (moves_freely || (!holding_ && !TouchNow().hand)) {
        if (log_.lags_rad.size() == 0) log_.lags_rad = lags_rad;
        log_.lags_rad = log_.lags_rad.cwiseMax(lags_rad);
      }
      if (motion == Motion::kPushing) log_.lift_lag_rad = std::max(log_.lift_lag_rad, lag_rad);
      if (lag_rad > kLimit_rad[static_cast<int>(motion)]) {
        command_.velocity.setZero();
        return false;
      }
    }
    command_.velocity.setZero();
    return true;
  }

  // A motion that must be completed; if it is not, the grasp has failed.
  void FollowToTheEnd(const base::JointTrajectory& trajectory, const char* name,
                      Motion motion = Motion::kFree) {
    if (Follow(trajectory, motion)) return;
    log_.stopped_by_contact.emplace_back(name);
    blocked_ = true;
    command_.position = world_.ArmPositions();  // stops pushing
  }

  // A hand that closes on a fixed object, such as one that leans on a wall, pushes the arm along.
  template <class Done>
  void GiveWayUntil(const Done& done, double limit_s) {
    for (double t = 0.0; !done() && t < limit_s; t += Period()) {
      Tick();
      const VectorXd q = world_.ArmPositions();
      command_.position = command_.position.cwiseMin((q.array() + kGives_rad).matrix())
                              .cwiseMax((q.array() - kGives_rad).matrix());
      servo_.GiveWay(world_.data(), kGivesShare, command_.position);
    }
  }

  void Wait(double duration_s) {
    for (double t = 0.0; !Ended() && t < duration_s; t += Period()) Tick();
  }

  void Tick(bool moves_freely = false) {
    if (user_) user_->Tick();
    servo_.Command(world_.data(), command_);
    glove_.Tick(world_);
    controller_.Tick(slip_sensor_.Tick(world_.time_s(), glove_.PadSpeed()), glove_.Load_W());
    world_.Step();
    audit_.Step(holding_, moves_freely ? &command_ : nullptr);
    if (holding_) {
      untouched_s_ = TouchNow().hand ? 0.0 : untouched_s_ + Period();
      if (untouched_s_ > kLost_s) {
        RecordHold();
        lost_ = true;
      }
      if (!lost_) RecordLean();
      empty_s_ = ByAperture() && controller_.FeelsEmpty() ? empty_s_ + Period() : 0.0;
    }
    Frame();
  }

  // An empty hand goes on until the lift has ended, because it has to leave the objects.
  bool Ended() const { return ByAperture() ? carrying_ && empty_s_ > kLost_s : lost_; }

  void Frame() {
    if (observer_.frame_period_s <= 0.0 || !observer_.on_moment) return;
    if (world_.time_s() < next_frame_s_) return;
    next_frame_s_ = world_.time_s() + observer_.frame_period_s - 0.5 * Period();
    Moment("frame");
  }

  void Moment(const std::string& moment) {
    if (observer_.on_state) observer_.on_state(StateNow());
    if (observer_.on_moment) observer_.on_moment(moment, world_);
  }

  // The displacement in the hand keeps its last value after an object was released or lost.
  ExecutionState StateNow() {
    if (holding_ && !lost_) {
      slip_m_ = (closed_pose_.inverse() * PoseInHand(world_, hand_, target_)).translation().norm();
    }
    return {.stage = stage_,
            .time_s = world_.time_s(),
            .target = target_,
            .force_N = controller_.force_N(),
            .felt_N = controller_.FeltForce(),
            .slip_m = slip_m_};
  }

  internal::Touch TouchNow() const { return internal::TouchOf(world_, hand_, target_); }
  bool HeldNow() const {
    const internal::Touch touch = TouchNow();
    return !lost_ && touch.hand && !touch.other;
  }
  double Period() const { return world_.physics().timestep_s; }

  World& world_;
  int target_;
  const GraspProgram& program_;
  const AuditBounds& bounds_;
  const ExecutionObserver& observer_;
  const internal::HandGeoms hand_;
  const internal::ArmServo servo_;
  internal::HandController controller_;
  internal::Glove glove_;
  internal::SlipSensor slip_sensor_;
  internal::AuditRecorder audit_;
  const double start_s_;

  std::optional<User> user_;  ///< exists from grasping the object until taking it

  ExecutionLog log_;
  internal::JointCommand command_;
  base::Pose closed_pose_ = base::Pose::Identity();
  Vector3d up_O_ = Vector3d::UnitZ();  // of the target, when the hand closed
  Vector3d center_before_ = Vector3d::Zero();
  bool holding_ = false, carrying_ = false;
  bool lost_ = false, blocked_ = false;
  double untouched_s_ = 0.0, empty_s_ = 0.0, next_frame_s_ = 0.0;
  std::string stage_;    // for viewers
  double slip_m_ = 0.0;  // for viewers
};

}  // namespace

MoveLog MoveArm(World& world, const base::JointTrajectory& trajectory) {
  const internal::ArmServo servo(world.model());
  const double start_s = world.time_s();
  MoveLog log;
  double lag_rad = 0.0;
  const auto step = [&](const internal::JointCommand& command) {
    servo.Command(world.data(), command);
    world.Step();
    lag_rad = servo.Lags(world.data(), command).maxCoeff();
  };
  while (lag_rad <= kBlocked_rad && world.time_s() - start_s < trajectory.Duration()) {
    step(internal::CommandAt(trajectory, world.time_s() - start_s + world.physics().timestep_s));
    log.lag_rad = std::max(log.lag_rad, lag_rad);
  }
  log.arrived = log.lag_rad <= kBlocked_rad;
  // A stopped arm no longer pushes.
  const auto rest =
      internal::StayAt(log.arrived ? trajectory.positions.back() : world.ArmPositions());
  for (const double rest_s = world.time_s(); world.time_s() - rest_s < kMoveSettle_s;) step(rest);
  log.simulated_s = world.time_s() - start_s;
  return log;
}

ExecutionLog Execute(World& world, int target, const GraspProgram& program,
                     const HandControlOptions& hand, const AuditBounds& bounds, base::Rng rng,
                     const ExecutionObserver& observer) {
  if (target < 0 || target >= world.objects() || world.parked(target)) {
    throw std::invalid_argument(fmt::format("Execute: object {} is not in the world", target));
  }
  return Execution(world, target, program, hand, bounds, rng, observer).Run();
}

}  // namespace rangegrasp::sim
