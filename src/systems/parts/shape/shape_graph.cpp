#include "parts/shape/shape_graph.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

using GraphFace = std::array<std::uint32_t, 3>;

// Faces round one edge beyond which each is joined with the next only, not all with all: links
// would grow with the square.
constexpr std::size_t kManyFaces = 16;

// An undirected edge of a face.
struct EdgeOfFace {
  std::uint32_t a, b;  // a < b
  std::uint32_t face;
};

/// Sorts by a number below `count`, by counting, and what has the same number, a few each, by all
/// of it: half the time of a sort.
template <class T, class Number, class Less>
void SortByNumber(std::vector<T>& items, std::size_t count, const Number& number,
                  const Less& less) {
  std::vector<std::uint32_t> begin(count + 1, 0);
  for (const T& item : items) ++begin[number(item) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<T> sorted(items.size());
  std::vector<std::uint32_t> next = begin;
  for (const T& item : items) sorted[next[number(item)]++] = item;
  for (std::size_t k = 0; k < count; ++k) {
    std::sort(sorted.begin() + begin[k], sorted.begin() + begin[k + 1], less);
  }
  items = std::move(sorted);
}

std::vector<EdgeOfFace> SortedEdges(const Shape& mesh) {
  const std::vector<GraphFace>& faces = mesh.faces;
  std::vector<EdgeOfFace> edges;
  edges.reserve(3 * faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(faces[f][i], faces[f][(i + 1) % 3]);
      edges.push_back({a, b, f});
    }
  }
  SortByNumber(
      edges, mesh.points.size(), [](const EdgeOfFace& e) { return e.a; },
      [](const EdgeOfFace& p, const EdgeOfFace& q) {
        return std::tie(p.b, p.face) < std::tie(q.b, q.face);
      });
  return edges;
}

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
  for (const GraphFace& face : shape.faces) {
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

}  // namespace

FaceGraph BuildFaceGraph(const Shape& mesh) {
  const auto edges = SortedEdges(mesh);
  std::vector<FaceLink> links;
  links.reserve(2 * edges.size());
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].a == edges[begin].a && edges[end].b == edges[begin].b) {
      ++end;
    }
    LinkFaces(std::span(edges).subspan(begin, end - begin), links);
    begin = end;
  }
  return GraphOfLinks(mesh.faces.size(), std::move(links));
}

FaceGraph GraphOfLinks(std::size_t faces, std::vector<FaceLink> links) {
  SortByNumber(
      links, faces, [](const FaceLink& l) { return l.from; },
      [](const FaceLink& p, const FaceLink& q) {
        return std::tie(p.to, p.edge) < std::tie(q.to, q.edge);
      });
  FaceGraph graph;
  graph.begin.assign(faces + 1, 0);
  graph.neighbor.reserve(links.size());
  graph.edge.reserve(links.size());
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

}  // namespace rangegrasp::parts
