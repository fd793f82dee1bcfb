#pragma once

#include <cstddef>

#include "geometry/graph.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Faces that share an edge; non-manifold edges join all their faces (more than 16 in a row).
struct FaceGraph {
  Indices begin;  ///< faces + 1; neighbors of face i are [begin[i], begin[i+1])
  Indices neighbor;
  std::vector<Edge> edge;  ///< the shared vertices, parallel to neighbor
};
FaceGraph BuildFaceGraph(const Shape& mesh);

/// That a face, or a group of them, has another as its neighbor across an edge.
struct FaceLink {
  std::uint32_t from, to;
  Edge edge;
};
/// The graph of links among a number of faces: neighbors in ascending order, then edges.
FaceGraph GraphOfLinks(std::size_t faces, std::vector<FaceLink> links);

/// Vertices joined by an edge.
struct VertexGraph {
  Indices begin;  ///< vertices + 1
  Indices neighbor;
  std::vector<double> length;  ///< of the edge

  std::uint32_t Size() const { return static_cast<std::uint32_t>(begin.size() - 1); }
  geometry::LinkRows Links() const { return {begin, neighbor, length}; }
};
/// Of a mesh: its edges. Of a cloud: each point with its `cloud_neighbors` nearest, made symmetric.
/// Pieces that nothing joins stay apart.
VertexGraph BuildVertexGraph(const Shape& shape, int cloud_neighbors = 8);

struct VertexLink {
  std::uint32_t from, to;
  double length;
};
/// The graph of links, each both ways; of several between two vertices the shortest stays.
VertexGraph GraphOfLinks(std::size_t vertices, std::vector<VertexLink> links);

/// Calls visit(node, neighbor, k) for each link of a graph (FaceGraph, VertexGraph), both ways; k
/// is its place in `neighbor`.
template <typename Graph, typename Visit>
void ForEachLink(const Graph& graph, Visit visit) {
  for (std::uint32_t v = 0; v + 1 < graph.begin.size(); ++v) {
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      visit(v, graph.neighbor[k], k);
    }
  }
}

/// Connected pieces of a graph's nodes.
struct Pieces {
  Labels label;  ///< numbered from 0 by falling size, ties by their first node
  std::int32_t count = 0;
};
/// joined(a, b) says whether neighbors belong together. O(links).
/// @param chosen  nodes that count; the others get the label -1.
template <typename Graph, typename Joined>
Pieces ConnectedPieces(const Graph& graph, const std::vector<bool>& chosen, Joined joined) {
  geometry::UnionFind sets(chosen.size());
  ForEachLink(graph, [&](std::uint32_t v, std::uint32_t next, std::uint32_t) {
    if (chosen[v] && chosen[next] && joined(v, next)) sets.Unite(v, next);
  });
  Pieces pieces;
  pieces.count = geometry::LabelBySize(sets, chosen, pieces.label);
  return pieces;
}
/// Of all nodes.
template <typename Graph, typename Joined>
Pieces ConnectedPieces(const Graph& graph, Joined joined) {
  return ConnectedPieces(graph, std::vector<bool>(graph.begin.size() - 1, true), joined);
}
inline bool AnyNeighbors(std::uint32_t, std::uint32_t) { return true; }

/// The core, 0, and the connected pieces of the other faces, from 1 by falling size, as many as
/// count says.
Pieces LabelOutside(const FaceGraph& faces, const std::vector<bool>& core);

/// Which of some seeds each face is nearest to, along a graph whose links cost something.
struct NearestSeeds {
  std::vector<double> distance;  ///< infinite where no seed reaches
  Labels seed;                   ///< position in the seeds; -1 where none reaches
};
/// Takes the faces that are nearer to the seeds from `first` on than to those before.
/// @param costs  parallel to graph.neighbor
void GrowSeeds(const FaceGraph& graph, const std::vector<double>& costs, const Indices& seeds,
               std::size_t first, NearestSeeds& nearest);
/// Of each wanted group the face nearest to its center; none of a group without faces.
Indices MiddleFaces(const FaceFrames& frames, const Labels& group, const Points& center,
                    const std::vector<bool>& wanted);

/// Leaves of each label its largest connected piece (ties: that of the lowest face); other pieces
/// take the label they share most edges with, ties the lower one. Pieces without neighbors stay.
void JoinCrumbs(const FaceGraph& faces, Labels& label);

/// A link between two nodes, the same both ways; capacity >= 0.
struct CutLink {
  std::uint32_t a;
  std::uint32_t b;
  double capacity;
};

/// Source and sink where a caller names no other; its nodes count from 2.
inline constexpr std::uint32_t kSource = 0;
inline constexpr std::uint32_t kSink = 1;

/// The minimum cut between two nodes (Boykov and Kolmogorov 2004; Boost): true for the nodes on the
/// source's side, as few as can be, whatever the order of the links. Capacities are rounded to a
/// millionth of the largest, so that the flow is exact.
/// @throws std::invalid_argument if source equals sink or a node does not exist.
std::vector<bool> MinCut(std::uint32_t nodes, const std::vector<CutLink>& links,
                         std::uint32_t source = kSource, std::uint32_t sink = kSink);

/// Labels faces by the minimum cut: those with a node from 2 to nodes - 1, between those that keep
/// their labels as kSource or kSink. Faces of kNoNode are left out.
inline constexpr std::uint32_t kNoNode = static_cast<std::uint32_t>(-1);
void CutFaces(const FaceGraph& faces, const std::vector<double>& costs, std::uint32_t nodes,
              const Indices& node, std::int32_t of_source, std::int32_t of_sink, Labels& label);

/// The faces turned so that neighbors agree, piece by piece, and each piece encloses a volume >= 0
/// as seen from its own middle: files often mix orientations. O(n log n)
std::vector<Face> TurnedOutwards(const Shape& mesh);

}  // namespace rangegrasp::parts
