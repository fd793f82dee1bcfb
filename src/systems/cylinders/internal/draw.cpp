#include "cylinders/internal/draw.h"

#include <numeric>
#include <utility>
#include <vector>

#include "base/image/image.h"
#include "geometry/draw/canvas.h"
#include "geometry/shape.h"
#include "grasp/scene_view.h"

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
constexpr double kBeyond = 0.15;  // of its height: how far the axis sticks out

geometry::TriangleMesh MeshOf(const cylinders::Cylinder& cylinder) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kCylinder;
  shape.size = {cylinder.radius_m, 0.5 * cylinder.height_m, 0.0};
  shape.X_BS = base::MakePose(
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), cylinder.axis).matrix(),
      cylinder.center);
  return geometry::Tessellate(shape, 48);
}

}  // namespace

void DrawCylinders(const cylinders::CylinderScene& scene, const Eigen::Vector3d& sensor_origin_C,
                   const std::filesystem::path& png) {
  Canvas canvas;
  const auto& cloud = scene.cloud.points;
  canvas.dots.push_back({geometry::Select(scene.points_C, scene.table.points), kTable, kDot_px});
  canvas.dots.push_back({geometry::Select(scene.points_C, scene.outliers), kOutlier, 4.0F});
  std::vector<bool> marked(cloud.size(), false);
  const auto mark = [&](const geometry::Indices& positions, const Color& color,
                        float size_px = 2.5F) {
    geometry::Points points;
    for (const auto i : positions) {
      if (!marked[i]) points.push_back(cloud[i]);
      marked[i] = true;
    }
    canvas.dots.push_back({std::move(points), color, size_px});
  };
  for (const auto& found : scene.cylinders) mark(found.barrel, kBarrel);
  mark(scene.curved, kCurved);
  mark(scene.edges, kEdge);
  geometry::Indices all(cloud.size());
  std::iota(all.begin(), all.end(), 0u);
  mark(all, kRest, kDot_px);
  for (const auto& found : scene.cylinders) {
    const cylinders::Cylinder& c = found.cylinder_C;
    const Eigen::Vector3d half = (0.5 + kBeyond) * c.height_m * c.axis;
    canvas.lines.push_back({{c.center - half, c.center + half}, kAxis, 3.0F});
    Color color = PaletteColor(found.given);
    color.w() = kOpacity;
    canvas.surfaces.push_back({MeshOf(c), color});
  }
  const View view = LookAtPoints(cloud, scene.table.plane.normal, sensor_origin_C);
  image::WritePng(png, Render(canvas, view, 1280, 960));
}

}  // namespace rangegrasp::draw
