#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/shortest_path.h"
#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// Faces that share an edge. Non-manifold edges join all their faces (those of more than 16 in a
/// row); 3 slots a face are not assumed.
struct FaceGraph {
  std::vector<std::uint32_t> begin;  ///< faces + 1; neighbors of face i are [begin[i], begin[i+1])
  std::vector<std::uint32_t> neighbor;
  std::vector<std::array<std::uint32_t, 2>> edge;  ///< the shared vertices, parallel to neighbor
};
FaceGraph BuildFaceGraph(const Shape& mesh);

/// That one face, or a group of them, has another as its neighbor across an edge.
struct FaceLink {
  std::uint32_t from, to;
  std::array<std::uint32_t, 2> edge;
};
/// The graph of links among a number of faces: neighbors in ascending order, then edges.
FaceGraph GraphOfLinks(std::size_t faces, std::vector<FaceLink> links);

/// Vertices joined by an edge.
struct VertexGraph {
  std::vector<std::uint32_t> begin;  ///< vertices + 1
  std::vector<std::uint32_t> neighbor;
  std::vector<double> length;  ///< of the edge

  std::uint32_t Size() const { return static_cast<std::uint32_t>(begin.size() - 1); }
  geometry::LinkRows Links() const { return {begin, neighbor, length}; }
};
/// Of a mesh: its edges. Of a cloud: each point with its `cloud_neighbors` nearest, made symmetric.
/// Pieces that nothing joins stay apart.
VertexGraph BuildVertexGraph(const Shape& shape, int cloud_neighbors = 8);

}  // namespace rangegrasp::parts
