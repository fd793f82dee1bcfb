#include "parts/shape/canonical_mesh.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::Points;
using Face = std::array<std::uint32_t, 3>;

/// Of a mesh of area 1: far above what a turn in double precision rounds off, far below any face.
constexpr double kGrid = 0x1p-30;

Vector3d Cross(const Shape& mesh, const Face& face) {
  const Vector3d& a = mesh.points[face[0]];
  return (mesh.points[face[1]] - a).cross(mesh.points[face[2]] - a);
}

/// Points by their coordinates.
std::vector<std::uint32_t> OrderOf(const Points& points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vector3d& p = points[a];
    const Vector3d& q = points[b];
    return std::tie(p.x(), p.y(), p.z()) < std::tie(q.x(), q.y(), q.z());
  });
  return order;
}

/// Vertices by their coordinates, faces by their vertices, the lowest of each first.
void Sort(CanonicalMesh& canonical) {
  Shape& mesh = canonical.mesh;
  const std::vector<std::uint32_t> order = OrderOf(mesh.points);
  std::vector<std::uint32_t> place(order.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;
  mesh.points = geometry::Select(mesh.points, order);
  std::vector<std::pair<Face, std::uint32_t>> faces;
  faces.reserve(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    Face face = mesh.faces[f];
    for (std::uint32_t& v : face) v = place[v];
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    faces.emplace_back(face, canonical.origin[f]);
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::tie(mesh.faces[f], canonical.origin[f]) = faces[f];
  }
}

void ShiftAndScale(Shape& mesh) {
  double area = 0.0;
  Vector3d center = Vector3d::Zero();
  // From a vertex on: far from the origin the mean of places would be rounded more.
  const Vector3d first = mesh.points.front();
  for (const Face& face : mesh.faces) {
    const double part = 0.5 * Cross(mesh, face).norm();
    area += part;
    for (const std::uint32_t v : face) center += part / 3.0 * (mesh.points[v] - first);
  }
  center = first + center / area;
  for (Vector3d& p : mesh.points) p = (p - center) / std::sqrt(area);
}

/// The integral of x x^T over the surface: exact for each triangle.
Matrix3d Inertia(const Shape& mesh) {
  Matrix3d sum = Matrix3d::Zero();
  for (const Face& face : mesh.faces) {
    Vector3d all = Vector3d::Zero();
    Matrix3d each = Matrix3d::Zero();
    for (const std::uint32_t v : face) {
      all += mesh.points[v];
      each += mesh.points[v] * mesh.points[v].transpose();
    }
    sum += Cross(mesh, face).norm() / 24.0 * (each + all * all.transpose());
  }
  return sum;
}

/// The integrals of the cubes of the coordinates over the surface, exact for each triangle.
Vector3d Skews(const Shape& mesh) {
  Vector3d sum = Vector3d::Zero();
  for (const Face& face : mesh.faces) {
    // Over a triangle: area / 10 times the sum of all products of three corners, with repetition.
    const Vector3d& a = mesh.points[face[0]];
    const Vector3d& b = mesh.points[face[1]];
    const Vector3d& c = mesh.points[face[2]];
    const auto products = [&](int i) {
      const double x = a[i], y = b[i], z = c[i];
      return x * x * (x + y + z) + y * y * (y + z) + z * z * z + x * y * (y + z) + (x + y) * z * z;
    };
    sum += 0.05 * Cross(mesh, face).norm() * Vector3d(products(0), products(1), products(2));
  }
  return sum;
}

/// Turns points to the axes of a symmetric matrix, the largest first, each pointing where the skews
/// along them, as measured after that turn, are positive.
template <class Skewed>
void Turn(const Matrix3d& inertia, Points& points, const Skewed& skews_of) {
  const Matrix3d by_rising = Eigen::SelfAdjointEigenSolver<Matrix3d>(inertia).eigenvectors();
  const Matrix3d axes = by_rising.rowwise().reverse();
  for (Vector3d& p : points) p = axes.transpose() * p;
  const Vector3d skews = skews_of();
  // Two signs are told by the skews; the least skewed axis makes the frame right-handed.
  Vector3d signs = skews.unaryExpr([](double skew) { return skew < 0.0 ? -1.0 : 1.0; });
  int weakest = 0;
  skews.cwiseAbs().minCoeff(&weakest);
  signs[weakest] *= axes.determinant() * signs.prod();
  for (Vector3d& p : points) p = p.cwiseProduct(signs);
}

void RoundOff(Points& points) {
  for (Vector3d& p : points) {
    p = p.unaryExpr([](double x) { return std::round(x / kGrid) * kGrid; });
  }
}

}  // namespace

CanonicalMesh MakeCanonical(const Shape& mesh) {
  CanonicalMesh canonical{{mesh.points, mesh.faces, {}},
                          std::vector<std::uint32_t>(mesh.faces.size())};
  std::iota(canonical.origin.begin(), canonical.origin.end(), 0u);
  Sort(canonical);  // sums are rounded in the order of their terms
  ShiftAndScale(canonical.mesh);
  Turn(Inertia(canonical.mesh), canonical.mesh.points, [&] { return Skews(canonical.mesh); });
  RoundOff(canonical.mesh.points);
  Sort(canonical);
  return canonical;
}

CanonicalCloud MakeCanonicalCloud(const Points& input) {
  CanonicalCloud canonical{{}, OrderOf(input)};
  Points& points = canonical.points;
  points = geometry::Select(input, canonical.origin);
  const Vector3d middle = geometry::Centroid(points);
  Matrix3d inertia = Matrix3d::Zero();
  for (Vector3d& p : points) {
    p -= middle;
    inertia += p * p.transpose() / static_cast<double>(points.size());
  }
  const double size = std::sqrt(inertia.trace());
  for (Vector3d& p : points) p /= size;
  Turn(inertia, points, [&] {
    Vector3d skews = Vector3d::Zero();
    for (const Vector3d& p : points) skews += p.cwiseProduct(p).cwiseProduct(p);
    return skews;
  });
  RoundOff(points);
  const std::vector<std::uint32_t> order = OrderOf(points);
  points = geometry::Select(points, order);
  std::vector<std::uint32_t> origin;
  for (const std::uint32_t k : order) origin.push_back(canonical.origin[k]);
  canonical.origin = std::move(origin);
  return canonical;
}

}  // namespace rangegrasp::parts
