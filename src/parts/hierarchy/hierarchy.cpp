#include "parts/hierarchy/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "core/error.h"
#include "parts/hierarchy/internal/best_split.h"
#include "parts/hierarchy/internal/facets.h"
#include "parts/hierarchy/internal/mirror_candidates.h"
#include "parts/hierarchy/internal/move_borders.h"
#include "parts/hierarchy/internal/surface_bend.h"
#include "parts/shape/canonical_mesh.h"
#include "parts/shape/internal/pieces.h"

namespace rangegrasp::parts {
namespace {

/// Of a small part too: fewer centers miss one of its sides.
constexpr int kMinCenters = 4;

void Check(const HierarchyOptions& options) {
  if (options.cells < 2 || options.centers < kMinCenters || options.levels < 1 ||
      !(options.fine > 0.0) || !(options.coarse > 0.0) || !(options.concavity >= 0.0) ||
      !(options.cut_quality > 0.0) || !(options.min_area > 0.0) || !(options.flat_side > 0.0)) {
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

/// The parts of a connected set of cells.
void CutApart(const Cells& cells, const CellSet& part, double total_area,
              const HierarchyOptions& options, std::vector<CellSet>& parts) {
  const Cells own = Subset(cells, part);
  const double share = std::accumulate(own.area.begin(), own.area.end(), 0.0) / total_area;
  const int centers = std::max(kMinCenters, static_cast<int>(options.centers * std::sqrt(share)));
  const double min_area = options.min_area * total_area;
  const Split split = BestSplit(
      own, MirrorCandidates(own, {.centers = centers, .levels = options.levels}),
      {.min_area = min_area, .solidity = options.solidity, .max_flatness = options.max_flatness});
  if (!(split.quality <= options.cut_quality)) {
    parts.push_back(part);
    return;
  }
  for (const CellSet& piece : Divide(own, split.off, min_area)) {
    CellSet of_all;
    for (const std::uint32_t c : piece) of_all.push_back(part[c]);
    CutApart(cells, of_all, total_area, options, parts);
  }
}

/// Numbers labels by falling area, ties by their first face. Returns how many there are.
std::int32_t NumberByArea(const FaceFrames& frames, std::vector<std::int32_t>& label) {
  std::vector<double> area(label.size(), 0.0);
  std::vector<std::int32_t> names;
  for (std::size_t f = 0; f < label.size(); ++f) {
    const auto l = static_cast<std::size_t>(label[f]);
    if (area[l] == 0.0) names.push_back(label[f]);
    area[l] += frames.area[f];
  }
  std::stable_sort(names.begin(), names.end(), [&](std::int32_t a, std::int32_t b) {
    return area[static_cast<std::size_t>(a)] > area[static_cast<std::size_t>(b)];
  });
  std::vector<std::int32_t> number(label.size(), 0);
  for (std::size_t k = 0; k < names.size(); ++k) {
    number[static_cast<std::size_t>(names[k])] = static_cast<std::int32_t>(k);
  }
  for (std::int32_t& l : label) l = number[static_cast<std::size_t>(l)];
  return static_cast<std::int32_t>(names.size());
}

}  // namespace

Segmentation SegmentHierarchy(const Shape& shape, const HierarchyOptions& options) {
  if (!shape.IsMesh()) {
    throw core::InputError("method hierarchy needs a mesh; the input is a point cloud");
  }
  Check(options);
  const CanonicalMesh canonical = MakeCanonical(shape);
  const Facets facets = MakeFacets(canonical.mesh, options.flat_side);
  const Shape& mesh = facets.mesh;
  const FaceGraph& faces = facets.graph;
  const FaceFrames& frames = facets.frames;
  std::vector<double> bends;
  const std::vector<double> costs = Costs(mesh, faces, frames, options, bends);
  const Cells cells = BuildCells(mesh, faces, frames, bends, costs, options.cells, options.crease);

  std::vector<CellSet> parts;
  const std::vector<CellSet> pieces = ConnectedSets(cells, std::vector<bool>(cells.size(), false));
  for (const CellSet& piece : pieces) CutApart(cells, piece, frames.total_area, options, parts);

  std::vector<std::int32_t> of_cell(cells.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (const std::uint32_t c : parts[p]) of_cell[c] = static_cast<std::int32_t>(p);
  }
  std::vector<std::int32_t> label;
  for (const std::int32_t c : cells.of_face) label.push_back(of_cell[static_cast<std::size_t>(c)]);
  MoveBorders(faces, frames, costs,
              options.border_reach * std::sqrt(frames.total_area / cells.size()), label);
  JoinCrumbs(faces, label);
  Segmentation result;
  result.label.assign(shape.faces.size(), 0);
  const std::vector<std::int32_t> sorted = LabelsOfOrigin(facets, shape.faces.size(), label);
  for (std::size_t f = 0; f < sorted.size(); ++f) result.label[canonical.origin[f]] = sorted[f];
  result.parts = NumberByArea(BuildFaceFrames(shape), result.label);
  result.has_core = result.parts > 1;
  if (result.parts == 1) result.note = "one part: no cut is short and concave enough";
  return result;
}

}  // namespace rangegrasp::parts
