#include "sim/check/internal/finger_poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "base/linear_algebra.h"

namespace rangegrasp::check::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kOpening_m = 0.1;    // between the surfaces of the tips
constexpr double kSqueeze_m = 0.002;  // by which the tips of the closed hand would overlap
constexpr double kBeside = 2.3;       // of a tip's half thickness, from finger to finger
constexpr double kRow_m = 0.01;       // fingers that are closer together stand in no row
constexpr double kPlace_m = 0.002;    // of a tip; weighs as much as a joint's whole range
constexpr double kLoose = 0.1;        // weight of what is only to stay near
constexpr double kHeld_rad = 0.2;     // joints that would move less stand still: they hold better
constexpr int kSteps = 200;
constexpr double kDone_rad = 1e-7;

struct Finger {
  std::vector<int> tips;  // geoms
  double half_thickness_m = 0.0;
};

/// One scalar aim: a weighted sum of tip positions, along a direction.
struct Aim {
  VectorXd share;  // of each finger
  Vector3d along;
  double wanted_m = 0.0;
  double weight = 1.0;
};

class Hand {
 public:
  Hand(const Model& model, std::vector<int> joints, std::vector<Finger> fingers)
      : m_(model.m()),
        data_(mj_makeData(&m_)),
        joints_(std::move(joints)),
        fingers_(std::move(fingers)) {
    const auto n = static_cast<Eigen::Index>(joints_.size());
    low_.resize(n);
    high_.resize(n);
    range_.resize(n);
    natural_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int joint = joints_[static_cast<std::size_t>(i)];
      std::tie(low_[i], high_[i]) = model.RangeOf(joint, mjPI);
      range_[i] = high_[i] - low_[i];
      natural_[i] =
          IsOutermost(joint) ? std::clamp(0.0, low_[i], high_[i]) : 0.5 * (low_[i] + high_[i]);
    }
  }

  Eigen::Index fingers() const { return static_cast<Eigen::Index>(fingers_.size()); }
  const VectorXd& natural() const { return natural_; }

  /// Tip positions, one a column, the thumb's first.
  MatrixXd Tips(const VectorXd& q) {
    Set(q);
    MatrixXd tips(3, fingers());
    for (Eigen::Index f = 0; f < fingers(); ++f) tips.col(f) = TipOf(fingers_[Index(f)]);
    return tips;
  }

  /// Joint positions within their ranges that fulfil the aims best and stay near others.
  VectorXd Reach(const std::vector<Aim>& aims, const VectorXd& near) {
    VectorXd q = near;
    double damping = 1e-3;
    double cost = CostOf(aims, q, near);
    for (int step = 0; step < kSteps; ++step) {
      auto [H, g] = NormalEquations(aims, q, near);
      H.diagonal() *= 1.0 + damping;
      for (Eigen::Index i = 0; i < q.size(); ++i) {  // at an end and pushed out of its range
        if ((q[i] > low_[i] || g[i] <= 0.0) && (q[i] < high_[i] || g[i] >= 0.0)) continue;
        H.row(i).setZero();
        H.col(i).setZero();
        H(i, i) = 1.0;
        g[i] = 0.0;
      }
      const VectorXd next = (q - base::SolveLdlt(H, g)).cwiseMax(low_).cwiseMin(high_);
      const double next_cost = CostOf(aims, next, near);
      damping *= next_cost < cost ? 0.3 : 10.0;
      if (next_cost >= cost) continue;
      const bool done = (next - q).cwiseAbs().maxCoeff() < kDone_rad;
      q = next;
      cost = next_cost;
      if (done) break;
    }
    return q;
  }

  /// A joint that stays where it is from now on.
  void Hold(Eigen::Index joint, double at) { low_[joint] = high_[joint] = at; }

  /// A finger, or the thumb (0), less the middle of all but the thumb.
  VectorXd FromFingers(Eigen::Index finger) const {
    VectorXd share = VectorXd::Constant(fingers(), -1.0 / static_cast<double>(fingers() - 1));
    share[0] = 0.0;
    share[finger] += 1.0;
    return share;
  }

  double BesideEachOther() const { return kBeside * MeanHalfThickness(); }
  double Touching() const {
    return fingers_[0].half_thickness_m + MeanHalfThickness() - kSqueeze_m;
  }

 private:
  static std::size_t Index(Eigen::Index i) { return static_cast<std::size_t>(i); }

  bool IsOutermost(int joint) const {
    return std::ranges::none_of(joints_, [&](int other) {
      return other != joint && m_.jnt_bodyid[other] != m_.jnt_bodyid[joint] &&
             mjcf::InSubtree(&m_, m_.jnt_bodyid[other], m_.jnt_bodyid[joint]);
    });
  }

  double MeanHalfThickness() const {
    double sum_m = 0.0;
    for (const Finger& finger : fingers_) sum_m += finger.half_thickness_m;
    return (sum_m - fingers_[0].half_thickness_m) / static_cast<double>(fingers_.size() - 1);
  }

  void Set(const VectorXd& q) {
    for (Eigen::Index i = 0; i < q.size(); ++i)
      data_->qpos[m_.jnt_qposadr[joints_[Index(i)]]] = q[i];
    mj_kinematics(&m_, data_.get());
    mj_comPos(&m_, data_.get());
  }

  Vector3d TipOf(const Finger& finger) const {
    Vector3d sum = Vector3d::Zero();
    for (const int geom : finger.tips) sum += sim::internal::Vec3(data_->geom_xpos + 3 * geom);
    return sum / static_cast<double>(finger.tips.size());
  }

  MatrixXd JacobianOf(const Finger& finger) const {
    MatrixXd sum = MatrixXd::Zero(3, natural_.size());
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> whole(3, m_.nv);
    for (const int geom : finger.tips) {
      mj_jacGeom(&m_, data_.get(), whole.data(), nullptr, geom);
      for (Eigen::Index i = 0; i < sum.cols(); ++i) {
        sum.col(i) += whole.col(m_.jnt_dofadr[joints_[Index(i)]]);
      }
    }
    return sum / static_cast<double>(finger.tips.size());
  }

  double CostOf(const std::vector<Aim>& aims, const VectorXd& q, const VectorXd& near) {
    const MatrixXd tips = Tips(q);
    double cost = (q - near).cwiseQuotient(range_).squaredNorm();
    for (const Aim& aim : aims) {
      const double off = aim.along.dot(tips * aim.share) - aim.wanted_m;
      cost += std::pow(aim.weight / kPlace_m * off, 2);
    }
    return cost;
  }

  std::pair<MatrixXd, VectorXd> NormalEquations(const std::vector<Aim>& aims, const VectorXd& q,
                                                const VectorXd& near) {
    const MatrixXd tips = Tips(q);
    std::vector<MatrixXd> jacobians;
    for (const Finger& finger : fingers_) jacobians.push_back(JacobianOf(finger));
    const VectorXd ridge = range_.array().square().inverse();
    MatrixXd H = ridge.asDiagonal();
    VectorXd g = ridge.cwiseProduct(q - near);
    for (const Aim& aim : aims) {
      VectorXd row = VectorXd::Zero(q.size());
      for (Eigen::Index f = 0; f < fingers(); ++f) {
        row += aim.share[f] * jacobians[Index(f)].transpose() * aim.along;
      }
      const double weight = std::pow(aim.weight / kPlace_m, 2);
      H += weight * row * row.transpose();
      g += weight * (aim.along.dot(tips * aim.share) - aim.wanted_m) * row;
    }
    return {H, g};
  }

  const mjModel& m_;
  sim::internal::DataPtr data_;
  std::vector<int> joints_;
  std::vector<Finger> fingers_;
  VectorXd low_, high_, range_, natural_;
};

/// Across the hand: along the row of fingers, and square to it from them to the thumb.
struct Axes {
  Vector3d row, to_thumb;
  bool is_row = false;
};

Axes AxesOf(const MatrixXd& tips) {
  const MatrixXd fingers = tips.rightCols(tips.cols() - 1);
  const Vector3d middle = fingers.rowwise().mean();
  const MatrixXd offsets = fingers.colwise() - middle;
  const auto spread = base::SymmetricEigen<3>(offsets * offsets.transpose());
  Axes axes;
  axes.is_row = spread.values[2] > kRow_m * kRow_m;
  axes.to_thumb = tips.col(0) - middle;
  axes.row = axes.is_row ? Vector3d(spread.vectors.col(2)) : axes.to_thumb.unitOrthogonal();
  axes.to_thumb = (axes.to_thumb - axes.row.dot(axes.to_thumb) * axes.row).normalized();
  return axes;
}

VectorXd Closed(Hand& hand) {
  const MatrixXd tips = hand.Tips(hand.natural());
  Axes axes = AxesOf(tips);
  const Vector3d row = axes.row;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(hand.fingers() - 1));
  std::iota(order.begin(), order.end(), 1);
  std::ranges::sort(order, {}, [&](Eigen::Index f) { return row.dot(tips.col(f)); });
  // The thumb stands before the middle of the row: before a finger, or between two.
  const double touching_m = hand.Touching();
  const double beside_m = axes.is_row && order.size() % 2 == 0 ? 0.5 * hand.BesideEachOther() : 0.0;
  const double before_m = std::sqrt(std::max(0.0, touching_m * touching_m - beside_m * beside_m));
  VectorXd q = hand.natural();
  for (int round = 0; round < 3; ++round) {  // the line to the thumb turns a little
    std::vector<Aim> aims;
    for (int a = 0; a < 3; ++a) {
      const Vector3d along = Vector3d::Unit(a);
      aims.push_back({hand.FromFingers(0), along, before_m * along.dot(axes.to_thumb)});
    }
    for (std::size_t k = 0; axes.is_row && k < order.size(); ++k) {
      const double place = static_cast<double>(k) - 0.5 * static_cast<double>(order.size() - 1);
      aims.push_back({hand.FromFingers(order[k]), row, place * hand.BesideEachOther()});
    }
    q = hand.Reach(aims, hand.natural());
    const Vector3d to_thumb = hand.Tips(q) * hand.FromFingers(0);
    axes.to_thumb = (to_thumb - row.dot(to_thumb) * row).normalized();
  }
  return q;
}

VectorXd Open(Hand& hand, const VectorXd& closed) {
  const MatrixXd tips = hand.Tips(closed);
  const Vector3d x = (tips * hand.FromFingers(0)).normalized();
  const Vector3d y = x.unitOrthogonal();
  std::vector<Aim> aims;
  for (const Vector3d& along : {x, y, Vector3d(x.cross(y))}) {
    const bool apart = along == x;
    aims.push_back(
        {hand.FromFingers(0), along, apart ? hand.Touching() + kSqueeze_m + kOpening_m : 0.0});
    for (Eigen::Index f = 0; f < hand.fingers(); ++f) {
      // The fingers stay side by side, in their planes; the thumb and their middle near where
      // they were.
      aims.push_back({VectorXd::Unit(hand.fingers(), f), along, along.dot(tips.col(f)),
                      apart || f == 0 ? kLoose : 1.0});
      if (!apart || f == 0) continue;
      const VectorXd share = hand.FromFingers(f);
      aims.push_back({share, along, along.dot(tips * share)});
    }
  }
  const VectorXd open = hand.Reach(aims, closed);
  for (Eigen::Index i = 0; i < open.size(); ++i) {
    if (std::abs(open[i] - closed[i]) < kHeld_rad) hand.Hold(i, closed[i]);
  }
  return hand.Reach(aims, closed);
}

}  // namespace

std::optional<std::vector<mjcf::HandMotor>> FingerPoses(const Model& model,
                                                        const std::vector<int>& actuators,
                                                        const std::vector<int>& fingertips) {
  const mjModel& m = model.m();
  std::vector<int> joints;
  for (const int a : actuators) {
    if (m.actuator_trntype[a] != mjTRN_JOINT) return std::nullopt;
    joints.push_back(m.actuator_trnid[2 * a]);
  }
  for (int j = 0; j < m.njnt; ++j) {
    if (!model.InSubtree(m.jnt_bodyid[j], model.hand)) continue;
    if (std::ranges::count(joints, j) != 1) return std::nullopt;
  }
  std::vector<int> roots;  // of the fingers, in the order of their tips
  std::vector<Finger> fingers;
  for (const int geom : fingertips) {
    const int root = mjcf::HandBranch(&m, m.geom_bodyid[geom], model.hand);
    const auto found = std::ranges::find(roots, root);
    const auto at = static_cast<std::size_t>(found - roots.begin());
    if (found == roots.end()) {
      roots.push_back(root);
      fingers.emplace_back();
    }
    const mjtNum* half = m.geom_aabb + 6 * geom + 3;
    fingers[at].half_thickness_m =
        std::max(fingers[at].half_thickness_m, *std::min_element(half, half + 3));
    fingers[at].tips.push_back(geom);
  }
  if (fingers.size() < 2 || joints.size() <= fingers.size()) return std::nullopt;
  Hand hand(model, joints, std::move(fingers));
  const VectorXd closed = Closed(hand);
  const VectorXd open = Open(hand, closed);
  std::vector<mjcf::HandMotor> motors;
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    const double gear = m.actuator_gear[6 * actuators[i]];
    const auto at = static_cast<Eigen::Index>(i);
    motors.push_back({actuators[i], gear * open[at], gear * closed[at]});
  }
  return motors;
}

}  // namespace rangegrasp::check::internal
