#include "parts/hierarchy/hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "base/words.h"
#include "parts/cloud/cloud_mesh.h"
#include "parts/cloud/internal/seen_side.h"
#include "parts/hierarchy/internal/cells.h"
#include "parts/hierarchy/internal/cuts.h"

namespace rangegrasp::parts {
namespace {

// ---- facets ----

/// A mesh divided into flat pieces. Adjacent coplanar faces are one facet; large facets are cut
/// along the cubes of a grid, so that it does not matter how a flat piece is triangulated.
struct Facets {
  Shape mesh;
  Indices origin;     ///< per face of the mesh: the face it is a part of
  Labels of_face;     ///< facet of each face of the mesh
  FaceGraph graph;    ///< of the facets; two facets may share several edges
  FaceFrames frames;  ///< of the facets
};

using Eigen::Vector3d;

/// Distance, relative to the grid's side, below which a point lies in a plane. Far above the
/// rounding of single precision, so that no slivers are cut off by it.
constexpr double kNear = 1e-3;

/// Maximum number of cuts of one mesh. A surface takes some thousands plus some for each of its
/// small faces; an endlessly long needle takes more.
constexpr double kMaxCuts = 20000.0;
constexpr double kMaxCutsOfFace = 2.0;

/// The cut across an edge that is nearest to its middle.
std::optional<Vector3d> CutOf(const Vector3d& a, const Vector3d& b, int axis, double side) {
  const double low = std::min(a[axis], b[axis]) / side + kNear;
  const double high = std::max(a[axis], b[axis]) / side - kNear;
  const double first = std::ceil(low);
  const double last = std::floor(high);
  if (first > last) return std::nullopt;
  const double plane = side * std::clamp(std::round(0.5 * (low + high)), first, last);
  Vector3d cut = a + (plane - a[axis]) / (b[axis] - a[axis]) * (b - a);
  cut[axis] = plane;
  return cut;
}

/// Splits a face at the vertices in `cut` on the edges opposite to its corners (< 0: none).
void AddParts(const Points& points, const Face& face, const std::array<std::int64_t, 3>& cut,
              std::vector<Face>& parts) {
  const auto is_cut = [&](std::size_t i) { return cut[i % 3] >= 0; };
  const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(cut[i % 3]); };
  const int count = is_cut(0) + is_cut(1) + is_cut(2);
  if (count == 0) parts.push_back(face);
  if (count == 3) parts.push_back({at(0), at(1), at(2)});
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t a = face[i], b = face[(i + 1) % 3], c = face[(i + 2) % 3];
    if (count == 1 && is_cut(i)) {
      parts.push_back({a, b, at(i)});
      parts.push_back({a, at(i), c});
    } else if (count == 2 && !is_cut(i)) {  // b - c is not cut; the rest without a has four corners
      const std::uint32_t on_ab = at(i + 2), on_ca = at(i + 1);
      parts.push_back({a, on_ab, on_ca});
      const bool from_b =
          (points[b] - points[on_ca]).squaredNorm() <= (points[c] - points[on_ab]).squaredNorm();
      parts.push_back({on_ab, b, from_b ? on_ca : c});
      parts.push_back({from_b ? b : on_ab, c, on_ca});
    } else if (count == 3) {
      parts.push_back({a, at(i + 2), at(i + 1)});
    }
  }
}

/// Cuts each edge of the chosen faces that crosses a plane once; returns false if there is none.
bool CutOnce(double side, int axis, const std::vector<bool>& chosen, Shape& mesh, Indices& origin) {
  std::map<Edge, std::uint32_t> cuts;
  std::vector<bool> at_cut(mesh.points.size(), false);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen[origin[f]]) continue;
    for (const Edge& edge : EdgesOf(mesh.faces[f])) {
      const auto cut = CutOf(mesh.points[edge[0]], mesh.points[edge[1]], axis, side);
      if (!cut) continue;
      if (!cuts.try_emplace(edge, static_cast<std::uint32_t>(mesh.points.size())).second) continue;
      mesh.points.push_back(*cut);
      at_cut[edge[0]] = at_cut[edge[1]] = true;
    }
  }
  if (cuts.empty()) return false;
  const auto cut_of = [&](std::uint32_t a, std::uint32_t b) -> std::int64_t {
    if (!at_cut[a] || !at_cut[b]) return -1;
    const auto at = cuts.find({std::min(a, b), std::max(a, b)});
    return at == cuts.end() ? -1 : static_cast<std::int64_t>(at->second);
  };
  std::vector<Face> faces;
  Indices origins;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [a, b, c] = mesh.faces[f];
    AddParts(mesh.points, mesh.faces[f], {cut_of(b, c), cut_of(c, a), cut_of(a, b)}, faces);
    origins.resize(faces.size(), origin[f]);
  }
  mesh.faces = std::move(faces);
  origin = std::move(origins);
  return true;
}

/// Cuts some faces of a mesh along the planes of a grid (x, y or z a multiple of `side`), so that
/// none of them crosses a plane. Faces next to them are cut where they share a cut edge. Nothing is
/// cut if that took more than 20,000 cuts plus two per face.
/// @param origin  of each face, passed on to its parts
/// @param chosen  for each origin, whether it is to be cut
void SliceAlongGrid(double side, const std::vector<bool>& chosen, Shape& mesh, Indices& origin) {
  double cuts = 0.0;  // upper limit: the planes that the edges of the chosen faces cross
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen[origin[f]]) continue;
    for (const auto& [p, q] : EdgesOf(mesh.faces[f])) {
      cuts += ((mesh.points[p] - mesh.points[q]) / side).lpNorm<1>();
    }
  }
  const double max_cuts = kMaxCuts + kMaxCutsOfFace * static_cast<double>(mesh.faces.size());
  if (!(cuts < max_cuts)) return;
  for (int axis = 0; axis < 3;) axis += CutOnce(side, axis, chosen, mesh, origin) ? 0 : 1;
}

/// Maximum sine of the angle between coplanar faces: above the error from single precision on faces
/// of a hundredth of the size, below anything visible.
constexpr double kFlat = 1e-3;

/// Numbers facets by the coordinates of their centers.
void NumberByCenter(FaceFrames& frames, Labels& of_face) {
  const Indices order = geometry::CanonicalOrder(frames.center);
  frames = {geometry::Select(frames.center, order), geometry::Select(frames.normal, order),
            ValuesAt(frames.area, order), frames.total_area};
  Labels number(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) number[order[k]] = static_cast<std::int32_t>(k);
  of_face = ValuesAt(number, of_face);
}

FaceGraph GraphOf(const FaceGraph& faces, const Labels& of_face, std::size_t count) {
  std::vector<FaceLink> links;
  links.reserve(faces.neighbor.size());
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const auto from = static_cast<std::uint32_t>(of_face[f]);
    const auto to = static_cast<std::uint32_t>(of_face[g]);
    if (to != from) links.push_back({from, to, faces.edge[k]});
  });
  return GraphOfLinks(count, std::move(links));
}

/// Divides a mesh into facets, numbered by the coordinates of their centers. O(n log n).
/// @param side  of the cubes; a facet is large if its area is more than half a cube's side.
Facets MakeFacets(const Shape& mesh, double side) {
  Facets facets;
  facets.mesh = {mesh.points, mesh.faces, {}};
  facets.origin.resize(mesh.faces.size());
  std::iota(facets.origin.begin(), facets.origin.end(), 0u);
  FaceGraph faces = BuildFaceGraph(mesh);
  FaceFrames frames = BuildFaceFrames(mesh);
  const Pieces flat = ConnectedPieces(faces, [&](std::uint32_t f, std::uint32_t g) {
    return frames.normal[f].dot(frames.normal[g]) > 0.0 &&
           frames.normal[f].cross(frames.normal[g]).norm() < kFlat;
  });
  const std::vector<double> area = GroupSums(flat.label, frames.area, flat.count);
  std::vector<bool> large;
  for (const std::int32_t piece : flat.label) large.push_back(area[piece] > 0.5 * side * side);
  if (std::ranges::find(large, true) != large.end()) {
    SliceAlongGrid(side, large, facets.mesh, facets.origin);
    faces = BuildFaceGraph(facets.mesh);
    frames = BuildFaceFrames(facets.mesh);
  }
  const auto cube = [&](std::uint32_t f) -> Eigen::Vector3i {
    return (frames.center[f] / side).array().floor().cast<int>();
  };
  Pieces pieces = ConnectedPieces(faces, [&](std::uint32_t f, std::uint32_t g) {
    const std::uint32_t from = facets.origin[f];
    return flat.label[from] == flat.label[facets.origin[g]] && (!large[from] || cube(f) == cube(g));
  });
  facets.of_face = std::move(pieces.label);
  facets.frames = GroupFrames(frames, facets.of_face, pieces.count);
  NumberByCenter(facets.frames, facets.of_face);
  facets.graph = GraphOf(faces, facets.of_face, pieces.count);
  return facets;
}

// ---- parts ----

/// Also for a small part: fewer centers miss one of its sides.
constexpr int kMinCenters = 4;
/// Added to a number of centers, so that the whole gets all even if its share is rounded below 1.
constexpr double kRounding = 1e-6;

/// The more concave bend of both scales at each edge.
std::vector<double> Bends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                          const HierarchyOptions& options) {
  const double unit = std::sqrt(frames.total_area);
  std::vector<double> bends = EdgeBends(mesh, faces, frames, options.fine * unit);
  const std::vector<double> coarse = EdgeBends(mesh, faces, frames, options.coarse * unit);
  for (std::size_t k = 0; k < bends.size(); ++k) bends[k] = std::max(bends[k], coarse[k]);
  return bends;
}

/// A part with its best cut.
struct Node {
  Indices cells;   ///< ascending
  double quality;  ///< of its best cut, made or not; infinite if there is none
  Indices off;     ///< cells that its best cut takes off
  bool is_leaf = true;
};

/// The tree of cuts: the best one first, until it is not good enough or there are enough parts.
std::vector<Node> CutIntoParts(const Cells& cells, double total_area,
                               const HierarchyOptions& options) {
  constexpr double kNoCut = std::numeric_limits<double>::infinity();
  const double min_area = options.min_area * total_area;
  std::vector<Node> nodes;
  const auto add = [&](Indices some) {
    const Cells own = Subset(cells, some);
    const double share = std::accumulate(own.area.begin(), own.area.end(), 0.0) / total_area;
    const int centers =
        std::max(kMinCenters, static_cast<int>(options.centers * std::sqrt(share) + kRounding));
    CutOff split =
        BestSplit(own, MirrorCandidates(own, centers, options.levels), min_area, options);
    nodes.push_back({std::move(some), split.quality, std::move(split.off)});
  };
  for (Indices& piece : ConnectedSets(cells, Sides(cells.size(), 0))) add(std::move(piece));
  const auto quality_of = [](const Node& node) { return node.is_leaf ? node.quality : kNoCut; };
  while (true) {
    const auto next = std::ranges::min_element(nodes, {}, quality_of);
    const double quality = quality_of(*next);
    const bool wanted = options.parts
                            ? std::ranges::count(nodes, true, &Node::is_leaf) < *options.parts
                            : quality <= options.cut_quality;
    if (!wanted || quality == kNoCut) return nodes;
    next->is_leaf = false;
    const Indices whole = next->cells;
    for (const Indices& piece : Divide(Subset(cells, whole), next->off, min_area)) {
      add(ValuesAt(whole, piece));
    }
  }
}

/// Numbers labels by decreasing weight, on ties by their first element. Returns the new number of
/// each label, -1 for labels without elements.
Labels Renumber(const std::vector<double>& weight, Labels& label) {
  std::vector<bool> seen(weight.size(), false);
  Indices names;
  for (const std::int32_t l : label) {
    if (!seen[l]) names.push_back(static_cast<std::uint32_t>(l));
    seen[l] = true;
  }
  const Labels number = RankLabels(std::move(names), weight);
  for (std::int32_t& l : label) l = number[l];
  return number;
}

Segmentation SegmentMesh(const Shape& shape, const HierarchyOptions& options) {
  const CanonicalMesh canonical = MakeCanonical(shape);
  const Facets facets = MakeFacets(canonical.mesh, options.flat_side);
  const Shape& mesh = facets.mesh;
  const FaceGraph& faces = facets.graph;
  const FaceFrames& frames = facets.frames;
  const std::vector<double> bends = Bends(mesh, faces, frames, options);
  const std::vector<double> costs = BendCosts(mesh, faces, bends, options.concavity);
  Cells cells = BuildCells(mesh, faces, frames, bends, costs, options.cells, options.crease);
  if (options.sight > 0.0) cells.sight = std::make_shared<Sight>(mesh, frames, cells);
  cells.name.resize(cells.size());
  std::iota(cells.name.begin(), cells.name.end(), 0u);

  const std::vector<Node> nodes = CutIntoParts(cells, frames.total_area, options);
  Labels of_cell(cells.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!nodes[k].is_leaf) continue;
    for (const std::uint32_t c : nodes[k].cells) of_cell[c] = static_cast<std::int32_t>(k);
  }
  Labels label = ValuesAt(of_cell, cells.of_face);
  MoveBorders(faces, frames, costs,
              options.border_reach * std::sqrt(frames.total_area / cells.size()), label);
  JoinCrumbs(faces, label);
  Segmentation result;
  result.label.assign(shape.faces.size(), 0);
  // A face that was cut gets the label with the largest share of it.
  const Labels sorted = LargestLabels(shape.faces.size(), facets.origin,
                                      ValuesAt(label, facets.of_face), BuildFaceFrames(mesh).area);
  for (std::size_t f = 0; f < sorted.size(); ++f) result.label[canonical.origin[f]] = sorted[f];
  const auto number =
      Renumber(GroupSums(result.label, BuildFaceFrames(shape).area, nodes.size()), result.label);
  result.parts = *std::ranges::max_element(number) + 1;
  result.has_core = result.parts > 1;
  if (result.parts == 1) result.note = "one part: no cut is short and concave enough";
  if (options.parts && result.parts != *options.parts) {
    result.note =
        fmt::format("{}, not {}: {}", base::Counted(result.parts, "part"), *options.parts,
                    result.parts < *options.parts
                        ? "there are no more cuts along concave bends"
                        : "a cut gives more than two parts, or there are separate pieces");
  }
  return result;
}

/// The parts of a body of revolution that is seen from one side are joined from smaller ones. A
/// missed handle stays missed, but parts that were cut too often are joined again.
Segmentation SegmentSeen(const Shape& mesh, HierarchyOptions options) {
  const auto axis = FindSeenBody(mesh);
  if (!axis) return JoinWalls(mesh, SegmentMesh(mesh, options));
  options.cut_quality *= 2.0;
  return JoinTurned(mesh, *axis, SegmentMesh(mesh, options));
}

/// Removes parts without elements: a small part of a mesh may not be the nearest to any point.
void DropEmptyParts(Segmentation& found) {
  std::vector<double> as_before(found.parts);
  for (std::size_t l = 0; l < as_before.size(); ++l) as_before[l] = -static_cast<double>(l);
  const Labels number = Renumber(as_before, found.label);
  found.parts = *std::ranges::max_element(number) + 1;
  found.has_core = found.parts > 1;
}

/// A single view has no inside to look through, and noise lets light through thin walls. Clouds are
/// therefore cut along creases only, with values chosen for that.
Segmentation SegmentCloud(const Shape& cloud, HierarchyOptions options) {
  options.sight = 0.0;
  options.max_flatness = 0.88;
  options.cut_quality *= 0.42 / HierarchyOptions{}.cut_quality;
  const CloudMesh surface = MeshOfCloud(cloud.points);
  if (!surface.mesh.IsMesh()) {
    return {.label = Labels(cloud.points.size(), 0),
            .parts = 1,
            .note = "one part: its points lie too far apart to make a surface of them"};
  }
  Segmentation found =
      options.parts ? SegmentMesh(surface.mesh, options) : SegmentSeen(surface.mesh, options);
  found.label = ValuesAt(found.label, surface.face_of_point);
  DropEmptyParts(found);
  return found;
}

}  // namespace

Segmentation SegmentHierarchy(const Shape& shape, const HierarchyOptions& options) {
  return shape.IsMesh() ? SegmentMesh(shape, options) : SegmentCloud(shape, options);
}

}  // namespace rangegrasp::parts
