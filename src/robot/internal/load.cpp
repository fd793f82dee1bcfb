#include <fmt/format.h>

#include <algorithm>

#include "robot/internal/hand_sampling.h"
#include "robot/internal/mjcf.h"
#include "robot/robot.h"

namespace rangegrasp::robot {
namespace {

using internal::Mjcf;

/// Bodies from the base to the one that carries the hand.
std::vector<int> ChainBodies(const Mjcf& mjcf, int base, int hand) {
  std::vector<int> chain;
  int body = mjcf.model().body_parentid[hand];
  for (; body > base; body = mjcf.model().body_parentid[body]) chain.push_back(body);
  if (body != base) mjcf.Fail("body \"hand\" is not below body \"base\"");
  chain.push_back(base);
  std::reverse(chain.begin(), chain.end());
  return chain;
}

/// The joint of a chain body as a position in arm_joints; -1 if it has none.
int ArmJoint(const Mjcf& mjcf, int body, const std::vector<int>& arm_joints) {
  const mjModel& m = mjcf.model();
  if (m.body_jntnum[body] == 0) return -1;
  const int id = m.body_jntadr[body];
  const auto found = std::find(arm_joints.begin(), arm_joints.end(), id);
  if (m.body_jntnum[body] > 1 || m.jnt_type[id] != mjJNT_HINGE || found == arm_joints.end()) {
    mjcf.Fail(fmt::format("body \"{}\" should have one hinge joint, listed in \"arm_joints\"",
                          mjcf.Name(mjOBJ_BODY, body)));
  }
  return static_cast<int>(found - arm_joints.begin());
}

Link MakeLink(const Mjcf& mjcf, int body, int parent, const std::vector<int>& arm_joints) {
  const mjModel& m = mjcf.model();
  Link link;
  link.name = mjcf.Name(mjOBJ_BODY, body);
  link.parent = parent;
  link.X_PB = parent < 0 ? mjcf.BodyPose(body)
                         : internal::FromPosQuat(m.body_pos + 3 * body, m.body_quat + 4 * body);
  link.axis_B = Eigen::Vector3d::UnitZ();
  link.anchor_B = Eigen::Vector3d::Zero();
  link.joint = ArmJoint(mjcf, body, arm_joints);
  if (link.joint < 0) return link;
  const int id = m.body_jntadr[body];
  link.axis_B = Eigen::Map<const Eigen::Vector3d>(m.jnt_axis + 3 * id);
  link.anchor_B = Eigen::Map<const Eigen::Vector3d>(m.jnt_pos + 3 * id);
  // MuJoCo draws the body at the joint's reference angle: turn it back to zero.
  const Eigen::AngleAxisd back(-m.qpos0[m.jnt_qposadr[id]], link.axis_B);
  link.X_PB =
      link.X_PB * Eigen::Translation3d(link.anchor_B) * back * Eigen::Translation3d(-link.anchor_B);
  return link;
}

/// Gives each link the geoms of its body and of what hangs rigidly on it (not the hand).
void AddShapes(const Mjcf& mjcf, const std::vector<int>& chain, int hand,
               std::vector<Link>& links) {
  const mjModel& m = mjcf.model();
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    if (!mjcf.Collides(g) || !mjcf.InSubtree(body, chain.front()) || mjcf.InSubtree(body, hand)) {
      continue;
    }
    int link_body = body;
    while (std::find(chain.begin(), chain.end(), link_body) == chain.end()) {
      link_body = m.body_parentid[link_body];
    }
    const auto position = std::find(chain.begin(), chain.end(), link_body) - chain.begin();
    const core::Pose X_BS = mjcf.BodyPose(link_body).inverse() * mjcf.GeomPose(g);
    links[static_cast<std::size_t>(position)].shapes.push_back(mjcf.ShapeOf(g, X_BS));
  }
}

bool Excluded(const mjModel& m, int a, int b) {
  const int low = std::min(a, b);
  const int high = std::max(a, b);
  return std::any_of(m.exclude_signature, m.exclude_signature + m.nexclude, [&](int signature) {
    return signature == (low << 16) + high || signature == (high << 16) + low;
  });
}

std::vector<std::array<int, 2>> SelfPairs(const Mjcf& mjcf, const std::vector<int>& chain,
                                          int hand) {
  std::vector<int> bodies = chain;
  bodies.push_back(hand);
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 2; j < bodies.size(); ++j) {
      if (!Excluded(mjcf.model(), bodies[i], bodies[j])) {
        pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
      }
    }
  }
  return pairs;
}

/// How far from z = 0 the table's top may lie: rounding of its file's numbers.
constexpr double kTableTop_m = 1e-6;

/// The table's top is what lies level at z = 0 under the workspace.
bool IsTableTop(const Mjcf& mjcf, int geom, const core::Pose& X_WWorkspace) {
  const mjModel& m = mjcf.model();
  if (m.geom_type[geom] == mjGEOM_PLANE) return true;
  if (m.geom_type[geom] != mjGEOM_BOX) return false;
  const core::Pose X_WS = mjcf.GeomPose(geom);
  const Eigen::Map<const Eigen::Vector3d> half(m.geom_size + 3 * geom);
  const double top = X_WS.translation().z() + X_WS.linear().row(2).cwiseAbs().dot(half);
  const Eigen::Vector3d p_S = X_WS.inverse() * X_WWorkspace.translation();
  return std::abs(top) < kTableTop_m && std::abs(p_S.x()) <= half.x() &&
         std::abs(p_S.y()) <= half.y();
}

std::vector<geometry::Shape> Workcell(const Mjcf& mjcf, int base, const core::Pose& X_WWorkspace) {
  const mjModel& m = mjcf.model();
  // An open box with objects in it is part of what is to be seen, not of the work cell's drawing.
  const int container = mjcf.FindIfAny(mjOBJ_SITE, "container");
  const int container_body = container < 0 ? -1 : m.site_bodyid[container];
  std::vector<geometry::Shape> shapes;
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    if (body == container_body) continue;
    const bool fixed = m.body_weldid[body] == 0 && !mjcf.InSubtree(body, base);
    if (fixed && mjcf.Collides(g) && !IsTableTop(mjcf, g, X_WWorkspace)) {
      shapes.push_back(mjcf.ShapeOf(g, mjcf.GeomPose(g)));
    }
  }
  return shapes;
}

void ReadLimits(const Mjcf& mjcf, const std::vector<int>& arm_joints, Robot& robot) {
  const int dof = static_cast<int>(arm_joints.size());
  robot.lower.resize(dof);
  robot.upper.resize(dof);
  for (int i = 0; i < dof; ++i) {
    const int id = arm_joints[static_cast<std::size_t>(i)];
    if (!mjcf.model().jnt_limited[id]) {
      mjcf.Fail(fmt::format("joint \"{}\" needs a range", mjcf.Name(mjOBJ_JOINT, id)));
    }
    robot.lower[i] = mjcf.model().jnt_range[2 * id];
    robot.upper[i] = mjcf.model().jnt_range[2 * id + 1];
  }
  robot.velocity = mjcf.Numeric("joint_velocity", dof);
  robot.acceleration = mjcf.Numeric("joint_acceleration", dof);
  robot.home = mjcf.Numeric("home", dof);
}

}  // namespace

Robot Robot::Load(const std::filesystem::path& scene_mjcf) {
  const Mjcf mjcf(scene_mjcf);
  const int base = mjcf.Require(mjOBJ_BODY, "base");
  const int hand = mjcf.Require(mjOBJ_BODY, "hand");
  const std::vector<int> arm_joints = mjcf.Tuple("arm_joints", mjOBJ_JOINT);
  const std::vector<int> chain = ChainBodies(mjcf, base, hand);

  Robot robot;
  ReadLimits(mjcf, arm_joints, robot);
  for (std::size_t i = 0; i < chain.size(); ++i) {
    robot.links_.push_back(MakeLink(mjcf, chain[i], static_cast<int>(i) - 1, arm_joints));
  }
  AddShapes(mjcf, chain, hand, robot.links_);
  robot.self_pairs_ = SelfPairs(mjcf, chain, hand);
  const mjModel& m = mjcf.model();
  robot.X_FH = internal::FromPosQuat(m.body_pos + 3 * hand, m.body_quat + 4 * hand);
  robot.X_WScanner = mjcf.SitePose(mjcf.Require(mjOBJ_SITE, "scanner"));
  robot.X_WDelivery = mjcf.SitePose(mjcf.Require(mjOBJ_SITE, "delivery"));
  const int workspace = mjcf.Require(mjOBJ_SITE, "workspace");
  robot.X_WWorkspace = mjcf.SitePose(workspace);
  robot.workspace_radius_m = m.site_size[3 * workspace];
  robot.workcell_ = Workcell(mjcf, base, robot.X_WWorkspace);
  robot.hand_ = internal::SampleHand(mjcf, hand);
  return robot;
}

}  // namespace rangegrasp::robot
