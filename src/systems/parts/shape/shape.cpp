#include "parts/shape/shape.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/linear_algebra.h"
#include "base/units.h"
#include "geometry/plane.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::TriangleMesh;

// ---- cleaning ----

/// Points of a tetrahedron: fewer have no inside.
constexpr std::size_t kMinPoints = 4;
/// Sine of a corner angle below which a face's area is rounding: about 50 spacings of doubles.
constexpr double kMinSine = 1e-14;

// For each usable point the first one at the same position.
Indices FirstAtPlace(const Points& points) {
  Indices order = geometry::PositionsWhere(points, IsUsable);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return CoordinatesOf(points[i]); });
  return geometry::FirstTwin(points, order);
}

bool HasArea(const Points& points, const Face& face) {
  const Vector3d u = points[face[1]] - points[face[0]];
  const Vector3d v = points[face[2]] - points[face[0]];
  return u.cross(v).norm() > kMinSine * std::max(u.squaredNorm(), v.squaredNorm());
}

// The face with equal points merged; nullopt if no triangle is left.
std::optional<Face> Joined(const TriangleMesh& mesh, const Face& face, const Indices& first) {
  Face joined;
  for (std::size_t i = 0; i < 3; ++i) {
    if (face[i] >= first.size() || !IsUsable(mesh.vertices[face[i]])) return std::nullopt;
    joined[i] = first[face[i]];
  }
  const bool differ = joined[0] != joined[1] && joined[1] != joined[2] && joined[2] != joined[0];
  return differ && HasArea(mesh.vertices, joined) ? std::optional(joined) : std::nullopt;
}

void KeepFaces(const TriangleMesh& mesh, const Indices& first, Shape& shape) {
  for (const Face& face : mesh.triangles) {
    const auto joined = Joined(mesh, face, first);
    shape.element_of_input.push_back(joined ? static_cast<std::int32_t>(shape.faces.size()) : -1);
    if (joined) shape.faces.push_back(*joined);
  }
  if (shape.faces.empty()) {
    throw base::InputError(
        fmt::format("none of its {} faces is a triangle of three different finite vertices",
                    mesh.triangles.size()));
  }
  shape.points = geometry::Select(mesh.vertices, UseOnly(mesh.vertices.size(), shape.faces));
}

void KeepPoints(const Points& points, const Indices& first, Shape& shape) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::int32_t element = -1;
    if (IsUsable(points[i]) && first[i] < i) {
      element = shape.element_of_input[first[i]];
    } else if (IsUsable(points[i])) {
      element = static_cast<std::int32_t>(shape.points.size());
      shape.points.push_back(points[i]);
    }
    shape.element_of_input.push_back(element);
  }
}

// ---- canonical form ----

/// For a mesh of area 1: far above rounding of a rotation in double precision, far below any face.
constexpr double kGrid = 0x1p-30;

Vector3d Cross(const Shape& mesh, const Face& face) {
  const Vector3d& a = mesh.points[face[0]];
  return (mesh.points[face[1]] - a).cross(mesh.points[face[2]] - a);
}

/// Sorts vertices by coordinates and faces by their vertices, each with its lowest vertex first.
void Sort(CanonicalMesh& canonical) {
  Shape& mesh = canonical.mesh;
  const Indices order = geometry::CanonicalOrder(mesh.points);
  Indices place(order.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;
  mesh.points = geometry::Select(mesh.points, order);
  std::vector<std::pair<Face, std::uint32_t>> faces;
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
  // Relative to a vertex: far from the origin the mean position would have a larger rounding error.
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

/// Rotates points to the axes of a symmetric matrix, the largest first. Each axis points where the
/// skew along it, measured after that rotation, is positive.
template <class Skewed>
void Turn(const Matrix3d& inertia, Points& points, const Skewed& skews_of) {
  const Matrix3d by_rising = base::SymmetricEigen(inertia).vectors;
  const Matrix3d axes = by_rising.rowwise().reverse();
  for (Vector3d& p : points) p = axes.transpose() * p;
  const Vector3d skews = skews_of();
  // The skews determine two signs; that of the least skewed axis makes the frame right-handed.
  Vector3d signs = skews.unaryExpr([](double skew) { return skew < 0.0 ? -1.0 : 1.0; });
  int weakest = 0;
  skews.cwiseAbs().minCoeff(&weakest);
  signs[weakest] *= axes.determinant() * signs.prod();
  for (Vector3d& p : points) p = p.cwiseProduct(signs);
}

void RoundOff(Points& points) {
  for (Vector3d& p : points) p = (p / kGrid).array().round() * kGrid;
}

}  // namespace

Indices UseOnly(std::size_t vertices, std::vector<Face>& faces) {
  std::vector<bool> used(vertices, false);
  for (const Face& face : faces) {
    for (const std::uint32_t v : face) used[v] = true;
  }
  const Indices kept = geometry::PositionsOf(used);
  Indices number(vertices);
  for (std::uint32_t k = 0; k < kept.size(); ++k) number[kept[k]] = k;
  for (Face& face : faces) {
    for (std::uint32_t& v : face) v = number[v];
  }
  return kept;
}

bool IsUsable(const Eigen::Vector3d& p) {
  // Fourth powers of larger values exceed the range of a double.
  constexpr double kMaxCoordinate = 1e70;
  return p.allFinite() && p.cwiseAbs().maxCoeff() < kMaxCoordinate;
}

Shape MakeShape(const TriangleMesh& mesh) {
  const auto first = FirstAtPlace(mesh.vertices);
  Shape shape;
  mesh.triangles.empty() ? KeepPoints(mesh.vertices, first, shape) : KeepFaces(mesh, first, shape);
  if (shape.points.size() < kMinPoints) {
    throw base::InputError(
        fmt::format("has only {} different finite points; a shape has at least {}",
                    shape.points.size(), kMinPoints));
  }
  if (geometry::IsFlat(shape.points)) {
    throw base::InputError("all of its points lie in one plane; a shape needs a depth");
  }
  return shape;
}

FaceFrames BuildFaceFrames(const Shape& mesh) {
  FaceFrames frames;
  for (const Face& face : mesh.faces) {
    const auto& [a, b, c] = face;
    const Vector3d cross = Cross(mesh, face);
    frames.center.emplace_back((mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0);
    frames.normal.emplace_back(cross.normalized());
    frames.area.push_back(0.5 * cross.norm());
    frames.total_area += frames.area.back();
  }
  return frames;
}

Vector3d SpiralDirection(int k, double z) {
  const double turn = k * base::kPi * (3.0 - std::sqrt(5.0));
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

std::vector<double> GroupSums(const Labels& group, const std::vector<double>& weight,
                              std::size_t count) {
  std::vector<double> sums(count, 0.0);
  for (std::size_t i = 0; i < group.size(); ++i) sums[group[i]] += weight[i];
  return sums;
}

FaceFrames GroupFrames(const FaceFrames& faces, const Labels& group, std::size_t count) {
  FaceFrames sums{Points(count, Vector3d::Zero()), Points(count, Vector3d::Zero()),
                  GroupSums(group, faces.area, count), faces.total_area};
  for (std::size_t f = 0; f < group.size(); ++f) {
    sums.center[group[f]] += faces.area[f] * faces.center[f];
    sums.normal[group[f]] += faces.area[f] * faces.normal[f];
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (sums.area[k] > 0.0) sums.center[k] /= sums.area[k];
    sums.normal[k].normalize();
  }
  return sums;
}

std::vector<double> HeightsAbove(const TriangleMesh& hull, const Points& points) {
  std::vector<double> height(points.size(), -std::numeric_limits<double>::infinity());
  for (const auto& [a, b, c] : hull.triangles) {
    const Vector3d& corner = hull.vertices[a];
    const Vector3d normal =
        (hull.vertices[b] - corner).cross(hull.vertices[c] - corner).normalized();
    for (std::size_t i = 0; i < points.size(); ++i) {
      height[i] = std::max(height[i], normal.dot(points[i] - corner));
    }
  }
  return height;
}

CanonicalMesh MakeCanonical(const Shape& mesh) {
  CanonicalMesh canonical{{mesh.points, mesh.faces, {}}, Indices(mesh.faces.size())};
  std::iota(canonical.origin.begin(), canonical.origin.end(), 0u);
  Sort(canonical);  // rounding of sums depends on the order of their terms
  ShiftAndScale(canonical.mesh);
  Turn(Inertia(canonical.mesh), canonical.mesh.points, [&] { return Skews(canonical.mesh); });
  RoundOff(canonical.mesh.points);
  Sort(canonical);
  return canonical;
}

CanonicalCloud MakeCanonicalCloud(const Points& input) {
  const Indices origin = geometry::CanonicalOrder(input);
  Points points = geometry::Select(input, origin);
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
  const Indices order = geometry::CanonicalOrder(points);
  return {geometry::Select(points, order), ValuesAt(origin, order)};
}

}  // namespace rangegrasp::parts
