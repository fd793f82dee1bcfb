#include "parts/stretched/internal/core_growth.h"

#include <algorithm>
#include <span>

#include "geometry/hull.h"
#include "parts/shape/face_frames.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

/// The points of an element.
std::span<const std::uint32_t> PointsOf(const Shape& shape, const std::uint32_t& element) {
  if (shape.IsMesh()) return shape.faces[element];
  return {&element, 1};
}

/// For each point the factor by which a hull has to grow about `center` until it holds the point.
std::vector<double> GrowthToHold(const geometry::Points& points, const geometry::TriangleMesh& hull,
                                 const Eigen::Vector3d& center) {
  std::vector<double> growth(points.size(), 0.0);
  for (const auto& [a, b, c] : hull.triangles) {
    const Eigen::Vector3d normal =
        (hull.vertices[b] - hull.vertices[a]).cross(hull.vertices[c] - hull.vertices[a]);
    const double distance = normal.dot(hull.vertices[a] - center);
    if (!(distance > 0.0)) continue;
    for (std::size_t i = 0; i < points.size(); ++i) {
      growth[i] = std::max(growth[i], normal.dot(points[i] - center) / distance);
    }
  }
  return growth;
}

geometry::Points CorePoints(const Shape& form, const Segmentation& segmentation) {
  std::vector<bool> used(form.points.size(), false);
  for (std::uint32_t i = 0; i < form.Elements(); ++i) {
    if (segmentation.label[i] != 0) continue;
    for (const std::uint32_t p : PointsOf(form, i)) used[p] = true;
  }
  geometry::Points core;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) core.push_back(form.points[i]);
  }
  return core;
}

/// The largest value of an element's points; that of the core's elements is 0.
std::vector<double> OfElements(const Shape& form, const Segmentation& segmentation,
                               const std::vector<double>& of_point) {
  std::vector<double> value(form.Elements(), 0.0);
  for (std::uint32_t i = 0; i < value.size(); ++i) {
    if (segmentation.label[i] == 0) continue;
    for (const std::uint32_t p : PointsOf(form, i)) value[i] = std::max(value[i], of_point[p]);
  }
  return value;
}

void JoinAsIn(const Shape& shape, StandingOut& out) {
  if (shape.IsMesh()) {
    FaceGraph graph = BuildFaceGraph(shape);
    out.begin = std::move(graph.begin);
    out.neighbor = std::move(graph.neighbor);
    out.weight = BuildFaceFrames(shape).area;
    return;
  }
  VertexGraph graph = BuildVertexGraph(shape);
  out.begin = std::move(graph.begin);
  out.neighbor = std::move(graph.neighbor);
  out.weight.assign(shape.points.size(), 1.0);
}

}  // namespace

Segmentation GrowCore(const Shape& shape, const Shape& form, const Segmentation& segmentation,
                      const std::vector<double>& remoteness, const LimbOptions& options) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(CorePoints(form, segmentation));
  if (hull.triangles.empty()) return segmentation;
  StandingOut out;
  out.growth = OfElements(form, segmentation,
                          GrowthToHold(form.points, hull, geometry::Centroid(hull.vertices)));
  out.remoteness = OfElements(form, segmentation, remoteness);
  JoinAsIn(shape, out);
  Segmentation grown = segmentation;
  grown.label = LabelLimbs(out, options);
  grown.parts = 1 + *std::ranges::max_element(grown.label);
  return grown;
}

}  // namespace rangegrasp::parts
