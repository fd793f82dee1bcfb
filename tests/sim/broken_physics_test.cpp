// Each bound of the audit is reached by an execution in which one thing is broken: the physics, the
// arm or the hand.

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
  const char* figure;                  ///< with which the audit's verdict begins
  double AuditBounds::*bound;          ///< of that figure; null if it has none
  std::function<void(Broken)> breaks;  ///< one thing
  const char* object = "dextrose";
};

bool OfHand(const mjModel* model, int geom) { return model->geom_priority[geom] > 0; }

// Contacts of geoms give way in `time_s` instead of 5 ms.
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
  Soften(model, 0.06, [&](int geom) { return OfHand(model, geom); });
}
void SoftenTable(Broken broken) {
  mjModel* model = broken.world.model();
  Soften(model, 0.2, [&](int geom) { return model->geom_type[geom] == mjGEOM_PLANE; });
}
// The gear between the fingers slips.
void SoftenCoupling(Broken broken) { broken.world.model()->eq_solref[0] = 0.1; }
// Friction that gives way, as soft as contact.
void SoftenFriction(Broken broken) {
  broken.world.model()->opt.noslip_iterations = 0;
  broken.world.model()->opt.impratio = 1.0;
}
void LetSlide(Broken broken) {
  SoftenFriction(broken);
  broken.world.model()->opt.impratio = 0.2;
  broken.hand.slip_control = false;
}
// The motor presses five times as hard as it is told to.
void MisgearMotor(Broken broken) {
  mjModel* model = broken.world.model();
  for (int i = 0; i < model->nnumeric; ++i) {
    if (std::string(mj_id2name(model, mjOBJ_NUMERIC, i)).ends_with("grip_torque_per_force")) {
      model->numeric_data[model->numeric_adr[i]] *= 5.0;
    }
  }
  broken.hand.max_force_N = 20.0;
}
// The explicit integrator makes the arm buzz.
void BuzzArm(Broken broken) { broken.world.model()->opt.integrator = mjINT_EULER; }
void WeakenArm(Broken broken) {
  mjtNum* range = broken.world.model()->jnt_actfrcrange + 2 * 1;
  range[0] = -3.0;
  range[1] = 3.0;
}
// The carry has a jump, as between two plans that do not meet.
void Jump(Broken broken) {
  auto& positions = broken.program.carry.positions;
  for (std::size_t i = positions.size() / 2; i < positions.size(); ++i) positions[i][0] += 0.05;
}
void StopSolverEarly(Broken broken) { broken.world.model()->opt.iterations = 1; }
// Friction of the joints of the box on nothing that drives it.
void DriveBox(Broken broken) {
  const int dof = broken.world.model()->body_dofadr[broken.world.object_body(0)];
  std::fill_n(broken.world.model()->dof_damping + dof, 6, -20.0);
}

class BrokenPhysics : public ::testing::TestWithParam<Fault> {};

ExecutionLog ExecuteWith(const Fault& fault) {
  World world = samples::StandingAlone(samples::Tabletop(), fault.object);
  samples::HandMadeGrasp grasp;
  const bool cup = fault.object == std::string("coffee_cup");
  grasp.point_W = cup ? Eigen::Vector3d(0, 0.039, 0.083) : Eigen::Vector3d(0, 0, 0.1);
  grasp.yaw_rad = base::kPi / 2;
  grasp.pitch_rad = cup ? 0.0 : base::Deg(10.0);
  auto program = samples::MakeProgram(world, grasp);
  if (!program) return {};
  HandControlOptions hand;
  if (fault.breaks) fault.breaks({world, *program, hand});
  AuditBounds bounds;
  for (double AuditBounds::*bound :
       {&AuditBounds::penetration_p95_m, &AuditBounds::penetration_max_m,
        &AuditBounds::penetration_share, &AuditBounds::penetration_elsewhere_m,
        &AuditBounds::creep_m_s, &AuditBounds::creep_rad_s, &AuditBounds::equality_share,
        &AuditBounds::grip_share, &AuditBounds::energy_gain_m, &AuditBounds::drive_limit_s,
        &AuditBounds::tracking_error_rad}) {
    if (fault.breaks && bound != fault.bound) bounds.*bound = kNever;
  }
  return Execute(world, 0, *program, hand, bounds, base::Rng(1));
}

// The others are far, so that the verdict is this bound's, at its default.
TEST_P(BrokenPhysics, IsOutOfTheBoundOfTheAudit) {
  EXPECT_THAT(ExecuteWith(GetParam()).audit.failed, StartsWith(GetParam().figure));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, BrokenPhysics,
    ::testing::Values(
        Fault{"SoftGlove", "penetration_p95_m ", &AuditBounds::penetration_p95_m, SoftenGlove},
        Fault{"SofterGlove", "penetration_max_m ", &AuditBounds::penetration_max_m, SoftenGlove},
        Fault{"SoftGloveOnACupsWall", "penetration_share ", &AuditBounds::penetration_share,
              SoftenGlove, "coffee_cup"},
        Fault{"SoftTable", "penetration_elsewhere_m ", &AuditBounds::penetration_elsewhere_m,
              SoftenTable},
        Fault{"SoftFriction", "creep_m_s ", &AuditBounds::creep_m_s, SoftenFriction},
        Fault{"SoftFrictionOfACupsRim", "creep_rad_s ", &AuditBounds::creep_rad_s, SoftenFriction,
              "coffee_cup"},
        Fault{"FrictionThatLetsSlide", "unrest_s ", &AuditBounds::unrest_s, LetSlide},
        Fault{"SoftCoupling", "equality_share ", &AuditBounds::equality_share, SoftenCoupling},
        Fault{"MisgearedMotor", "grip_share ", &AuditBounds::grip_share, MisgearMotor},
        Fault{"BuzzingArm", "energy_gain_J ", &AuditBounds::energy_gain_m, BuzzArm},
        Fault{"WeakArm", "drive_limit_s ", &AuditBounds::drive_limit_s, WeakenArm},
        Fault{"JumpingPlan", "tracking_error_rad ", &AuditBounds::tracking_error_rad, Jump},
        Fault{"SolverThatStopsEarly", "unsolved_steps ", nullptr, StopSolverEarly},
        Fault{"DrivenBox", "engine warnings", nullptr, DriveBox}),
    [](const auto& tested) { return std::string(tested.param.name); });

// What the faults are of: nothing is broken, and all bounds hold.
TEST(IntactPhysics, NothingBrokenIsWithinAllBounds) {
  for (const char* object : {"dextrose", "coffee_cup"}) {
    const ExecutionLog log = ExecuteWith({"", "", nullptr, nullptr, object});
    EXPECT_TRUE(log.held_after_carry) << object;
    EXPECT_EQ(log.audit.failed, "") << object;
    EXPECT_EQ(log.audit.repeated_steps, 0) << object;
  }
}

}  // namespace
}  // namespace rangegrasp::sim
