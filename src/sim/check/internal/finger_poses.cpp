#include "sim/check/internal/finger_poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>

#include "base/linear_algebra.h"

namespace rangegrasp::check::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kOpening_m = 0.1;    // between the surfaces of the tips
constexpr double kSqueeze_m = 0.002;  // by which the tips of the closed hand would overlap
constexpr double kBeside = 2.3;       // distance between fingers, per half thickness of a tip
constexpr double kRow_m = 0.01;       // fingers that are closer together form no row
constexpr double kPlace_m = 0.002;    // error of a tip that weighs as much as a joint's whole range
constexpr double kLoose = 0.1;        // weight of tips that only need to stay near
constexpr double kStraight = 0.3;     // weight of straight rows and flat last segments
constexpr double kHeld_rad = 0.2;     // joints that would move less are fixed: they hold better
constexpr int kSteps = 200;
constexpr double kDone_rad = 1e-7;

struct Finger {
  std::vector<int> tips;  // geoms
  int knuckle = -1;       // the joint that moves them
  double half_thickness_m = 0.0;
};

/// One scalar aim: a weighted sum of points, along a direction.
struct Aim {
  VectorXd share;  // weight of each tip, then of each knuckle
  Vector3d along;
  double wanted_m = 0.0;
  double weight = 1.0;
  bool half_way = false;  // at the midpoint of the joint motion
};

/// Joint positions, and their cost: errors of the aims plus motion of the joints.
struct Posture {
  VectorXd q;
  double cost = 0.0;
};

using Held = Eigen::Array<bool, Eigen::Dynamic, 1>;

class Hand {
 public:
  Hand(const Model& model, std::vector<int> joints, std::vector<Finger> fingers)
      : m_(model.m()),
        data_(mj_makeData(&m_)),
        joints_(std::move(joints)),
        fingers_(std::move(fingers)) {
    const Eigen::Index n = std::ssize(joints_);
    for (VectorXd* of : {&low_, &high_, &range_, &natural_}) of->resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int joint = joints_[i];
      std::tie(low_[i], high_[i]) = model.RangeOf(joint, mjPI);
      range_[i] = high_[i] - low_[i];
      natural_[i] =
          IsOutermost(joint) ? std::clamp(0.0, low_[i], high_[i]) : 0.5 * (low_[i] + high_[i]);
    }
  }

  Eigen::Index fingers() const { return std::ssize(fingers_); }
  const VectorXd& natural() const { return natural_; }

  /// Positions of the tips, the thumb's first, then of their knuckles, one per column.
  MatrixXd Points(const VectorXd& q) {
    Set(q);
    MatrixXd points(3, 2 * fingers());
    for (Eigen::Index f = 0; f < fingers(); ++f) {
      points.col(f) = TipOf(fingers_[f]);
      points.col(fingers() + f) = KnuckleOf(fingers_[f]);
    }
    return points;
  }

  /// Joint positions within their ranges that best fulfil the aims and stay near given ones; held
  /// joints do not move.
  Posture Reach(const std::vector<Aim>& aims, const VectorXd& near, const Held& held) {
    VectorXd q = near;
    double damping = 1e-3;
    double cost = CostOf(aims, q, near);
    for (int step = 0; step < kSteps; ++step) {
      auto [H, g] = NormalEquations(aims, q, near);
      H.diagonal() *= 1.0 + damping;
      for (Eigen::Index i = 0; i < q.size(); ++i) {  // fix joints pushed out of their range
        const bool is_free = (q[i] > low_[i] || g[i] <= 0.0) && (q[i] < high_[i] || g[i] >= 0.0);
        if (is_free && !held[i]) continue;
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
    return {q, cost};
  }

  /// Weights of a finger's tip, or the thumb's (0), minus the mean of the fingers' tips.
  VectorXd FromFingers(Eigen::Index finger) const {
    VectorXd share = VectorXd::Zero(2 * fingers());
    share.segment(1, fingers() - 1).setConstant(-1.0 / static_cast<double>(fingers() - 1));
    share[finger] += 1.0;
    return share;
  }
  VectorXd Tip(Eigen::Index finger) const { return VectorXd::Unit(2 * fingers(), finger); }
  VectorXd FromKnuckle(Eigen::Index finger) const {
    return Tip(finger) - VectorXd::Unit(2 * fingers(), fingers() + finger);
  }

  /// Distance between the surfaces of the tips of both sides.
  double Gap(const VectorXd& q) {
    Set(q);
    mjcf::LastSegments tips{fingers_[0].tips, {}};
    for (const Finger& finger : std::span(fingers_).subspan(1)) {
      tips.fingers.insert(tips.fingers.end(), finger.tips.begin(), finger.tips.end());
    }
    return mjcf::GapOf(&m_, data_.get(), tips);
  }

  double BesideEachOther() const { return kBeside * MeanHalfThickness(); }
  double Touching() const {
    return fingers_[0].half_thickness_m + MeanHalfThickness() - kSqueeze_m;
  }

 private:
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
    sim::internal::SetJoints(&m_, data_.get(), joints_, q.data());
    mj_kinematics(&m_, data_.get());
    mj_comPos(&m_, data_.get());
  }

  Vector3d TipOf(const Finger& finger) const {
    Vector3d sum = Vector3d::Zero();
    for (const int geom : finger.tips) sum += sim::internal::Vec3(data_->geom_xpos + 3 * geom);
    return sum / static_cast<double>(finger.tips.size());
  }

  Vector3d KnuckleOf(const Finger& finger) const {
    return sim::internal::Vec3(data_->xanchor + 3 * finger.knuckle);
  }

  MatrixXd JacobianAt(const Vector3d& point, int body) const {
    return sim::internal::JacobianOf(&m_, data_.get(), joints_, body, point);
  }

  /// Jacobians of all points.
  std::vector<MatrixXd> Jacobians() const {
    std::vector<MatrixXd> jacobians;
    for (const Finger& finger : fingers_) {
      MatrixXd sum = MatrixXd::Zero(3, natural_.size());
      for (const int geom : finger.tips) {
        sum += JacobianAt(sim::internal::Vec3(data_->geom_xpos + 3 * geom), m_.geom_bodyid[geom]);
      }
      jacobians.push_back(sum / static_cast<double>(finger.tips.size()));
    }
    for (const Finger& finger : fingers_) {
      jacobians.push_back(JacobianAt(KnuckleOf(finger), m_.jnt_bodyid[finger.knuckle]));
    }
    return jacobians;
  }

  double CostOf(const std::vector<Aim>& aims, const VectorXd& q, const VectorXd& near) {
    double cost = (q - near).cwiseQuotient(range_).squaredNorm();
    for (const bool half_way : {false, true}) {
      const MatrixXd points = Points(half_way ? VectorXd(0.5 * (q + near)) : q);
      for (const Aim& aim : aims) {
        if (aim.half_way != half_way) continue;
        const double off = aim.along.dot(points * aim.share) - aim.wanted_m;
        cost += std::pow(aim.weight / kPlace_m * off, 2);
      }
    }
    return cost;
  }

  std::pair<MatrixXd, VectorXd> NormalEquations(const std::vector<Aim>& aims, const VectorXd& q,
                                                const VectorXd& near) {
    const VectorXd ridge = range_.array().square().inverse();
    MatrixXd H = ridge.asDiagonal();
    VectorXd g = ridge.cwiseProduct(q - near);
    for (const bool half_way : {false, true}) {
      const MatrixXd points = Points(half_way ? VectorXd(0.5 * (q + near)) : q);
      const std::vector<MatrixXd> jacobians = Jacobians();
      for (const Aim& aim : aims) {
        if (aim.half_way != half_way) continue;
        VectorXd row = VectorXd::Zero(q.size());
        for (Eigen::Index p = 0; p < aim.share.size(); ++p) {
          row += aim.share[p] * jacobians[p].transpose() * aim.along;
        }
        if (half_way) row *= 0.5;
        const double weight = std::pow(aim.weight / kPlace_m, 2);
        H += weight * row * row.transpose();
        g += weight * (aim.along.dot(points * aim.share) - aim.wanted_m) * row;
      }
    }
    return {H, g};
  }

  const mjModel& m_;
  sim::internal::DataPtr data_;
  std::vector<int> joints_;
  std::vector<Finger> fingers_;
  VectorXd low_, high_, range_, natural_;
};

/// Axes across the hand: along the row of fingers, and perpendicular to it towards the thumb.
struct Axes {
  Vector3d row, to_thumb;
  bool is_row = false;
};

Axes AxesOf(const MatrixXd& points) {
  const MatrixXd fingers = points.middleCols(1, points.cols() / 2 - 1);
  const Vector3d middle = fingers.rowwise().mean();
  const MatrixXd offsets = fingers.colwise() - middle;
  const auto spread = base::SymmetricEigen<3>(offsets * offsets.transpose());
  Axes axes;
  axes.is_row = spread.values[2] > kRow_m * kRow_m;
  axes.to_thumb = points.col(0) - middle;
  axes.row = axes.is_row ? Vector3d(spread.vectors.col(2)) : axes.to_thumb.unitOrthogonal();
  axes.to_thumb = (axes.to_thumb - axes.row.dot(axes.to_thumb) * axes.row).normalized();
  return axes;
}

/// @param side  1: the thumb is where it is at rest; -1: it is on the other side of the row
Posture Closed(Hand& hand, double side) {
  const VectorXd& rest = hand.natural();
  const MatrixXd points = hand.Points(rest);
  Axes axes = AxesOf(points);
  axes.to_thumb *= side;
  const Vector3d row = axes.row;
  std::vector<Eigen::Index> order(hand.fingers() - 1);
  std::iota(order.begin(), order.end(), 1);
  std::ranges::sort(order, {}, [&](Eigen::Index f) { return row.dot(points.col(f)); });
  // The thumb is opposite the middle of the row: opposite a finger, or between two.
  const double touching_m = hand.Touching();
  const double beside_m = axes.is_row && order.size() % 2 == 0 ? 0.5 * hand.BesideEachOther() : 0.0;
  const double before_m = std::sqrt(std::max(0.0, touching_m * touching_m - beside_m * beside_m));
  Posture closed;
  for (int round = 0; round < 3; ++round) {  // the line to the thumb turns a little
    std::vector<Aim> aims;
    for (int a = 0; a < 3; ++a) {
      const Vector3d along = Vector3d::Unit(a);
      aims.push_back({hand.FromFingers(0), along, before_m * along.dot(axes.to_thumb)});
    }
    for (std::size_t k = 0; axes.is_row && k < order.size(); ++k) {
      const double place = static_cast<double>(k) - 0.5 * static_cast<double>(order.size() - 1);
      const VectorXd share = hand.FromFingers(order[k]);
      aims.push_back({share, row, place * hand.BesideEachOther()});
      for (const Vector3d& across : {axes.to_thumb, Vector3d(row.cross(axes.to_thumb))}) {
        aims.push_back({share, across, 0.0, kStraight});
      }
    }
    closed = hand.Reach(aims, rest, Held::Constant(rest.size(), false));
    const Vector3d to_thumb = hand.Points(closed.q) * hand.FromFingers(0);
    axes.to_thumb = (to_thumb - row.dot(to_thumb) * row).normalized();
  }
  return closed;
}

/// @param apart_m  from the middle of the thumb's tip to that of the others
Posture Open(Hand& hand, const VectorXd& closed, double apart_m) {
  const MatrixXd points = hand.Points(closed);
  const Vector3d x = (points * hand.FromFingers(0)).normalized();
  Vector3d y = AxesOf(points).row;
  y = (y - y.dot(x) * x).normalized();
  std::vector<Aim> aims;
  const auto stay = [&](const VectorXd& share, const Vector3d& along, double weight) {
    aims.push_back({share, along, along.dot(points * share), weight});
  };
  for (const Vector3d& along : {x, y, Vector3d(x.cross(y))}) {
    aims.push_back({hand.FromFingers(0), along, along == x ? apart_m : 0.0});
    // The fingers stay side by side and in their planes, with all tips near where they were. They
    // may move forward or back together, as long fingers do when they open.
    for (Eigen::Index f = 0; f < hand.fingers(); ++f) {
      stay(hand.Tip(f), along, along == y && f > 0 ? 1.0 : kLoose);
      if (along != y && f > 0) stay(hand.FromFingers(f), along, 1.0);
    }
  }
  for (Eigen::Index f = 0; f < hand.fingers(); ++f) {
    aims.push_back({hand.FromKnuckle(f), x, 0.0, kStraight});
  }
  // The thumb stays opposite the fingers' middle on the way, too, or objects turn in the hand.
  aims.push_back({hand.FromFingers(0), y, 0.0, 1.0, true});
  Held held = Held::Constant(closed.size(), false);
  for (;;) {
    const Posture open = hand.Reach(aims, closed, held);
    const Held still = (open.q - closed).array().abs() < kHeld_rad;
    if ((still == held).all()) return open;
    held = held || still;
  }
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
    const int root = model.Finger(m.geom_bodyid[geom]);
    const auto found = std::ranges::find(roots, root);
    const std::size_t at = found - roots.begin();
    if (found == roots.end()) {
      roots.push_back(root);
      fingers.emplace_back();
    }
    const mjtNum* half = m.geom_aabb + 6 * geom + 3;
    fingers[at].half_thickness_m =
        std::max(fingers[at].half_thickness_m, *std::min_element(half, half + 3));
    fingers[at].tips.push_back(geom);
    int body = m.geom_bodyid[geom];
    while (m.body_jntnum[body] == 0) body = m.body_parentid[body];
    fingers[at].knuckle = m.body_jntadr[body] + m.body_jntnum[body] - 1;
  }
  if (fingers.size() < 2 || joints.size() <= fingers.size()) return std::nullopt;
  Hand hand(model, joints, std::move(fingers));
  // The hand may not be able to open on the side where the thumb is at rest.
  VectorXd closed, open;
  double least = std::numeric_limits<double>::infinity();
  for (const double side : {1.0, -1.0}) {
    const Posture shut = Closed(hand, side);
    const double apart_m = hand.Touching() + kSqueeze_m + kOpening_m;
    Posture apart = Open(hand, shut.q, apart_m);
    apart = Open(hand, shut.q, apart_m + kOpening_m - hand.Gap(apart.q));  // tips have a size
    if (shut.cost + apart.cost >= least) continue;
    least = shut.cost + apart.cost;
    closed = shut.q;
    open = apart.q;
  }
  std::vector<mjcf::HandMotor> motors;
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    const double gear = m.actuator_gear[6 * actuators[i]];
    motors.push_back({actuators[i], gear * open[i], gear * closed[i]});
  }
  return motors;
}

}  // namespace rangegrasp::check::internal
