#pragma once

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// A mesh as its flat pieces: touching faces in one plane are one facet, and large facets are cut
/// along the cubes of a grid, so that it does not matter how a flat piece is cut into triangles.
struct Facets {
  Shape mesh;
  Indices origin;     ///< of each face of the mesh: the face it is a part of
  Labels of_face;     ///< of the mesh
  FaceGraph graph;    ///< of facets; two may share several edges
  FaceFrames frames;  ///< of facets
};
/// Facets are numbered by the coordinates of their centers. O(n log n).
/// @param side  of the cubes; a facet is large if its area is more than half a cube's side.
Facets MakeFacets(const Shape& mesh, double side);

/// Labels of the faces of origin: that of the largest share of its area, ties the lower one.
Labels LabelsOfOrigin(const Facets& facets, std::size_t faces, const Labels& label_of_facet);

}  // namespace rangegrasp::parts
