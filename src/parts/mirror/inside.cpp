#include "parts/mirror/inside.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "parts/mirror/internal/space.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using Face = std::array<std::uint32_t, 3>;

// The solid angle of a triangle seen from the origin (van Oosterom and Strackee 1983), positive if
// it is seen from behind.
double SolidAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double det = a.dot(b.cross(c));
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(det, rest);
}

bool RunsAlong(const Face& face, const std::array<std::uint32_t, 2>& edge) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (face[i] == edge[0] && face[(i + 1) % 3] == edge[1]) return true;
  }
  return false;
}

// The faces turned so that neighbors agree, piece by piece, and each piece encloses a volume >= 0
// as seen from its own middle: files often mix orientations.
std::vector<Face> Oriented(const Shape& mesh) {
  const FaceGraph graph = BuildFaceGraph(mesh);
  std::vector<Face> faces = mesh.faces;
  std::vector<bool> seen(faces.size(), false);
  std::vector<std::uint32_t> piece;
  for (std::uint32_t first = 0; first < faces.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = true;
    piece.assign(1, first);
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const std::uint32_t f = piece[k];
      for (std::uint32_t e = graph.begin[f]; e < graph.begin[f + 1]; ++e) {
        const std::uint32_t next = graph.neighbor[e];
        if (seen[next]) continue;
        seen[next] = true;
        if (RunsAlong(faces[f], graph.edge[e]) == RunsAlong(faces[next], graph.edge[e])) {
          std::swap(faces[next][1], faces[next][2]);
        }
        piece.push_back(next);
      }
    }
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::uint32_t f : piece) middle += mesh.points[faces[f][0]];
    middle /= static_cast<double>(piece.size());
    double volume = 0.0;
    for (const std::uint32_t f : piece) {
      volume +=
          (mesh.points[faces[f][0]] - middle)
              .dot((mesh.points[faces[f][1]] - middle).cross(mesh.points[faces[f][2]] - middle));
    }
    if (volume >= 0.0) continue;
    for (const std::uint32_t f : piece) std::swap(faces[f][1], faces[f][2]);
  }
  return faces;
}

bool IsInsideMesh(const Shape& mesh, const Eigen::Vector3d& p) {
  double angle = 0.0;
  for (const Face& f : Oriented(mesh)) {
    angle += SolidAngle(mesh.points[f[0]] - p, mesh.points[f[1]] - p, mesh.points[f[2]] - p);
  }
  return angle >= 0.5 * 4.0 * core::kPi;
}

// Cells of equal width on the faces of a cube round p; a cell is covered if a point is seen in it.
bool IsInsideCloud(const geometry::Points& points, const Eigen::Vector3d& p) {
  constexpr double kPointsACell = 8.0;  // fewer: gaps between points leave cells uncovered
  constexpr double kMaxSide = 8.0;      // 384 cells; more would see through holes of the surface
  const auto side = static_cast<int>(std::clamp(
      std::sqrt(static_cast<double>(points.size()) / (6.0 * kPointsACell)), 1.0, kMaxSide));
  std::vector<bool> covered(static_cast<std::size_t>(6 * side * side), false);
  for (const Eigen::Vector3d& q : points) {
    const Eigen::Vector3d d = q - p;
    if (!(d.squaredNorm() > 0.0)) return true;
    covered[CubeCell(d, side)] = true;
  }
  const auto count = std::count(covered.begin(), covered.end(), true);
  return 2 * static_cast<std::size_t>(count) >= covered.size();
}

}  // namespace

bool IsInside(const Shape& shape, const Eigen::Vector3d& p) {
  return shape.IsMesh() ? IsInsideMesh(shape, p) : IsInsideCloud(shape.points, p);
}

}  // namespace rangegrasp::parts
