#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"

namespace rangegrasp::robot {

/// The hand as a caliper: one closing number moves all driven fingers. Holds its shapes and tool
/// centres for each closing, sampled once from the hand's MJCF.
struct HandModel {
  /// One state of the hand, in its root body's frame H.
  struct State {
    double gap_m = 0.0;  ///< shortest distance from the thumb's to the fingers' last segments
    std::vector<geometry::Shape> shapes;  ///< all collision shapes of the hand (X_BS is X_HS here)
    std::vector<char> is_finger;   ///< per shape: pads and segments that may touch the object
    std::vector<char> is_thumb;    ///< per shape
    Eigen::Vector3d thumb_pad_H;   ///< the point of the thumb that meets the fingers when closed
    Eigen::Vector3d finger_pad_H;  ///< the mean of the fingers' points that meet the thumb
    /// The published tool centres: between the tips of thumb and index finger (cylindrical and rim
    /// grasps), and between the thumb and the middle of index and little finger (power grasps).
    Eigen::Vector3d tip_center_H, power_center_H;
  };
  /// 24 states, evenly spaced from open to closed (pads touch, or the drives' travel ends). Shape i
  /// of each is shape i of the first, moved.
  std::vector<State> states;
  /// Tool centre of the cylindrical and the rim grasp, for the open hand at pitch 0.
  base::Pose X_HG_tip = base::Pose::Identity();
  /// The hand is held level and approaches straight: its best pitch was not measured.
  bool level = false;
  double depth_m = 0.0;  ///< from the palm's front to the line of the tips

  double MaxGap() const { return states.front().gap_m; }
  /// The index of the state whose gap is nearest above gap_m (of the open one if there is none).
  std::size_t IndexAtGap(double gap_m) const;
  const State& AtGap(double gap_m) const { return states[IndexAtGap(gap_m)]; }
};

/// The length [m] that corresponds to a rotation of the hand by 1 rad: about the hand's length.
constexpr double kRotationRadius_m = 0.25;

/// A body of the arm and its collision shapes, in the body's frame.
struct Link {
  std::string name;
  base::Pose X_PB = base::Pose::Identity();  ///< at joint position 0; P: the link before (base: W)
  int joint = -1;  ///< the joint that moves this link, -1: fixed to its parent
  Eigen::Vector3d axis_B = Eigen::Vector3d::UnitZ();  ///< the joint's axis through anchor_B
  Eigen::Vector3d anchor_B = Eigen::Vector3d::Zero();
  std::vector<geometry::Shape> shapes;
};

/// The kinematics and geometry of the arm and hand in a scene file, and the fixed geometry around
/// them that a work cell's drawing would give (table, pedestal, scanner). The arm has hinges; its
/// base carries the first of them. No ground truth: the scene is read as written, before objects
/// are added, and without the body of the site "container", an open box.
class Robot {
 public:
  /// @throws base::InputError naming the file and the missing tuple, joint, site ...
  static Robot Load(const std::filesystem::path& scene_mjcf);

  int dof() const { return static_cast<int>(lower.size()); }
  const std::vector<Link>& links() const { return links_; }  ///< a chain, from the base
  const HandModel& hand() const { return hand_; }
  /// Fixed collision shapes of the work cell in W, without the table's plane (z = 0).
  const std::vector<geometry::Shape>& workcell() const { return workcell_; }

  std::vector<base::Pose> LinkPoses(const Eigen::VectorXd& q) const;  ///< in W, q in [rad]
  base::Pose HandPose(const Eigen::VectorXd& q) const;                ///< the hand's root body in W
  /// The same with the 6 x dof Jacobian of the hand's root body in W: linear [m/rad], then angular.
  base::Pose HandPoseAndJacobian(const Eigen::VectorXd& q, Eigen::MatrixXd& J_WH) const;

  /// Pairs of links (indices in links(); links().size(): the hand) that may collide: all except
  /// rigidly joined links, neighbors across one joint, and pairs that the MJCF excludes or whose
  /// geoms never collide by their types. Ascending.
  const std::vector<std::array<int, 2>>& self_pairs() const { return self_pairs_; }
  /// Whether the MJCF keeps a link (links().size(): the hand) from colliding with a shape of
  /// workcell(), or with the table's top (for an arm on the floor next to the table).
  bool Ignores(std::size_t link, std::size_t shape) const { return ignored_[link][shape] != 0; }
  bool IgnoresTable(std::size_t link) const { return ignores_table_[link] != 0; }

  Eigen::VectorXd lower, upper;  ///< [rad]; a continuous joint has one turn to either side of zero
  Eigen::VectorXd velocity, acceleration;          ///< [rad/s], [rad/s^2] the published limits
  Eigen::VectorXd home;                            ///< [rad]
  base::Pose X_FH = base::Pose::Identity();        ///< hand's root body in the last link
  base::Pose X_WScanner = base::Pose::Identity();  ///< site "scanner"
  std::optional<base::Pose> X_HWristScanner;  ///< site "wrist_scanner", moves with the hand's root
  base::Pose X_WDelivery = base::Pose::Identity();  ///< site "delivery"
  base::Pose X_WWorkspace = base::Pose::Identity();
  double workspace_radius_m = 0.0;

 private:
  std::vector<Link> links_;
  HandModel hand_;
  std::vector<geometry::Shape> workcell_;
  std::vector<std::array<int, 2>> self_pairs_;
  std::vector<std::vector<char>> ignored_;  // by link and shape of the work cell
  std::vector<char> ignores_table_;         // by link
};

}  // namespace rangegrasp::robot
