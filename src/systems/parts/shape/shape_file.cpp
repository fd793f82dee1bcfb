#include "parts/shape/shape_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/image/image.h"
#include "base/words.h"
#include "geometry/cloud_file.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {
namespace {

std::string_view Trimmed(std::string_view line) {
  const auto first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

template <class T>
void AppendRaw(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void AppendColor(std::int32_t label, std::string& bytes) {
  for (const std::uint8_t channel : PartColor(label)) AppendRaw(channel, bytes);
}

constexpr float kDot_px = 3.0F;            // for clouds: smaller is hardly seen, larger hides gaps
constexpr double kAir = 1.05;              // margin around a shape, relative to its size
constexpr double kMinEyeDistance = 1e-12;  // of the eye, for a single point
// The eye is in front of the shape, moved right and up by these fractions of that direction.
constexpr double kRightOfFront = 0.6, kAboveFront = 0.5;
// Picture size: a larger one shows smaller parts and takes more time and disk space.
constexpr int kWidth_px = 960, kHeight_px = 720;

/// Distance of the eye at which all points lie within the circular cone of the view.
double DistanceFor(geometry::PointSpan points, const draw::View& view,
                   const Eigen::Vector3d& back) {
  const double tangent = std::tan(0.5 * view.field_of_view_rad);
  double distance = kMinEyeDistance;
  for (const Eigen::Vector3d& p : points) {
    if (!p.allFinite()) continue;
    const Eigen::Vector3d q = p - view.target;
    const double towards = q.dot(back);
    distance = std::max(distance, towards + kAir * (q - towards * back).norm() / tangent);
  }
  return distance;
}

}  // namespace

geometry::PolygonMesh ReadPolygons(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 5> kMeshes = {".off", ".obj", ".stl", ".glb", ".gltf"};
  constexpr std::array<std::string_view, 4> kClouds = {".ply", ".pcd", ".npy", ".xyz"};
  const std::string ending = base::EndingOf(file);
  const bool mesh = std::ranges::find(kMeshes, ending) != kMeshes.end();
  if (!mesh && std::ranges::find(kClouds, ending) == kClouds.end()) {
    throw base::InputError(file.string() + ": unknown ending '" + ending +
                           "'; a shape is .off, .obj, .stl, .ply, .glb, .gltf, .pcd, .npy or .xyz");
  }
  if (mesh || (ending == ".ply" && geometry::PlyHoldsMesh(file))) {
    return geometry::ReadPolygonMesh(file);
  }
  return {.mesh = {.vertices = geometry::ReadCloud(file).points, .triangles = {}}, .polygon = {}};
}

Shape ShapeOf(const geometry::PolygonMesh& polygons, const std::filesystem::path& file) {
  try {
    return MakeShape(polygons.mesh);
  } catch (const base::InputError& error) {
    throw base::InputError(file.string() + ": " + error.what());
  }
}

Shape ReadShape(const std::filesystem::path& file) { return ShapeOf(ReadPolygons(file), file); }

Labels ReadLabels(const std::filesystem::path& file) {
  const std::string text = base::ReadFile(file);
  const std::string_view whole(text.data(), text.find_last_not_of(" \t\r\n") + 1);
  Labels labels;
  if (whole.empty()) return labels;
  for (const std::string& line : base::Split(whole, '\n')) {
    const std::string_view word = Trimmed(line);
    const auto label = base::NumberFrom<std::int32_t>(word);
    if (!label) {
      throw base::InputError(
          fmt::format("{}:{}: '{:.40}' must be a label, one whole number per line", file.string(),
                      labels.size() + 1, word));
    }
    labels.push_back(*label);
  }
  return labels;
}

Labels ReadLabels(const std::filesystem::path& file, std::size_t elements) {
  Labels labels = ReadLabels(file);
  if (labels.size() != elements) {
    throw base::InputError(fmt::format(
        "{}:{}: has {}; the shape has {}", file.string(), std::min(labels.size(), elements) + 1,
        base::Counted(labels.size(), "label"), base::Counted(elements, "element")));
  }
  return labels;
}

void WriteLabels(const std::filesystem::path& file, std::span<const std::int32_t> labels) {
  std::string text;
  for (const std::int32_t label : labels) fmt::format_to(std::back_inserter(text), "{}\n", label);
  base::WriteFile(file, text);
}

void WriteColoredShape(const std::filesystem::path& file, const geometry::TriangleMesh& input,
                       std::span<const std::int32_t> labels) {
  const bool mesh = !input.triangles.empty();
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\n",
      input.vertices.size());
  if (mesh) {
    bytes += fmt::format("element face {}\nproperty list uchar int vertex_indices\n",
                         input.triangles.size());
  }
  bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  for (std::size_t i = 0; i < input.vertices.size(); ++i) {
    for (const double x : input.vertices[i]) AppendRaw(static_cast<float>(x), bytes);
    if (!mesh) AppendColor(labels[i], bytes);
  }
  for (std::size_t i = 0; i < input.triangles.size(); ++i) {
    AppendRaw(std::uint8_t{3}, bytes);
    for (const std::uint32_t v : input.triangles[i]) AppendRaw(static_cast<std::int32_t>(v), bytes);
    AppendColor(labels[i], bytes);
  }
  base::WriteFile(file, bytes);
}

draw::Color PaintOf(std::int32_t label) {
  const auto [r, g, b] = PartColor(label);
  return {static_cast<float>(r) / 255.0F, static_cast<float>(g) / 255.0F,
          static_cast<float>(b) / 255.0F, 1.0F};
}

draw::Canvas DrawLabels(const geometry::TriangleMesh& shape, std::span<const std::int32_t> labels) {
  const bool mesh = !shape.triangles.empty();
  std::map<std::int32_t, geometry::TriangleMesh> groups;
  const auto is_finite = [&](std::uint32_t v) { return shape.vertices[v].allFinite(); };
  for (std::uint32_t i = 0; i < labels.size(); ++i) {
    using Corners = std::span<const std::uint32_t>;
    const Corners corners = mesh ? Corners(shape.triangles[i]) : Corners(&i, 1);
    if (!std::ranges::all_of(corners, is_finite)) continue;
    geometry::TriangleMesh& group = groups[labels[i]];
    const auto first = static_cast<std::uint32_t>(group.vertices.size());
    for (const std::uint32_t v : corners) group.vertices.push_back(shape.vertices[v]);
    if (mesh) group.triangles.push_back({first, first + 1, first + 2});
  }
  draw::Canvas canvas;
  for (auto& [label, group] : groups) {
    if (mesh) {
      canvas.surfaces.push_back({std::move(group), PaintOf(label)});
    } else {
      canvas.dots.push_back({std::move(group.vertices), PaintOf(label), kDot_px});
    }
  }
  return canvas;
}

draw::View LookAtShape(geometry::PointSpan points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) {
    if (p.allFinite()) box.extend(p);
  }
  draw::View view;
  view.target = box.center();
  const Eigen::Vector3d back = Eigen::Vector3d(kRightOfFront, -1.0, kAboveFront).normalized();
  view.eye = view.target + DistanceFor(points, view, back) * back;
  return view;
}

void WriteParts(const std::filesystem::path& base, const geometry::PolygonMesh& input,
                std::span<const std::int32_t> triangles) {
  const auto named = [&](const char* ending) { return base.string() + ending; };
  const auto polygons = LabelsOfPolygons(input, triangles);
  WriteLabels(named(".seg"), polygons);
  const auto labels = input.polygons > 0 ? ValuesAt(polygons, input.polygon) : polygons;
  WriteColoredShape(named(".ply"), input.mesh, labels);
  image::WritePng(named(".png"),
                  draw::Render(DrawLabels(input.mesh, labels), LookAtShape(input.mesh.vertices),
                               kWidth_px, kHeight_px));
}

}  // namespace rangegrasp::parts
