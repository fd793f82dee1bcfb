#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/frames.h"
#include "core/rng.h"
#include "core/trajectory.h"
#include "geometry/shape.h"
#include "robot/hand_model.h"

namespace rangegrasp::robot {

/// A body of the arm and its collision shapes, in the body's frame.
struct Link {
  std::string name;
  int parent = -1;  ///< position in Robot::links(), -1: W (of the base, links()[0], alone)
  core::Pose X_PB =
      core::Pose::Identity();  ///< in the parent's frame (base: in W), at joint position 0
  int joint = -1;              ///< the joint that moves this link, -1: fixed to its parent
  Eigen::Vector3d axis_B;      ///< the joint's axis through anchor_B
  Eigen::Vector3d anchor_B;
  std::vector<geometry::Shape> shapes;
};

/// The kinematics and geometry of the arm and hand in a scene file, and the fixed geometry round
/// them that a work cell's drawing would give (table, pedestal, scanner). No object, no truth: it
/// reads the scene as written, before objects are put in.
class Robot {
 public:
  /// @throws core::InputError naming the file and the missing tuple, joint, site ...
  static Robot Load(const std::filesystem::path& scene_mjcf);

  int dof() const { return static_cast<int>(lower.size()); }
  const std::vector<Link>& links() const { return links_; }
  const HandModel& hand() const { return hand_; }
  /// Fixed collision shapes of the work cell in W, the table's plane not among them (z = 0).
  const std::vector<geometry::Shape>& workcell() const { return workcell_; }

  /// Poses of all links in W at joint positions q [rad].
  std::vector<core::Pose> LinkPoses(const Eigen::VectorXd& q) const;
  /// The hand's root body in W.
  core::Pose HandPose(const Eigen::VectorXd& q) const;
  /// 6 x dof: linear [m/rad] then angular velocity of the hand's root body, in W.
  Eigen::MatrixXd HandJacobian(const Eigen::VectorXd& q) const;
  /// Both in one sweep along the chain; J_WH is resized only where its size is wrong.
  core::Pose HandPoseAndJacobian(const Eigen::VectorXd& q, Eigen::MatrixXd& J_WH) const;

  /// Pairs of links (positions in links(); links().size() stands for the hand) that may hit each
  /// other: all but neighbours and the pairs that the MJCF excludes. Ascending.
  const std::vector<std::array<int, 2>>& self_pairs() const { return self_pairs_; }

  Eigen::VectorXd lower, upper;                     ///< [rad]
  Eigen::VectorXd velocity, acceleration;           ///< [rad/s], [rad/s^2] the published limits
  Eigen::VectorXd home;                             ///< [rad]
  core::Pose X_FH = core::Pose::Identity();         ///< hand's root body in the last link
  core::Pose X_WScanner = core::Pose::Identity();   ///< site "scanner"
  core::Pose X_WDelivery = core::Pose::Identity();  ///< site "delivery"
  core::Pose X_WWorkspace = core::Pose::Identity();
  double workspace_radius_m = 0.0;

 private:
  std::vector<Link> links_;
  HandModel hand_;
  std::vector<geometry::Shape> workcell_;
  std::vector<std::array<int, 2>> self_pairs_;
};

struct IkOptions {
  int starts = 24;  ///< random restarts after the seed itself
  int iterations = 60;
  double position_tolerance_m = 1e-5;
  double rotation_tolerance_rad = 1e-4;
  double limit_margin_rad = 0.02;  ///< stay this far inside the joint limits
};
/// Damped least squares (Levenberg-Marquardt) with joint limits from a seed and random restarts.
/// @return all distinct solutions found up to `most`, nearest to the seed first; empty if none.
std::vector<Eigen::VectorXd> SolveIk(const Robot& robot, const core::Pose& X_WH,
                                     const Eigen::VectorXd& seed, const IkOptions& options,
                                     core::Rng& rng, std::size_t most = 8);

/// Moves the hand through the poses X_WH one after the other from q_start (a pose near the first),
/// staying on one branch and using the redundancy to keep off the limits: one joint vector a pose
/// (1e-6 m, 1e-5 rad), q_start not among them. nullopt if a pose cannot be met within the joint
/// limits or a joint would jump by more than 0.2 rad.
std::optional<std::vector<Eigen::VectorXd>> FollowPoses(const Robot& robot,
                                                        const Eigen::VectorXd& q_start,
                                                        const std::vector<core::Pose>& poses_WH);

/// Moves the hand on a straight line in W (rotation by slerp) from X_WH(q_start) to X_WH, by steps,
/// as FollowPoses does. The first joint vector is q_start. nullopt if the line leaves the joint
/// limits or jumps.
std::optional<std::vector<Eigen::VectorXd>> StraightLine(const Robot& robot,
                                                         const Eigen::VectorXd& q_start,
                                                         const core::Pose& X_WH,
                                                         double step_m = 0.01);

struct TimingOptions {
  double velocity_scale = 1.0;  ///< of the published limits, in (0, 1]
  double acceleration_scale = 1.0;
  double period_s = 0.01;
  double corner_rad = 0.05;   ///< how far the rounding may leave a corner of the path (2-norm)
  double smoothing_s = 0.08;  ///< sliding mean over time: bounds the jerk by 2 a / smoothing_s
};
/// Time-parameterises a joint path under the robot's velocity and acceleration limits, at rest at
/// both ends. Corners become circular arcs (Kunz and Stilman 2012), the speed along the path is the
/// fastest allowed (reachability analysis on a grid, Pham and Pham 2018), a sliding mean over
/// smoothing_s then bounds the jerk; it keeps all bounds since it averages shifted copies. The
/// first and last samples are the path's ends exactly. Each joint leaves the path by at most
/// corner_rad + acceleration * smoothing_s^2 / 24.
/// @param path  at least one joint vector; straight joint lines in between.
/// @throws std::invalid_argument if the path is empty or an option is out of range.
core::JointTrajectory TimeParameterise(const Robot& robot, const std::vector<Eigen::VectorXd>& path,
                                       const TimingOptions& options);

}  // namespace rangegrasp::robot
