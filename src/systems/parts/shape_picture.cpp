#include "parts/shape_picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace rangegrasp::draw {
namespace {

constexpr float kDot_px = 3.0F;         // of a cloud: smaller is hardly seen, larger hides gaps
constexpr double kAir = 1.05;           // round a shape, of its size
constexpr double kMinDistance = 1e-12;  // of the eye from a single point
// The eye stands before the shape, by these parts of the way to the right and above.
constexpr double kRightOfFront = 0.6;
constexpr double kAboveFront = 0.5;

Color ColorOf(const LabelColor& color, std::int32_t label) {
  const auto [r, g, b] = color(label);
  return {static_cast<float>(r) / 255.0F, static_cast<float>(g) / 255.0F,
          static_cast<float>(b) / 255.0F, 1.0F};
}

void DrawCloud(const geometry::TriangleMesh& cloud, std::span<const std::int32_t> labels,
               const LabelColor& color, Canvas& canvas) {
  std::map<std::int32_t, geometry::Points> groups;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (cloud.vertices[i].allFinite()) groups[labels[i]].push_back(cloud.vertices[i]);
  }
  for (auto& [label, points] : groups) {
    canvas.dots.push_back({std::move(points), ColorOf(color, label), kDot_px});
  }
}

void DrawMesh(const geometry::TriangleMesh& mesh, std::span<const std::int32_t> labels,
              const LabelColor& color, Canvas& canvas) {
  std::map<std::int32_t, geometry::TriangleMesh> groups;
  for (std::size_t f = 0; f < labels.size(); ++f) {
    const auto& corners = mesh.triangles[f];
    if (!std::all_of(corners.begin(), corners.end(),
                     [&](std::uint32_t v) { return mesh.vertices[v].allFinite(); })) {
      continue;
    }
    geometry::TriangleMesh& group = groups[labels[f]];
    const auto first = static_cast<std::uint32_t>(group.vertices.size());
    for (const std::uint32_t v : corners) group.vertices.push_back(mesh.vertices[v]);
    group.triangles.push_back({first, first + 1, first + 2});
  }
  for (auto& [label, group] : groups) {
    canvas.surfaces.push_back({std::move(group), ColorOf(color, label)});
  }
}

/// How far the eye must go back for all points to lie within the round cone of the view.
double DistanceFor(geometry::PointSpan points, const View& view, const Eigen::Vector3d& back) {
  const double tangent = std::tan(0.5 * view.field_of_view_rad);
  double distance = kMinDistance;
  for (const Eigen::Vector3d& p : points) {
    if (!p.allFinite()) continue;
    const Eigen::Vector3d q = p - view.target;
    const double towards = q.dot(back);
    distance = std::max(distance, towards + kAir * (q - towards * back).norm() / tangent);
  }
  return distance;
}

}  // namespace

Canvas DrawLabels(const geometry::TriangleMesh& shape, std::span<const std::int32_t> labels,
                  const LabelColor& color) {
  const bool mesh = !shape.triangles.empty();
  if (labels.size() != (mesh ? shape.triangles.size() : shape.vertices.size())) {
    throw std::invalid_argument("DrawLabels: one label a face or, without faces, a point");
  }
  Canvas canvas;
  mesh ? DrawMesh(shape, labels, color, canvas) : DrawCloud(shape, labels, color, canvas);
  return canvas;
}

View LookAtShape(geometry::PointSpan points, int up) {
  if (up < 0 || up > 2) throw std::invalid_argument("LookAtShape: up is 0, 1 or 2");
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY);
  Eigen::Vector3d high = -low;
  for (const Eigen::Vector3d& p : points) {
    if (!p.allFinite()) continue;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (!(low.x() <= high.x())) throw std::invalid_argument("LookAtShape: no finite point");
  View view;
  view.target = 0.5 * (low + high);
  view.up = Eigen::Vector3d::Unit(up);
  const Eigen::Vector3d front =
      (up == 1 ? 1.0 : -1.0) * Eigen::Vector3d::Unit((up + (up == 1 ? 1 : 2)) % 3);
  const Eigen::Vector3d right = front.cross(-view.up);
  const Eigen::Vector3d back = (front + kRightOfFront * right + kAboveFront * view.up).normalized();
  view.eye = view.target + DistanceFor(points, view, back) * back;
  return view;
}

}  // namespace rangegrasp::draw
