#include "report/internal/view_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/image/image.h"
#include "geometry/draw/canvas.h"
#include "report/internal/packed.h"

namespace rangegrasp::report {
namespace {

using experiment::View;
using nlohmann::ordered_json;

// What a row of the list shows, twice as fine for sharp screens [px].
constexpr int kThumbnailWidth_px = 192;
constexpr int kThumbnailHeight_px = 144;
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
  constexpr double kWide = static_cast<double>(kThumbnailWidth_px) / kThumbnailHeight_px;
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

// What the list of cases shows of a view: what was perceived; of what nothing was perceived, the
// bodies as they stand at first; the first of what is painted; the first diagram's lines.
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
  return draw::Render(canvas, look, kThumbnailWidth_px, kThumbnailHeight_px);
}

constexpr double kForceDigits = 1e3;  // of forces and their places: mN, mm

ordered_json Json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
ordered_json Json(const Eigen::Vector4f& v) { return {v.x(), v.y(), v.z(), v.w()}; }

double Rounded(double x) { return std::round(x * kForceDigits) / kForceDigits; }

std::string Dump(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

// @return the mesh's name
std::string WriteMesh(const geometry::TriangleMesh& mesh, const std::filesystem::path& folder) {
  const std::string text = Dump(internal::PackedMesh(mesh));
  std::string name = base::Hex(base::Fnv1a(text));
  const auto file = folder / "meshes" / (name + ".js");
  if (!std::filesystem::exists(file)) {
    base::WriteFile(file, fmt::format("rangegrasp.meshes[\"{}\"]={};\n", name, text));
  }
  return name;
}

bool Moves(const View::Body& body) {
  return std::any_of(body.X_WB.begin(), body.X_WB.end(),
                     [&](const base::Pose& X) { return X.matrix() != body.X_WB.front().matrix(); });
}

ordered_json FramesJson(const std::vector<View::Frame>& frames) {
  ordered_json json = ordered_json::array();
  for (const View::Frame& frame : frames) {
    ordered_json forces = ordered_json::array();
    for (const auto& [point, force] : frame.forces) {
      for (const Eigen::Vector3d& v : {point, force}) {
        for (int i = 0; i < 3; ++i) forces.push_back(Rounded(v[i]));
      }
    }
    json.push_back({{"time", Rounded(frame.time_s)}, {"moment", frame.moment}, {"forces", forces}});
  }
  return json;
}

ordered_json BodiesJson(const View& view, const std::filesystem::path& folder) {
  ordered_json json = ordered_json::array();
  for (const View::Body& body : view.bodies) {
    if (body.X_WB.empty()) continue;
    auto poses = body.X_WB;
    if (!Moves(body)) poses.resize(1);
    json.push_back({{"name", body.name},
                    {"layer", body.layer},
                    {"color", Json(body.color)},
                    {"mesh", WriteMesh(body.mesh_B, folder)},
                    {"poses", internal::PackedPoses(poses)}});
  }
  return json;
}

ordered_json PaintedJson(const View& view, const std::filesystem::path& folder) {
  ordered_json json = ordered_json::array();
  for (const View::Painted& one : view.painted) {
    ordered_json colors = ordered_json::array();
    for (const View::Color& color : one.colors) colors.push_back(Json(color));
    json.push_back({{"layer", one.layer},
                    {"mesh", WriteMesh(one.mesh_W, folder)},
                    {"colors", colors},
                    {"paint", internal::Base64(one.paint)}});
  }
  return json;
}

// null: 0, 1, 2 and so on, which the page counts itself.
ordered_json AbscissasJson(const std::vector<double>& x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (x[i] != static_cast<double>(i)) return internal::PackedNumbers(x);
  }
  return nullptr;
}

ordered_json PanelJson(const draw::Panel& panel) {
  ordered_json json = {{"title", panel.title},
                       {"x", panel.x_label},
                       {"y", panel.y_label},
                       {"equal", panel.equal_axes},
                       {"series", ordered_json::array()},
                       {"markers", ordered_json::array()}};
  for (const draw::Series& series : panel.series) {
    json["series"].push_back({{"name", series.label},
                              {"color", series.color},
                              {"dots", series.dots},
                              {"x", AbscissasJson(series.x)},
                              {"y", internal::PackedNumbers(series.y)}});
  }
  for (const draw::Marker& marker : panel.markers) {
    json["markers"].push_back({{"x", marker.x}, {"name", marker.label}, {"color", marker.color}});
  }
  return json;
}

ordered_json PanelsJson(const std::vector<draw::Panel>& panels) {
  ordered_json json = ordered_json::array();
  for (const draw::Panel& panel : panels) json.push_back(PanelJson(panel));
  return json;
}

ordered_json PagesJson(const std::vector<View::Page>& pages) {
  ordered_json json = ordered_json::array();
  for (const View::Page& page : pages) {
    json.push_back({{"name", page.name}, {"panels", PanelsJson(page.panels)}});
  }
  return json;
}

ordered_json ViewJson(const View& view, const std::filesystem::path& folder) {
  ordered_json json = {{"eye", Json(view.eye_W)}, {"target", Json(view.target_W)}};
  for (const char* part : {"points", "lines", "surfaces"}) json[part] = ordered_json::array();
  const auto add = [&](const char* part, const auto& item, const char* what, ordered_json data) {
    json[part].push_back(
        {{"layer", item.layer}, {"color", Json(item.color)}, {what, std::move(data)}});
  };
  for (const auto& one : view.points) {
    if (!one.points_W.empty()) add("points", one, "points", internal::PackedPoints(one.points_W));
  }
  for (const auto& one : view.lines) {
    add("lines", one, "points", internal::PackedPoints(one.points_W));
  }
  for (const auto& one : view.surfaces) {
    add("surfaces", one, "mesh", internal::PackedMesh(one.mesh_W));
  }
  json["painted"] = PaintedJson(view, folder);
  json["bodies"] = BodiesJson(view, folder);
  json["frames"] = FramesJson(view.frames);
  json["panels"] = PanelsJson(view.panels);
  json["pages"] = PagesJson(view.pages);
  return json;
}

}  // namespace

void WriteView(const View& view, const std::filesystem::path& folder, std::size_t number) {
  const auto file = folder / "views" / fmt::format("{}.js", number);
  image::WritePng(std::filesystem::path(file).replace_extension(".png"), ViewPicture(view));
  base::WriteFile(file,
                  fmt::format("rangegrasp.views[{}]={};\n", number, Dump(ViewJson(view, folder))));
}

}  // namespace rangegrasp::report
