#include "grasp/scene_view.h"

namespace rangegrasp::draw {
namespace {

using Eigen::Vector3d;
using geometry::PointSpan;
using geometry::Select;
using perception::Scene;
using robot::HandModel;

// Colors, dot sizes and line widths on a white ground; grasps stand out.
const Color kTable{0.55F, 0.65F, 0.80F, 1.0F};
const Color kOutlier{0.9F, 0.1F, 0.1F, 1.0F};
const Color kRest{0.7F, 0.7F, 0.7F, 1.0F};
const Color kRim{0.0F, 0.0F, 0.0F, 1.0F};
const Color kHand{0.85F, 0.68F, 0.55F, 0.75F};
const Color kCollidingHand{0.85F, 0.2F, 0.15F, 0.5F};
const Color kApproach{0.0F, 0.55F, 0.15F, 1.0F};
constexpr float kDot_px = 1.5F;
constexpr float kObjectDot_px = 2.5F;
constexpr float kOutlierDot_px = 4.0F;
constexpr float kContactDot_px = 8.0F;
constexpr float kRim_px = 1.5F;
constexpr float kApproach_px = 2.0F;
constexpr double kApproach_m = 0.1;  // length drawn before the tool centre
constexpr int kSegments = 16;        // of the hand's round shapes

// The viewpoint's distance in scene radii; it lies between the sensor's direction, up and side.
constexpr double kViewDistance = 4.2;
constexpr double kViewUp = 0.25;
constexpr double kViewSide = 0.45;
constexpr double kMinRadius_m = 0.1;

void DrawObject(const Scene& scene, const perception::PerceivedObject& object, const Color& color,
                Canvas& canvas) {
  canvas.dots.push_back({Select(scene.cloud.points, object.points), color, kObjectDot_px});
  if (object.top && !object.top->rim.empty()) {
    auto rim = Select(scene.cloud.points, object.top->rim);
    rim.push_back(rim.front());
    canvas.lines.push_back({std::move(rim), kRim, kRim_px});
  }
}

void DrawGrasp(const grasp::Grasp& grasp, const HandModel& hand, Canvas& canvas) {
  const Vector3d tool = grasp.X_CG.translation();
  canvas.lines.push_back(
      {{tool - kApproach_m * grasp.X_CG.linear().col(2), tool}, kApproach, kApproach_px});
  const Vector3d half = 0.5 * grasp.width_m * grasp.X_CG.linear().col(0);
  canvas.dots.push_back({{tool - half, tool + half}, kApproach, kContactDot_px});
  canvas.surfaces.push_back(
      {HandMesh(hand, grasp.opening_m, grasp.X_CH), grasp.collides ? kCollidingHand : kHand});
}

}  // namespace

Canvas DrawScene(PointSpan points_C, const Scene& scene,
                 const std::vector<std::vector<grasp::Grasp>>& grasps, const HandModel& hand) {
  Canvas canvas;
  canvas.dots.push_back({Select(points_C, scene.table.points), kTable, kDot_px});
  canvas.dots.push_back({Select(points_C, scene.outliers), kOutlier, kOutlierDot_px});
  std::vector<bool> rest(scene.cloud.size(), true);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    DrawObject(scene, scene.objects[i], PaletteColor(i), canvas);
    for (const auto p : scene.objects[i].points) rest[p] = false;
  }
  canvas.dots.push_back({Select(scene.cloud.points, geometry::PositionsOf(rest)), kRest, kDot_px});
  for (const auto& of_object : grasps) {
    // Free grasps come first. One that collides shows why the only object has none.
    if (of_object.empty() || (of_object.front().collides && grasps.size() > 1)) continue;
    DrawGrasp(of_object.front(), hand, canvas);
  }
  return canvas;
}

geometry::TriangleMesh HandMesh(const HandModel& hand, double gap_m, const base::Pose& X_CH) {
  geometry::TriangleMesh mesh;
  for (const auto& shape : hand.AtGap(gap_m).shapes) {
    geometry::Append(geometry::Transformed(geometry::Tessellate(shape, kSegments), X_CH), mesh);
  }
  return mesh;
}

View LookAtScene(const Scene& scene, const Vector3d& sensor_origin_C) {
  return LookAtPoints(scene.cloud.points, scene.table.plane.normal, sensor_origin_C);
}

View LookAtPoints(PointSpan points, const Vector3d& up, const Vector3d& sensor_origin_C) {
  Vector3d center = Vector3d::Zero();
  double radius = kMinRadius_m;
  if (!points.empty()) {
    center = geometry::Centroid(points);
    for (const auto& p : points) radius = std::max(radius, (p - center).norm());
  }
  const Vector3d to_sensor = (sensor_origin_C - center).normalized();
  const Vector3d side = up.cross(to_sensor).normalized();
  const Vector3d away = (to_sensor + kViewUp * up + kViewSide * side).normalized();
  return {.eye = center + kViewDistance * radius * away, .target = center, .up = up};
}

}  // namespace rangegrasp::draw
