#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/units.h"
#include "base/words.h"
#include "robot/ik.h"
#include "robot/planning/planning.h"
#include "robot/test_cells.h"

namespace rangegrasp::planning {
namespace {

using geometry::TriangleMesh;

TriangleMesh BoxMesh(const Eigen::Vector3d& center_W, const Eigen::Vector3d& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(center_W + Eigen::Vector3d((i & 1 ? 1 : -1) * half.x(),
                                                       (i & 2 ? 1 : -1) * half.y(),
                                                       (i & 4 ? 1 : -1) * half.z()));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A box that is an obstacle for the planner and for MuJoCo's check.
struct Obstacle {
  Eigen::Vector3d center_W, half;
};

/// A grasp from above, 0.02 m below the top of a box of 0.04 x 0.05 m that stands at (x, y).
struct Pick {
  Pick(const robot::Robot& robot, double x, double y, double height_m, double yaw_rad)
      : target{{x, y, 0.5 * height_m}, {0.02, 0.025, 0.5 * height_m}} {
    scene.target_W = BoxMesh(target.center_W, target.half);
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
        Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    const base::Pose X_WG = base::MakePose(R, {x, y, height_m - 0.02});
    request.X_WH = X_WG * robot.hand().X_HG_tip.inverse();
    request.q_start = robot.home;
    request.opening_m = robot.hand().MaxGap();
    request.closed_gap_m = 0.04;
  }
  void Add(const Obstacle& obstacle) {
    obstacles.push_back(obstacle);
    scene.obstacles_W.push_back(BoxMesh(obstacle.center_W, obstacle.half));
  }
  Obstacle target;
  PlanningScene scene;
  PickRequest request;
  std::vector<Obstacle> obstacles;
};

/// MuJoCo's own collision detection for the cell with the obstacles added as boxes, without any of
/// the planner's code.
class Judge {
 public:
  Judge(const std::filesystem::path& cell, const std::vector<Obstacle>& obstacles) {
    mjSpec* spec = mj_parseXML(cell.string().c_str(), nullptr, nullptr, 0);
    mjsBody* world = mjs_findBody(spec, "world");
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      mjsGeom* geom = mjs_addGeom(world, nullptr);
      geom->type = mjGEOM_BOX;
      mjs_setName(geom->element, ("obstacle" + std::to_string(i)).c_str());
      for (int k = 0; k < 3; ++k) {
        geom->pos[k] = obstacles[i].center_W[k];
        geom->size[k] = obstacles[i].half[k];
      }
    }
    reference_.m.reset(mj_compile(spec, nullptr));
    reference_.d.reset(mj_makeData(reference_.m.get()));
    mj_deleteSpec(spec);
  }

  /// The deepest contact of a motion [m] for the given finger closing, and the bodies in contact.
  double Deepest(const base::JointTrajectory& motion, double closing, std::string& who) {
    mjModel* m = reference_.m.get();
    mjData* d = reference_.d.get();
    double deepest = 0.0;
    for (const Eigen::VectorXd& q : motion.positions) {
      reference_.SetArm(q);
      SetHand(closing);
      mj_kinematics(m, d);
      mj_collision(m, d);
      for (int c = 0; c < d->ncon; ++c) {
        if (!Counts(d->contact[c]) || -d->contact[c].dist <= deepest) continue;
        deepest = -d->contact[c].dist;
        who = NameOf(d->contact[c].geom[0]) + " and " + NameOf(d->contact[c].geom[1]);
      }
    }
    return deepest;
  }

 private:
  std::string NameOf(int geom) const {
    const char* name = mj_id2name(reference_.m.get(), mjOBJ_GEOM, geom);
    return name ? name : "geom " + std::to_string(geom);
  }
  /// Contacts between fingers are allowed; the planner does not check them.
  bool Counts(const mjContact& contact) const {
    const mjModel* m = reference_.m.get();
    const int hand = reference_.Find(mjOBJ_BODY, "hand");
    const auto of_hand = [&](int geom) {
      int body = m->geom_bodyid[geom];
      while (body > hand) body = m->body_parentid[body];
      return body == hand;
    };
    return !of_hand(contact.geom[0]) || !of_hand(contact.geom[1]);
  }
  void SetHand(double closing) {
    const mjModel* m = reference_.m.get();
    const int tuple = reference_.Find(mjOBJ_TUPLE, "hand_joints");
    for (int i = 0; i < m->tuple_size[tuple]; ++i) {
      const int joint = m->tuple_objid[m->tuple_adr[tuple] + i];
      reference_.d->qpos[m->jnt_qposadr[joint]] =
          m->jnt_range[2 * joint] +
          closing * (m->jnt_range[2 * joint + 1] - m->jnt_range[2 * joint]);
    }
  }
  Reference reference_{SmallCell()};
};

std::vector<const base::JointTrajectory*> Motions(const PickPlan& plan) {
  return {&plan.reach, &plan.approach, &plan.lift, &plan.carry, &plan.lower, &plan.retreat};
}

PlanResult PlanFor(const robot::Robot& robot, const PlanOptions& options, const Pick& pick,
                   base::Rng& rng) {
  Planner planner(robot, options);
  planner.SetScene(pick.scene);
  return planner.Plan(pick.request, rng);
}

class OnePlan : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  PlanResult Plan(const Pick& pick, std::uint64_t seed = 1) {
    base::Rng rng(seed);
    return PlanFor(robot_, {}, pick, rng);
  }
  Pick AtWorkspace(double dx, double dy, double height_m, double yaw_rad) {
    const Eigen::Vector3d p_W = robot_.X_WWorkspace.translation();
    return {robot_, p_W.x() + dx, p_W.y() + dy, height_m, yaw_rad};
  }
  robot::Robot robot_ = robot::Robot::Load(GetParam());
};

TEST_P(OnePlan, MotionsFollowOneAnotherFromTheStartToTheRetreat) {
  const Pick pick = AtWorkspace(0.0, 0.03, 0.1, 0.4);
  const PlanResult result = Plan(pick);
  ASSERT_TRUE(result.plan) << base::Word(result.failure);
  const auto motions = Motions(*result.plan);
  EXPECT_EQ(motions.front()->positions.front(), robot_.home);
  for (std::size_t i = 1; i < motions.size(); ++i) {
    EXPECT_EQ(motions[i]->positions.front(), motions[i - 1]->positions.back());
  }
  const base::Pose X_WGrasp = robot_.HandPose(result.plan->approach.positions.back());
  EXPECT_TRUE(X_WGrasp.isApprox(pick.request.X_WH, 1e-3));
  EXPECT_LT((X_WGrasp.translation() - pick.request.X_WH.translation()).norm(), 1.1e-5);
}

// The object moves with the hand's frame, so its center follows from the hand's poses.
TEST_P(OnePlan, ObjectIsLiftedStraightCarriedUprightAndLaidOnTheDeliveryPlace) {
  const Pick pick = AtWorkspace(0.02, -0.03, 0.12, 1.3);
  const PlanResult result = Plan(pick);
  ASSERT_TRUE(result.plan) << base::Word(result.failure);
  const Eigen::Vector3d center_H =
      robot_.HandPose(result.plan->lift.positions.front()).inverse() * pick.target.center_W;
  const Eigen::Vector3d up_H = pick.request.X_WH.linear().transpose() * Eigen::Vector3d::UnitZ();
  const auto center_W = [&](const Eigen::VectorXd& q) -> Eigen::Vector3d {
    return robot_.HandPose(q) * center_H;
  };
  const Eigen::Vector3d lifted_W = center_W(result.plan->lift.positions.back());
  EXPECT_NEAR(lifted_W.z() - pick.target.center_W.z(), PlanOptions().lift_m, 1e-5);
  EXPECT_LT((lifted_W - pick.target.center_W).head<2>().norm(), 1e-5);
  for (const auto* motion : {&result.plan->lift, &result.plan->carry, &result.plan->lower}) {
    for (const auto& q : motion->positions) {
      const double upright = (robot_.HandPose(q).linear() * up_H).z();
      EXPECT_GE(upright, std::cos(PlanOptions().carry_tilt_rad));
    }
  }
  Eigen::Vector3d delivery_W = robot_.X_WDelivery.translation();
  delivery_W.z() = pick.target.center_W.z() + PlanOptions().lower_clearance_m;
  EXPECT_LT((center_W(result.plan->lower.positions.back()) - delivery_W).norm(), 1e-4);
  const double up_m = robot_.HandPose(result.plan->retreat.positions.back()).translation().z() -
                      robot_.HandPose(result.plan->retreat.positions.front()).translation().z();
  EXPECT_NEAR(up_m, PlanOptions().retreat_m, 1e-4);
}

TEST_P(OnePlan, SameStreamSameBytesAndAPlannerKeepsNoMemory) {
  Pick pick = AtWorkspace(0.0, 0.0, 0.1, 1.3);
  pick.Add(
      {robot_.X_WWorkspace.translation() + Eigen::Vector3d(-0.16, 0.0, 0.16), {0.01, 0.15, 0.16}});
  Planner planner(robot_, {});
  base::Rng a(3), other(4), b(3);
  planner.SetScene(pick.scene);
  const PlanResult first = planner.Plan(pick.request, a);
  planner.SetScene(AtWorkspace(0.05, 0.0, 0.1, 0.0).scene);
  planner.Plan(pick.request, other);
  planner.SetScene(pick.scene);
  const PlanResult again = planner.Plan(pick.request, b);
  ASSERT_EQ(first.plan.has_value(), again.plan.has_value());
  ASSERT_TRUE(first.plan) << base::Word(first.failure);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(Motions(*first.plan)[i]->positions, Motions(*again.plan)[i]->positions);
  }
}

TEST_P(OnePlan, FailuresNameTheirStage) {
  Pick far = AtWorkspace(0.0, 0.0, 0.1, 0.0);
  far.request.X_WH.translation().x() += 2.0;
  EXPECT_EQ(Plan(far).failure, PlanFailure::kNoIk);

  Pick roofed = AtWorkspace(0.0, 0.0, 0.1, 0.0);
  roofed.Add(
      {robot_.X_WWorkspace.translation() + Eigen::Vector3d(0.0, 0.0, 0.19), {0.15, 0.15, 0.005}});
  const PlanResult blocked = Plan(roofed);
  EXPECT_FALSE(blocked.plan);
  EXPECT_EQ(blocked.failure, PlanFailure::kApproachBlocked);
  EXPECT_TRUE(blocked.blocked_by.ends_with(" and what was seen beside the object"))
      << blocked.blocked_by;

  Pick delivery_full = AtWorkspace(0.0, 0.0, 0.1, 0.0);
  delivery_full.Add(
      {robot_.X_WDelivery.translation() + Eigen::Vector3d(0.0, 0.0, 0.05), {0.05, 0.05, 0.05}});
  EXPECT_EQ(Plan(delivery_full).failure, PlanFailure::kNoCarry);
}

// The approach is free and the grasp is within reach, but an obstacle blocks the hand at its start.
TEST_P(OnePlan, NoReachMeansThatTheStartIsShutIn) {
  Pick pick = AtWorkspace(0.0, 0.0, 0.1, 0.0);
  ASSERT_TRUE(Plan(pick).plan);
  pick.Add({robot_.HandPose(robot_.home).translation(), {0.02, 0.02, 0.02}});
  const PlanResult result = Plan(pick);
  EXPECT_FALSE(result.plan);
  EXPECT_EQ(result.failure, PlanFailure::kNoReach) << base::Word(result.failure);
  // The hand and the link that it is mounted on are there.
  EXPECT_TRUE(result.blocked_by == "the hand and what was seen beside the object" ||
              result.blocked_by == "link7 and what was seen beside the object")
      << result.blocked_by;
}

INSTANTIATE_TEST_SUITE_P(Cells, OnePlan, ::testing::ValuesIn(Cells()),
                         [](const auto& cell) { return CellName(cell.param); });

/// True if a motion deviates from the straight joint line between its ends by more than 0.1 rad.
bool IsDetour(const base::JointTrajectory& motion) {
  const Eigen::VectorXd& from = motion.positions.front();
  const Eigen::VectorXd leg = motion.positions.back() - from;
  return std::ranges::any_of(motion.positions, [&](const auto& q) {
    const double t = (q - from).dot(leg) / leg.squaredNorm();
    return (q - from - t * leg).norm() > 0.1;
  });
}

/// The hand starts low on one side of a wall and the object stands on the other side. Another
/// object stands on the way to the delivery place.
Pick BehindAWall(const robot::Robot& robot, base::Rng& rng) {
  const double x = rng.Uniform(-0.05, 0.05);
  const double y = rng.Uniform(-0.05, 0.02);
  Pick pick(robot, x, y, rng.Uniform(0.06, 0.12), rng.Uniform(-3.1, 3.1));
  const double height_m = rng.Uniform(0.2, 0.3);
  pick.Add({{x, y + 0.15, 0.5 * height_m}, {rng.Uniform(0.1, 0.15), 0.01, 0.5 * height_m}});
  pick.Add({{x, y - 0.17, 0.07}, {0.03, 0.03, 0.07}});
  base::Pose X_WStart = pick.request.X_WH;
  X_WStart.translation() += Eigen::Vector3d(-0.05, 0.33, 0.05);
  const auto starts = robot::SolveIk(robot, X_WStart, robot.home, {}, rng);
  if (!starts.empty()) pick.request.q_start = starts.front();
  return pick;
}

/// Checks the deepest contact of each motion and names the bodies in contact.
void ExpectTouchesNothing(const Pick& pick, const PickPlan& plan) {
  std::vector<Obstacle> with_target = pick.obstacles;
  with_target.push_back(pick.target);
  Judge before(SmallCell(), with_target);
  Judge after(SmallCell(), pick.obstacles);
  const double bound_m = 2e-4;
  std::string who;
  EXPECT_LT(before.Deepest(plan.reach, 0.0, who), bound_m) << "reach: " << who;
  EXPECT_LT(before.Deepest(plan.approach, 0.0, who), bound_m) << "approach: " << who;
  for (const auto* motion : {&plan.lift, &plan.carry, &plan.lower, &plan.retreat}) {
    EXPECT_LT(after.Deepest(*motion, 0.0, who), bound_m) << who;
  }
}

// The planner keeps a distance of 3 mm, except where the hand passes objects closely in its
// straight motions. It checks timed samples half a resolution apart. A link at 0.8 m moves 16 mm
// between two samples, which can cut an edge by less than 3 mm. The test accepts up to 0.2 mm.
TEST(AroundAWall, MotionsTouchNothingAsMujocoSeesIt) {
  const robot::Robot robot = robot::Robot::Load(SmallCell());
  int plans = 0;
  int detours = 0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    base::Rng rng(seed);
    const Pick pick = BehindAWall(robot, rng);
    const PlanResult result = PlanFor(robot, {}, pick, rng);
    if (!result.plan) continue;
    ++plans;
    detours += IsDetour(result.plan->reach);
    ExpectTouchesNothing(pick, *result.plan);
  }
  EXPECT_GE(plans, 18);
  EXPECT_GE(detours, 6);
}

// Without iterations no tree grows, so goals that need a detour are not reached, though a plan
// exists.
TEST(AroundAWall, NoReachMeansThatTheSearchFoundNoWay) {
  const robot::Robot robot = robot::Robot::Load(SmallCell());
  PlanOptions no_search;
  no_search.planning_iterations = 0;
  int detours = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    base::Rng rng(seed);
    const Pick pick = BehindAWall(robot, rng);
    base::Rng again = rng;
    const PlanResult result = PlanFor(robot, {}, pick, rng);
    if (!result.plan || !IsDetour(result.plan->reach)) continue;
    ++detours;
    const PlanResult none = PlanFor(robot, no_search, pick, again);
    if (none.plan) {
      // Another configuration at the grasp was reached on a straight line.
      EXPECT_FALSE(IsDetour(none.plan->reach));
    } else {
      EXPECT_EQ(none.failure, PlanFailure::kNoReach);
    }
  }
  EXPECT_GT(detours, 1);
}

}  // namespace
}  // namespace rangegrasp::planning
