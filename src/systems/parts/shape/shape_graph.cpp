#include "parts/shape/shape_graph.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

// Number of faces at one edge above which each is linked with the next one only: links between all
// of them would grow quadratically.
constexpr std::size_t kManyFaces = 16;

// An undirected edge of a face.
struct EdgeOfFace {
  Edge edge;  // lower vertex first
  std::uint32_t face;
};

/// Counting sort by a number below `count`; the few items with the same number are sorted by
/// `less`. It takes half the time of a plain sort.
/// @return where the items of each number begin, and the end
template <class T, class Number, class Less>
Indices SortByNumber(std::vector<T>& items, std::size_t count, const Number& number,
                     const Less& less) {
  Indices begin(count + 1, 0);
  for (const T& item : items) ++begin[number(item) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<T> sorted(items.size());
  Indices next = begin;
  for (const T& item : items) sorted[next[number(item)]++] = item;
  for (std::size_t k = 0; k < count; ++k) {
    std::sort(sorted.begin() + begin[k], sorted.begin() + begin[k + 1], less);
  }
  items = std::move(sorted);
  return begin;
}

std::vector<EdgeOfFace> SortedEdges(const Shape& mesh) {
  const std::vector<Face>& faces = mesh.faces;
  std::vector<EdgeOfFace> edges;
  edges.reserve(3 * faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (const Edge& edge : EdgesOf(faces[f])) edges.push_back({edge, f});
  }
  SortByNumber(
      edges, mesh.points.size(), [](const EdgeOfFace& e) { return e.edge[0]; },
      [](const EdgeOfFace& p, const EdgeOfFace& q) {
        return std::tie(p.edge[1], p.face) < std::tie(q.edge[1], q.face);
      });
  return edges;
}

void LinkFaces(std::span<const EdgeOfFace> round, std::vector<FaceLink>& links) {
  const auto link = [&](const EdgeOfFace& p, const EdgeOfFace& q) {
    if (p.face == q.face) return;
    links.push_back({p.face, q.face, p.edge});
    links.push_back({q.face, p.face, p.edge});
  };
  for (std::size_t i = 0; i < round.size(); ++i) {
    const std::size_t end =
        round.size() > kManyFaces ? std::min(i + 2, round.size()) : round.size();
    for (std::size_t j = i + 1; j < end; ++j) link(round[i], round[j]);
  }
}

using Graph = boost::compressed_sparse_row_graph<boost::directedS>;
using Arc = boost::graph_traits<Graph>::edge_descriptor;

// Steps of the largest capacity: finer than the accuracy of the costs, and far from overflow.
constexpr double kSteps = 1e6;

bool RunsAlong(const Face& face, const Edge& edge) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (face[i] == edge[0] && face[(i + 1) % 3] == edge[1]) return true;
  }
  return false;
}

}  // namespace

FaceGraph BuildFaceGraph(const Shape& mesh) {
  const auto edges = SortedEdges(mesh);
  std::vector<FaceLink> links;
  links.reserve(2 * edges.size());
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].edge == edges[begin].edge) ++end;
    LinkFaces(std::span(edges).subspan(begin, end - begin), links);
    begin = end;
  }
  return GraphOfLinks(mesh.faces.size(), std::move(links));
}

FaceGraph GraphOfLinks(std::size_t faces, std::vector<FaceLink> links) {
  FaceGraph graph;
  graph.begin = SortByNumber(
      links, faces, [](const FaceLink& l) { return l.from; },
      [](const FaceLink& p, const FaceLink& q) {
        return std::tie(p.to, p.edge) < std::tie(q.to, q.edge);
      });
  graph.neighbor.reserve(links.size());
  graph.edge.reserve(links.size());
  for (const FaceLink& link : links) {
    graph.neighbor.push_back(link.to);
    graph.edge.push_back(link.edge);
  }
  return graph;
}

VertexGraph BuildVertexGraph(const Shape& shape) {
  std::vector<VertexLink> links;
  const auto link = [&](std::uint32_t a, std::uint32_t b) {
    links.push_back({a, b, LengthOf(shape.points, {a, b})});
  };
  for (const Face& face : shape.faces) {
    for (const auto& [a, b] : EdgesOf(face)) link(a, b);
  }
  if (!shape.IsMesh()) {
    const geometry::KdTree tree(shape.points);
    std::vector<geometry::KdTree::Neighbor> found;
    for (std::uint32_t i = 0; i < shape.points.size(); ++i) {
      tree.Nearest(shape.points[i], kCloudNeighbors + 1, found);
      for (const auto& n : found) {
        if (n.index != i) link(i, n.index);
      }
    }
  }
  return GraphOfLinks(shape.points.size(), std::move(links));
}

VertexGraph GraphOfLinks(std::size_t vertices, std::vector<VertexLink> links) {
  for (std::size_t i = links.size(); i-- > 0;) {
    links.push_back({links[i].to, links[i].from, links[i].length});
  }
  const auto key = [](const VertexLink& l) { return std::tie(l.from, l.to, l.length); };
  std::ranges::sort(links, {}, key);
  VertexGraph graph;
  graph.begin.assign(vertices + 1, 0);
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (i > 0 && links[i].from == links[i - 1].from && links[i].to == links[i - 1].to) continue;
    ++graph.begin[links[i].from + 1];
    graph.neighbor.push_back(links[i].to);
    graph.length.push_back(links[i].length);
  }
  std::partial_sum(graph.begin.begin(), graph.begin.end(), graph.begin.begin());
  return graph;
}

void GrowSeeds(const FaceGraph& graph, const std::vector<double>& costs, const Indices& seeds,
               std::size_t first, NearestSeeds& nearest) {
  auto& [distance, seed] = nearest;
  distance.resize(graph.begin.size() - 1, geometry::kFar);
  seed.resize(distance.size(), -1);
  for (std::size_t s = first; s < seeds.size(); ++s) seed[seeds[s]] = static_cast<std::int32_t>(s);
  const auto expand = [&](std::uint32_t f, double d, const auto& reach) {
    for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
      const std::uint32_t next = graph.neighbor[k];
      if (reach(next, d + costs[k])) nearest.seed[next] = nearest.seed[f];
    }
  };
  geometry::LowerDistances(std::span(seeds).subspan(first), distance, expand);
}

Indices MiddleFaces(const FaceFrames& frames, const Labels& group, const Points& center) {
  std::vector<double> nearest(center.size(), geometry::kFar);
  Indices face(center.size(), kNoNode);
  for (std::uint32_t f = 0; f < group.size(); ++f) {
    const double squared = (frames.center[f] - center[group[f]]).squaredNorm();
    if (squared >= nearest[group[f]]) continue;
    nearest[group[f]] = squared;
    face[group[f]] = f;
  }
  std::erase(face, kNoNode);
  return face;
}

void JoinCrumbs(const FaceGraph& faces, Labels& label) {
  const Pieces pieces = ConnectedPieces(
      faces, [&](std::uint32_t f, std::uint32_t g) { return label[f] == label[g]; });
  Labels of_piece(pieces.count);
  for (std::size_t f = 0; f < label.size(); ++f) of_piece[pieces.label[f]] = label[f];
  std::vector<std::map<std::int32_t, std::size_t>> shared(pieces.count);  // edges per neighbor
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t) {
    if (label[f] != label[g]) ++shared[pieces.label[f]][pieces.label[g]];
  });
  std::set<std::int32_t> seen;
  for (std::int32_t p = 0; p < pieces.count; ++p) {
    if (seen.insert(of_piece[p]).second) continue;
    std::map<std::int32_t, std::size_t> votes;
    for (const auto& [other, edges] : shared[p]) votes[of_piece[other]] += edges;
    const auto best =
        std::ranges::max_element(votes, {}, &std::pair<const std::int32_t, std::size_t>::second);
    if (best != votes.end()) of_piece[p] = best->first;
  }
  for (std::size_t f = 0; f < label.size(); ++f) label[f] = of_piece[pieces.label[f]];
}

std::vector<bool> MinCut(std::uint32_t nodes, const std::vector<CutLink>& links) {
  double largest = 0.0;
  // One link per node to the source and one to the sink: of several, Boost sees only one.
  std::vector<double> of_source(nodes, 0.0), of_sink(nodes, 0.0);
  std::vector<CutLink> all;
  for (const CutLink& link : links) {
    largest = std::max(largest, link.capacity);
    const bool from_b = link.b <= kSink;
    const std::uint32_t terminal = from_b ? link.b : link.a, other = from_b ? link.a : link.b;
    if (terminal == kSource) {
      of_source[other] += link.capacity;
    } else if (terminal == kSink) {
      of_sink[other] += link.capacity;
    } else {
      all.push_back(link);
    }
  }
  for (std::uint32_t v = 0; v < nodes; ++v) {
    if (of_source[v] > 0.0) all.push_back({kSource, v, of_source[v]});
    if (of_sink[v] > 0.0) all.push_back({v, kSink, of_sink[v]});
  }
  // Arcs in both directions, those of a node next to each other.
  std::vector<std::size_t> end(nodes + 1, 0);
  for (const CutLink& link : all) {
    ++end[link.a];
    ++end[link.b];
  }
  std::exclusive_scan(end.begin(), end.end(), end.begin(), std::size_t{0});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends(2 * all.size());
  std::vector<std::int64_t> capacity(ends.size());
  std::vector<std::size_t> back(ends.size());
  for (const CutLink& link : all) {
    const std::size_t there = end[link.a]++;
    const std::size_t again = end[link.b]++;
    ends[there] = {link.a, link.b};
    ends[again] = {link.b, link.a};
    back[there] = again;
    back[again] = there;
    capacity[there] = capacity[again] =
        link.capacity > 0.0 ? std::llround(kSteps * link.capacity / largest) : 0;
  }
  const Graph graph(boost::edges_are_sorted, ends.begin(), ends.end(), nodes);
  std::vector<Arc> reverse(ends.size());
  for (std::size_t k = 0; k < ends.size(); ++k) reverse[k] = {ends[k].second, back[k]};

  std::vector<std::int64_t> residual(ends.size());
  std::vector<Arc> predecessor(nodes);
  std::vector<boost::default_color_type> color(nodes);
  std::vector<long> distance(nodes);
  const auto of_node = boost::get(boost::vertex_index, graph);
  const auto arcs = [of_arc = boost::get(boost::edge_index, graph)](auto& values) {
    return boost::make_iterator_property_map(values.begin(), of_arc);
  };
  const auto at_nodes = [of_node](auto& values) {
    return boost::make_iterator_property_map(values.begin(), of_node);
  };
  boost::boykov_kolmogorov_max_flow(graph, arcs(capacity), arcs(residual), arcs(reverse),
                                    at_nodes(predecessor), at_nodes(color), at_nodes(distance),
                                    of_node, kSource, kSink);
  std::vector<bool> with_source(nodes);
  for (std::uint32_t v = 0; v < nodes; ++v) with_source[v] = color[v] == boost::black_color;
  return with_source;
}

void CutFaces(const FaceGraph& faces, const std::vector<double>& costs, std::uint32_t nodes,
              const Indices& node, std::int32_t of_source, std::int32_t of_sink, Labels& label) {
  std::vector<CutLink> links;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (f >= g || node[f] == node[g] || node[f] == kNoNode || node[g] == kNoNode) return;
    links.push_back({node[f], node[g], costs[k]});
  });
  const std::vector<bool> with_source = MinCut(nodes, links);
  for (std::size_t f = 0; f < node.size(); ++f) {
    if (node[f] <= kSink || node[f] == kNoNode) continue;
    label[f] = with_source[node[f]] ? of_source : of_sink;
  }
}

std::vector<Face> TurnedOutwards(const Shape& mesh) {
  const FaceGraph graph = BuildFaceGraph(mesh);
  std::vector<Face> faces = mesh.faces;
  std::vector<bool> seen(faces.size(), false);
  Indices piece;
  for (std::uint32_t first = 0; first < faces.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = true;
    piece.assign(1, first);
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const std::uint32_t f = piece[k];
      for (std::uint32_t e = graph.begin[f]; e < graph.begin[f + 1]; ++e) {
        const std::uint32_t next = graph.neighbor[e];
        if (seen[next]) continue;
        seen[next] = true;
        if (RunsAlong(faces[f], graph.edge[e]) == RunsAlong(faces[next], graph.edge[e])) {
          std::swap(faces[next][1], faces[next][2]);
        }
        piece.push_back(next);
      }
    }
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::uint32_t f : piece) middle += mesh.points[faces[f][0]];
    middle /= static_cast<double>(piece.size());
    double volume = 0.0;
    for (const std::uint32_t f : piece) {
      const auto from_middle = [&](std::size_t i) -> Eigen::Vector3d {
        return mesh.points[faces[f][i]] - middle;
      };
      volume += from_middle(0).dot(from_middle(1).cross(from_middle(2)));
    }
    if (volume >= 0.0) continue;
    for (const std::uint32_t f : piece) std::swap(faces[f][1], faces[f][2]);
  }
  return faces;
}

}  // namespace rangegrasp::parts
