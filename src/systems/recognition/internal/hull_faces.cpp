#include "recognition/internal/hull_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/hull.h"
#include "geometry/mass_properties.h"

namespace rangegrasp::recognition::internal {
namespace {

using Eigen::Vector3d;

/// cos 2 deg: finer than one side of a round body of 64 (5.6 deg).
constexpr double kCoplanar = 0.99939;
constexpr double kSameFace_m = 0.0005;
/// Faces this near in direction (8 deg) are one way to lie.
constexpr double kSameWay = 0.9903;

/// By how much a point in a convex face's plane is outside of it [m]; negative inside.
double Outside(const HullFace& face, const Vector3d& p) {
  double outside = -1.0;
  const std::size_t n = face.corners_B.size();
  for (std::size_t i = 0; i + 2 < n + 0; i += 3) {
    double of_triangle = -1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& a = face.corners_B[i + k];
      const Vector3d& b = face.corners_B[i + (k + 1) % 3];
      const Vector3d out = (b - a).cross(face.normal_B).normalized();
      of_triangle = std::max(of_triangle, out.dot(p - a));
    }
    outside = i == 0 ? of_triangle : std::min(outside, of_triangle);
  }
  return outside;
}

}  // namespace

std::vector<HullFace> HullFaces(geometry::PointSpan points_B) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(points_B);
  std::vector<HullFace> faces;
  for (const auto& triangle : hull.triangles) {
    const Vector3d& a = hull.vertices[triangle[0]];
    const Vector3d& b = hull.vertices[triangle[1]];
    const Vector3d& c = hull.vertices[triangle[2]];
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
  return faces;
}

std::vector<Vector3d> LyingDirections(geometry::PointSpan points_B, double slack_m) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(points_B);
  const Vector3d middle_B = geometry::MassPropertiesOf(hull).center_M;
  auto faces = HullFaces(points_B);
  std::ranges::stable_sort(faces, std::greater{}, &HullFace::area_m2);
  std::vector<Vector3d> ways;
  for (const HullFace& face : faces) {
    const Vector3d foot = middle_B + (face.offset_m - face.normal_B.dot(middle_B)) * face.normal_B;
    if (Outside(face, foot) > slack_m) continue;
    const bool known = std::ranges::any_of(
        ways, [&](const Vector3d& way) { return way.dot(face.normal_B) > kSameWay; });
    if (!known) ways.push_back(face.normal_B);
  }
  return ways;
}

}  // namespace rangegrasp::recognition::internal
