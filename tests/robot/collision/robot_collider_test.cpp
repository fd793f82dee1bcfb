#include <gtest/gtest.h>

#include <algorithm>

#include "robot/collision/collider.h"
#include "robot/ik.h"
#include "robot/test_cells.h"

namespace rangegrasp::collision {
namespace {

using Eigen::Vector3d;
using Target = Contacts::Target;

geometry::Shape BoxShape(const Vector3d& center_W, const Vector3d& half) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kBox;
  shape.size = half;
  shape.X_BS.translation() = center_W;
  return shape;
}

geometry::TriangleMesh Box(const Vector3d& center_W, const Vector3d& half) {
  return geometry::Tessellate(BoxShape(center_W, half));
}

Vector3d RandomWithin(base::Rng& rng, double reach) {
  const double x = rng.Uniform(-reach, reach);
  const double y = rng.Uniform(-reach, reach);
  const double z = rng.Uniform(-reach, reach);
  return {x, y, z};
}

const Vector3d kHalf(0.02, 0.03, 0.04);

/// The cell in MuJoCo with one additional box, without any code of this module.
class WithBox {
 public:
  explicit WithBox(const std::filesystem::path& cell) : reference_(cell) {
    mjSpec* spec = mj_parseXML(cell.string().c_str(), nullptr, nullptr, 0);
    mjsBody* body = mjs_addBody(mjs_findBody(spec, "world"), nullptr);
    body->mocap = true;
    mjsGeom* geom = mjs_addGeom(body, nullptr);
    geom->type = mjGEOM_BOX;
    mjs_setName(geom->element, "obstacle");
    for (int k = 0; k < 3; ++k) geom->size[k] = kHalf[k];
    reference_.m.reset(mj_compile(spec, nullptr));
    reference_.d.reset(mj_makeData(reference_.m.get()));
    mj_deleteSpec(spec);
    obstacle_ = reference_.Find(mjOBJ_GEOM, "obstacle");
  }

  /// Penetration depth of the robot at q in the box [m]; negative if they do not touch.
  double Depth(const Eigen::VectorXd& q, const Vector3d& center_W) {
    mjModel* m = reference_.m.get();
    mjData* d = reference_.d.get();
    Eigen::Map<Vector3d>(d->mocap_pos) = center_W;
    reference_.SetArm(q);
    mj_kinematics(m, d);
    mj_collision(m, d);
    double depth = -1.0;
    for (int c = 0; c < d->ncon; ++c) {
      const mjContact& contact = d->contact[c];
      if (contact.geom[0] != obstacle_ && contact.geom[1] != obstacle_) continue;
      depth = std::max(depth, -contact.dist);
    }
    return depth;
  }

 private:
  rangegrasp::Reference reference_;
  int obstacle_ = -1;
};

class Cell : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  /// Joint positions without contact of the robot with itself or its cell, with the hand well above
  /// the table.
  Eigen::VectorXd FreeJoints(RobotCollider& collider, base::Rng& rng) const {
    collider.SetScene(0.0, {}, {});
    for (;;) {
      Eigen::VectorXd q = RandomJoints(robot_, rng);
      if (robot_.HandPose(q).translation().z() < 0.3) continue;
      if (!collider.Hits(robot_.LinkPoses(q), {})) return q;
    }
  }
  /// True if the robot hits something with this obstacle in the scene.
  bool HitsObstacle(RobotCollider& collider, const Eigen::VectorXd& q,
                    const geometry::TriangleMesh& obstacle_W, const Contacts& contacts) const {
    collider.SetScene(0.0, std::vector{obstacle_W}, {});
    return collider.Hits(robot_.LinkPoses(q), contacts);
  }
  /// Joint positions with the hand pointing down and the midpoint of its pads 250 mm above the
  /// workspace.
  Eigen::VectorXd PointingDown() const {
    base::Rng rng(5);
    base::Pose X_WG = robot_.X_WWorkspace;
    X_WG.linear() = Vector3d(1.0, -1.0, -1.0).asDiagonal();
    X_WG.translation().z() = 0.25;
    return robot::SolveIk(robot_, X_WG * robot_.hand().X_HG_tip.inverse(), robot_.home, {}, rng)
        .at(0);
  }
  robot::Robot robot_ = robot::Robot::Load(GetParam());
};

// MuJoCo's contacts are the reference. Both are exact on these shapes, but MuJoCo's iterations stop
// at 1e-6 m, so cases within 0.1 mm of first contact are not decided. Passive joints are at 0 in
// MuJoCo's hand and at their springs' rest positions in the hand model, so the obstacle is placed
// next to a link of the arm.
TEST_P(Cell, ArmHitsTheObstaclesThatItHitsInMujoco) {
  RobotCollider collider(robot_, 0.0);
  WithBox reference(GetParam());
  base::Rng rng(2);
  int hits = 0;
  int free = 0;
  for (int i = 0; i < 150; ++i) {
    const Eigen::VectorXd q = FreeJoints(collider, rng);
    const std::vector<base::Pose> links_W = robot_.LinkPoses(q);
    const std::size_t link = 1 + rng.Index(links_W.size() - 2);
    const Vector3d center_W = links_W[link] * RandomWithin(rng, 0.2);
    if ((center_W - robot_.HandPose(q).translation()).norm() < 0.3) continue;
    const double depth = reference.Depth(q, center_W);
    if (std::abs(depth) < 1e-4) continue;
    const bool hit = HitsObstacle(collider, q, Box(center_W, kHalf), {});
    EXPECT_EQ(hit, depth > 0.0) << i << " " << depth;
    ++(hit ? hits : free);
  }
  EXPECT_GT(hits, 10);
  EXPECT_GT(free, 10);
}

// Compares the grasp check with the motion check for the same hand, pose and clearance. The facets
// of one are at most 0.7 mm away from the exact shapes of the other, so they agree except for
// obstacles within that distance of the clearance. (If an obstacle also hits the arm, the result
// for the hand is not visible, so the obstacle must be free as a target that the hand may touch.)
TEST_P(Cell, BothChecksSayTheSameOfTheHand) {
  const double clearance_m = 0.003;
  const double band_m = 0.0007;
  RobotCollider motions(robot_, clearance_m);
  RobotCollider tighter(robot_, clearance_m - band_m);
  RobotCollider wider(robot_, clearance_m + band_m);
  base::Rng rng(8);
  int hits = 0;
  int free = 0;
  int differ = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::VectorXd q = FreeJoints(motions, rng);
    const base::Pose X_WH = robot_.HandPose(q);
    Contacts contacts;
    contacts.hand_state = rng.Index(robot_.hand().states.size());
    const auto obstacle =
        Box(X_WH * Vector3d(0.0, 0.05, 0.05) + RandomWithin(rng, 0.1), Vector3d::Constant(0.02));
    motions.SetScene(0.0, {}, obstacle);
    Contacts arm_only = contacts;
    arm_only.target = Target::kHandMayTouch;
    if (motions.Hits(robot_.LinkPoses(q), arm_only)) continue;
    const HandCollider grasps(robot_.hand(), std::vector{obstacle}, {}, {}, {clearance_m, 0.004});
    const bool of_grasps = grasps.HitsObstacle(X_WH, contacts.hand_state);
    const bool of_motions = HitsObstacle(motions, q, obstacle, contacts);
    EXPECT_LE(HitsObstacle(tighter, q, obstacle, contacts), of_grasps) << i;
    EXPECT_LE(of_grasps, HitsObstacle(wider, q, obstacle, contacts)) << i;
    ++(of_grasps ? hits : free);
    differ += of_grasps != of_motions;
  }
  EXPECT_GT(hits, 20);
  EXPECT_GT(free, 20);
  EXPECT_LT(differ, 10);
}

/// A block in the hand that extends 60 mm below and above the midpoint of the pads.
struct Carried {
  explicit Carried(const robot::Robot& robot, const Eigen::VectorXd& q) {
    links_W = robot.LinkPoses(q);
    X_WH = robot.HandPose(q);
    center_W = (X_WH * robot.hand().X_HG_tip).translation();
    target_W = Box(center_W, {0.015, 0.015, 0.06});
    contacts.hand_state = robot.hand().IndexAtGap(0.03);
    contacts.target = Target::kHeld;
    contacts.X_HT = X_WH.inverse();  // the target's frame is W, as perceived
    contacts.held_ignores = {0};
  }
  std::vector<base::Pose> links_W;
  base::Pose X_WH;
  Vector3d center_W;
  geometry::TriangleMesh target_W;
  Contacts contacts;
};

// The hand points down. Only the block reaches the obstacle below the hand.
TEST_P(Cell, WhatTheHandCarriesHitsWhatTheEmptyHandClears) {
  RobotCollider collider(robot_, 0.0);
  Carried carried(robot_, PointingDown());
  const Vector3d half(0.03, 0.03, 0.005);
  const auto below = [&](double depth_m) {
    return std::vector{Box(carried.center_W - Vector3d(0, 0, depth_m + half.z()), half)};
  };
  const auto hits = [&](double depth_m, Target target, bool ignored = false) {
    collider.SetScene(0.0, below(depth_m), carried.target_W);
    Contacts contacts = carried.contacts;
    contacts.target = target;
    contacts.held_ignores = {ignored};
    return collider.Hits(carried.links_W, contacts);
  };
  // The block's underside is 60 mm deep.
  EXPECT_TRUE(hits(0.0599, Target::kHeld));
  EXPECT_FALSE(hits(0.0601, Target::kHeld));
  EXPECT_FALSE(hits(0.0599, Target::kGone)) << "the hand alone clears it";
  EXPECT_FALSE(hits(0.0599, Target::kHeld, true)) << "it stood there at the grasp";
  collider.SetScene(0.0, below(0.0599), carried.target_W);
  EXPECT_EQ(collider.TouchedByTarget(carried.X_WH, carried.contacts.X_HT), std::vector<char>{1});
  collider.SetScene(0.0, below(0.0601), carried.target_W);
  EXPECT_EQ(collider.TouchedByTarget(carried.X_WH, carried.contacts.X_HT), std::vector<char>{0});
}

TEST_P(Cell, WhatTheHandCarriesMustClearTheTableUnlessItMayTouchIt) {
  RobotCollider collider(robot_, 0.0);
  Carried carried(robot_, PointingDown());
  carried.contacts.held_ignores.clear();
  const double underside = carried.center_W.z() - 0.06;
  for (const double off_m : {-1e-4, 1e-4}) {
    collider.SetScene(underside + off_m, {}, carried.target_W);
    carried.contacts.may_touch_table = false;
    EXPECT_EQ(collider.Hits(carried.links_W, carried.contacts), off_m > 0.0);
    carried.contacts.may_touch_table = true;
    EXPECT_FALSE(collider.Hits(carried.links_W, carried.contacts));
    carried.contacts.may_touch_table = false;
    carried.contacts.target = Target::kGone;
    EXPECT_FALSE(collider.Hits(carried.links_W, carried.contacts));
    carried.contacts.target = Target::kHeld;
  }
}

// The block is above the highest level surface of the work cell. It must keep the margin of 10 mm,
// plus the distance by which it may extend below its seen part.
TEST_P(Cell, WhatTheHandCarriesKeepsAMarginToTheWorkCell) {
  RobotCollider collider(robot_, 0.0, 0.01);
  Carried carried(robot_, PointingDown());
  carried.contacts.held_ignores.clear();
  carried.contacts.X_HT = carried.X_WH.inverse();
  double top_m = 0.0;
  Vector3d middle_W = Vector3d::Zero();
  for (const geometry::Shape& shape : robot_.workcell()) {
    const double top = geometry::Support(shape, base::Pose::Identity(), Vector3d::UnitZ());
    if (top <= top_m || shape.X_BS.linear()(2, 2) < 0.9999) continue;  // only level tops
    top_m = top;
    middle_W = shape.X_BS.translation();
  }
  const auto touch = [&](double above_m, bool margin, double below_m) {
    const Vector3d half(0.01, 0.01, 0.01);
    const Vector3d center_W(middle_W.x(), middle_W.y(), top_m + above_m + half.z());
    collider.SetScene(-10.0, {}, Box(center_W, half));
    carried.contacts.cell_margin = margin;
    carried.contacts.held_below_m = below_m;
    return collider.FirstTouch(carried.links_W, carried.contacts);
  };
  const auto without = touch(0.0099, false, 0.02);
  if (without && without->other == Touch::Other::kRobot) {
    GTEST_SKIP() << "the robot itself stands there";
  }
  EXPECT_FALSE(without);
  EXPECT_TRUE(touch(0.0099, true, 0.0));
  EXPECT_FALSE(touch(0.0101, true, 0.0));
  EXPECT_TRUE(touch(0.0299, true, 0.02));
  EXPECT_FALSE(touch(0.0301, true, 0.02));
}

TEST_P(Cell, OnlyAHandThatCarriesKeepsTheMarginToTheWorkCell) {
  RobotCollider collider(robot_, 0.0, 0.05);
  collider.SetScene(-10.0, {}, {});
  base::Rng rng(3);
  Contacts contacts;
  int near = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto links_W = robot_.LinkPoses(RandomJoints(robot_, rng));
    contacts.cell_margin = false;
    const bool hits = collider.Hits(links_W, contacts);
    contacts.cell_margin = true;
    const bool comes_near = collider.Hits(links_W, contacts);
    EXPECT_LE(hits, comes_near);
    near += comes_near && !hits ? 1 : 0;
  }
  EXPECT_GT(near, 0);
}

// The target as an obstacle, as an object that the hand may touch, and removed.
TEST_P(Cell, TargetIsAnObstacleUntilTheHandMayTouchIt) {
  RobotCollider collider(robot_, 0.003);
  base::Rng rng(7);
  for (int i = 0; i < 20; ++i) {
    const Eigen::VectorXd q = FreeJoints(collider, rng);
    const Vector3d thumb_W = robot_.HandPose(q) * robot_.hand().states.front().thumb_pad_H;
    collider.SetScene(0.0, {}, Box(thumb_W, Vector3d::Constant(0.003)));
    Contacts contacts;
    EXPECT_TRUE(collider.Hits(robot_.LinkPoses(q), contacts));
    for (const Target target : {Target::kHandMayTouch, Target::kGone}) {
      contacts.target = target;
      EXPECT_FALSE(collider.Hits(robot_.LinkPoses(q), contacts));
    }
  }
}

// Checks the arm's links against each other and the work cell. Contacts that MuJoCo finds deeper
// than 0.1 mm are hits. MuJoCo skips the same pairs: neighbors and pairs that the model excludes.
TEST_P(Cell, ArmHitsItselfAndTheWorkCellWhereItDoesInMujoco) {
  RobotCollider collider(robot_, 0.0);
  collider.SetScene(-10.0, {}, {});
  rangegrasp::Reference reference(GetParam());
  mjModel* m = reference.m.get();
  mjData* d = reference.d.get();
  std::vector<bool> is_link(static_cast<std::size_t>(m->nbody), false);
  for (const robot::Link& link : robot_.links()) {
    is_link[mj_name2id(m, mjOBJ_BODY, link.name.c_str())] = true;
  }
  const auto of_arm = [&](int geom) { return is_link[m->geom_bodyid[geom]]; };
  const auto of_cell = [&](int geom) {
    const char* name = mj_id2name(m, mjOBJ_GEOM, geom);
    const auto& cell = robot_.workcell();
    return name != nullptr &&
           std::ranges::any_of(cell, [&](const auto& shape) { return shape.name == name; });
  };
  base::Rng rng(3);
  int itself = 0;
  int cell = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::VectorXd q = RandomJoints(robot_, rng);
    reference.SetArm(q);
    mj_kinematics(m, d);
    mj_collision(m, d);
    bool touches = false;
    for (int c = 0; c < d->ncon; ++c) {
      const int a = d->contact[c].geom[0];
      const int b = d->contact[c].geom[1];
      if (d->contact[c].dist > -1e-4) continue;
      itself += of_arm(a) && of_arm(b);
      cell += (of_arm(a) && of_cell(b)) || (of_cell(a) && of_arm(b));
      touches = touches || (of_arm(a) && of_arm(b)) || (of_arm(a) && of_cell(b)) ||
                (of_cell(a) && of_arm(b));
    }
    if (touches) {
      EXPECT_TRUE(collider.Hits(robot_.LinkPoses(q), {})) << i;
    }
  }
  EXPECT_GT(itself + cell, 20);
}

// One table is touched only by the hand, the other by the arm, too.
TEST_P(Cell, TheHandMayTouchTheTableAndTheArmMustNot) {
  RobotCollider collider(robot_, 0.0);
  const Eigen::VectorXd q = PointingDown();
  const auto hits = [&](double table_z_m, bool may_touch) {
    collider.SetScene(table_z_m, {}, {});
    Contacts contacts;
    contacts.may_touch_table = may_touch;
    return collider.Hits(robot_.LinkPoses(q), contacts);
  };
  const double lowest = collider.LowestOfHand(robot_.HandPose(q), 0);
  EXPECT_FALSE(hits(lowest - 1e-4, false));
  EXPECT_TRUE(hits(lowest + 1e-4, false));
  EXPECT_FALSE(hits(lowest + 1e-4, true));
  EXPECT_TRUE(hits(10.0, true));
}

/// True if a held cube of 4 mm at this point hits something; the hand may be anywhere.
bool HeldAt(RobotCollider& collider, const robot::Robot& robot, const Eigen::VectorXd& q,
            const Vector3d& center_W, Target target = Target::kHeld) {
  collider.SetScene(-10.0, {}, Box(center_W, Vector3d::Constant(0.002)));
  Contacts contacts;
  contacts.target = target;
  contacts.X_HT = robot.HandPose(q).inverse();
  return collider.Hits(robot.LinkPoses(q), contacts);
}

TEST_P(Cell, WhatTheHandCarriesMustClearTheWorkCell) {
  RobotCollider collider(robot_, 0.0);
  const Eigen::VectorXd q = PointingDown();
  Vector3d highest = Vector3d::Constant(-1e9);
  for (const geometry::Shape& shape : robot_.workcell()) {
    for (const Vector3d& p : geometry::Tessellate(shape).vertices) {
      EXPECT_TRUE(HeldAt(collider, robot_, q, p)) << shape.name;
      EXPECT_FALSE(HeldAt(collider, robot_, q, p, Target::kGone)) << shape.name;
      if (p.z() > highest.z()) highest = p;
    }
  }
  ASSERT_FALSE(robot_.workcell().empty());
  const Vector3d up = Vector3d::UnitZ();
  EXPECT_TRUE(HeldAt(collider, robot_, q, highest + 0.0019 * up));
  EXPECT_FALSE(HeldAt(collider, robot_, q, highest + 0.0021 * up));
}

TEST_P(Cell, WhatTheHandCarriesMustClearTheArmAndNotTheHand) {
  RobotCollider collider(robot_, 0.0);
  const Eigen::VectorXd q = PointingDown();
  const std::vector<base::Pose> links_W = robot_.LinkPoses(q);
  for (std::size_t i = 0; i < links_W.size(); ++i) {
    for (const geometry::Shape& shape : robot_.links()[i].shapes) {
      // Some points of the surface; they are on it or at most 1 % of its size below it.
      const auto mesh = geometry::Tessellate(shape);
      for (std::size_t k = 0; k < mesh.vertices.size(); k += 1 + mesh.vertices.size() / 5) {
        const Vector3d p = links_W[i] * mesh.vertices[k];
        EXPECT_TRUE(HeldAt(collider, robot_, q, p)) << robot_.links()[i].name;
        EXPECT_FALSE(HeldAt(collider, robot_, q, p, Target::kGone));
      }
    }
  }
  const Vector3d thumb_W = robot_.HandPose(q) * robot_.hand().states.front().thumb_pad_H;
  EXPECT_TRUE(HeldAt(collider, robot_, q, thumb_W, Target::kObstacle));
  EXPECT_FALSE(HeldAt(collider, robot_, q, thumb_W));
}

// The target is above the arm's highest point. Tessellated shapes end up to 1 mm below exact ones.
TEST_P(Cell, WhatTheHandCarriesKeepsTheMarginFromTheArm) {
  const Eigen::VectorXd q = PointingDown();
  const std::vector<base::Pose> links_W = robot_.LinkPoses(q);
  Vector3d highest = Vector3d::Constant(-1e9);
  for (std::size_t i = 0; i < links_W.size(); ++i) {
    for (const geometry::Shape& shape : robot_.links()[i].shapes) {
      for (const Vector3d& p : geometry::Tessellate(shape).vertices) {
        if ((links_W[i] * p).z() > highest.z()) highest = links_W[i] * p;
      }
    }
  }
  const auto hits = [&](double margin_m, double above_m) {
    RobotCollider collider(robot_, margin_m);
    return HeldAt(collider, robot_, q, highest + (above_m + 0.002) * Vector3d::UnitZ());
  };
  EXPECT_TRUE(hits(0.005, 0.0049));
  EXPECT_FALSE(hits(0.005, 0.0061));
  EXPECT_FALSE(hits(0.0, 0.0011));
}

// There is an obstacle or a table under the hand.
TEST_P(Cell, TheHandKeepsTheMarginWhereItIsAsked) {
  constexpr double kMargin_m = 0.003;
  RobotCollider collider(robot_, kMargin_m);
  const Eigen::VectorXd q = PointingDown();
  const double lowest = collider.LowestOfHand(robot_.HandPose(q), 0);
  const Vector3d half(0.15, 0.15, 0.005);
  for (const bool margin : {false, true}) {
    for (const double below : {-1e-4, 1e-4, kMargin_m - 1e-4, kMargin_m + 1e-4}) {
      Vector3d center = robot_.HandPose(q).translation();
      center.z() = lowest - below - half.z();
      Contacts contacts;
      contacts.hand_margin = margin;
      const bool expected = below < (margin ? kMargin_m : 0.0);
      collider.SetScene(-10.0, std::vector{Box(center, half)}, {});
      EXPECT_EQ(collider.Hits(robot_.LinkPoses(q), contacts), expected) << margin << below;
      collider.SetScene(lowest - below, {}, {});
      EXPECT_EQ(collider.Hits(robot_.LinkPoses(q), contacts), expected) << margin << below;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, Cell, ::testing::ValuesIn(Cells()),
                         [](const auto& cell) { return CellName(cell.param); });

}  // namespace
}  // namespace rangegrasp::collision
