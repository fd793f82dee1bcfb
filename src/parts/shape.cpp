#include "parts/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>

#include "core/error.h"
#include "geometry/io.h"
#include "geometry/kd_tree.h"
#include "geometry/plane.h"

namespace rangegrasp::parts {
namespace {

using geometry::Points;
using geometry::TriangleMesh;
using Face = std::array<std::uint32_t, 3>;

constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
// Squares of squares of what is larger leave the range of a double.
constexpr double kLargest = 1e70;
// Faces round one edge beyond which each is joined with the next only, not all with all.
constexpr std::size_t kManyFaces = 16;

bool IsUsable(const Eigen::Vector3d& p) {
  return p.allFinite() && p.cwiseAbs().maxCoeff() < kLargest;
}

// For each point the first one at the same place; kNone where it is not usable.
std::vector<std::uint32_t> FirstAtPlace(const Points& points) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (IsUsable(points[i])) order.push_back(i);
  }
  const auto key = [&points](std::uint32_t i) {
    return std::tie(points[i].x(), points[i].y(), points[i].z());
  };
  std::stable_sort(order.begin(), order.end(),
                   [&key](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<std::uint32_t> first(points.size(), kNone);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

bool HasArea(const Points& points, const Face& face) {
  const Eigen::Vector3d u = points[face[1]] - points[face[0]];
  const Eigen::Vector3d v = points[face[2]] - points[face[0]];
  return u.cross(v).norm() > 1e-14 * std::max(u.squaredNorm(), v.squaredNorm());
}

// The face with equal points joined; nullopt if that leaves no triangle.
std::optional<Face> Joined(const TriangleMesh& mesh, const Face& face,
                           const std::vector<std::uint32_t>& first) {
  Face joined;
  for (std::size_t i = 0; i < 3; ++i) {
    if (face[i] >= first.size() || first[face[i]] == kNone) return std::nullopt;
    joined[i] = first[face[i]];
  }
  if (joined[0] == joined[1] || joined[1] == joined[2] || joined[2] == joined[0]) {
    return std::nullopt;
  }
  if (!HasArea(mesh.vertices, joined)) return std::nullopt;
  return joined;
}

void KeepFaces(const TriangleMesh& mesh, const std::vector<std::uint32_t>& first, Shape& shape) {
  for (const Face& face : mesh.triangles) {
    const auto joined = Joined(mesh, face, first);
    shape.element_of_input.push_back(joined ? static_cast<std::int32_t>(shape.faces.size()) : -1);
    if (joined) shape.faces.push_back(*joined);
  }
  if (shape.faces.empty()) {
    throw core::InputError("none of its " + std::to_string(mesh.triangles.size()) +
                           " faces is a triangle of three different finite vertices");
  }
  // Only vertices that a face uses stay, in their order.
  std::vector<std::uint32_t> position(mesh.vertices.size(), kNone);
  for (const Face& face : shape.faces) {
    for (const std::uint32_t v : face) position[v] = 0;
  }
  for (std::size_t i = 0; i < position.size(); ++i) {
    if (position[i] == kNone) continue;
    position[i] = static_cast<std::uint32_t>(shape.points.size());
    shape.points.push_back(mesh.vertices[i]);
  }
  for (Face& face : shape.faces) {
    for (std::uint32_t& v : face) v = position[v];
  }
}

void KeepPoints(const Points& points, const std::vector<std::uint32_t>& first, Shape& shape) {
  shape.element_of_input.assign(points.size(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (first[i] == kNone) continue;
    if (first[i] == i) {
      shape.element_of_input[i] = static_cast<std::int32_t>(shape.points.size());
      shape.points.push_back(points[i]);
    } else {
      shape.element_of_input[i] = shape.element_of_input[first[i]];
    }
  }
}

// An undirected edge of a face.
struct EdgeOfFace {
  std::uint32_t a, b;  // a < b
  std::uint32_t face;
};

std::vector<EdgeOfFace> SortedEdges(const std::vector<Face>& faces) {
  std::vector<EdgeOfFace> edges;
  edges.reserve(3 * faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(faces[f][i], faces[f][(i + 1) % 3]);
      edges.push_back({a, b, f});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeOfFace& p, const EdgeOfFace& q) {
    return std::tie(p.a, p.b, p.face) < std::tie(q.a, q.b, q.face);
  });
  return edges;
}

struct FaceLink {
  std::uint32_t from, to;
  std::array<std::uint32_t, 2> edge;
};

void LinkFaces(std::span<const EdgeOfFace> round, std::vector<FaceLink>& links) {
  const auto link = [&](const EdgeOfFace& p, const EdgeOfFace& q) {
    if (p.face == q.face) return;
    links.push_back({p.face, q.face, {p.a, p.b}});
    links.push_back({q.face, p.face, {p.a, p.b}});
  };
  for (std::size_t i = 0; i < round.size(); ++i) {
    const std::size_t end =
        round.size() > kManyFaces ? std::min(i + 2, round.size()) : round.size();
    for (std::size_t j = i + 1; j < end; ++j) link(round[i], round[j]);
  }
}

std::vector<std::array<std::uint32_t, 2>> MeshLinks(const Shape& shape) {
  std::vector<std::array<std::uint32_t, 2>> links;
  for (const Face& face : shape.faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      links.push_back({face[i], face[(i + 1) % 3]});
      links.push_back({face[(i + 1) % 3], face[i]});
    }
  }
  return links;
}

std::vector<std::array<std::uint32_t, 2>> CloudLinks(const Shape& shape, int neighbors) {
  const geometry::KdTree tree(shape.points);
  std::vector<geometry::KdTree::Neighbor> found;
  std::vector<std::array<std::uint32_t, 2>> links;
  for (std::uint32_t i = 0; i < shape.points.size(); ++i) {
    tree.Nearest(shape.points[i], static_cast<std::size_t>(neighbors) + 1, found);
    for (const auto& n : found) {
      if (n.index == i) continue;
      links.push_back({i, n.index});
      links.push_back({n.index, i});
    }
  }
  return links;
}

Eigen::Vector3d Center(const TriangleMesh& mesh, std::size_t element) {
  if (mesh.triangles.empty()) return mesh.vertices[element];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::uint32_t v : mesh.triangles[element]) {
    if (v >= mesh.vertices.size()) return Eigen::Vector3d::Constant(std::nan(""));
    sum += mesh.vertices[v] / 3.0;
  }
  return sum;
}

}  // namespace

Shape MakeShape(const TriangleMesh& mesh) {
  const auto first = FirstAtPlace(mesh.vertices);
  Shape shape;
  if (mesh.triangles.empty()) {
    KeepPoints(mesh.vertices, first, shape);
  } else {
    KeepFaces(mesh, first, shape);
  }
  if (shape.points.size() < 4) {
    throw core::InputError("has only " + std::to_string(shape.points.size()) +
                           " different finite points; a shape has at least 4");
  }
  if (geometry::IsFlat(shape.points)) {
    throw core::InputError("all of its points lie in one plane; a shape needs a depth");
  }
  return shape;
}

TriangleMesh ReadInput(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const bool mesh = ending == ".off" || ending == ".obj" || ending == ".stl";
  if (!mesh && ending != ".ply" && ending != ".pcd") {
    throw core::InputError(file.string() + ": unknown ending '" + ending +
                           "'; a shape is .off, .obj, .stl, .ply or .pcd");
  }
  if (mesh || (ending == ".ply" && geometry::PlyHoldsMesh(file))) return geometry::ReadMesh(file);
  return {.vertices = geometry::ReadCloud(file).points, .triangles = {}};
}

Shape ReadShape(const std::filesystem::path& file) {
  const TriangleMesh mesh = ReadInput(file);
  try {
    return MakeShape(mesh);
  } catch (const core::InputError& error) {
    throw core::InputError(file.string() + ": " + error.what());
  }
}

FaceGraph BuildFaceGraph(const Shape& mesh) {
  const auto edges = SortedEdges(mesh.faces);
  std::vector<FaceLink> links;
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].a == edges[begin].a && edges[end].b == edges[begin].b) {
      ++end;
    }
    LinkFaces(std::span(edges).subspan(begin, end - begin), links);
    begin = end;
  }
  std::sort(links.begin(), links.end(), [](const FaceLink& p, const FaceLink& q) {
    return std::tie(p.from, p.to, p.edge) < std::tie(q.from, q.to, q.edge);
  });
  FaceGraph graph;
  graph.begin.assign(mesh.faces.size() + 1, 0);
  for (const FaceLink& link : links) {
    ++graph.begin[link.from + 1];
    graph.neighbor.push_back(link.to);
    graph.edge.push_back(link.edge);
  }
  std::partial_sum(graph.begin.begin(), graph.begin.end(), graph.begin.begin());
  return graph;
}

VertexGraph BuildVertexGraph(const Shape& shape, int cloud_neighbors) {
  auto links = shape.IsMesh() ? MeshLinks(shape) : CloudLinks(shape, cloud_neighbors);
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  VertexGraph graph;
  graph.begin.assign(shape.points.size() + 1, 0);
  for (const auto& [from, to] : links) {
    ++graph.begin[from + 1];
    graph.neighbor.push_back(to);
    graph.length.push_back((shape.points[from] - shape.points[to]).norm());
  }
  std::partial_sum(graph.begin.begin(), graph.begin.end(), graph.begin.begin());
  return graph;
}

std::vector<std::int32_t> LabelsOfInput(const Shape& shape, const TriangleMesh& input,
                                        const Segmentation& segmentation) {
  const std::size_t n = shape.element_of_input.size();
  std::vector<std::int32_t> label(n, 0);
  Points kept;
  std::vector<std::size_t> kept_index;
  for (std::size_t i = 0; i < n; ++i) {
    if (shape.element_of_input[i] < 0) continue;
    label[i] = segmentation.label[static_cast<std::size_t>(shape.element_of_input[i])];
    kept.push_back(Center(input, i));
    kept_index.push_back(i);
  }
  if (kept.size() == n || kept.empty()) return label;
  const geometry::KdTree tree(kept);
  std::vector<geometry::KdTree::Neighbor> found;
  for (std::size_t i = 0; i < n; ++i) {
    if (shape.element_of_input[i] >= 0) continue;
    const Eigen::Vector3d center = Center(input, i);
    if (!IsUsable(center)) {
      label[i] = -1;
      continue;
    }
    tree.Nearest(center, 1, found);
    label[i] = label[kept_index[found.front().index]];
  }
  return label;
}

}  // namespace rangegrasp::parts
