#include "cylinders/internal/draw.h"

#include <utility>
#include <vector>

#include "geometry/shape.h"

namespace rangegrasp::draw {
namespace {

// Colours as in the dissertation's figures, where they name them.
const Color kTable{0.70F, 0.78F, 0.88F, 1.0F};
const Color kOutlier{0.9F, 0.1F, 0.1F, 1.0F};
const Color kRest{0.65F, 0.65F, 0.65F, 1.0F};
const Color kCurved{0.1F, 0.65F, 0.2F, 1.0F};
const Color kEdge{0.95F, 0.55F, 0.1F, 1.0F};
const Color kBarrel{0.1F, 0.2F, 0.9F, 1.0F};
const Color kAxis{0.0F, 0.0F, 0.0F, 1.0F};
constexpr float kOpacity = 0.35F;  // of a cylinder: the points on it are to be seen
constexpr float kDot_px = 1.5F;
constexpr float kMarkedDot_px = 2.5F;
constexpr float kOutlierDot_px = 4.0F;
constexpr float kAxis_px = 3.0F;
constexpr int kSegments = 48;
constexpr double kBeyond = 0.15;  // of its height: how far the axis sticks out

geometry::TriangleMesh MeshOf(const cylinders::Cylinder& cylinder) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kCylinder;
  shape.size = {cylinder.radius_m, 0.5 * cylinder.height_m, 0.0};
  shape.X_BS = base::MakePose(
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), cylinder.axis).matrix(),
      cylinder.center);
  return geometry::Tessellate(shape, kSegments);
}

}  // namespace

Canvas DrawCylinders(const cylinders::CylinderScene& scene) {
  Canvas canvas;
  const auto& cloud = scene.cloud.points;
  canvas.dots.push_back({geometry::Select(scene.points_C, scene.table.points), kTable, kDot_px});
  canvas.dots.push_back(
      {geometry::Select(scene.points_C, scene.outliers), kOutlier, kOutlierDot_px});
  std::vector<bool> marked(cloud.size(), false);
  const auto mark = [&](const geometry::Indices& positions, const Color& color) {
    geometry::Points points;
    for (const auto i : positions) {
      if (!marked[i]) points.push_back(cloud[i]);
      marked[i] = true;
    }
    canvas.dots.push_back({std::move(points), color, kMarkedDot_px});
  };
  for (const auto& found : scene.cylinders) mark(found.barrel, kBarrel);
  mark(scene.curved, kCurved);
  mark(scene.edges, kEdge);
  geometry::Points rest;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!marked[i]) rest.push_back(cloud[i]);
  }
  canvas.dots.push_back({std::move(rest), kRest, kDot_px});
  for (const auto& found : scene.cylinders) {
    const cylinders::Cylinder& c = found.cylinder_C;
    const Eigen::Vector3d half = (0.5 + kBeyond) * c.height_m * c.axis;
    canvas.lines.push_back({{c.center - half, c.center + half}, kAxis, kAxis_px});
    Color color = PaletteColor(found.given);
    color.w() = kOpacity;
    canvas.surfaces.push_back({MeshOf(c), color});
  }
  return canvas;
}

}  // namespace rangegrasp::draw
