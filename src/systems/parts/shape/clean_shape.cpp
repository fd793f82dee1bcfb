#include "parts/shape/clean_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "base/error.h"
#include "geometry/plane.h"

namespace rangegrasp::parts {
namespace {

using geometry::Points;
using geometry::TriangleMesh;
using CleanFace = std::array<std::uint32_t, 3>;

constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
/// Of a tetrahedron: fewer have no inside.
constexpr std::size_t kMinPoints = 4;
/// Sine of a face's corner below which its area is rounding: about 50 times the spacing of doubles.
constexpr double kMinSine = 1e-14;

// For each point the first one at the same place; kNone where it is not usable.
std::vector<std::uint32_t> FirstAtPlace(const Points& points) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (IsUsable(points[i])) order.push_back(i);
  }
  const auto key = [&points](std::uint32_t i) {
    return std::tie(points[i].x(), points[i].y(), points[i].z());
  };
  std::stable_sort(order.begin(), order.end(),
                   [&key](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<std::uint32_t> first(points.size(), kNone);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

bool HasArea(const Points& points, const CleanFace& face) {
  const Eigen::Vector3d u = points[face[1]] - points[face[0]];
  const Eigen::Vector3d v = points[face[2]] - points[face[0]];
  return u.cross(v).norm() > kMinSine * std::max(u.squaredNorm(), v.squaredNorm());
}

// The face with equal points joined; nullopt if that leaves no triangle.
std::optional<CleanFace> Joined(const TriangleMesh& mesh, const CleanFace& face,
                                const std::vector<std::uint32_t>& first) {
  CleanFace joined;
  for (std::size_t i = 0; i < 3; ++i) {
    if (face[i] >= first.size() || first[face[i]] == kNone) return std::nullopt;
    joined[i] = first[face[i]];
  }
  if (joined[0] == joined[1] || joined[1] == joined[2] || joined[2] == joined[0]) {
    return std::nullopt;
  }
  if (!HasArea(mesh.vertices, joined)) return std::nullopt;
  return joined;
}

void KeepFaces(const TriangleMesh& mesh, const std::vector<std::uint32_t>& first, Shape& shape) {
  for (const CleanFace& face : mesh.triangles) {
    const auto joined = Joined(mesh, face, first);
    shape.element_of_input.push_back(joined ? static_cast<std::int32_t>(shape.faces.size()) : -1);
    if (joined) shape.faces.push_back(*joined);
  }
  if (shape.faces.empty()) {
    throw base::InputError(
        fmt::format("none of its {} faces is a triangle of three different finite vertices",
                    mesh.triangles.size()));
  }
  // Only vertices that a face uses stay, in their order.
  std::vector<std::uint32_t> position(mesh.vertices.size(), kNone);
  for (const CleanFace& face : shape.faces) {
    for (const std::uint32_t v : face) position[v] = 0;
  }
  for (std::size_t i = 0; i < position.size(); ++i) {
    if (position[i] == kNone) continue;
    position[i] = static_cast<std::uint32_t>(shape.points.size());
    shape.points.push_back(mesh.vertices[i]);
  }
  for (CleanFace& face : shape.faces) {
    for (std::uint32_t& v : face) v = position[v];
  }
}

void KeepPoints(const Points& points, const std::vector<std::uint32_t>& first, Shape& shape) {
  shape.element_of_input.assign(points.size(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (first[i] == kNone) continue;
    if (first[i] == i) {
      shape.element_of_input[i] = static_cast<std::int32_t>(shape.points.size());
      shape.points.push_back(points[i]);
    } else {
      shape.element_of_input[i] = shape.element_of_input[first[i]];
    }
  }
}

}  // namespace

bool IsUsable(const Eigen::Vector3d& p) {
  // Squares of squares of what is larger leave the range of a double.
  constexpr double kMaxCoordinate = 1e70;
  return p.allFinite() && p.cwiseAbs().maxCoeff() < kMaxCoordinate;
}

Shape MakeShape(const TriangleMesh& mesh) {
  const auto first = FirstAtPlace(mesh.vertices);
  Shape shape;
  if (mesh.triangles.empty()) {
    KeepPoints(mesh.vertices, first, shape);
  } else {
    KeepFaces(mesh, first, shape);
  }
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

}  // namespace rangegrasp::parts
