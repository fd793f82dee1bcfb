#include "geometry/internal/polygon_soup.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "base/error.h"
#include "geometry/internal/triangulate.h"

namespace rangegrasp::geometry::internal {
namespace {

// The first vertex at the place of each.
std::vector<std::uint32_t> FirstAtPlace(const Points& points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&points](std::uint32_t i) {
    return std::tie(points[i].x(), points[i].y(), points[i].z());
  };
  std::sort(order.begin(), order.end(), [&key](std::uint32_t a, std::uint32_t b) {
    return std::tuple_cat(key(a), std::tie(a)) < std::tuple_cat(key(b), std::tie(b));
  });
  std::vector<std::uint32_t> first(points.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

// Joins equal vertices and leaves those out that no triangle has; the order stays.
void CleanVertices(TriangleMesh& mesh) {
  const auto first = FirstAtPlace(mesh.vertices);
  std::vector<std::uint32_t> place(mesh.vertices.size(), 0);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) place[v = first[v]] = 1;
  }
  Points kept;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] == 0) continue;
    place[i] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(mesh.vertices[i]);
  }
  mesh.vertices = std::move(kept);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = place[v];
  }
}

}  // namespace

PolygonMesh ToPolygonMesh(const std::filesystem::path& file, const PolygonSoup& soup) {
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    if (soup.points[i].allFinite()) continue;
    throw base::InputError(fmt::format("{}: vertex {} is not finite", file.string(), i));
  }
  PolygonMesh result;
  result.polygons = soup.Polygons();
  result.mesh.vertices = soup.points;
  for (std::uint32_t i = 0; i < soup.Polygons(); ++i) {
    const std::span<const std::uint32_t> corners(soup.corner.begin() + soup.begin[i],
                                                 soup.corner.begin() + soup.begin[i + 1]);
    AppendTriangles(soup.points, corners, result.mesh.triangles);
    result.polygon.resize(result.mesh.triangles.size(), i);
  }
  if (result.mesh.triangles.empty()) throw base::InputError(file.string() + ": has no triangles");
  CleanVertices(result.mesh);
  return result;
}

}  // namespace rangegrasp::geometry::internal
