#include "report/view_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/hash.h"
#include "draw/canvas.h"
#include "image/png.h"
#include "report/internal/packed.h"

namespace rangegrasp::report {
namespace {

using experiment::View;
using nlohmann::ordered_json;

// Of the small picture [px]: what a row of the list shows, twice as fine for sharp screens.
constexpr int kPictureWidth_px = 192;
constexpr int kPictureHeight_px = 144;
constexpr float kDot_px = 1.5F;
constexpr float kLine_px = 1.5F;
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
  std::string name = core::Hex(core::Fnv1a(text));
  const auto file = folder / "meshes" / (name + ".js");
  if (!std::filesystem::exists(file)) {
    core::WriteFile(file, fmt::format("rangegrasp.meshes[\"{}\"]={};\n", name, text));
  }
  return name;
}

bool Moves(const View::Body& body) {
  return std::any_of(body.X_WB.begin(), body.X_WB.end(),
                     [&](const core::Pose& X) { return X.matrix() != body.X_WB.front().matrix(); });
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
  json["bodies"] = BodiesJson(view, folder);
  json["frames"] = FramesJson(view.frames);
  return json;
}

// Of what nothing was perceived, the bodies as they stand at first.
image::Image Picture(const View& view) {
  draw::Canvas canvas;
  for (const auto& one : view.points) canvas.dots.push_back({one.points_W, one.color, kDot_px});
  for (const auto& one : view.lines) {
    if (one.layer != "colliding grasps")
      canvas.lines.push_back({one.points_W, one.color, kLine_px});
  }
  for (const auto& one : view.surfaces) canvas.surfaces.push_back({one.mesh_W, one.color});
  if (view.points.empty() && view.surfaces.empty()) {
    for (const auto& body : view.bodies) {
      canvas.surfaces.push_back(
          {geometry::Transformed(body.mesh_B, body.X_WB.front()), body.color});
    }
  }
  draw::View look;
  look.eye = view.eye_W;
  look.target = view.target_W;
  return draw::Render(canvas, look, kPictureWidth_px, kPictureHeight_px);
}

}  // namespace

void WriteView(const View& view, const std::filesystem::path& folder, std::size_t number) {
  const auto file = folder / "views" / fmt::format("{}.js", number);
  image::WritePng(std::filesystem::path(file).replace_extension(".png"), Picture(view));
  core::WriteFile(file,
                  fmt::format("rangegrasp.views[{}]={};\n", number, Dump(ViewJson(view, folder))));
}

}  // namespace rangegrasp::report
