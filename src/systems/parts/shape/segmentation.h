#pragma once

#include <span>
#include <string>

#include "geometry/mesh_file.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Result of a method: one label per element, 0 .. parts-1; a core has the label 0.
struct Segmentation {
  Labels label;
  int parts = 0;
  bool has_core = false;
  std::string note;  ///< message for the user (center moved, one part, ...); empty if there is none
};

/// For each point the label of the nearest labelled one.
Labels LabelsOfNearest(const Points& points, const Points& labelled, const Labels& labels);

/// Gives the points in `others` the labels of the nearest points in `kept`.
void LabelByNearest(const Points& points, const Indices& kept, const Indices& others,
                    Labels& label);

/// Labels of the input's elements; those left out get the label of the nearest one that was kept.
Labels LabelsOfInput(const Shape& shape, const geometry::TriangleMesh& input,
                     const Segmentation& segmentation);

/// For each of `count` groups the label with the largest weight among its members, on ties the
/// lower one; -1 for a group without members.
Labels LargestLabels(std::size_t count, const Indices& group, std::span<const std::int32_t> labels,
                     const std::vector<double>& weights);

/// Labels of the polygons from those of their triangles: the label with the largest area, on ties
/// the lower one; -1 for a polygon without triangles. Labels of a cloud are returned unchanged.
Labels LabelsOfPolygons(const geometry::PolygonMesh& input,
                        std::span<const std::int32_t> triangles);

/// Numbers some labels from 0 by decreasing weight, on ties in the given order; others get -1.
Labels RankLabels(Indices labels, const std::vector<double>& weight);

/// Distinct colors, always the same for a label. Label 0 (the core) is red as in the chapter,
/// labels below 0 are grey.
std::array<std::uint8_t, 3> PartColor(std::int32_t label);

}  // namespace rangegrasp::parts
