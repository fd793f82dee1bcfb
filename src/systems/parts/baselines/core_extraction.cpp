#include "parts/baselines/core_extraction.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "base/error.h"
#include "parts/baselines/internal/cut_refinement.h"
#include "parts/baselines/internal/landmark_form.h"
#include "parts/shape/internal/pieces.h"

namespace rangegrasp::parts {
namespace {

using CoreFaces = std::vector<std::uint32_t>;

/// Some faces of a mesh as a shape of its own.
struct CorePiece {
  Shape shape;
  std::vector<bool> cut;  ///< a vertex: on an edge where it was cut from the rest
};

CorePiece Extract(const Shape& mesh, const FaceGraph& graph, const CoreFaces& faces) {
  CorePiece piece;
  std::vector<bool> within(mesh.faces.size(), false);
  std::vector<bool> used(mesh.points.size(), false);
  std::vector<bool> cut(mesh.points.size(), false);
  for (const std::uint32_t f : faces) within[f] = true;
  for (const std::uint32_t f : faces) {
    for (const std::uint32_t v : mesh.faces[f]) used[v] = true;
    for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
      if (within[graph.neighbor[k]]) continue;
      for (const std::uint32_t v : graph.edge[k]) cut[v] = true;
    }
  }
  std::vector<std::uint32_t> number(mesh.points.size(), 0);
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    if (!used[v]) continue;
    number[v] = static_cast<std::uint32_t>(piece.shape.points.size());
    piece.shape.points.push_back(mesh.points[v]);
    piece.cut.push_back(cut[v]);
  }
  for (const std::uint32_t f : faces) {
    const auto& [a, b, c] = mesh.faces[f];
    piece.shape.faces.push_back({number[a], number[b], number[c]});
  }
  return piece;
}

/// A face has the label of two of its vertices' landmarks, else that of the core.
std::vector<std::int32_t> LabelFaces(const Shape& mesh, const std::vector<std::uint32_t>& landmark,
                                     const std::vector<std::int32_t>& of_landmark) {
  std::vector<std::int32_t> label;
  for (const auto& [a, b, c] : mesh.faces) {
    const std::int32_t la = of_landmark[landmark[a]];
    const std::int32_t lb = of_landmark[landmark[b]];
    const std::int32_t lc = of_landmark[landmark[c]];
    label.push_back(la == lb || la == lc ? la : lb == lc ? lb : 0);
  }
  return label;
}

/// The faces of a part as its core and segments; empty if it stays whole.
std::vector<CoreFaces> Split(const Shape& shape, const FaceGraph& shape_graph,
                             const CoreFaces& part, const CoreExtractionOptions& options) {
  const double share = static_cast<double>(part.size()) / static_cast<double>(shape.faces.size());
  const int landmarks = static_cast<int>(options.landmarks * std::sqrt(share));
  if (landmarks < options.min_landmarks) return {};
  const CorePiece piece = Extract(shape, shape_graph, part);
  const VertexGraph graph = GeodesicGraph(piece.shape);
  const LandmarkForm form = MakeLandmarkForm(graph, piece.cut, landmarks);
  if (form.size() < static_cast<std::uint32_t>(options.min_landmarks)) return {};
  std::vector<std::int32_t> of_landmark;
  const std::int32_t segments = LabelLandmarks(form, options.hull_fraction, of_landmark);
  if (segments == 0) return {};

  std::vector<std::int32_t> label = LabelFaces(piece.shape, form.spread.nearest, of_landmark);
  const FaceGraph faces = BuildFaceGraph(piece.shape);
  JoinCrumbs(faces, label);
  const std::vector<double> costs = CutCosts(piece.shape, faces);
  for (std::int32_t s = 1; s <= segments; ++s) {
    RefineBoundary(piece.shape, graph, faces, costs, s,
                   options.boundary_reach * form.spread.spacing, label);
  }
  JoinCrumbs(faces, label);
  std::map<std::int32_t, CoreFaces> by_label;
  for (std::size_t i = 0; i < label.size(); ++i) by_label[label[i]].push_back(part[i]);
  std::vector<CoreFaces> split;
  for (auto& [unused, some] : by_label) split.push_back(std::move(some));
  return split;
}

std::vector<CoreFaces> ConnectedPieces(const Shape& mesh, const FaceGraph& graph) {
  std::vector<std::int32_t> piece;
  const std::int32_t pieces = LabelPieces(graph, std::vector<bool>(mesh.faces.size(), true), piece);
  std::vector<CoreFaces> result(static_cast<std::size_t>(pieces));
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    result[static_cast<std::size_t>(piece[f])].push_back(f);
  }
  return result;
}

struct Part {
  CoreFaces faces;
  bool whole;  ///< was looked at and cannot be split
};

}  // namespace

// The paper looks for feature points and the core in a coarsened mesh; here that is the landmarks
// and the contacts of their cells, so that there is nothing to simplify and to map back.
Segmentation SegmentByCoreExtraction(const Shape& shape, const CoreExtractionOptions& options) {
  if (!shape.IsMesh()) {
    throw base::InputError("core extraction needs a mesh; the input is a point cloud");
  }
  if (options.levels < 1 || options.landmarks < 1 || options.min_landmarks < 1) {
    throw std::invalid_argument(
        "core extraction: levels, landmarks and min_landmarks must be >= 1");
  }
  const FaceGraph graph = BuildFaceGraph(shape);
  Segmentation result;
  std::vector<Part> parts;
  for (CoreFaces& faces : ConnectedPieces(shape, graph)) parts.push_back({std::move(faces), false});
  for (int level = 0; level < options.levels; ++level) {
    std::vector<Part> finer;
    for (Part& part : parts) {
      const std::vector<CoreFaces> split =
          part.whole ? std::vector<CoreFaces>{} : Split(shape, graph, part.faces, options);
      if (split.size() < 2) {
        finer.push_back({std::move(part.faces), true});
        continue;
      }
      result.has_core = result.has_core || finer.empty();
      for (const CoreFaces& faces : split) finer.push_back({faces, false});
    }
    parts = std::move(finer);
  }
  result.label.assign(shape.faces.size(), 0);
  for (const Part& part : parts) {
    for (const std::uint32_t f : part.faces) result.label[f] = result.parts;
    ++result.parts;
  }
  if (!result.has_core) result.note = "no core: no feature points, or nearly convex";
  return result;
}

}  // namespace rangegrasp::parts
