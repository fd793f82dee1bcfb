#include "recognition/internal/revolution.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

namespace rangegrasp::recognition::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kAxisIterations = 20;
/// A point that turns off its surface by more than this for each radian is of another part: a
/// scan's noise for each of the steps that poses are turned in.
constexpr double kOff_m = 0.002;
constexpr double kLeastShare = 0.7;

/// A turn with the velocity v = shift + turn x p at p, |turn| = 1.
struct Motion {
  Vector3d turn;
  Vector3d shift;

  /// Along the normal [m per radian].
  double Leaves(const Vector3d& p, const Vector3d& n) const { return n.dot(shift + turn.cross(p)); }
};

/// The motion that the weighted points leave their surfaces least by.
Motion LeastLeaving(const geometry::Points& points, const geometry::Points& normals,
                    const std::vector<double>& weights) {
  Matrix3d turns = Matrix3d::Zero(), mixed = Matrix3d::Zero(), shifts = Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d arm = points[i].cross(normals[i]);
    turns += weights[i] * arm * arm.transpose();
    mixed += weights[i] * normals[i] * arm.transpose();
    shifts += weights[i] * normals[i] * normals[i].transpose();
  }
  // Shifts that leave nothing, along a cylinder, stay none.
  const Matrix3d shift_of_turn = -shifts.completeOrthogonalDecomposition().solve(mixed);
  const Matrix3d rest = turns + mixed.transpose() * shift_of_turn;
  const Vector3d turn = Eigen::SelfAdjointEigenSolver<Matrix3d>(rest).eigenvectors().col(0);
  return {turn, shift_of_turn * turn};
}

}  // namespace

std::optional<Axis> AxisOfRevolution(const geometry::PointCloud& surface_B) {
  const Vector3d center_B = geometry::Centroid(surface_B.points);
  geometry::Points points = surface_B.points;
  for (Vector3d& p : points) p -= center_B;
  std::vector<double> weights(points.size(), 1.0);
  Motion motion;
  std::size_t staying = 0;
  for (int k = 0; k < kAxisIterations; ++k) {
    motion = LeastLeaving(points, surface_B.normals, weights);
    staying = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double off = motion.Leaves(points[i], surface_B.normals[i]) / kOff_m;
      weights[i] = 1.0 / ((1.0 + off * off) * (1.0 + off * off));
      if (std::abs(off) <= 1.0) ++staying;
    }
  }
  const double share = static_cast<double>(staying) / static_cast<double>(points.size());
  if (share < kLeastShare) return std::nullopt;
  return Axis{center_B + motion.turn.cross(motion.shift), motion.turn};
}

}  // namespace rangegrasp::recognition::internal
