#include "parts/hierarchy/internal/grid_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;
using SliceFace = std::array<std::uint32_t, 3>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// What lies nearer to a plane lies in it, of the grid's side: far above the rounding of single
/// precision, so that no slivers are cut off by it.
constexpr double kNear = 1e-3;

/// Cuts of one mesh, at most: a surface takes some thousands and some for each of its small faces;
/// a needle without end takes more.
constexpr double kMaxCuts = 20000.0;
constexpr double kMaxCutsOfFace = 2.0;

/// How many planes the edges of the chosen faces cross, at most.
double CutsOf(double side, const std::vector<bool>& chosen, const Shape& mesh,
              const std::vector<std::uint32_t>& origin) {
  double cuts = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen[origin[f]]) continue;
    const auto& [a, b, c] = mesh.faces[f];
    for (const auto& [p, q] : {Edge{a, b}, Edge{b, c}, Edge{c, a}}) {
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
void AddParts(const geometry::Points& points, const SliceFace& face,
              const std::array<std::int64_t, 3>& cut, std::vector<SliceFace>& parts) {
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
    if (count == 2 && !is_cut(i)) {  // b - c stays whole; what is left beside a has four corners
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
bool CutOnce(double side, int axis, const std::vector<bool>& chosen, Shape& mesh,
             std::vector<std::uint32_t>& origin) {
  std::map<Edge, std::uint32_t> cuts;
  std::vector<bool> at_cut(mesh.points.size(), false);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!chosen[origin[f]]) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const Edge edge = std::minmax(mesh.faces[f][i], mesh.faces[f][(i + 1) % 3]);
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
  std::vector<SliceFace> faces;
  std::vector<std::uint32_t> origins;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [a, b, c] = mesh.faces[f];
    AddParts(mesh.points, mesh.faces[f], {cut_of(b, c), cut_of(c, a), cut_of(a, b)}, faces);
    origins.resize(faces.size(), origin[f]);
  }
  mesh.faces = std::move(faces);
  origin = std::move(origins);
  return true;
}

}  // namespace

void SliceAlongGrid(double side, const std::vector<bool>& chosen, Shape& mesh,
                    std::vector<std::uint32_t>& origin) {
  const double max_cuts = kMaxCuts + kMaxCutsOfFace * static_cast<double>(mesh.faces.size());
  if (!(CutsOf(side, chosen, mesh, origin) < max_cuts)) return;
  for (int axis = 0; axis < 3; ++axis) {
    while (CutOnce(side, axis, chosen, mesh, origin)) {
    }
  }
}

}  // namespace rangegrasp::parts
