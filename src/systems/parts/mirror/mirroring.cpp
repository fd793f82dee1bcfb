#include "parts/mirror/mirroring.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/error.h"
#include "geometry/kd_tree.h"
#include "geometry/plane.h"
#include "geometry/union_find.h"
#include "parts/cloud/surface_points.h"
#include "parts/mirror/internal/space.h"
#include "parts/shape/internal/pieces.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;
using geometry::Points;

// Points round a point that are its neighbors in a cloud: as many as a pixel has, as in
// BuildVertexGraph.
constexpr std::size_t kNeighbors = 8;

std::vector<bool> CoreElements(const Shape& shape, const Core& core) {
  if (!shape.IsMesh()) return core.inside;
  std::vector<bool> in_core(shape.faces.size());
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    in_core[f] =
        std::ranges::all_of(shape.faces[f], [&](std::uint32_t v) { return core.inside[v]; });
  }
  return in_core;
}

std::vector<std::size_t> CountLabels(const std::vector<std::int32_t>& label) {
  std::vector<std::size_t> count(static_cast<std::size_t>(1 + *std::ranges::max_element(label)), 0);
  for (const std::int32_t l : label) ++count[static_cast<std::size_t>(l)];
  return count;
}

// Pieces of no more points than a neighborhood has are crumbs: each point of them goes to the part
// or core of the nearest point that is in none.
void JoinSmallPieces(const Points& points, std::vector<std::int32_t>& label) {
  const auto count = CountLabels(label);
  const auto is_crumb = [&](std::int32_t l) {
    return l > 0 && count[static_cast<std::size_t>(l)] <= kNeighbors;
  };
  Points kept;
  std::vector<std::int32_t> kept_label;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_crumb(label[i])) continue;
    kept.push_back(points[i]);
    kept_label.push_back(label[i]);
  }
  if (kept.empty() || kept.size() == points.size()) return;
  const KdTree tree(kept);
  std::vector<KdTree::Neighbor> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_crumb(label[i])) continue;
    tree.Nearest(points[i], 1, found);
    label[i] = kept_label[found.front().index];
  }
}

// Numbers the parts by falling size from 1, ties by their first point; the core stays 0.
void NumberBySize(std::vector<std::int32_t>& label) {
  const auto count = CountLabels(label);
  std::vector<std::int32_t> order;  // by first point
  std::vector<bool> seen(count.size(), false);
  for (const std::int32_t l : label) {
    if (l == 0 || seen[static_cast<std::size_t>(l)]) continue;
    seen[static_cast<std::size_t>(l)] = true;
    order.push_back(l);
  }
  std::ranges::stable_sort(order, [&](std::int32_t a, std::int32_t b) {
    return count[static_cast<std::size_t>(a)] > count[static_cast<std::size_t>(b)];
  });
  std::vector<std::int32_t> number(count.size(), 0);
  for (std::size_t k = 0; k < order.size(); ++k) {
    number[static_cast<std::size_t>(order[k])] = static_cast<std::int32_t>(k) + 1;
  }
  for (std::int32_t& l : label) l = number[static_cast<std::size_t>(l)];
}

std::vector<std::uint32_t> InOrder(const std::vector<std::uint32_t>& values,
                                   const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> ordered;
  for (const std::uint32_t i : order) ordered.push_back(values[i]);
  return ordered;
}

// Flood filling of points at d < d_a (eq. 6.8): the pieces, numbered by falling size.
std::vector<std::int32_t> FloodFill(const Points& points) {
  // A little more than the mean, so that rounding does not part points as far apart as it.
  constexpr double kMirrorSlack = 1.0 + 1e-9;
  const KdTree tree(points);
  struct Link {
    std::uint32_t a, b;
    double squared;
  };
  std::vector<Link> links;
  std::vector<double> reach;  // to the last of a point's neighbors, squared
  std::vector<KdTree::Neighbor> found;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Nearest(points[i], kNeighbors + 1, found);
    for (const auto& n : found) {
      if (n.index != i) links.push_back({i, n.index, n.squared_distance});
    }
    reach.push_back(found.back().squared_distance);
    sum += std::sqrt(reach.back());
  }
  const double d_a = sum / static_cast<double>(points.size()) * kMirrorSlack;
  geometry::UnionFind sets(points.size());
  for (const Link& link : links) {
    if (link.squared <= std::max(d_a * d_a, reach[link.b])) sets.Unite(link.a, link.b);
  }
  std::vector<std::int32_t> piece;
  geometry::LabelBySize(sets, std::vector<bool>(points.size(), true), piece);
  return piece;
}

// Section 6.2.2 for clouds.
std::vector<std::int32_t> FillCloud(const Shape& cloud, const std::vector<bool>& in_core) {
  std::vector<std::uint32_t> rest;
  for (std::uint32_t i = 0; i < in_core.size(); ++i) {
    if (!in_core[i]) rest.push_back(i);
  }
  std::vector<std::int32_t> label(in_core.size(), 0);
  if (rest.empty()) return label;
  rest = InOrder(rest, SpatialOrder(geometry::Select(cloud.points, rest)));
  const std::vector<std::int32_t> piece = FloodFill(geometry::Select(cloud.points, rest));
  for (std::size_t k = 0; k < rest.size(); ++k) label[rest[k]] = piece[k] + 1;
  JoinSmallPieces(cloud.points, label);
  NumberBySize(label);
  return label;
}

// Section 6.2.2 for meshes: faces that share an edge.
std::vector<std::int32_t> FillMesh(const Shape& mesh, const std::vector<bool>& in_core) {
  std::vector<std::int32_t> label;
  LabelOutside(BuildFaceGraph(mesh), in_core, label);
  return label;
}

Segmentation Mirror(const Shape& shape, const MirrorOptions& options) {
  const auto core = ExtractCore(shape, options);
  if (!core) {
    throw base::InputError(
        "neither the centre of the smallest enclosing sphere nor the centre of gravity is inside; "
        "go_on_outside segments nevertheless");
  }
  const auto in_core = CoreElements(shape, *core);
  Segmentation result;
  result.label = shape.IsMesh() ? FillMesh(shape, in_core) : FillCloud(shape, in_core);
  result.has_core = std::find(result.label.begin(), result.label.end(), 0) != result.label.end();
  if (!result.has_core) {
    for (std::int32_t& l : result.label) --l;
  }
  result.parts = 1 + *std::max_element(result.label.begin(), result.label.end());
  if (!core->center_inside) {
    result.note = "no centre inside was found; mirrored at that of the smallest enclosing sphere";
  } else if (core->used_centroid) {
    result.note =
        "the centre of the smallest enclosing sphere is outside; mirrored at the centre "
        "of gravity";
  }
  return result;
}

/// The points of the surface in place of a noisy cloud's; nothing where it is not noisy.
std::optional<Shape> Calmed(const Points& points) {
  if (!IsNoisy(MeasureSampling(points, KdTree(points)))) return std::nullopt;
  Shape calm{PointsOfSurface(points).points, {}, {}};
  if (geometry::IsFlat(calm.points)) return std::nullopt;
  return calm;
}

}  // namespace

Segmentation SegmentByMirroring(const Shape& shape, const MirrorOptions& options) {
  const auto calm = shape.IsMesh() ? std::nullopt : Calmed(shape.points);
  if (!calm) return Mirror(shape, options);
  Segmentation found = Mirror(*calm, options);
  const KdTree tree(calm->points);
  std::vector<KdTree::Neighbor> nearest;
  std::vector<std::int32_t> label;
  for (const Eigen::Vector3d& p : shape.points) {
    tree.Nearest(p, 1, nearest);
    label.push_back(found.label[nearest.front().index]);
  }
  found.label = std::move(label);
  return found;
}

}  // namespace rangegrasp::parts
