#include <gtest/gtest.h>

#include <array>
#include <set>
#include <tuple>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "robot/test_cells.h"

namespace rangegrasp::robot {
namespace {

class Kinematics : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  Kinematics() : robot_(Robot::Load(GetParam())), reference_(GetParam()) {}
  Robot robot_;
  Reference reference_;
};

// Chains have about ten rotations and translations of about 1 m; rounding is below 1e-14 per step.
TEST_P(Kinematics, LinkAndHandPosesAreThoseOfMujoco) {
  base::Rng rng(1);
  for (int n = 0; n < 200; ++n) {
    const Eigen::VectorXd q = RandomJoints(robot_, rng);
    reference_.SetArm(q);
    mj_kinematics(reference_.m.get(), reference_.d.get());
    const auto poses = robot_.LinkPoses(q);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const int body = mj_name2id(reference_.m.get(), mjOBJ_BODY, robot_.links()[i].name.c_str());
      ASSERT_LT((poses[i].matrix() - reference_.BodyPose(body).matrix()).cwiseAbs().maxCoeff(),
                1e-12)
          << robot_.links()[i].name;
    }
    const int hand = reference_.Find(mjOBJ_BODY, "hand");
    ASSERT_LT(
        (robot_.HandPose(q).matrix() - reference_.BodyPose(hand).matrix()).cwiseAbs().maxCoeff(),
        1e-12);
  }
}

TEST_P(Kinematics, HandJacobianIsThatOfMujoco) {
  base::Rng rng(2);
  mjModel* m = reference_.m.get();
  const int hand = reference_.Find(mjOBJ_BODY, "hand");
  const std::vector<int> joints = reference_.ArmJoints();
  std::vector<mjtNum> jacp(static_cast<std::size_t>(3 * m->nv));
  std::vector<mjtNum> jacr(jacp.size());
  for (int n = 0; n < 200; ++n) {
    const Eigen::VectorXd q = RandomJoints(robot_, rng);
    reference_.SetArm(q);
    mj_kinematics(m, reference_.d.get());
    mj_comPos(m, reference_.d.get());
    mj_jacBody(m, reference_.d.get(), jacp.data(), jacr.data(), hand);
    Eigen::MatrixXd J;
    robot_.HandPoseAndJacobian(q, J);
    for (int i = 0; i < robot_.dof(); ++i) {
      const int dof = m->jnt_dofadr[joints[i]];
      for (int k = 0; k < 3; ++k) {
        const auto at = static_cast<std::size_t>(k * m->nv + dof);
        ASSERT_NEAR(J(k, i), jacp[at], 1e-12);
        ASSERT_NEAR(J(k + 3, i), jacr[at], 1e-12);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, Kinematics, ::testing::ValuesIn(AllCells()),
                         [](const auto& cell) { return CellName(cell.param); });

TEST(Load, TakesTheFixedCellWithoutTheTableTopAndWithoutWhatIsOnlySeen) {
  const Robot robot = Robot::Load(SmallCell());
  std::vector<std::string> names;
  for (const auto& shape : robot.workcell()) names.push_back(shape.name);
  EXPECT_EQ(names, (std::vector<std::string>{"rim", "scanner_box", "pedestal"}));
  EXPECT_EQ(robot.dof(), 7);
  EXPECT_EQ(robot.links().size(), 8u);
  EXPECT_DOUBLE_EQ(robot.workspace_radius_m, 0.1);
  EXPECT_NEAR(robot.X_WDelivery.translation().y(), -0.38, 1e-15);
}

TEST(Load, SelfPairsLeaveOutNeighboursAndExclusionsAlone) {
  const Robot robot = Robot::Load(SmallCell());
  for (const auto& [a, b] : robot.self_pairs()) EXPECT_GE(b - a, 2);
  // 9 bodies with the hand make 36 pairs: 8 are neighbors and 7 others are excluded.
  EXPECT_EQ(robot.self_pairs().size(), 36u - 8u - 7u);
}

TEST(Load, TheBaseIsWhatTheFirstJointTurnsOnWhateverItsName) {
  EXPECT_EQ(Robot::Load(OwnArm("six_on_pedestal")).links().front().name, "arm/foot");
  EXPECT_EQ(Robot::Load(OwnArm("seven_on_ceiling")).links().front().name, "arm/link0");
  // Another body with this name is not the base.
  const auto file = std::filesystem::path(::testing::TempDir()) / "two_bases.xml";
  std::string text = base::ReadFile(SmallCell());
  text.replace(text.find("name=\"stand\""), 12, "name=\"q/base\"");
  base::WriteFile(file, text);
  EXPECT_EQ(Robot::Load(file).links().front().name, "p/base");
}

TEST(Load, AnArmOnTheWorldItselfStandsWhereItsFirstLinkIs) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "on_world.xml";
  std::string text = base::ReadFile(SmallCell());
  // Without pedestal and base, link1 is attached to the world at the same place.
  const auto from = text.find("<body name=\"pedestal\"");
  const auto to = text.find("<body name=\"link1\"");
  text.replace(from, to - from, "");
  text.replace(text.find("pos=\"0 0 0.1\" euler=\"0 0 20\""), 13, "pos=\"-0.45 0 0.3\"");
  text.replace(text.find("</worldbody>") - 20, 0, "");
  for (int i = 0; i < 2; ++i) {
    const auto last = text.rfind("</body>", text.find("</worldbody>"));
    text.erase(last, 7);
  }
  for (const char* gone : {"<exclude body1=\"p/base\" body2=\"link1\"/>",
                           "<exclude body1=\"p/base\" body2=\"link2\"/>",
                           "<exclude body1=\"pedestal\" body2=\"p/base\"/>"}) {
    text.erase(text.find(gone), std::string(gone).size());
  }
  base::WriteFile(file, text);
  const Robot robot = Robot::Load(file);
  const Robot whole = Robot::Load(SmallCell());
  EXPECT_TRUE(robot.links().front().shapes.empty());
  EXPECT_NEAR((robot.links().front().X_PB.translation() - Eigen::Vector3d(-0.45, 0, 0.3)).norm(), 0,
              1e-12);
  base::Rng rng(3);
  for (int n = 0; n < 20; ++n) {
    const Eigen::VectorXd q = RandomJoints(whole, rng);
    EXPECT_TRUE(robot.HandPose(q).isApprox(whole.HandPose(q), 1e-12));
  }
}

TEST(Load, AContinuousJointHasOneTurnToEitherSide) {
  const Robot robot = Robot::Load(OwnArm("seven_on_pedestal"));
  for (const int continuous : {0, 6}) {
    EXPECT_DOUBLE_EQ(robot.lower[continuous], -2.0 * base::kPi);
    EXPECT_DOUBLE_EQ(robot.upper[continuous], 2.0 * base::kPi);
  }
  EXPECT_DOUBLE_EQ(robot.upper[1], 1.8);
}

// six_joints.xml has a flange without a joint between its last link and the hand.
TEST(Load, SelfPairsLeaveOutWhatHangsRigidlyTogetherAsTheEngineDoes) {
  const auto file = OwnArm("six_on_pedestal");
  const Robot robot = Robot::Load(file);
  const Reference reference(file);
  std::vector<int> welds;
  for (const Link& link : robot.links()) {
    welds.push_back(reference.m->body_weldid[reference.Find(mjOBJ_BODY, link.name)]);
  }
  welds.push_back(reference.m->body_weldid[reference.Find(mjOBJ_BODY, "hand")]);
  const auto parent = [&](int weld) {
    return reference.m->body_weldid[reference.m->body_parentid[weld]];
  };
  std::set<std::array<int, 2>> expected;
  for (int a = 0; a < static_cast<int>(welds.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(welds.size()); ++b) {
      const int low = welds[a];
      const int high = welds[b];
      if (low != high && parent(high) != low) expected.insert({a, b});
    }
  }
  EXPECT_EQ(std::set(robot.self_pairs().begin(), robot.self_pairs().end()), expected);
}

TEST(Load, WhatTheSceneExcludesFromTheTableAndTheCellIsIgnored) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "excluded.xml";
  std::string text = base::ReadFile(SmallCell());
  text.replace(text.find("<exclude body1=\"link1\" body2=\"link3\"/>"), 0,
               "<exclude body1=\"table\" body2=\"link1\"/>"
               "<exclude body1=\"stand\" body2=\"link7\"/>");
  base::WriteFile(file, text);
  const Robot robot = Robot::Load(file);
  for (std::size_t link = 0; link <= robot.links().size(); ++link) {
    EXPECT_EQ(robot.IgnoresTable(link), link == 1) << link;
    for (std::size_t shape = 0; shape < robot.workcell().size(); ++shape) {
      const std::string& name = robot.workcell()[shape].name;
      const bool ignored = (link == 1 && name == "rim") || (link == 7 && name == "scanner_box") ||
                           (link == 0 && name == "pedestal");
      EXPECT_EQ(robot.Ignores(link, shape), ignored) << link << " " << name;
    }
  }
}

TEST(Load, NamesTheFileAndWhatIsMissing) {
  const auto file = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "tests/data/missing.xml";
  try {
    Robot::Load(file);
    FAIL() << "should throw";
  } catch (const base::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("missing.xml"), std::string::npos);
  }
}

// The small cell with one error each, and the text that the message must contain.
TEST(Load, NamesWhatIsWrongInTheFile) {
  const std::string cell = base::ReadFile(SmallCell());
  const auto file = std::filesystem::path(::testing::TempDir()) / "wrong_cell.xml";
  for (const auto& [right, wrong, named] :
       {std::tuple("name=\"workspace\"", "name=\"elsewhere\"", "workspace"),
        std::tuple("name=\"stand\"", "name=\"q/hand\"", "twice"),
        std::tuple("objname=\"j3\"", "objname=\"passive\"", "does not move body \"hand\""),
        std::tuple("<joint name=\"j2\"", "<joint name=\"j2\" type=\"slide\"", "hinge")}) {
    std::string text = cell;
    const auto at = text.find(right);
    ASSERT_NE(at, std::string::npos) << right;
    text.replace(at, std::string(right).size(), wrong);
    base::WriteFile(file, text);
    try {
      Robot::Load(file);
      ADD_FAILURE() << "should throw: " << wrong;
    } catch (const base::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("wrong_cell.xml"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
  }
}

class Hand : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  Hand() : robot_(Robot::Load(GetParam())), hand_(robot_.hand()) {}
  Robot robot_;
  const HandModel& hand_;
};

TEST_P(Hand, ClosesFromOpenUntilThePadsTouchOrTheJointsEnd) {
  ASSERT_GE(hand_.states.size(), 23u);
  for (std::size_t i = 1; i < hand_.states.size(); ++i) {
    EXPECT_LT(hand_.states[i].gap_m, hand_.states[i - 1].gap_m);
  }
  EXPECT_LT(hand_.states.back().gap_m, 1e-6);
}

TEST_P(Hand, PadsMeetWhenClosedAndOpenAlongTheClosingDirection) {
  const auto& closed = hand_.states.back();
  const auto& open = hand_.states.front();
  // These are means over the fingers' points, so they are up to half the fingers' spacing apart.
  EXPECT_LT((closed.thumb_pad_H - closed.finger_pad_H).norm(), 0.01);
  const Eigen::Vector3d opening = (open.thumb_pad_H - open.finger_pad_H).normalized();
  EXPECT_GT(opening.dot(hand_.X_HG_tip.linear().col(0)), 0.95);
}

// The published tool centres lie between the tips: midway between both sides of the hand at every
// opening, and at the sites of the open hand, except along the row of its fingers.
TEST_P(Hand, ToolCentresMoveWithTheOpening) {
  for (const auto& state : hand_.states) {
    for (const Eigen::Vector3d& center : {state.tip_center_H, state.power_center_H}) {
      const Eigen::Vector3d pads = 0.5 * (state.thumb_pad_H + state.finger_pad_H);
      const Eigen::Vector3d closing = hand_.X_HG_tip.linear().col(0);
      // A thumb's tip is longer than its pad, and the little finger stops before the other fingers.
      EXPECT_LT(std::abs((center - pads).dot(closing)), 0.008);
    }
  }
  const auto shift = [&](const Eigen::Vector3d& to) {
    return (to - hand_.states.front().tip_center_H).norm();
  };
  EXPECT_GT(shift(hand_.states.back().tip_center_H), 0.001);
}

TEST_P(Hand, AtGapGivesTheTightestStateThatIsWideEnough) {
  for (double gap_m = 0.0; gap_m < hand_.MaxGap(); gap_m += 0.0013) {
    const auto& state = hand_.AtGap(gap_m);
    EXPECT_GE(state.gap_m, gap_m);
    for (const auto& other : hand_.states) {
      EXPECT_FALSE(other.gap_m >= gap_m && other.gap_m < state.gap_m);
    }
  }
  EXPECT_EQ(&hand_.AtGap(1.0), &hand_.states.front());
}

TEST_P(Hand, AStatesOwnGapIsWideEnough) {
  for (std::size_t i = 0; i < hand_.states.size(); ++i) {
    EXPECT_EQ(hand_.IndexAtGap(hand_.states[i].gap_m), i);
  }
}

TEST_P(Hand, ThumbShapesAreFingersAndEveryShapeIsFlagged) {
  for (const auto& state : hand_.states) {
    ASSERT_EQ(state.is_finger.size(), state.shapes.size());
    ASSERT_EQ(state.is_thumb.size(), state.shapes.size());
    int thumbs = 0;
    for (std::size_t i = 0; i < state.shapes.size(); ++i) {
      EXPECT_LE(state.is_thumb[i], state.is_finger[i]);
      thumbs += state.is_thumb[i];
    }
    EXPECT_GT(thumbs, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, Hand, ::testing::ValuesIn(Cells()),
                         [](const auto& cell) { return CellName(cell.param); });

/// How far the hand is closed in a state, from 0 to 1.
double ClosingOf(const HandModel& hand, std::size_t state) {
  return static_cast<double>(state) / static_cast<double>(hand.states.size() - 1);
}

// Finger and thumb are mirror images, hinged at x = -+0.055 and turned outward by 5 deg. Their axes
// are 0.095 m long with radius 0.008; the finger's last segment is the outer 0.045 m. When turned
// inward by a, the tips' ends are nearest. When turned outward, the start of the finger's last
// segment is nearest, and the nearest point of the thumb's axis is the foot of the perpendicular.
TEST(SmallHand, GapFollowsFromTheHinges) {
  const Robot robot = Robot::Load(SmallCell());
  const HandModel& hand = robot.hand();
  for (std::size_t i = 0; i < hand.states.size(); ++i) {
    const double touch = std::asin((0.055 - 0.008) / 0.095);  // tips' axes 0.016 apart
    const double angle = ClosingOf(hand, i) * (touch + base::Deg(5)) - base::Deg(5);
    const double axes = angle > 0.0
                            ? 2.0 * (0.055 - 0.095 * std::sin(angle))
                            : 0.11 * std::cos(angle) - 0.1 * std::sin(angle) * std::cos(angle);
    const double expected = axes - 0.016;
    EXPECT_NEAR(hand.states[i].gap_m, expected, 2e-6) << i;
  }
}

TEST(SmallHand, PassiveFingerFollowsItsSpringUpToItsLimit) {
  const Robot robot = Robot::Load(SmallCell());
  const HandModel& hand = robot.hand();
  const double closed = std::asin((0.055 - 0.008) / 0.095) + base::Deg(5);
  for (std::size_t i = 0; i < hand.states.size(); ++i) {
    const double turn = std::min(ClosingOf(hand, i) * closed, base::Deg(30)) - base::Deg(5);
    const Eigen::Vector3d along(std::sin(turn), 0.0, std::cos(turn));
    for (const auto& shape : hand.states[i].shapes) {
      if (shape.name != "passive") continue;
      EXPECT_NEAR(std::abs(shape.X_BS.linear().col(2).dot(along)), 1.0, 1e-9);
    }
  }
}

TEST(SmallHand, DepthReachesFromThePalmToTheToolCentre) {
  EXPECT_NEAR(Robot::Load(SmallCell()).hand().depth_m, 0.12 - 0.02, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::robot
