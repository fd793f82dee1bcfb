// Each bound of the audit is exceeded by an execution with one fault in the physics, the arm or the
// hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "base/units.h"
#include "sim/grasp_program.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

using ::testing::StartsWith;

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Broken {
  World& world;
  GraspProgram& program;
  HandControlOptions& hand;
};
struct Fault {
  const char* name;
  const char* figure;                  ///< start of the audit's verdict
  double AuditBounds::*bound;          ///< bound of that figure; null if none
  std::function<void(Broken)> breaks;  ///< the fault
  const char* object = "dextrose";
  bool once_closed = false;  ///< applied then, else before the grasp
};

bool OfHand(const mjModel* model, int geom) { return model->geom_priority[geom] > 0; }

// Contacts of geoms have the time constant `time_s` instead of 5 ms.
template <class Predicate>
void Soften(mjModel* model, double time_s, const Predicate& of) {
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!of(geom)) continue;
    model->geom_solref[geom * mjNREF] = time_s;
    model->geom_priority[geom] += 2;
  }
}
void SoftenGlove(Broken broken) {
  mjModel* model = broken.world.model();
  Soften(model, 0.04, [&](int geom) { return OfHand(model, geom); });
}
void SoftenTable(Broken broken) {
  mjModel* model = broken.world.model();
  Soften(model, 0.2, [&](int geom) { return model->geom_type[geom] == mjGEOM_PLANE; });
}
// The gear between the fingers slips.
void SoftenCoupling(Broken broken) { broken.world.model()->eq_solref[0] = 0.1; }
// Removes the solver iterations that prevent creep.
void LetCreep(Broken broken) { broken.world.model()->opt.noslip_iterations = 0; }
// Friction is five times softer than the normal contact, and the hand does not sense slip.
void LetSlide(Broken broken) {
  LetCreep(broken);
  broken.world.model()->opt.impratio = 0.2;
  broken.hand.slip_control = false;
}
// The motor presses five times as hard as commanded.
void MisgearMotor(Broken broken) {
  mjModel* model = broken.world.model();
  for (int i = 0; i < model->nnumeric; ++i) {
    if (std::string(mj_id2name(model, mjOBJ_NUMERIC, i)).ends_with("grip_torque_per_force")) {
      model->numeric_data[model->numeric_adr[i]] *= 5.0;
    }
  }
  broken.hand.max_force_N = 20.0;
}
// The drives and joints of the arm have no damping.
void ShakeArm(Broken broken) {
  mjModel* model = broken.world.model();
  for (int i = 0; i < 7; ++i) model->actuator_biasprm[i * mjNBIAS + 2] = 0.0;
  std::fill_n(model->dof_damping, 7, 0.0);
}
// The wrist's drive can barely carry the box.
void WeakenArm(Broken broken) {
  mjtNum* range = broken.world.model()->jnt_actfrcrange + 2 * 5;
  range[0] = -1.5;
  range[1] = 1.5;
}
// The carry motion has a jump, as between two plans that do not connect.
void Jump(Broken broken) {
  auto& positions = broken.program.carry.positions;
  for (std::size_t i = positions.size() / 2; i < positions.size(); ++i) positions[i][0] += 0.2;
}
void SendNowhere(Broken broken) {
  broken.program.retreat.positions.back()[0] = std::numeric_limits<double>::quiet_NaN();
}
// Negative damping accelerates the box's motion.
void DriveBox(Broken broken) {
  const int dof = broken.world.model()->body_dofadr[broken.world.object_body(0)];
  std::fill_n(broken.world.model()->dof_damping + dof, 6, -20.0);
}

class BrokenPhysics : public ::testing::TestWithParam<Fault> {};

// A wall of 4 mm thickness on a foot, or a shipped object.
ObjectModel ModelOf(const std::string& name) {
  if (name != "wall") return samples::RepositoryObject(name);
  return samples::MakeObject(name, R"(
      <geom type="box" pos="0 0 -0.055" size="0.04 0.04 0.005" mass="0.1"/>
      <geom type="box" size="0.04 0.002 0.06" mass="0.1"/>)");
}

ExecutionLog ExecuteWith(const Fault& fault) {
  World world = samples::StandingAlone(samples::Tabletop(), ModelOf(fault.object));
  samples::HandMadeGrasp grasp;
  grasp.point_W = {0, 0, 0.1};
  grasp.yaw_rad = base::kPi / 2;
  grasp.pitch_rad = base::Deg(10.0);
  auto program = samples::MakeProgram(world, grasp);
  HandControlOptions hand;
  if (fault.breaks && !fault.once_closed) fault.breaks({world, program, hand});
  ExecutionObserver observer;
  observer.on_moment = [&](const std::string& moment, World&) {
    if (fault.once_closed && moment == "closed") fault.breaks({world, program, hand});
  };
  AuditBounds bounds;
  for (double AuditBounds::*bound :
       {&AuditBounds::penetration_p95_m, &AuditBounds::penetration_max_m,
        &AuditBounds::penetration_share, &AuditBounds::elsewhere_p95_m,
        &AuditBounds::elsewhere_max_m, &AuditBounds::creep_m_s, &AuditBounds::creep_rad_s,
        &AuditBounds::equality_share, &AuditBounds::grip_share, &AuditBounds::energy_gain_m,
        &AuditBounds::drive_limit_s, &AuditBounds::tracking_error_rad}) {
    if (fault.breaks && bound != fault.bound) bounds.*bound = kNever;
  }
  return Execute(world, 0, program, hand, bounds, base::Rng(1), observer);
}

// The other bounds are far away, so that this bound, at its default, determines the verdict.
TEST_P(BrokenPhysics, IsOutOfTheBoundOfTheAudit) {
  EXPECT_THAT(ExecuteWith(GetParam()).audit.failed, StartsWith(GetParam().figure));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, BrokenPhysics,
    ::testing::Values(
        Fault{"SoftGlove", "penetration_p95_m ", &AuditBounds::penetration_p95_m, SoftenGlove},
        Fault{"SofterGlove", "penetration_max_m ", &AuditBounds::penetration_max_m, SoftenGlove},
        Fault{"SoftGloveOnAWall", "penetration_share ", &AuditBounds::penetration_share,
              SoftenGlove, "wall"},
        Fault{"SoftTable", "elsewhere_p95_m ", &AuditBounds::elsewhere_p95_m, SoftenTable},
        Fault{"SofterTable", "elsewhere_max_m ", &AuditBounds::elsewhere_max_m, SoftenTable},
        Fault{"FrictionThatCreeps", "creep_m_s ", &AuditBounds::creep_m_s, LetCreep},
        Fault{"FrictionThatTurns", "creep_rad_s ", &AuditBounds::creep_rad_s, LetCreep},
        Fault{"FrictionThatLetsSlide", "unrest_s ", &AuditBounds::unrest_s, LetSlide},
        Fault{"SoftCoupling", "equality_share ", &AuditBounds::equality_share, SoftenCoupling},
        Fault{"MisgearedMotor", "grip_share ", &AuditBounds::grip_share, MisgearMotor},
        Fault{"ShakingArm", "energy_gain_j ", &AuditBounds::energy_gain_m, ShakeArm, "dextrose",
              true},
        Fault{"WeakArm", "drive_limit_s ", &AuditBounds::drive_limit_s, WeakenArm, "dextrose",
              true},
        Fault{"JumpingPlan", "tracking_error_rad ", &AuditBounds::tracking_error_rad, Jump},
        Fault{"DrivenBox", "unsolved_steps ", nullptr, DriveBox},
        Fault{"PlanThatIsNoNumber", "engine warnings", nullptr, SendNowhere}),
    [](const auto& tested) { return std::string(tested.param.name); });

// Without a fault, all bounds hold.
TEST(IntactPhysics, NothingBrokenIsWithinAllBounds) {
  for (const char* object : {"dextrose", "wall"}) {
    const ExecutionLog log = ExecuteWith({"", "", nullptr, nullptr, object});
    EXPECT_TRUE(log.held_after_carry) << object;
    EXPECT_EQ(log.audit.failed, "") << object;
    EXPECT_EQ(log.audit.repeated_steps, 0) << object;
  }
}

}  // namespace
}  // namespace rangegrasp::sim
