#include "report/internal/view_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <ranges>
#include <string_view>

#include "base/file.h"
#include "base/image/image.h"
#include "geometry/draw/canvas.h"

namespace rangegrasp::report {
namespace {

namespace fs = std::filesystem;
using experiment::View;
using nlohmann::ordered_json;

// Size of a picture in a row of the list, doubled for high-resolution screens [px].
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

// Color from text such as "#1f77b4".
View::Color ColorOf(const std::string& hex) {
  unsigned r = 0, g = 0, b = 0;
  std::sscanf(hex.c_str(), "#%2x%2x%2x", &r, &g, &b);
  return {static_cast<float>(r) / 255.0F, static_cast<float>(g) / 255.0F,
          static_cast<float>(b) / 255.0F, 1.0F};
}

// Draws a panel without its axes, as wide and high as the picture.
draw::View AddPanel(const draw::Panel& panel, draw::Canvas& canvas) {
  constexpr double kWide = static_cast<double>(kThumbnailWidth_px) / kThumbnailHeight_px;
  constexpr double kAway = 1.1;  // of the eye, for a margin
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

// What the list of cases shows of a view: what was perceived; if nothing was, the bodies in their
// first poses; the first painted mesh; the lines of the first diagram.
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

constexpr double kForceDigits = 1e3;  // for forces and their points: mN, mm

ordered_json Json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
ordered_json Json(const Eigen::Vector4f& v) { return {v.x(), v.y(), v.z(), v.w()}; }

double Rounded(double x) { return std::round(x * kForceDigits) / kForceDigits; }

std::string Dump(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

// @return the mesh's name
std::string WriteMesh(const geometry::TriangleMesh& mesh, const fs::path& folder) {
  const std::string text = Dump(PackedMesh(mesh));
  std::string name = base::Hex(base::Fnv1a(text));
  const auto file = folder / "meshes" / (name + ".js");
  if (!fs::exists(file)) {
    base::WriteFile(file, fmt::format("rangegrasp.meshes[\"{}\"]={};\n", name, text));
  }
  return name;
}

bool Moves(const View::Body& body) {
  return std::ranges::any_of(
      body.X_WB, [&](const base::Pose& X) { return X.matrix() != body.X_WB.front().matrix(); });
}

ordered_json FrameJson(const View::Frame& frame) {
  std::vector<double> forces;
  for (const auto& [point, force] : frame.forces) {
    for (const Eigen::Vector3d& v : {point, force}) {
      for (int i = 0; i < 3; ++i) forces.push_back(Rounded(v[i]));
    }
  }
  return {{"time", Rounded(frame.time_s)}, {"moment", frame.moment}, {"forces", forces}};
}

ordered_json BodiesJson(const View& view, const fs::path& folder) {
  ordered_json json = ordered_json::array();
  for (const View::Body& body : view.bodies) {
    if (body.X_WB.empty()) continue;
    auto poses = body.X_WB;
    if (!Moves(body)) poses.resize(1);
    json.push_back({{"name", body.name},
                    {"layer", body.layer},
                    {"color", Json(body.color)},
                    {"mesh", WriteMesh(body.mesh_B, folder)},
                    {"poses", PackedPoses(poses)}});
  }
  return json;
}

// null stands for 0, 1, 2 and so on, which the page counts itself.
ordered_json AbscissasJson(const std::vector<double>& x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (x[i] != static_cast<double>(i)) return PackedNumbers(x);
  }
  return nullptr;
}

ordered_json SeriesJson(const draw::Series& series) {
  return {{"name", series.label},
          {"color", series.color},
          {"dots", series.dots},
          {"x", AbscissasJson(series.x)},
          {"y", PackedNumbers(series.y)}};
}

ordered_json MarkerJson(const draw::Marker& marker) {
  return {{"x", marker.x}, {"name", marker.label}, {"color", marker.color}};
}

ordered_json PanelJson(const draw::Panel& panel) {
  return {{"title", panel.title},
          {"x", panel.x_label},
          {"y", panel.y_label},
          {"equal", panel.equal_axes},
          {"series", ListOf(panel.series, SeriesJson)},
          {"markers", ListOf(panel.markers, MarkerJson)}};
}

ordered_json ViewJson(const View& view, const fs::path& folder) {
  const auto layer = [](const auto& one, const char* what, ordered_json data) -> ordered_json {
    return {{"layer", one.layer}, {"color", Json(one.color)}, {what, std::move(data)}};
  };
  const auto points = [&](const auto& one) {
    return layer(one, "points", PackedPoints(one.points_W));
  };
  const auto surface = [&](const View::Surface& one) {
    return layer(one, "mesh", PackedMesh(one.mesh_W));
  };
  const auto painted = [&](const View::Painted& one) -> ordered_json {
    const auto color = [](const View::Color& rgba) { return Json(rgba); };
    return {{"layer", one.layer},
            {"mesh", WriteMesh(one.mesh_W, folder)},
            {"colors", ListOf(one.colors, color)},
            {"paint", Base64(one.paint)}};
  };
  const auto page = [](const View::Page& one) -> ordered_json {
    return {{"name", one.name}, {"panels", ListOf(one.panels, PanelJson)}};
  };
  const auto is_there = [](const View::Points& one) { return !one.points_W.empty(); };
  return {{"eye", Json(view.eye_W)},
          {"target", Json(view.target_W)},
          {"points", ListOf(view.points | std::views::filter(is_there), points)},
          {"lines", ListOf(view.lines, points)},
          {"surfaces", ListOf(view.surfaces, surface)},
          {"painted", ListOf(view.painted, painted)},
          {"bodies", BodiesJson(view, folder)},
          {"frames", ListOf(view.frames, FrameJson)},
          {"panels", ListOf(view.panels, PanelJson)},
          {"pages", ListOf(view.pages, page)}};
}

static_assert(std::endian::native == std::endian::little);

constexpr double kSteps = 65535.0;
constexpr double kTurnSteps = 32767.0;

template <typename Number>
std::string Bytes(const std::vector<Number>& numbers) {
  return Base64(
      {reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size() * sizeof(Number)});
}

template <typename Number>
std::string TriangleBytes(const geometry::TriangleMesh& mesh) {
  std::vector<Number> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (const auto corner : triangle) corners.push_back(static_cast<Number>(corner));
  }
  return Bytes(corners);
}

}  // namespace

void WriteView(const View& view, const fs::path& folder, std::size_t number) {
  const auto file = folder / "views" / fmt::format("{}.js", number);
  image::WritePng(fs::path(file).replace_extension(".png"), ViewPicture(view));
  base::WriteFile(file,
                  Script(fmt::format("rangegrasp.views[{}]", number), ViewJson(view, folder)));
}

std::string Script(const std::string& variable, const ordered_json& value) {
  return fmt::format("{}={};\n", variable, Dump(value));
}

ordered_json PackedPoints(const geometry::Points& points) {
  const Eigen::AlignedBox3d box = geometry::BoundsOf(points);
  const Eigen::Vector3d low = points.empty() ? Eigen::Vector3d(0.0, 0.0, 0.0) : box.min();
  const double edge = points.empty() ? 0.0 : box.sizes().maxCoeff();
  const double step = edge > 0.0 ? edge / kSteps : 1.0;
  std::vector<std::uint16_t> steps;
  steps.reserve(3 * points.size());
  for (const Eigen::Vector3d& p : points) {
    for (int i = 0; i < 3; ++i) {
      steps.push_back(static_cast<std::uint16_t>(std::lround((p[i] - low[i]) / step)));
    }
  }
  return {{"low", {low.x(), low.y(), low.z()}}, {"step", step}, {"data", Bytes(steps)}};
}

ordered_json PackedMesh(const geometry::TriangleMesh& mesh) {
  const bool wide = mesh.vertices.size() > std::numeric_limits<std::uint16_t>::max();
  return {{"vertices", PackedPoints(mesh.vertices)},
          {"wide", wide},
          {"triangles",
           wide ? TriangleBytes<std::uint32_t>(mesh) : TriangleBytes<std::uint16_t>(mesh)}};
}

ordered_json PackedPoses(const std::vector<base::Pose>& poses) {
  geometry::Points places;
  std::vector<std::int16_t> turns;
  for (const base::Pose& X : poses) {
    places.push_back(X.translation());
    const Eigen::Quaterniond turn(X.linear());
    for (const double part : {turn.x(), turn.y(), turn.z(), turn.w()}) {
      turns.push_back(static_cast<std::int16_t>(std::lround(part * kTurnSteps)));
    }
  }
  return {{"places", PackedPoints(places)}, {"turns", Bytes(turns)}};
}

ordered_json PackedNumbers(std::span<const double> numbers) {
  constexpr std::uint16_t kNone = 65535;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double x : numbers) {
    if (!std::isfinite(x)) continue;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  if (!(low <= high)) low = high = 0.0;
  const double step = high > low ? (high - low) / (kNone - 1) : 1.0;
  std::vector<std::uint16_t> steps;
  steps.reserve(numbers.size());
  for (const double x : numbers) {
    steps.push_back(std::isfinite(x) ? static_cast<std::uint16_t>(std::lround((x - low) / step))
                                     : kNone);
  }
  return {{"low", low}, {"step", step}, {"data", Bytes(steps)}};
}

std::string Base64(std::span<const unsigned char> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8U | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (unsigned k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace rangegrasp::report
