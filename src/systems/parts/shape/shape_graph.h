#pragma once

#include <cstddef>

#include "geometry/graph.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Faces that share an edge. A non-manifold edge links all its faces (more than 16: in a chain).
struct FaceGraph {
  Indices begin;  ///< size: faces + 1; neighbors of face i are [begin[i], begin[i+1])
  Indices neighbor;
  std::vector<Edge> edge;  ///< the shared vertices, parallel to neighbor
};
FaceGraph BuildFaceGraph(const Shape& mesh);

/// A link from a face, or a group of faces, to a neighbor across an edge.
struct FaceLink {
  std::uint32_t from, to;
  Edge edge;
};
/// The graph of the links between `faces` faces, sorted by neighbor, then by edge.
FaceGraph GraphOfLinks(std::size_t faces, std::vector<FaceLink> links);

/// Graph of vertices joined by an edge.
struct VertexGraph {
  Indices begin;  ///< size: vertices + 1
  Indices neighbor;
  std::vector<double> length;  ///< length of each edge

  std::uint32_t Size() const { return static_cast<std::uint32_t>(begin.size() - 1); }
  geometry::LinkRows Links() const { return {begin, neighbor, length}; }
};
/// Number of neighbors of a point in a cloud: as many as a pixel has.
inline constexpr std::size_t kCloudNeighbors = 8;
/// Mesh: its edges. Cloud: each point with its kCloudNeighbors nearest points, made symmetric.
/// Disconnected pieces stay separate.
VertexGraph BuildVertexGraph(const Shape& shape);

struct VertexLink {
  std::uint32_t from, to;
  double length;
};
/// The graph of the links in both directions; the shortest of several parallel links is kept.
VertexGraph GraphOfLinks(std::size_t vertices, std::vector<VertexLink> links);

/// Calls visit(node, neighbor, k) for each link of a graph (FaceGraph, VertexGraph) in both
/// directions; k is its index in `neighbor`.
template <typename Graph, typename Visit>
void ForEachLink(const Graph& graph, Visit visit) {
  for (std::uint32_t v = 0; v + 1 < graph.begin.size(); ++v) {
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      visit(v, graph.neighbor[k], k);
    }
  }
}

/// Connected pieces of a graph.
struct Pieces {
  Labels label;  ///< numbered from 0 by decreasing size, ties by their first node
  std::int32_t count = 0;
};
/// joined(a, b) is true if neighbors belong together. O(links).
/// @param chosen  nodes to consider; the others get the label -1
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
/// The same for all nodes.
template <typename Graph, typename Joined>
Pieces ConnectedPieces(const Graph& graph, Joined joined) {
  return ConnectedPieces(graph, std::vector<bool>(graph.begin.size() - 1, true), joined);
}
inline bool AnyNeighbors(std::uint32_t, std::uint32_t) { return true; }

/// The seed that is nearest to each face along a graph with link costs.
struct NearestSeeds {
  std::vector<double> distance;  ///< infinite if no seed reaches the face
  Labels seed;                   ///< index in the seeds; -1 if none reaches the face
};
/// Reassigns the faces that are nearer to the seeds from `first` on than to the earlier ones.
/// @param costs  parallel to graph.neighbor
void GrowSeeds(const FaceGraph& graph, const std::vector<double>& costs, const Indices& seeds,
               std::size_t first, NearestSeeds& nearest);
/// For each group the face nearest to its center; groups without faces are skipped.
Indices MiddleFaces(const FaceFrames& frames, const Labels& group, const Points& center);

/// Keeps the largest connected piece of each label (on ties that with the lowest face). Other
/// pieces take the label with which they share most edges, on ties the lower one. Pieces without
/// neighbors stay.
void JoinCrumbs(const FaceGraph& faces, Labels& label);

/// An undirected link between two nodes; capacity >= 0.
struct CutLink {
  std::uint32_t a;
  std::uint32_t b;
  double capacity;
};

/// Source and sink; a caller's own nodes are numbered from 2.
inline constexpr std::uint32_t kSource = 0;
inline constexpr std::uint32_t kSink = 1;

/// Minimum cut between source and sink (Boykov and Kolmogorov 2004; Boost). True for the nodes on
/// the source's side, which are as few as possible for any order of the links. Capacities are
/// rounded to a millionth of the largest, so that the flow is exact.
/// @param nodes  their number, >= 2
std::vector<bool> MinCut(std::uint32_t nodes, const std::vector<CutLink>& links);

/// Relabels the faces with a node from 2 to nodes - 1 by a minimum cut. Faces with node kSource or
/// kSink keep their labels; those with kNoNode are left out.
inline constexpr std::uint32_t kNoNode = static_cast<std::uint32_t>(-1);
void CutFaces(const FaceGraph& faces, const std::vector<double>& costs, std::uint32_t nodes,
              const Indices& node, std::int32_t of_source, std::int32_t of_sink, Labels& label);

/// Orients the faces of each connected piece consistently and so that it encloses a volume >= 0 as
/// seen from its own middle; files often mix orientations. O(n log n)
std::vector<Face> TurnedOutwards(const Shape& mesh);

}  // namespace rangegrasp::parts
