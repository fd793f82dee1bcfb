#include "recognition/symmetry.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "geometry/hull.h"
#include "geometry/kd_tree.h"
#include "recognition/internal/hull_faces.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Directions nearer than this are one (2.6 deg).
constexpr double kSameDirection = 0.999;
/// Turns by these are no symmetry of anything but a solid of revolution [rad].
constexpr double kOddTurns_rad[] = {0.29, 0.83, 1.37, 2.11, 2.93};
/// Faces of the hull whose normals may be axes, the largest.
constexpr std::size_t kMaxFaces = 12;
/// No solid but one of revolution has more: an icosahedron's.
constexpr std::size_t kMaxTurns = 60;

double AngleOf(const Matrix3d& R) {
  return std::acos(std::clamp((R.trace() - 1.0) / 2.0, -1.0, 1.0));
}

/// The surface, and how far a turned copy of it is off.
class Turned {
 public:
  Turned(const geometry::PointCloud& surface_B, const Vector3d& center_B,
         const SymmetryOptions& options)
      : surface_(surface_B), tree_(surface_B.points), center_(center_B), options_(options) {}

  bool LiesOnItself(const Matrix3d& R) const {
    const std::size_t n = surface_.size();
    const std::size_t step = std::max<std::size_t>(1, n / options_.samples);
    std::size_t seen = 0;
    std::size_t strays = 0;
    const auto most = static_cast<double>(n / step) * options_.stray_share;
    for (std::size_t i = 0; i < n; i += step, ++seen) {
      strays += Distance(center_ + R * (surface_.points[i] - center_)) > options_.tolerance_m;
      if (static_cast<double>(strays) > most) return false;
    }
    return seen > 0;
  }

 private:
  // To the planes of the nearest samples.
  double Distance(const Vector3d& p) const {
    thread_local std::vector<geometry::KdTree::Neighbor> near;
    tree_.Nearest(p, 4, near);
    double least = std::numeric_limits<double>::infinity();
    for (const auto& neighbor : near) {
      least = std::min(
          least,
          std::abs((p - surface_.points[neighbor.index]).dot(surface_.normals[neighbor.index])));
    }
    // Beyond an edge the plane goes on where there is no surface.
    const double nearest = std::sqrt(near.front().squared_distance);
    return std::max(least, nearest - kSpacing_m);
  }

  static constexpr double kSpacing_m = 0.003;  // of the samples, generously

  const geometry::PointCloud& surface_;
  geometry::KdTree tree_;
  Vector3d center_;
  const SymmetryOptions& options_;
};

void Add(const Vector3d& direction, std::vector<Vector3d>& axes) {
  if (direction.norm() < 1e-6) return;
  const Vector3d unit = direction.normalized();
  const bool known = std::ranges::any_of(
      axes, [&](const Vector3d& axis) { return std::abs(axis.dot(unit)) > kSameDirection; });
  if (!known) axes.push_back(unit);
}

std::vector<Vector3d> CandidateAxes(const geometry::TriangleMesh& mesh_B,
                                    const Matrix3d& principal) {
  std::vector<Vector3d> axes;
  for (int k = 0; k < 3; ++k) Add(principal.col(k), axes);
  auto faces = internal::HullFaces(mesh_B.vertices);
  std::ranges::stable_sort(faces, std::greater{}, &internal::HullFace::area_m2);
  faces.resize(std::min(faces.size(), kMaxFaces));
  for (const auto& face : faces) Add(face.normal_B, axes);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      Add(faces[i].normal_B + faces[j].normal_B, axes);
      Add(faces[i].normal_B - faces[j].normal_B, axes);
      Add(faces[i].normal_B.cross(faces[j].normal_B), axes);
    }
  }
  return axes;
}

void AddTurn(const Matrix3d& R, std::vector<Matrix3d>& turns) {
  const bool known = std::ranges::any_of(
      turns, [&](const Matrix3d& turn) { return AngleOf(R.transpose() * turn) < 0.05; });
  if (!known) turns.push_back(R);
}

/// What two turns make is one.
void Close(std::vector<Matrix3d>& turns) {
  for (std::size_t i = 0; i < turns.size(); ++i) {
    for (std::size_t j = 0; j < turns.size() && turns.size() < kMaxTurns; ++j) {
      AddTurn(Matrix3d(turns[i] * turns[j]), turns);
    }
  }
}

Matrix3d Turn(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

/// First and second moment of the surface itself: samples of it would be off by their own spread.
struct Moments {
  Vector3d center_B = Vector3d::Zero();
  Matrix3d scatter_B = Matrix3d::Zero();
};
Moments MomentsOf(const geometry::TriangleMesh& mesh_B) {
  Moments moments;
  double area = 0.0;
  for (const auto& triangle : mesh_B.triangles) {
    const Vector3d& a = mesh_B.vertices[triangle[0]];
    const Vector3d& b = mesh_B.vertices[triangle[1]];
    const Vector3d& c = mesh_B.vertices[triangle[2]];
    const double of_triangle = (b - a).cross(c - a).norm() / 2.0;
    const Vector3d sum = a + b + c;
    area += of_triangle;
    moments.center_B += of_triangle * sum / 3.0;
    // The mean of p p^T over a triangle.
    moments.scatter_B +=
        of_triangle / 12.0 *
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  moments.center_B /= area;
  moments.scatter_B = moments.scatter_B / area - moments.center_B * moments.center_B.transpose();
  return moments;
}

}  // namespace

Symmetry SymmetryOf(const geometry::TriangleMesh& mesh_B, const geometry::PointCloud& surface_B,
                    const SymmetryOptions& options) {
  if (surface_B.size() < 4 || surface_B.normals.size() != surface_B.size()) {
    throw std::invalid_argument("SymmetryOf: needs 4 points or more, and a normal for each");
  }
  Symmetry symmetry;
  const Moments moments = MomentsOf(mesh_B);
  symmetry.center_B = moments.center_B;
  const Matrix3d principal =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(moments.scatter_B).eigenvectors();
  const Turned turned(surface_B, symmetry.center_B, options);
  const auto axes = CandidateAxes(mesh_B, principal);
  for (const Vector3d& axis : axes) {
    const bool revolves = std::ranges::all_of(
        kOddTurns_rad, [&](double angle) { return turned.LiesOnItself(Turn(angle, axis)); });
    if (!revolves) continue;
    symmetry.axis_B = axis;
    const Matrix3d flip = Turn(std::numbers::pi, axis.unitOrthogonal());
    if (turned.LiesOnItself(flip)) symmetry.rotations.push_back(flip);
    return symmetry;
  }
  for (const Vector3d& axis : axes) {
    for (int n = 2; n <= options.max_fold; ++n) {
      const double angle = 2.0 * std::numbers::pi / n;
      if (!turned.LiesOnItself(Turn(angle, axis))) continue;
      for (int k = 1; k < n; ++k) AddTurn(Turn(k * angle, axis), symmetry.rotations);
    }
  }
  Close(symmetry.rotations);
  return symmetry;
}

PoseDifference Difference(const base::Pose& X_CB, const base::Pose& other_CB,
                          const Symmetry& symmetry) {
  PoseDifference difference;
  difference.distance_m = (X_CB * symmetry.center_B - other_CB * symmetry.center_B).norm();
  difference.angle_rad = std::numbers::pi;
  const Matrix3d between = X_CB.linear().transpose() * other_CB.linear();
  for (const Matrix3d& turn : symmetry.rotations) {
    const Matrix3d left = between * turn;
    const double angle =
        symmetry.axis_B
            ? std::acos(std::clamp((left * *symmetry.axis_B).dot(*symmetry.axis_B), -1.0, 1.0))
            : AngleOf(left);
    difference.angle_rad = std::min(difference.angle_rad, angle);
  }
  return difference;
}

}  // namespace rangegrasp::recognition
