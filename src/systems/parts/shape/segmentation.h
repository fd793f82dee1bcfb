#pragma once

#include <span>
#include <string>

#include "geometry/mesh_file.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// A part on the way from the whole to the parts: cut further, or one of them.
struct PartNode {
  int parent = -1;          ///< in the tree; -1: a piece that nothing joins to others
  int level = 0;            ///< how many cuts above it
  std::int32_t label = -1;  ///< of the part that it is; -1 if it is cut further
  double quality = 0.0;     ///< of its best cut, made or not; infinite if there is none
};

/// What a method found: one label an element, 0 .. parts-1; with a core, it is 0.
struct Segmentation {
  Labels label;
  int parts = 0;
  bool has_core = false;
  std::string note;  ///< what the user should know (center moved, one part, ...), empty if nothing
  std::vector<PartNode> tree = {};  ///< of a hierarchical method, parents first; else empty
};

/// Of each point the label of the nearest labelled one.
Labels LabelsOfNearest(const Points& points, const Points& labelled, const Labels& labels);

/// Gives the other points the labels of the nearest of those that are kept.
void LabelByNearest(const Points& points, const Indices& kept, const Indices& others,
                    Labels& label);

/// Labels of the input's elements: those left out get that of the nearest that was kept.
Labels LabelsOfInput(const Shape& shape, const geometry::TriangleMesh& input,
                     const Segmentation& segmentation);

/// Of each of `count` groups the label of the largest weight among its members, ties the lower one;
/// -1 without members.
Labels LargestLabels(std::size_t count, const Indices& group, std::span<const std::int32_t> labels,
                     const std::vector<double>& weights);

/// Labels of the polygons that the triangles were cut of: that of the largest area, ties the lower
/// one; -1 of a polygon without triangles. Of a cloud the labels themselves.
Labels LabelsOfPolygons(const geometry::PolygonMesh& input,
                        std::span<const std::int32_t> triangles);
/// The other way round. @throws std::invalid_argument if there is not one label a polygon.
Labels LabelsOfTriangles(const geometry::PolygonMesh& input,
                         std::span<const std::int32_t> polygons);

/// Numbers some labels from 0 by falling weight, ties as they stand; -1 for the others.
Labels RankLabels(Indices labels, const std::vector<double>& weight);

/// The same with fewer parts: those of the tree that are at most so many cuts below the whole,
/// numbered by falling number of elements. Without a tree nothing changes.
Segmentation AtLevel(const Segmentation& segmentation, int level);

/// Far-apart colors, the same for the same label everywhere; 0 (the core) is red as in the
/// chapter, below 0 grey.
std::array<std::uint8_t, 3> PartColor(std::int32_t label);

}  // namespace rangegrasp::parts
