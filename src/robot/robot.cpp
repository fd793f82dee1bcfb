#include "robot/robot.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "base/units.h"
#include "robot/internal/mjcf.h"

namespace rangegrasp::robot {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using internal::Mjcf;

/// Without limits, a joint gets this range on each side of zero and half on each side of home.
constexpr double kContinuous_rad = 2.0 * base::kPi;

/// A body's pose in its parent, as written in the file.
base::Pose PoseInParent(const mjModel& m, int body) {
  const mjtNum* q = m.body_quat + 4 * body;
  return base::MakePose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix(),
                        mjcf::Vec3(m.body_pos + 3 * body));
}

/// The link's pose X_WB from its parent's X_WP, at joint positions q.
base::Pose Advance(const base::Pose& X_WP, const Link& link, const VectorXd& q) {
  base::Pose X_WB = X_WP * link.X_PB;
  if (link.joint < 0) return X_WB;
  const Vector3d anchor_W = X_WB * link.anchor_B;
  X_WB.linear() = X_WB.linear() * Eigen::AngleAxisd(q[link.joint], link.axis_B).toRotationMatrix();
  X_WB.translation() = anchor_W - X_WB.linear() * link.anchor_B;
  return X_WB;
}

/// Bodies from the base (on which the first joint turns, maybe the world) to the hand's carrier.
std::vector<int> ChainBodies(const Mjcf& mjcf, int hand, const std::vector<int>& arm_joints) {
  const mjModel& m = mjcf.model();
  std::vector<int> chain;
  std::size_t base = 0;
  for (int body = m.body_parentid[hand]; body > 0; body = m.body_parentid[body]) {
    chain.push_back(body);
    if (m.body_jntnum[body] > 0) base = chain.size();
  }
  if (base == 0) {
    mjcf.Fail(
        "no joint between the world and body \"hand\": attach the hand to the arm's last link");
  }
  for (const int joint : arm_joints) {
    if (std::ranges::find(chain, m.jnt_bodyid[joint]) != chain.end()) continue;
    mjcf.Fail(fmt::format("joint \"{}\" of tuple \"arm_joints\" does not move body \"hand\"",
                          mjcf.Name(mjOBJ_JOINT, joint)));
  }
  const int base_body = base < chain.size() ? chain[base] : 0;
  chain.resize(base);
  chain.push_back(base_body);
  std::ranges::reverse(chain);
  return chain;
}

/// The index in arm_joints of a chain body's joint; -1 if it has none.
int ArmJoint(const Mjcf& mjcf, int body, const std::vector<int>& arm_joints) {
  const mjModel& m = mjcf.model();
  if (m.body_jntnum[body] == 0) return -1;
  const int id = m.body_jntadr[body];
  const auto found = std::ranges::find(arm_joints, id);
  if (m.body_jntnum[body] > 1 || m.jnt_type[id] != mjJNT_HINGE || found == arm_joints.end()) {
    mjcf.Fail(fmt::format("body \"{}\" must have one hinge joint, listed in \"arm_joints\"",
                          mjcf.Name(mjOBJ_BODY, body)));
  }
  return static_cast<int>(found - arm_joints.begin());
}

Link MakeLink(const Mjcf& mjcf, int body, bool is_base, const std::vector<int>& arm_joints) {
  const mjModel& m = mjcf.model();
  Link link;
  link.name = mjcf.Name(mjOBJ_BODY, body);
  link.X_PB = is_base ? mjcf.BodyPose(body) : PoseInParent(m, body);
  link.joint = ArmJoint(mjcf, body, arm_joints);
  if (link.joint < 0) return link;
  const int id = m.body_jntadr[body];
  link.axis_B = mjcf::Vec3(m.jnt_axis + 3 * id);
  link.anchor_B = mjcf::Vec3(m.jnt_pos + 3 * id);
  // MuJoCo places the body at the joint's reference angle: turn it back to zero.
  const Eigen::AngleAxisd back(-m.qpos0[m.jnt_qposadr[id]], link.axis_B);
  link.X_PB =
      link.X_PB * Eigen::Translation3d(link.anchor_B) * back * Eigen::Translation3d(-link.anchor_B);
  return link;
}

/// The index in the chain of the body that a body is or is rigidly attached to; nullopt for another
/// tree, the hand, and (if the world is the base) everything fixed.
std::optional<std::size_t> LinkOf(const Mjcf& mjcf, const std::vector<int>& chain, int hand,
                                  int body) {
  if (mjcf.InSubtree(body, hand)) return std::nullopt;
  for (int b = body; b > 0; b = mjcf.model().body_parentid[b]) {
    const auto found = std::ranges::find(chain, b);
    if (found != chain.end()) return static_cast<std::size_t>(found - chain.begin());
  }
  return std::nullopt;
}

bool Excluded(const mjModel& m, int a, int b) {
  return std::any_of(m.exclude_signature, m.exclude_signature + m.nexclude, [&](int signature) {
    return signature == (a << 16) + b || signature == (b << 16) + a;
  });
}

/// Whether the engine lets two geoms collide: their bodies are not excluded, and one's type matches
/// the other's affinity.
bool GeomsMeet(const mjModel& m, int g, int h) {
  const bool types = (m.geom_contype[g] & m.geom_conaffinity[h]) != 0 ||
                     (m.geom_contype[h] & m.geom_conaffinity[g]) != 0;
  return types && !Excluded(m, m.geom_bodyid[g], m.geom_bodyid[h]);
}

/// Whether the engine lets no geom of a link collide with `geom`.
bool NeverMeets(const mjModel& m, const std::vector<int>& geoms_of_link, int geom) {
  return std::ranges::none_of(geoms_of_link, [&](int g) { return GeomsMeet(m, g, geom); });
}

/// Geoms of each link, the hand's last.
std::vector<std::vector<int>> GeomsOfLinks(const Mjcf& mjcf, const std::vector<int>& chain,
                                           int hand) {
  const mjModel& m = mjcf.model();
  std::vector<std::vector<int>> geoms(chain.size() + 1);
  for (int g = 0; g < m.ngeom; ++g) {
    if (!mjcf.Collides(g)) continue;
    const bool of_hand = mjcf.InSubtree(m.geom_bodyid[g], hand);
    const auto link = of_hand ? chain.size() : LinkOf(mjcf, chain, hand, m.geom_bodyid[g]);
    if (link) geoms[*link].push_back(g);
  }
  return geoms;
}

/// Weld groups: how many joints lie between the base and each link, the hand last.
std::vector<int> WeldGroups(const Mjcf& mjcf, const std::vector<int>& chain) {
  std::vector<int> groups;
  int joints = 0;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    if (i > 0 && mjcf.model().body_jntnum[chain[i]] > 0) ++joints;
    groups.push_back(joints);
  }
  groups.push_back(joints);
  return groups;
}

/// As in the engine, rigidly joined links and neighbors across one joint never collide. An
/// exclusion of the hand's root body also applies to its fingers.
std::vector<std::array<int, 2>> SelfPairs(const Mjcf& mjcf, const std::vector<int>& chain, int hand,
                                          const std::vector<std::vector<int>>& geoms) {
  const mjModel& m = mjcf.model();
  std::vector<int> bodies = chain;
  bodies.push_back(hand);
  const std::vector<int> groups = WeldGroups(mjcf, chain);
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      if (groups[j] - groups[i] < 2 || Excluded(m, bodies[i], bodies[j])) continue;
      const bool meet =
          !std::ranges::all_of(geoms[i], [&](int g) { return NeverMeets(m, geoms[j], g); });
      if (meet) pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  return pairs;
}

/// How far the table's top may be from z = 0: rounding of the numbers in its file.
constexpr double kTableTop_m = 1e-6;

/// The table's top is a plane, or a box whose level top is at z = 0 under the workspace.
bool IsTableTop(const Mjcf& mjcf, int geom, const base::Pose& X_WWorkspace) {
  const mjModel& m = mjcf.model();
  if (m.geom_type[geom] == mjGEOM_PLANE) return true;
  if (m.geom_type[geom] != mjGEOM_BOX) return false;
  const base::Pose X_WS = mjcf.GeomPose(geom);
  const auto half = mjcf::Vec3(m.geom_size + 3 * geom);
  const double top = X_WS.translation().z() + X_WS.linear().row(2).cwiseAbs().dot(half);
  const Vector3d p_S = X_WS.inverse() * X_WWorkspace.translation();
  return std::abs(top) < kTableTop_m && std::abs(p_S.x()) <= half.x() &&
         std::abs(p_S.y()) <= half.y();
}

/// Fixed geoms other than the arm's.
struct FixedGeoms {
  std::vector<int> tops;  ///< of the table
  std::vector<int> others;
};

FixedGeoms FindFixed(const Mjcf& mjcf, const std::vector<int>& chain, int hand,
                     const base::Pose& X_WWorkspace) {
  const mjModel& m = mjcf.model();
  // An open box with objects in it belongs to the perceived scene, not to the work cell's drawing.
  const int container = mjcf.FindIfAny(mjOBJ_SITE, "container");
  const int container_body = container < 0 ? -1 : m.site_bodyid[container];
  FixedGeoms fixed;
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    if (body == container_body || m.body_weldid[body] != 0 || !mjcf.Collides(g)) continue;
    if (LinkOf(mjcf, chain, hand, body)) continue;
    (IsTableTop(mjcf, g, X_WWorkspace) ? fixed.tops : fixed.others).push_back(g);
  }
  return fixed;
}

void ReadLimits(const Mjcf& mjcf, const std::vector<int>& arm_joints, Robot& robot) {
  const int dof = static_cast<int>(arm_joints.size());
  robot.lower.resize(dof);
  robot.upper.resize(dof);
  robot.home = mjcf.Numeric("home", dof);
  for (int i = 0; i < dof; ++i) {
    const int id = arm_joints[i];
    const bool limited = mjcf.model().jnt_limited[id] != 0;
    const double* range = mjcf.model().jnt_range + 2 * id;
    const double half = 0.5 * kContinuous_rad;
    robot.lower[i] = limited ? range[0] : std::min(-kContinuous_rad, robot.home[i] - half);
    robot.upper[i] = limited ? range[1] : std::max(kContinuous_rad, robot.home[i] + half);
  }
  robot.velocity = mjcf.Numeric("joint_velocity", dof);
  robot.acceleration = mjcf.Numeric("joint_acceleration", dof);
}

/// Pose of the site "wrist_scanner" in the hand's root body; nullopt if the scene has none.
std::optional<base::Pose> WristScanner(const Mjcf& mjcf, int hand) {
  const int site = mjcf.FindIfAny(mjOBJ_SITE, "wrist_scanner");
  if (site < 0) return std::nullopt;
  const mjModel& m = mjcf.model();
  if (m.body_weldid[m.site_bodyid[site]] != m.body_weldid[hand]) {
    mjcf.Fail("site \"wrist_scanner\" must move with body \"hand\": put it on the arm's last link");
  }
  return mjcf.BodyPose(hand).inverse() * mjcf.SitePose(site);
}

}  // namespace

std::size_t HandModel::IndexAtGap(double gap_m) const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    if (states[i].gap_m >= gap_m && states[i].gap_m < states[best].gap_m) best = i;
  }
  return best;
}

std::vector<base::Pose> Robot::LinkPoses(const VectorXd& q) const {
  std::vector<base::Pose> poses_W;
  poses_W.reserve(links_.size());
  base::Pose X_WB = base::Pose::Identity();
  for (const Link& link : links_) {
    X_WB = Advance(X_WB, link, q);
    poses_W.push_back(X_WB);
  }
  return poses_W;
}

base::Pose Robot::HandPose(const VectorXd& q) const {
  base::Pose X_WB = base::Pose::Identity();
  for (const Link& link : links_) X_WB = Advance(X_WB, link, q);
  return X_WB * X_FH;
}

base::Pose Robot::HandPoseAndJacobian(const VectorXd& q, Eigen::MatrixXd& J_WH) const {
  J_WH.resize(6, dof());
  base::Pose X_WB = base::Pose::Identity();
  // The upper half holds the anchors until the hand's position is known.
  for (const Link& link : links_) {
    X_WB = Advance(X_WB, link, q);
    if (link.joint < 0) continue;
    J_WH.col(link.joint).head<3>() = X_WB * link.anchor_B;
    J_WH.col(link.joint).tail<3>() = X_WB.linear() * link.axis_B;
  }
  const base::Pose X_WH = X_WB * X_FH;
  for (Eigen::Index i = 0; i < J_WH.cols(); ++i) {
    const Vector3d arm_W = X_WH.translation() - J_WH.col(i).head<3>();
    const Vector3d axis_W = J_WH.col(i).tail<3>();
    J_WH.col(i).head<3>() = axis_W.cross(arm_W);
  }
  return X_WH;
}

Robot Robot::Load(const std::filesystem::path& scene_mjcf) {
  const Mjcf mjcf(scene_mjcf);
  const int hand = mjcf.Require(mjOBJ_BODY, "hand");
  const std::vector<int> arm_joints = mjcf.Tuple("arm_joints", mjOBJ_JOINT);
  const std::vector<int> chain = ChainBodies(mjcf, hand, arm_joints);

  Robot robot;
  ReadLimits(mjcf, arm_joints, robot);
  for (const int body : chain) {
    robot.links_.push_back(MakeLink(mjcf, body, body == chain.front(), arm_joints));
  }
  if (chain.front() == 0) {
    // If the arm is mounted on the world itself, the base's frame is at the first link.
    robot.links_[0].X_PB.translation() = robot.links_[1].X_PB.translation();
    robot.links_[1].X_PB.translation().setZero();
  }
  const auto geoms = GeomsOfLinks(mjcf, chain, hand);
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const base::Pose X_BW = mjcf.BodyPose(chain[i]).inverse();
    for (const int g : geoms[i]) {
      robot.links_[i].shapes.push_back(mjcf.ShapeOf(g, X_BW * mjcf.GeomPose(g)));
    }
  }
  robot.self_pairs_ = SelfPairs(mjcf, chain, hand, geoms);
  const mjModel& m = mjcf.model();
  robot.X_FH = PoseInParent(m, hand);
  robot.X_WScanner = mjcf.SitePose(mjcf.Require(mjOBJ_SITE, "scanner"));
  robot.X_HWristScanner = WristScanner(mjcf, hand);
  robot.X_WDelivery = mjcf.SitePose(mjcf.Require(mjOBJ_SITE, "delivery"));
  const int workspace = mjcf.Require(mjOBJ_SITE, "workspace");
  robot.X_WWorkspace = mjcf.SitePose(workspace);
  robot.workspace_radius_m = m.site_size[3 * workspace];
  const FixedGeoms fixed = FindFixed(mjcf, chain, hand, robot.X_WWorkspace);
  for (const int g : fixed.others) {
    robot.workcell_.push_back(mjcf.ShapeOf(g, mjcf.GeomPose(g)));
    robot.workcell_.back().name = mjcf.GeomTitle(g);
  }
  for (const std::vector<int>& of_link : geoms) {
    const auto never_meets = [&](int g) { return NeverMeets(m, of_link, g); };
    std::vector<char>& ignored = robot.ignored_.emplace_back();
    for (const int g : fixed.others) ignored.push_back(never_meets(g));
    robot.ignores_table_.push_back(!fixed.tops.empty() &&
                                   std::ranges::all_of(fixed.tops, never_meets));
  }
  robot.hand_ = internal::SampleHand(mjcf, hand);
  return robot;
}

}  // namespace rangegrasp::robot
