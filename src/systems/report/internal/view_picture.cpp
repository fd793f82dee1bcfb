#include "report/internal/view_picture.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>

#include "geometry/draw/canvas.h"

namespace rangegrasp::report::internal {
namespace {

using experiment::View;

// What a row of the list shows, twice as fine for sharp screens [px].
constexpr int kWidth_px = 192;
constexpr int kHeight_px = 144;
constexpr float kDot_px = 1.5F;
constexpr float kLine_px = 1.5F;

void AddPerceived(const View& view, draw::Canvas& canvas) {
  for (const auto& one : view.points) canvas.dots.push_back({one.points_W, one.color, kDot_px});
  for (const auto& one : view.lines) {
    if (one.layer != "colliding grasps")
      canvas.lines.push_back({one.points_W, one.color, kLine_px});
  }
  for (const auto& one : view.surfaces) canvas.surfaces.push_back({one.mesh_W, one.color});
}

void AddPainted(const View::Painted& painted, draw::Canvas& canvas) {
  std::vector<geometry::TriangleMesh> meshes(painted.colors.size());
  for (std::size_t i = 0; i < painted.paint.size(); ++i) {
    geometry::TriangleMesh& mesh = meshes[painted.paint[i]];
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const auto corner : painted.mesh_W.triangles[i]) {
      mesh.vertices.push_back(painted.mesh_W.vertices[corner]);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    canvas.surfaces.push_back({std::move(meshes[i]), painted.colors[i]});
  }
}

// "#1f77b4"
View::Color ColorOf(const std::string& hex) {
  unsigned r = 0, g = 0, b = 0;
  std::sscanf(hex.c_str(), "#%2x%2x%2x", &r, &g, &b);
  return {static_cast<float>(r) / 255.0F, static_cast<float>(g) / 255.0F,
          static_cast<float>(b) / 255.0F, 1.0F};
}

// Without its axes, as wide and high as the picture.
draw::View AddPanel(const draw::Panel& panel, draw::Canvas& canvas) {
  constexpr double kWide = static_cast<double>(kWidth_px) / kHeight_px;
  constexpr double kAway = 1.1;  // of the eye, to leave a margin
  Eigen::AlignedBox2d box;
  for (const auto& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const Eigen::Vector2d p(series.x[i], series.y[i]);
      if (p.allFinite()) box.extend(p);
    }
  }
  for (const auto& series : panel.series) {
    geometry::Points points;
    for (std::size_t i = 0; !box.isEmpty() && i < series.x.size(); ++i) {
      const Eigen::Vector2d p = (Eigen::Vector2d(series.x[i], series.y[i]) - box.center())
                                    .cwiseQuotient(box.sizes().cwiseMax(1e-12));
      if (p.allFinite()) points.emplace_back(kWide * p.x(), p.y(), 0.0);
    }
    if (series.dots) {
      canvas.dots.push_back({std::move(points), ColorOf(series.color), kDot_px});
    } else {
      canvas.lines.push_back({std::move(points), ColorOf(series.color), kLine_px});
    }
  }
  draw::View look;
  look.up = Eigen::Vector3d::UnitY();
  look.target = Eigen::Vector3d::Zero();
  look.eye = kAway * 0.5 / std::tan(0.5 * look.field_of_view_rad) * Eigen::Vector3d::UnitZ();
  return look;
}

}  // namespace

image::Image ViewPicture(const View& view) {
  draw::Canvas canvas;
  draw::View look;
  look.eye = view.eye_W;
  look.target = view.target_W;
  AddPerceived(view, canvas);
  if (!view.painted.empty()) {
    AddPainted(view.painted.front(), canvas);
  } else if (!view.panels.empty()) {
    look = AddPanel(view.panels.front(), canvas);
  } else if (view.points.empty() && view.surfaces.empty()) {
    for (const auto& body : view.bodies) {
      canvas.surfaces.push_back(
          {geometry::Transformed(body.mesh_B, body.X_WB.front()), body.color});
    }
  }
  return draw::Render(canvas, look, kWidth_px, kHeight_px);
}

}  // namespace rangegrasp::report::internal
