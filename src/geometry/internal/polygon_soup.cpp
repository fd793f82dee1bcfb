#include "geometry/internal/polygon_soup.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "base/error.h"
#include "base/words.h"
#include "geometry/internal/cloud_format.h"

namespace rangegrasp::geometry::internal {
namespace {

using Eigen::Vector3d;

// Joins equal vertices and removes unused ones; the order is kept.
void CleanVertices(TriangleMesh& mesh) {
  const auto first = FirstTwin(mesh.vertices, CanonicalOrder(mesh.vertices));
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

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
// The info of a face is 1 inside the polygon, 0 outside, and -1 if not yet known.
using Face = CGAL::Constrained_triangulation_face_base_2<
    Kernel, CGAL::Triangulation_face_base_with_info_2<int, Kernel>>;
using Plane =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel,
                                               CGAL::Triangulation_data_structure_2<Vertex, Face>,
                                               CGAL::No_constraint_intersection_tag>;
using Corners = std::span<const std::uint32_t>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// The normal by Newell's method; its length is twice the area.
Vector3d NormalOf(const Points& points, Corners corners) {
  Vector3d normal = Vector3d::Zero();
  const Vector3d& origin = points[corners[0]];
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    normal += (points[corners[k]] - origin).cross(points[corners[k + 1]] - origin);
  }
  return normal;
}

void AppendFan(Corners corners, std::size_t from, Triangles& triangles) {
  const std::size_t n = corners.size();
  for (std::size_t k = 1; k + 1 < n; ++k) {
    triangles.push_back({corners[from], corners[(from + k) % n], corners[(from + k + 1) % n]});
  }
}

// The first reflex corner, at which the polygon turns the other way; 0 if there is none.
std::size_t HollowCorner(const Points& points, Corners corners, const Vector3d& normal) {
  const std::size_t n = corners.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3d& p = points[corners[k]];
    const Vector3d before = p - points[corners[(k + n - 1) % n]];
    if (before.cross(points[corners[(k + 1) % n]] - p).dot(normal) < 0.0) return k;
  }
  return 0;
}

// Marks the faces inside the polygon: starts outside and switches at each crossing of its border.
void TellInside(Plane& plane) {
  std::vector<std::pair<Plane::Face_handle, int>> open = {{plane.infinite_face(), 0}};
  while (!open.empty()) {
    const auto [face, inside] = open.back();
    open.pop_back();
    if (face->info() != -1) continue;
    face->info() = inside;
    for (int i = 0; i < 3; ++i) {
      open.emplace_back(face->neighbor(i), plane.is_constrained({face, i}) ? 1 - inside : inside);
    }
  }
}

Plane Triangulated(const Points& points, Corners corners, const Vector3d& normal) {
  const Vector3d x = normal.unitOrthogonal();
  const Vector3d y = normal.cross(x);
  Plane plane;
  std::vector<Plane::Vertex_handle> handles;
  for (const std::uint32_t c : corners) {
    const Vector3d p = points[c] - points[corners[0]];
    const Plane::Face_handle near = handles.empty() ? Plane::Face_handle() : handles.back()->face();
    handles.push_back(plane.insert(Kernel::Point_2(p.dot(x), p.dot(y)), near));
    handles.back()->info() = c;
  }
  for (std::size_t k = 0; k < handles.size(); ++k) {
    const auto& next = handles[(k + 1) % handles.size()];
    if (handles[k] != next) plane.insert_constraint(handles[k], next);
  }
  for (const auto& face : plane.all_face_handles()) face->info() = -1;
  return plane;
}

// @return whether the polygon is simple and was triangulated.
bool AppendDelaunay(const Points& points, Corners corners, const Vector3d& normal,
                    Triangles& triangles) {
  const std::size_t before = triangles.size();
  try {
    Plane plane = Triangulated(points, corners, normal);
    if (plane.dimension() < 2) return false;
    TellInside(plane);
    for (const auto& face : plane.finite_face_handles()) {
      if (face->info() != 1) continue;
      triangles.push_back(
          {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
    }
  } catch (const Plane::Intersection_of_constraints_exception&) {
    return false;
  }
  if (triangles.size() - before == corners.size() - 2) return true;
  triangles.resize(before);
  return false;
}

/// Appends the triangles of a polygon, with its orientation: a quad is cut along the diagonal from
/// its reflex corner, or from its first; more corners get a constrained Delaunay triangulation in
/// the mean plane. A polygon that crosses itself becomes a fan. O(n log n).
/// @param corners  indices into `points`, finite; less than three give no triangle.
void AppendTriangles(const Points& points, Corners corners, Triangles& triangles) {
  if (corners.size() <= 3) return AppendFan(corners, 0, triangles);
  const Vector3d normal = NormalOf(points, corners);
  if (!(normal.norm() > 0.0) || !normal.allFinite()) return AppendFan(corners, 0, triangles);
  const std::size_t hollow = HollowCorner(points, corners, normal);
  if (corners.size() == 4) return AppendFan(corners, hollow, triangles);
  if (AppendDelaunay(points, corners, normal.normalized(), triangles)) return;
  AppendFan(corners, hollow, triangles);
}

/// The next line; a line that ends with a backslash is joined with the next one in `joined`.
std::optional<std::string_view> NextLine(LineReader& lines, std::string& joined) {
  auto line = lines.Next();
  if (!line || !line->ends_with('\\')) return line;
  joined.clear();
  while (line) {
    const bool goes_on = line->ends_with('\\');
    joined += line->substr(0, line->size() - (goes_on ? 1 : 0));
    if (!goes_on) break;
    joined += ' ';
    line = lines.Next();
  }
  return joined;
}

/// Vertex index of "7", "7/1", "7//3", "7/1/3"; counted from 1, negative from the last one back.
std::uint32_t VertexOf(const LineReader& lines, std::string_view word, std::size_t vertices) {
  const auto number = base::NumberFrom<std::int64_t>(word.substr(0, word.find('/')));
  const auto n = static_cast<std::int64_t>(vertices);
  if (!number || *number == 0 || *number > n || *number < -n) {
    lines.Fail("a face uses vertex {}; there are {} up to here, from 1", Quoted(word), vertices);
  }
  return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : n + *number);
}

/// Shortest lines: "0 0 0" and "3 0 1 2", each with its line break, which may be absent.
constexpr std::uint64_t kMinVertex_bytes = 6;
constexpr std::uint64_t kMinFace_bytes = 8;

/// The words of the next line that is not blank, without its comment; empty at the end.
WordList NextWords(LineReader& lines) {
  while (const auto line = lines.Next()) {
    WordList words = Words(line->substr(0, line->find('#')));
    if (!words.empty()) return words;
  }
  return {};
}

struct Counts {
  std::uint32_t vertices = 0, faces = 0;
};

Counts ReadCounts(LineReader& lines, std::size_t bytes) {
  WordList head = NextWords(lines);
  if (head.empty() || !head.front().ends_with("OFF") || head.front().find_first_of("4n") == 0) {
    lines.Fail("{} is not one of OFF, COFF, NOFF, STOFF", head.empty() ? "\"\"" : Quoted(head[0]));
  }
  if (head.size() > 1 && head[1] == "BINARY")
    lines.Fail("binary OFF is not supported; save it as text");
  head.erase(head.begin());
  if (head.empty()) head = NextWords(lines);
  const auto count = [&](std::size_t i) {
    const auto n = i < head.size() ? base::NumberFrom<std::uint32_t>(head[i]) : std::nullopt;
    if (!n) lines.Fail("the numbers of vertices and faces are expected here, e.g. '8 12 0'");
    return *n;
  };
  const Counts counts{count(0), count(1)};
  if (kMinVertex_bytes * counts.vertices + kMinFace_bytes * counts.faces > bytes) {
    lines.Fail("{} vertices and {} faces are declared; a file of {} bytes is too short for them",
               counts.vertices, counts.faces, bytes);
  }
  return counts;
}

}  // namespace

PolygonMesh ToPolygonMesh(const std::filesystem::path& file, const PolygonSoup& soup) {
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    CheckPlace(file, fmt::format("vertex {}", i), soup.points[i], kMaxVertex);
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

PolygonSoup ReadObj(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  PolygonSoup soup;
  std::string joined;
  while (const auto line = NextLine(lines, joined)) {
    WordList words = Words(line->substr(0, line->find('#')));
    if (words.empty() || (words[0] != "v" && words[0] != "f")) continue;
    const bool vertex = words[0] == "v";
    words.erase(words.begin());
    if (vertex) {
      if (words.size() < 3) lines.Fail("a vertex must have three coordinates");
      soup.points.push_back(PointFrom(lines, words));
      continue;
    }
    for (const std::string_view word : words) {
      soup.corner.push_back(VertexOf(lines, word, soup.points.size()));
    }
    soup.EndPolygon();
  }
  return soup;
}

PolygonSoup ReadOff(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const Counts counts = ReadCounts(lines, bytes.size());
  PolygonSoup soup;
  soup.points.resize(counts.vertices);
  for (std::size_t i = 0; i < counts.vertices; ++i) {
    const WordList words = NextWords(lines);
    if (words.size() < 3) lines.Fail("vertex {} must have three coordinates", i);
    soup.points[i] = PointFrom(lines, words);
  }
  for (std::uint32_t i = 0; i < counts.faces; ++i) {
    const WordList words = NextWords(lines);
    const auto corners =
        words.empty() ? std::nullopt : base::NumberFrom<std::uint32_t>(words.front());
    if (!corners || words.size() <= *corners) {
      lines.Fail("face {} of {} must have a number of corners and as many vertices", i,
                 counts.faces);
    }
    for (std::size_t k = 1; k <= *corners; ++k) {
      const auto vertex = base::NumberFrom<std::uint32_t>(words[k]);
      if (!vertex || *vertex >= counts.vertices) {
        lines.Fail("face {} uses vertex '{}'; there are {}, from 0", i, words[k], counts.vertices);
      }
      soup.corner.push_back(*vertex);
    }
    soup.EndPolygon();
  }
  return soup;
}

}  // namespace rangegrasp::geometry::internal
