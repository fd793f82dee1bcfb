#include "recognition/model_shape.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "base/linear_algebra.h"
#include "base/rng.h"
#include "geometry/kd_tree.h"
#include "grasp/surface.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Points drawn per kept cell, so that few cells stay empty (e^-8).
constexpr double kDrawnPerCell = 8.0;
/// Directions closer than this are duplicates (2.6 deg).
constexpr double kSameDirection = 0.999;
/// Only a solid of revolution is symmetric under rotation by these angles [rad].
constexpr double kOddTurns_rad[] = {0.29, 0.83, 1.37, 2.11, 2.93};
/// Number of the hull's largest faces whose normals are candidate axes.
constexpr std::size_t kMaxFaces = 12;
/// Maximum number of rotations of a solid that is not one of revolution: an icosahedron's.
constexpr std::size_t kMaxTurns = 60;
/// Upper bound on the spacing of surface samples.
constexpr double kSampleSpacing_m = 0.003;
/// Coplanar faces: cos 2 deg, finer than one side of a 64-sided round body (5.6 deg).
constexpr double kCoplanar = 0.99939;
constexpr double kSameFace_m = 0.0005;
/// Faces this close in direction (8 deg) are one lying orientation.
constexpr double kSameDown = 0.9903;
constexpr int kAxisIterations = 20;
/// A point that turns off its surface by more [m/rad] is of another part: noise a step of turning.
constexpr double kOff_m = 0.002;
constexpr double kMinRoundShare = 0.7;

std::array<Vector3d, 3> CornersOf(const geometry::TriangleMesh& mesh,
                                  const std::array<std::uint32_t, 3>& triangle) {
  return {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]};
}

double AngleOf(const Matrix3d& R) {
  return std::acos(std::clamp((R.trace() - 1.0) / 2.0, -1.0, 1.0));
}

Matrix3d Turn(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// A hull's faces.

/// A flat face of a convex hull, in the frame B of its points.
struct HullFace {
  Vector3d normal_B = Vector3d::Zero();  ///< unit, outward
  double offset_m = 0.0;                 ///< normal . x on it
  double area_m2 = 0.0;
  geometry::Points corners_B;  ///< three of each triangle
};

/// The hull's triangles, merged into faces if they are coplanar, the largest face first.
std::vector<HullFace> FacesOf(const geometry::TriangleMesh& hull) {
  std::vector<HullFace> faces;
  for (const auto& triangle : hull.triangles) {
    const auto [a, b, c] = CornersOf(hull, triangle);
    const Vector3d cross = (b - a).cross(c - a);
    if (cross.norm() < 1e-10) continue;
    const Vector3d normal = cross.normalized();
    const double offset = normal.dot(a);
    auto face = std::ranges::find_if(faces, [&](const HullFace& f) {
      return f.normal_B.dot(normal) > kCoplanar && std::abs(f.offset_m - offset) < kSameFace_m;
    });
    if (face == faces.end()) {
      faces.push_back({normal, offset, 0.0, {}});
      face = faces.end() - 1;
    }
    face->area_m2 += cross.norm() / 2.0;
    face->corners_B.insert(face->corners_B.end(), {a, b, c});
  }
  std::ranges::stable_sort(faces, std::greater{}, &HullFace::area_m2);
  return faces;
}

/// Distance by which a point in a convex face's plane is outside the face [m]; negative inside.
double Outside(const HullFace& face, const Vector3d& p) {
  double outside = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 2 < face.corners_B.size(); i += 3) {
    double of_triangle = -1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& a = face.corners_B[i + k];
      const Vector3d& b = face.corners_B[i + (k + 1) % 3];
      const Vector3d out = (b - a).cross(face.normal_B).normalized();
      of_triangle = std::max(of_triangle, out.dot(p - a));
    }
    outside = std::min(outside, of_triangle);
  }
  return outside;
}

// Symmetry.

/// Maximum error of a turned surface, except for kStrayShare of it: a scan with 1 mm of noise and
/// error cannot resolve less.
constexpr double kTolerance_m = 0.0015;
constexpr double kStrayShare = 0.02;
constexpr std::size_t kSamples = 600;  // of the surface, that are turned
constexpr int kMaxFold = 8;            // turns by 360 deg / n up to this n

/// The surface, and the error of a turned copy of it.
class TurnedSurface {
 public:
  TurnedSurface(const geometry::PointCloud& surface_B, const Vector3d& center_B)
      : surface_(surface_B), tree_(surface_B.points), center_(center_B) {}

  bool LiesOnItself(const Matrix3d& R) const {
    const std::size_t n = surface_.size();
    const std::size_t step = std::max<std::size_t>(1, n / kSamples);
    const auto max_strays = static_cast<double>(n / step) * kStrayShare;
    std::size_t strays = 0;
    for (std::size_t i = 0; i < n; i += step) {
      strays += Distance(center_ + R * (surface_.points[i] - center_)) > kTolerance_m;
      if (static_cast<double>(strays) > max_strays) return false;
    }
    return true;
  }

 private:
  // Distance to the planes of the nearest samples.
  double Distance(const Vector3d& p) const {
    thread_local std::vector<geometry::KdTree::Neighbor> near;
    tree_.Nearest(p, 4, near);
    double distance = std::numeric_limits<double>::infinity();
    for (const auto& [i, squared_distance] : near) {
      distance = std::min(distance, std::abs((p - surface_.points[i]).dot(surface_.normals[i])));
    }
    // Beyond an edge the plane continues where there is no surface.
    return std::max(distance, std::sqrt(near.front().squared_distance) - kSampleSpacing_m);
  }

  const geometry::PointCloud& surface_;
  geometry::KdTree tree_;
  Vector3d center_;
};

void AddAxis(const Vector3d& direction, std::vector<Vector3d>& axes) {
  if (direction.norm() < 1e-6) return;
  const Vector3d unit = direction.normalized();
  const bool known = std::ranges::any_of(
      axes, [&](const Vector3d& axis) { return std::abs(axis.dot(unit)) > kSameDirection; });
  if (!known) axes.push_back(unit);
}

std::vector<Vector3d> CandidateAxes(const geometry::TriangleMesh& mesh_B,
                                    const Matrix3d& principal) {
  std::vector<Vector3d> axes;
  for (int k = 0; k < 3; ++k) AddAxis(principal.col(k), axes);
  auto faces = FacesOf(geometry::ConvexHull(mesh_B.vertices));
  faces.resize(std::min(faces.size(), kMaxFaces));
  for (const auto& face : faces) AddAxis(face.normal_B, axes);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      AddAxis(faces[i].normal_B + faces[j].normal_B, axes);
      AddAxis(faces[i].normal_B - faces[j].normal_B, axes);
      AddAxis(faces[i].normal_B.cross(faces[j].normal_B), axes);
    }
  }
  return axes;
}

void AddTurn(const Matrix3d& R, std::vector<Matrix3d>& turns) {
  const bool known = std::ranges::any_of(
      turns, [&](const Matrix3d& turn) { return AngleOf(R.transpose() * turn) < 0.05; });
  if (!known) turns.push_back(R);
}

/// Adds the products of all turns, which form a group.
void Close(std::vector<Matrix3d>& turns) {
  for (std::size_t i = 0; i < turns.size(); ++i) {
    for (std::size_t j = 0; j < turns.size() && turns.size() < kMaxTurns; ++j) {
      AddTurn(Matrix3d(turns[i] * turns[j]), turns);
    }
  }
}

/// First and second moments of the surface itself; samples would add an error by their own spread.
struct Moments {
  Vector3d center_B = Vector3d::Zero();
  Matrix3d scatter_B = Matrix3d::Zero();
};
Moments MomentsOf(const geometry::TriangleMesh& mesh_B) {
  Moments moments;
  double area = 0.0;
  for (const auto& triangle : mesh_B.triangles) {
    const auto [a, b, c] = CornersOf(mesh_B, triangle);
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

// The axis of revolution.

/// A turn with the velocity v = shift + turn x p at p, |turn| = 1.
struct Motion {
  Vector3d turn;
  Vector3d shift;
};

/// The motion in which the weighted points leave their surfaces least.
Motion LeastLeaving(const geometry::Points& points, const geometry::Points& normals,
                    const std::vector<double>& weights) {
  Matrix3d turns = Matrix3d::Zero(), mixed = Matrix3d::Zero(), shifts = Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d arm = points[i].cross(normals[i]);
    turns += weights[i] * arm * arm.transpose();
    mixed += weights[i] * normals[i] * arm.transpose();
    shifts += weights[i] * normals[i] * normals[i].transpose();
  }
  // Shifts that leave no surface, such as along a cylinder, are set to zero.
  const Matrix3d shift_of_turn = -shifts.completeOrthogonalDecomposition().solve(mixed);
  const Matrix3d rest = turns + mixed.transpose() * shift_of_turn;
  const Vector3d turn = base::SymmetricEigen(rest).vectors.col(0);
  return {turn, shift_of_turn * turn};
}

}  // namespace

geometry::PointCloud Thinned(const geometry::PointCloud& cloud, double edge_m) {
  std::set<std::array<long, 3>> taken;
  const auto kept = geometry::PositionsWhere(cloud.points, [&](const Vector3d& p) {
    return taken.insert(grasp::GridCell(p, edge_m)).second;
  });
  return {geometry::Select(cloud.points, kept), geometry::Select(cloud.normals, kept)};
}

geometry::PointCloud SampledSurface(const geometry::TriangleMesh& mesh, double spacing_m) {
  base::Rng rng(0);
  geometry::PointCloud drawn;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = CornersOf(mesh, triangle);
    const Vector3d cross = (b - a).cross(c - a);
    const double wanted = kDrawnPerCell * cross.norm() / 2.0 / (spacing_m * spacing_m);
    double left = wanted + rng.Uniform();
    for (; left >= 1.0; left -= 1.0) {
      const double u = rng.Uniform();
      const double v = rng.Uniform();
      drawn.points.push_back(geometry::TrianglePoint(a, b, c, u, v));
      drawn.normals.push_back(cross.normalized());
    }
  }
  return Thinned(drawn, spacing_m);
}

Symmetry SymmetryOf(const geometry::TriangleMesh& mesh_B, const geometry::PointCloud& surface_B) {
  Symmetry symmetry;
  const Moments moments = MomentsOf(mesh_B);
  symmetry.center_B = moments.center_B;
  const Matrix3d principal = base::SymmetricEigen(moments.scatter_B).vectors;
  const TurnedSurface turned(surface_B, symmetry.center_B);
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
    for (int n = 2; n <= kMaxFold; ++n) {
      const double angle = 2.0 * std::numbers::pi / n;
      if (!turned.LiesOnItself(Turn(angle, axis))) continue;
      for (int k = 1; k < n; ++k) AddTurn(Turn(k * angle, axis), symmetry.rotations);
    }
  }
  Close(symmetry.rotations);
  return symmetry;
}

base::Pose TurnAbout(const Matrix3d& turn, const Vector3d& about_B) {
  return base::MakePose(turn, about_B - turn * about_B);
}

std::vector<base::Pose> EqualPoses(const base::Pose& X_CB, const Symmetry& symmetry) {
  std::vector<base::Pose> poses;
  for (const Matrix3d& turn : symmetry.rotations) {
    poses.push_back(X_CB * TurnAbout(turn, symmetry.center_B));
  }
  return poses;
}

double AngleBetween(const Matrix3d& R_CB, const Matrix3d& other_CB, const Symmetry& symmetry) {
  double smallest = std::numbers::pi;
  const Matrix3d between = R_CB.transpose() * other_CB;
  for (const Matrix3d& turn : symmetry.rotations) {
    const Matrix3d left = between * turn;
    const double angle =
        symmetry.axis_B
            ? std::acos(std::clamp((left * *symmetry.axis_B).dot(*symmetry.axis_B), -1.0, 1.0))
            : AngleOf(left);
    smallest = std::min(smallest, angle);
  }
  return smallest;
}

PoseDifference Difference(const base::Pose& X_CB, const base::Pose& other_CB,
                          const Symmetry& symmetry) {
  return {(X_CB * symmetry.center_B - other_CB * symmetry.center_B).norm(),
          AngleBetween(X_CB.linear(), other_CB.linear(), symmetry)};
}

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
      // Motion along the normal [m per radian].
      const double leaves = surface_B.normals[i].dot(motion.shift + motion.turn.cross(points[i]));
      const double off = leaves / kOff_m;
      weights[i] = 1.0 / ((1.0 + off * off) * (1.0 + off * off));
      if (std::abs(off) <= 1.0) ++staying;
    }
  }
  const double share = static_cast<double>(staying) / static_cast<double>(points.size());
  if (share < kMinRoundShare) return std::nullopt;
  return Axis{center_B + motion.turn.cross(motion.shift), motion.turn};
}

std::vector<Vector3d> LyingDirections(geometry::PointSpan points_B, double slack_m) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(points_B);
  const Vector3d middle_B = geometry::MassPropertiesOf(hull).center_M;
  std::vector<Vector3d> ways;
  for (const HullFace& face : FacesOf(hull)) {
    const Vector3d foot = middle_B + (face.offset_m - face.normal_B.dot(middle_B)) * face.normal_B;
    if (Outside(face, foot) > slack_m) continue;
    const bool known = std::ranges::any_of(
        ways, [&](const Vector3d& way) { return way.dot(face.normal_B) > kSameDown; });
    if (!known) ways.push_back(face.normal_B);
  }
  return ways;
}

}  // namespace rangegrasp::recognition
