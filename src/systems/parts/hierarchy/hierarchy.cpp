#include "parts/hierarchy/hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "parts/cloud/cloud_mesh.h"
#include "parts/cloud/internal/seen_side.h"
#include "parts/hierarchy/internal/cells.h"
#include "parts/hierarchy/internal/cuts.h"
#include "parts/hierarchy/internal/facets.h"

namespace rangegrasp::parts {
namespace {

/// Of a small part too: fewer centers miss one of its sides.
constexpr int kMinCenters = 4;
/// Of a number of centers: the whole has all of them, also where its share is rounded below 1.
constexpr double kRounding = 1e-6;

void Check(const HierarchyOptions& options) {
  if (options.cells < 2 || options.centers < kMinCenters || options.levels < 1 ||
      !(options.fine > 0.0) || !(options.coarse > 0.0) || !(options.concavity >= 0.0) ||
      (options.parts && *options.parts < 1) || !(options.cut_quality > 0.0) ||
      !(options.min_area > 0.0) || !(options.flat_side > 0.0)) {
    throw std::invalid_argument("hierarchy: an option is out of range");
  }
}

std::vector<double> Costs(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                          const HierarchyOptions& options, std::vector<double>& bends) {
  const double unit = std::sqrt(frames.total_area);
  bends = EdgeBends(mesh, faces, frames, options.fine * unit);
  const std::vector<double> coarse = EdgeBends(mesh, faces, frames, options.coarse * unit);
  for (std::size_t k = 0; k < bends.size(); ++k) bends[k] = std::max(bends[k], coarse[k]);
  return BendCosts(mesh, faces, bends, options.concavity);
}

/// A part with the best cut through it.
struct Node {
  Indices cells;  ///< ascending
  PartNode part;
  CutOff split;
  bool is_leaf = true;
};

class Hierarchy {
 public:
  Hierarchy(const Cells& cells, double total_area, const HierarchyOptions& options)
      : cells_(cells), total_area_(total_area), options_(options) {
    for (Indices& piece : ConnectedSets(cells, std::vector<bool>(cells.size(), false))) {
      Add(std::move(piece), -1);
    }
    leaves_ = static_cast<int>(nodes_.size());
    while (const auto next = NextToCut()) Cut(*next);
  }

  const std::vector<Node>& nodes() const { return nodes_; }

 private:
  double MinArea() const { return options_.min_area * total_area_; }

  void Add(Indices cells, int parent) {
    const Cells own = Subset(cells_, cells);
    const double share = std::accumulate(own.area.begin(), own.area.end(), 0.0) / total_area_;
    const int centers =
        std::max(kMinCenters, static_cast<int>(options_.centers * std::sqrt(share) + kRounding));
    CutOff split =
        BestSplit(own, MirrorCandidates(own, {.centers = centers, .levels = options_.levels}),
                  {.min_area = MinArea(),
                   .solidity = options_.solidity,
                   .max_flatness = options_.max_flatness});
    PartNode part;
    part.parent = parent;
    part.level = parent < 0 ? 0 : nodes_[parent].part.level + 1;
    part.quality = split.quality;
    nodes_.push_back({std::move(cells), part, std::move(split)});
  }

  /// The leaf with the best cut, if it is good enough or more parts are wanted.
  std::optional<std::size_t> NextToCut() const {
    std::optional<std::size_t> best;
    double quality = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (!nodes_[k].is_leaf || nodes_[k].part.quality >= quality) continue;
      quality = nodes_[k].part.quality;
      best = k;
    }
    const bool wanted =
        options_.parts ? leaves_ < *options_.parts : quality <= options_.cut_quality;
    return wanted ? best : std::nullopt;
  }

  void Cut(std::size_t k) {
    const Indices cells = nodes_[k].cells;
    nodes_[k].is_leaf = false;
    --leaves_;
    for (const Indices& piece : Divide(Subset(cells_, cells), nodes_[k].split.off, MinArea())) {
      Indices of_all;
      for (const std::uint32_t c : piece) of_all.push_back(cells[c]);
      Add(std::move(of_all), static_cast<int>(k));
      ++leaves_;
    }
  }

  const Cells& cells_;
  double total_area_;
  const HierarchyOptions& options_;
  std::vector<Node> nodes_;
  int leaves_ = 0;
};

/// Numbers labels by falling area, ties by their first face. Returns the new number of each of
/// `count` labels, -1 of those that no face has.
Labels NumberByArea(const FaceFrames& frames, std::size_t count, Labels& label) {
  std::vector<double> area(count, 0.0);
  Labels names;
  for (std::size_t f = 0; f < label.size(); ++f) {
    if (area[label[f]] == 0.0) names.push_back(label[f]);
    area[label[f]] += frames.area[f];
  }
  std::ranges::stable_sort(names, std::greater<>(), [&](std::int32_t l) { return area[l]; });
  Labels number(count, -1);
  for (std::size_t k = 0; k < names.size(); ++k) number[names[k]] = static_cast<std::int32_t>(k);
  for (std::int32_t& l : label) l = number[l];
  return number;
}

Segmentation SegmentMesh(const Shape& shape, const HierarchyOptions& options) {
  const CanonicalMesh canonical = MakeCanonical(shape);
  const Facets facets = MakeFacets(canonical.mesh, options.flat_side);
  const Shape& mesh = facets.mesh;
  const FaceGraph& faces = facets.graph;
  const FaceFrames& frames = facets.frames;
  std::vector<double> bends;
  const std::vector<double> costs = Costs(mesh, faces, frames, options, bends);
  const Cells cells = BuildCells(mesh, faces, frames, bends, costs, options.cells, options.crease);

  const Hierarchy hierarchy(cells, frames.total_area, options);
  const std::vector<Node>& nodes = hierarchy.nodes();
  Labels of_cell(cells.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!nodes[k].is_leaf) continue;
    for (const std::uint32_t c : nodes[k].cells) of_cell[c] = static_cast<std::int32_t>(k);
  }
  Labels label;
  for (const std::int32_t c : cells.of_face) label.push_back(of_cell[c]);
  MoveBorders(faces, frames, costs,
              options.border_reach * std::sqrt(frames.total_area / cells.size()), label);
  JoinCrumbs(faces, label);
  Segmentation result;
  result.label.assign(shape.faces.size(), 0);
  const Labels sorted = LabelsOfOrigin(facets, shape.faces.size(), label);
  for (std::size_t f = 0; f < sorted.size(); ++f) result.label[canonical.origin[f]] = sorted[f];
  const auto number = NumberByArea(BuildFaceFrames(shape), nodes.size(), result.label);
  result.parts = *std::ranges::max_element(number) + 1;
  // Leaves that lost all of their faces, too small for the mesh, have no label.
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    result.tree.push_back(nodes[k].part);
    result.tree.back().label = number[k];
  }
  result.has_core = result.parts > 1;
  if (result.parts == 1) result.note = "one part: no cut is short and concave enough";
  if (options.parts && result.parts != *options.parts) {
    result.note = fmt::format("{} parts, not {}: {}", result.parts, *options.parts,
                              result.parts < *options.parts
                                  ? "there are no more cuts along concave bends"
                                  : "a cut gives more than two, or pieces lie apart");
  }
  return result;
}

/// The parts of a body of revolution that is seen from one side are joined from smaller ones: a
/// handle that is missed stays missed, but what is cut too often is put together again.
Segmentation SegmentSeen(const Shape& mesh, HierarchyOptions options) {
  const auto axis = FindSeenBody(mesh);
  if (!axis) return JoinWalls(mesh, SegmentMesh(mesh, options));
  options.cut_quality *= 2.0;
  return JoinTurned(mesh, *axis, SegmentMesh(mesh, options));
}

Segmentation SegmentCloud(const Shape& cloud, const HierarchyOptions& options) {
  const CloudMesh surface = MeshOfCloud(cloud.points);
  if (!surface.mesh.IsMesh()) {
    return {.label = Labels(cloud.points.size(), 0),
            .parts = 1,
            .note = "one part: its points lie too far apart to make a surface of them"};
  }
  Segmentation found =
      options.parts ? SegmentMesh(surface.mesh, options) : SegmentSeen(surface.mesh, options);
  Labels label;
  for (const std::uint32_t f : surface.face_of_point) label.push_back(found.label[f]);
  found.label = std::move(label);
  return found;
}

}  // namespace

Segmentation SegmentHierarchy(const Shape& shape, const HierarchyOptions& options) {
  Check(options);
  return shape.IsMesh() ? SegmentMesh(shape, options) : SegmentCloud(shape, options);
}

}  // namespace rangegrasp::parts
