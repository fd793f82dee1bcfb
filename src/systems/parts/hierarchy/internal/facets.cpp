#include "parts/hierarchy/internal/facets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;
using VertexPair = std::pair<std::uint32_t, std::uint32_t>;

/// What lies nearer to a plane lies in it, of the grid's side: far above the rounding of single
/// precision, so that no slivers are cut off by it.
constexpr double kNear = 1e-3;

/// Cuts of one mesh, at most: a surface takes some thousands and some for each of its small faces;
/// a needle without end takes more.
constexpr double kMaxCuts = 20000.0;
constexpr double kMaxCutsOfFace = 2.0;

/// How many planes the edges of the chosen faces cross, at most.
double CutsOf(double side, const std::vector<bool>& chosen, const Shape& mesh,
              const Indices& origin) {
  double cuts = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen[origin[f]]) continue;
    const auto& [a, b, c] = mesh.faces[f];
    for (const auto& [p, q] : {VertexPair{a, b}, VertexPair{b, c}, VertexPair{c, a}}) {
      cuts += ((mesh.points[p] - mesh.points[q]) / side).lpNorm<1>();
    }
  }
  return cuts;
}

/// The cut across an edge nearest to its middle.
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

/// A face's parts where the edges opposite to its corners have a vertex of `cut`, if they do.
void AddParts(const Points& points, const Face& face, const std::array<std::int64_t, 3>& cut,
              std::vector<Face>& parts) {
  const auto is_cut = [&](std::size_t i) { return cut[i % 3] >= 0; };
  const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(cut[i % 3]); };
  const int count = is_cut(0) + is_cut(1) + is_cut(2);
  if (count == 0) parts.push_back(face);
  if (count == 3) {
    parts.push_back({at(0), at(1), at(2)});
    for (std::size_t i = 0; i < 3; ++i) parts.push_back({face[i], at(i + 2), at(i + 1)});
  }
  for (std::size_t i = 0; i < 3 && (count == 1 || count == 2); ++i) {
    const std::uint32_t a = face[i], b = face[(i + 1) % 3], c = face[(i + 2) % 3];
    if (count == 1 && is_cut(i)) {
      parts.push_back({a, b, at(i)});
      parts.push_back({a, at(i), c});
    }
    if (count == 2 && !is_cut(i)) {  // b - c stays whole; what is left at a has four corners
      const std::uint32_t on_ab = at(i + 2), on_ca = at(i + 1);
      parts.push_back({a, on_ab, on_ca});
      const bool from_b =
          (points[b] - points[on_ca]).squaredNorm() <= (points[c] - points[on_ab]).squaredNorm();
      parts.push_back({on_ab, b, from_b ? on_ca : c});
      parts.push_back({from_b ? b : on_ab, c, on_ca});
    }
  }
}

/// Cuts each edge of the chosen faces that crosses a plane once; false if there is none.
bool CutOnce(double side, int axis, const std::vector<bool>& chosen, Shape& mesh, Indices& origin) {
  std::map<VertexPair, std::uint32_t> cuts;
  std::vector<bool> at_cut(mesh.points.size(), false);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen[origin[f]]) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexPair edge = std::minmax(mesh.faces[f][i], mesh.faces[f][(i + 1) % 3]);
      const auto cut = CutOf(mesh.points[edge.first], mesh.points[edge.second], axis, side);
      if (!cut) continue;
      if (!cuts.try_emplace(edge, static_cast<std::uint32_t>(mesh.points.size())).second) continue;
      mesh.points.push_back(*cut);
      at_cut[edge.first] = at_cut[edge.second] = true;
    }
  }
  if (cuts.empty()) return false;
  const auto cut_of = [&](std::uint32_t a, std::uint32_t b) -> std::int64_t {
    if (!at_cut[a] || !at_cut[b]) return -1;
    const auto at = cuts.find(std::minmax(a, b));
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
/// none of them reaches over a plane; faces next to them are cut where they share a cut edge.
/// Nothing is cut where that would be more than 20,000 cuts and two a face.
/// @param origin  of each face, handed on to its parts.
/// @param chosen  of each origin, whether it is to be cut.
void SliceAlongGrid(double side, const std::vector<bool>& chosen, Shape& mesh, Indices& origin) {
  const double max_cuts = kMaxCuts + kMaxCutsOfFace * static_cast<double>(mesh.faces.size());
  if (!(CutsOf(side, chosen, mesh, origin) < max_cuts)) return;
  for (int axis = 0; axis < 3; ++axis) {
    while (CutOnce(side, axis, chosen, mesh, origin)) {
    }
  }
}

/// Sine of the angle between faces in one plane, at most: above what coordinates of single
/// precision leave of it on faces of a hundredth of the size, below all that can be seen.
constexpr double kFlat = 1e-3;

/// Which flat piece each face is of.
std::int32_t FlatPieces(const FaceGraph& faces, const FaceFrames& frames, Labels& of_face) {
  return LabelPieces(
      faces, std::vector<bool>(frames.area.size(), true),
      [&](std::uint32_t f, std::uint32_t g) {
        return frames.normal[f].dot(frames.normal[g]) > 0.0 &&
               frames.normal[f].cross(frames.normal[g]).norm() < kFlat;
      },
      of_face);
}

/// Whether each face is of a piece of more area than a limit.
std::vector<bool> OfLargePieces(const FaceFrames& frames, std::int32_t pieces,
                                const Labels& of_face, double max_area) {
  std::vector<double> area(pieces, 0.0);
  for (std::size_t f = 0; f < of_face.size(); ++f) area[of_face[f]] += frames.area[f];
  std::vector<bool> large;
  for (const std::int32_t piece : of_face) large.push_back(area[piece] > max_area);
  return large;
}

/// Numbers facets by the places of their centers.
void NumberByCenter(FaceFrames& frames, Labels& of_face) {
  Indices order(frames.area.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t i) {
    const Vector3d& p = frames.center[i];
    return std::tuple(p.x(), p.y(), p.z(), i);
  });
  FaceFrames sorted{geometry::Select(frames.center, order),
                    geometry::Select(frames.normal, order),
                    {},
                    frames.total_area};
  Labels number(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    number[order[k]] = static_cast<std::int32_t>(k);
    sorted.area.push_back(frames.area[order[k]]);
  }
  frames = std::move(sorted);
  for (std::int32_t& facet : of_face) facet = number[facet];
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

}  // namespace

Facets MakeFacets(const Shape& mesh, double side) {
  Facets facets;
  facets.mesh = {mesh.points, mesh.faces, {}};
  facets.origin.resize(mesh.faces.size());
  std::iota(facets.origin.begin(), facets.origin.end(), 0u);
  FaceGraph faces = BuildFaceGraph(mesh);
  FaceFrames frames = BuildFaceFrames(mesh);
  Labels flat;
  const std::int32_t pieces = FlatPieces(faces, frames, flat);
  const std::vector<bool> large = OfLargePieces(frames, pieces, flat, 0.5 * side * side);
  if (std::ranges::find(large, true) != large.end()) {
    SliceAlongGrid(side, large, facets.mesh, facets.origin);
    faces = BuildFaceGraph(facets.mesh);
    frames = BuildFaceFrames(facets.mesh);
  }
  const auto cube = [&](std::uint32_t f) -> Eigen::Vector3i {
    return (frames.center[f] / side).array().floor().cast<int>();
  };
  const std::int32_t count = LabelPieces(
      faces, std::vector<bool>(facets.mesh.faces.size(), true),
      [&](std::uint32_t f, std::uint32_t g) {
        const std::uint32_t from = facets.origin[f];
        return flat[from] == flat[facets.origin[g]] && (!large[from] || cube(f) == cube(g));
      },
      facets.of_face);
  facets.frames = GroupFrames(frames, facets.of_face, count);
  NumberByCenter(facets.frames, facets.of_face);
  facets.graph = GraphOf(faces, facets.of_face, count);
  return facets;
}

Labels LabelsOfOrigin(const Facets& facets, std::size_t faces, const Labels& label_of_facet) {
  Labels labels;
  for (const std::int32_t facet : facets.of_face) labels.push_back(label_of_facet[facet]);
  return LargestLabels(faces, facets.origin, labels, BuildFaceFrames(facets.mesh).area);
}

}  // namespace rangegrasp::parts
