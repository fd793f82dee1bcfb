#include "parts/cloud/revolution.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Velocities a x p + m.
struct Rotation {
  Vector3d a = Vector3d::Zero();
  Vector3d m = Vector3d::Zero();

  Vector3d VelocityAt(const Vector3d& p) const { return a.cross(p) + m; }
};

/// The sums of the least squares, about the surface's middle and in units of its size.
struct RingSums {
  Matrix3d aa = Matrix3d::Zero(), am = Matrix3d::Zero(), mm = Matrix3d::Zero();

  void Add(double weight, const Vector3d& p, const Vector3d& n) {
    const Vector3d q = p.cross(n);
    aa += weight * q * q.transpose();
    am += weight * q * n.transpose();
    mm += weight * n * n.transpose();
  }
};

/// The surface in a frame of its own.
struct RingFaces {
  Vector3d middle = Vector3d::Zero();
  double size = 0.0;
  geometry::Points center;
  const FaceFrames& frames;

  explicit RingFaces(const FaceFrames& of) : frames(of) {
    for (std::size_t f = 0; f < of.center.size(); ++f) {
      middle += of.area[f] / of.total_area * of.center[f];
    }
    for (std::size_t f = 0; f < of.center.size(); ++f) {
      center.push_back(of.center[f] - middle);
      size += of.area[f] / of.total_area * center.back().squaredNorm();
    }
    size = std::sqrt(size);
    for (Vector3d& p : center) p /= size;
  }
};

/// What a translation costs beside a rotation: all but nothing, so that it is told where the
/// surface, as a cylinder, could also slide along its axis.
constexpr double kRidge = 1e-4;

/// m for a, such that the squares are least, without a pitch along a.
Rotation WithAxis(const RingSums& sums, const Vector3d& a) {
  const Matrix3d mm = sums.mm + kRidge * sums.mm.trace() * Matrix3d::Identity();
  const Vector3d m = -mm.ldlt().solve(sums.am.transpose() * a);
  return {a, m - a.dot(m) * a};
}

Rotation BestOf(const RingSums& sums) {
  const Matrix3d mm = sums.mm + kRidge * sums.mm.trace() * Matrix3d::Identity();
  const Matrix3d left = sums.aa - sums.am * mm.ldlt().solve(sums.am.transpose());
  return WithAxis(sums, Eigen::SelfAdjointEigenSolver<Matrix3d>(left).eigenvectors().col(0));
}

double TwistOf(const Rotation& rotation, const Vector3d& p, const Vector3d& n) {
  // Near to the axis its place is not known well enough for a direction round it.
  constexpr double kNearRing = 0.1;
  const Vector3d velocity = rotation.VelocityAt(p);
  return velocity.dot(n) / std::max(velocity.norm(), kNearRing);
}

Rotation Refine(const RingFaces& faces, Rotation rotation, const RevolutionOptions& options) {
  for (int round = 0; round < options.rounds; ++round) {
    RingSums sums;
    for (std::size_t f = 0; f < faces.center.size(); ++f) {
      const Vector3d& p = faces.center[f];
      const Vector3d& n = faces.frames.normal[f];
      const double twist = TwistOf(rotation, p, n) / options.softness;
      const double off = 1.0 + twist * twist;
      sums.Add(faces.frames.area[f] / (off * off), p, n);
    }
    rotation = BestOf(sums);
  }
  return rotation;
}

double ShareOf(const RingFaces& faces, const Rotation& rotation, double max_twist) {
  double area = 0.0;
  for (std::size_t f = 0; f < faces.center.size(); ++f) {
    if (std::abs(TwistOf(rotation, faces.center[f], faces.frames.normal[f])) <= max_twist) {
      area += faces.frames.area[f];
    }
  }
  return area / faces.frames.total_area;
}

}  // namespace

Eigen::Vector2d RevolutionAxis::ProfileOf(const Vector3d& p) const {
  const Vector3d d = p - point;
  return {direction.cross(d).norm(), direction.dot(d)};
}

double RevolutionAxis::Twist(const Vector3d& p, const Vector3d& normal) const {
  const Vector3d round = direction.cross(p - point);
  const double distance = round.norm();
  return distance > 0.0 ? std::abs(round.dot(normal)) / distance : 0.0;
}

std::optional<RevolutionAxis> FindRevolution(const FaceFrames& frames,
                                             const RevolutionOptions& options) {
  if (!(frames.total_area > 0.0)) return std::nullopt;
  const RingFaces faces(frames);
  RingSums all;
  for (std::size_t f = 0; f < faces.center.size(); ++f) {
    all.Add(frames.area[f], faces.center[f], frames.normal[f]);
  }
  std::vector<Rotation> guesses = {BestOf(all)};
  const Matrix3d of_normals = Eigen::SelfAdjointEigenSolver<Matrix3d>(all.mm).eigenvectors();
  for (int k = 0; k < 3; ++k) guesses.push_back(WithAxis(all, of_normals.col(k)));
  Rotation best;
  double share = -1.0;
  for (const Rotation& guess : guesses) {
    const Rotation refined = Refine(faces, guess, options);
    const double one = ShareOf(faces, refined, options.max_twist);
    if (one <= share) continue;
    share = one;
    best = refined;
  }
  // m = c x a for a point c of the axis.
  return RevolutionAxis{faces.middle + faces.size * best.a.cross(best.m), best.a, share};
}

}  // namespace rangegrasp::parts
