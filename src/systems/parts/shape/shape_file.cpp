#include "parts/shape/shape_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
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

constexpr const char* kColors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

}  // namespace

geometry::PolygonMesh ReadPolygons(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 5> kMeshes = {".off", ".obj", ".stl", ".glb", ".gltf"};
  const std::string ending = base::EndingOf(file);
  const bool mesh = std::find(kMeshes.begin(), kMeshes.end(), ending) != kMeshes.end();
  if (!mesh && ending != ".ply" && ending != ".pcd") {
    throw base::InputError(file.string() + ": unknown ending '" + ending +
                           "'; a shape is .off, .obj, .stl, .ply, .glb, .gltf or .pcd");
  }
  if (mesh || (ending == ".ply" && geometry::PlyHoldsMesh(file))) {
    return geometry::ReadPolygonMesh(file);
  }
  return {.mesh = {.vertices = geometry::ReadCloud(file).points, .triangles = {}}, .polygon = {}};
}

geometry::TriangleMesh ReadInput(const std::filesystem::path& file) {
  return ReadPolygons(file).mesh;
}

Shape ReadShape(const std::filesystem::path& file) {
  const geometry::TriangleMesh mesh = ReadInput(file);
  try {
    return MakeShape(mesh);
  } catch (const base::InputError& error) {
    throw base::InputError(file.string() + ": " + error.what());
  }
}

std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file) {
  const std::string text = base::ReadFile(file);
  const std::string_view whole(text.data(), text.find_last_not_of(" \t\r\n") + 1);
  std::vector<std::int32_t> labels;
  for (std::size_t at = 0; at < whole.size();) {
    const std::size_t end = std::min(whole.find('\n', at), whole.size());
    const std::string_view word = Trimmed(whole.substr(at, end - at));
    const auto label = base::NumberFrom<std::int32_t>(word);
    if (!label) {
      throw base::InputError(fmt::format("{}:{}: '{:.40}' must be a label, one whole number a line",
                                         file.string(), labels.size() + 1, word));
    }
    labels.push_back(*label);
    at = end + 1;
  }
  return labels;
}

std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file, std::size_t elements) {
  std::vector<std::int32_t> labels = ReadLabels(file);
  if (labels.size() != elements) {
    throw base::InputError(fmt::format("{}:{}: has {} labels; the shape has {} elements",
                                       file.string(), std::min(labels.size(), elements) + 1,
                                       labels.size(), elements));
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
  const std::size_t elements = mesh ? input.triangles.size() : input.vertices.size();
  if (labels.size() != elements) {
    throw std::invalid_argument(
        fmt::format("WriteColoredShape: {} labels for {} elements", labels.size(), elements));
  }
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\n",
      input.vertices.size());
  if (mesh) {
    bytes += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", elements);
  }
  bytes += std::string(kColors) + "end_header\n";
  for (std::size_t i = 0; i < input.vertices.size(); ++i) {
    for (const double x : input.vertices[i]) AppendRaw(static_cast<float>(x), bytes);
    if (!mesh) AppendColor(labels[i], bytes);
  }
  for (std::size_t i = 0; i < input.triangles.size(); ++i) {
    AppendRaw(std::uint8_t{3}, bytes);
    for (const std::uint32_t v : input.triangles[i]) {
      AppendRaw(static_cast<std::int32_t>(v), bytes);
    }
    AppendColor(labels[i], bytes);
  }
  base::WriteFile(file, bytes);
}

}  // namespace rangegrasp::parts
