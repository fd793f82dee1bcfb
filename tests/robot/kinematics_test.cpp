#include <gtest/gtest.h>

#include <tuple>

#include "core/error.h"
#include "core/file.h"
#include "robot/test_cells.h"

namespace rangegrasp::robot {
namespace {

class Kinematics : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  Kinematics() : robot_(Robot::Load(GetParam())), reference_(GetParam()) {}
  Robot robot_;
  Reference reference_;
};

// Chains of about ten rotations and translations of about 1 m: rounding stays below 1e-14 a step.
TEST_P(Kinematics, LinkAndHandPosesAreThoseOfMujoco) {
  core::Rng rng(1);
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
  core::Rng rng(2);
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
    const Eigen::MatrixXd J = robot_.HandJacobian(q);
    for (int i = 0; i < robot_.dof(); ++i) {
      const int dof = m->jnt_dofadr[joints[static_cast<std::size_t>(i)]];
      for (int k = 0; k < 3; ++k) {
        const auto at = static_cast<std::size_t>(k * m->nv + dof);
        ASSERT_NEAR(J(k, i), jacp[at], 1e-12);
        ASSERT_NEAR(J(k + 3, i), jacr[at], 1e-12);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, Kinematics, ::testing::ValuesIn(Cells()),
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
  // 9 bodies with the hand: 36 pairs, 8 of neighbours, 7 others excluded.
  EXPECT_EQ(robot.self_pairs().size(), 36u - 8u - 7u);
}

TEST(Load, NamesTheFileAndWhatIsMissing) {
  const auto file = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "tests/data/missing.xml";
  try {
    Robot::Load(file);
    FAIL() << "should throw";
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("missing.xml"), std::string::npos);
  }
}

// The small cell with one thing wrong each: what the message has to name.
TEST(Load, NamesWhatIsWrongInTheFile) {
  const std::string cell = core::ReadFile(SmallCell());
  const auto file = std::filesystem::path(::testing::TempDir()) / "wrong_cell.xml";
  for (const auto& [right, wrong, named] :
       {std::tuple("name=\"workspace\"", "name=\"elsewhere\"", "workspace"),
        std::tuple("name=\"stand\"", "name=\"q/hand\"", "twice"),
        std::tuple("name=\"stand\"", "name=\"q/base\"", "twice"),
        std::tuple("axis=\"0 0 1\" range=\"-180 180\"", "axis=\"0 0 1\"", "needs a range"),
        std::tuple("<joint name=\"j2\"", "<joint name=\"j2\" type=\"slide\"", "hinge")}) {
    std::string text = cell;
    const auto at = text.find(right);
    ASSERT_NE(at, std::string::npos) << right;
    text.replace(at, std::string(right).size(), wrong);
    core::WriteFile(file, text);
    try {
      Robot::Load(file);
      ADD_FAILURE() << "should throw: " << wrong;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("wrong_cell.xml"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace rangegrasp::robot
