#include "perception/segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "geometry/alpha_components.h"
#include "geometry/kd_tree.h"
#include "geometry/signed_graph.h"
#include "geometry/union_find.h"
#include "perception/internal/convexity.h"
#include "perception/internal/patches.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::KdTree;
using geometry::PointSpan;

/// The points of each label, for the labels with enough of them (labels go by descending size).
std::vector<Indices> Collect(const std::vector<std::int32_t>& label, std::int32_t labels,
                             const SegmentOptions& options) {
  std::vector<Indices> segments(static_cast<std::size_t>(labels));
  for (std::uint32_t i = 0; i < label.size(); ++i) {
    if (label[i] >= 0) segments[static_cast<std::size_t>(label[i])].push_back(i);
  }
  if (!options.drop_small_segments) return segments;
  std::erase_if(segments, [&options](const Indices& segment) {
    return segment.size() < static_cast<std::size_t>(std::max<int>(options.min_points, 0));
  });
  return segments;
}

void Check(const SegmentOptions& options) {
  if (!(options.alpha_m >= 0.0)) throw std::invalid_argument("Segment: alpha_m must be >= 0");
  if (!(options.min_alpha_m <= options.max_alpha_m)) {
    throw std::invalid_argument("Segment: min_alpha_m must be <= max_alpha_m");
  }
}

void Require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(fmt::format("Segment: convexity: {}", what));
}

void Check(const ConvexityOptions& o) {
  const auto is_share = [](double share) { return share >= 0.0 && share <= 1.0; };
  Require(o.link_m > 0.0 && std::isfinite(o.link_m), "link_m must be > 0");
  Require(o.patch_m > 0.0 && std::isfinite(o.patch_m), "patch_m must be > 0");
  Require(o.step_m >= 0.0, "step_m must be >= 0");
  Require(o.patch_turn > 0.0, "patch_turn must be > 0");
  Require(o.on_a_line >= 0.0, "on_a_line must be >= 0");
  Require(o.grazing_reach >= 1.0, "grazing_reach must be >= 1");
  Require(o.few_links >= 0, "few_links must be >= 0");
  Require(is_share(o.max_along_line), "max_along_line must be from 0 to 1");
  Require(is_share(o.max_link_slope), "max_link_slope must be from 0 to 1");
  Require(o.min_seed_points >= 1, "min_seed_points must be >= 1");
  Require(o.concavity_rad >= 0.0 && o.concavity_rad < o.concave_rad,
          "concavity_rad must be >= 0 and < concave_rad");
  Require(o.concave_weight >= 0.0, "concave_weight must be >= 0");
  Require(o.speck_patches >= 0.0, "speck_patches must be >= 0");
  Require(is_share(o.sliver_share), "sliver_share must be from 0 to 1");
  Require(o.sliver_depth >= 0.0, "sliver_depth must be >= 0");
}

}  // namespace

double MeshAlpha(double d_max_m, const SegmentOptions& options) {
  if (options.alpha_m > 0.0) return options.alpha_m;
  if (!options.bounded_alpha) return d_max_m;
  return std::clamp<double>(d_max_m, options.min_alpha_m, options.max_alpha_m);
}

std::vector<Indices> SegmentByMesh(PointSpan points, const SegmentOptions& options) {
  Check(options);
  if (points.size() < 3) return {};
  const KdTree tree(points);
  const bool given = options.alpha_m > 0.0;
  const double d_max_m = given ? 0.0 : geometry::NearestNeighborDistances(points, tree).max_m;
  const auto parts = geometry::FindAlphaComponents(points, tree, MeshAlpha(d_max_m, options));
  return Collect(parts.component, parts.components, options);
}

double NormalWeight(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return 1.0 - std::abs(a.dot(b) / (a.norm() * b.norm()));
}

std::vector<Indices> SegmentByRegionGrowing(PointSpan points, PointSpan normals,
                                            const SegmentOptions& options) {
  Check(options);
  if (normals.size() != points.size()) {
    throw std::invalid_argument("SegmentByRegionGrowing: needs one normal a point");
  }
  if (points.size() < 2) return {};
  const KdTree tree(points);
  const double d_a_m = geometry::NearestNeighborDistances(points, tree).mean_m;
  geometry::UnionFind regions(points.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], options.neighborhood * d_a_m, neighbors);
    for (const KdTree::Neighbor& n : neighbors) {
      if (n.index <= i || regions.Find(i) == regions.Find(n.index)) continue;
      const double distance_m = std::sqrt(n.squared_distance);
      if (distance_m * NormalWeight(normals[i], normals[n.index]) < d_a_m) {
        regions.Unite(i, n.index);
      }
    }
  }
  std::vector<std::int32_t> label;
  const std::int32_t labels =
      geometry::LabelBySize(regions, std::vector<bool>(points.size(), true), label);
  return Collect(label, labels, options);
}

std::vector<Indices> SegmentByConvexity(const geometry::PointCloud& cloud,
                                        const SegmentOptions& options) {
  Check(options);
  Check(options.convexity);
  if (cloud.normals.size() != cloud.size()) {
    throw std::invalid_argument("SegmentByConvexity: needs one normal a point");
  }
  const internal::Links links = internal::FindLinks(cloud, options.convexity);
  const internal::Patches grown = internal::GrowPatches(cloud, links, options.convexity);
  const auto borders = internal::FindBorders(cloud, links, grown);
  std::vector<geometry::SignedEdge> edges;
  for (const auto& border : borders) {
    const double together = internal::Togetherness(grown.patches[border.a], grown.patches[border.b],
                                                   border, options.convexity);
    edges.push_back({border.a, border.b, together * border.links});
  }
  geometry::UnionFind bodies = geometry::ContractGreedily(grown.patches.size(), edges);
  internal::JoinSpecks(links, grown, options.convexity, bodies);
  geometry::UnionFind points(cloud.size());
  // The other points of a body join its first.
  std::vector<std::optional<std::uint32_t>> first(grown.patches.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    auto& of_body = first[bodies.Find(grown.patch_of[i])];
    if (!of_body) of_body = i;
    points.Unite(*of_body, i);
  }
  std::vector<std::int32_t> label;
  const std::int32_t labels =
      geometry::LabelBySize(points, std::vector<bool>(cloud.size(), true), label);
  return Collect(label, labels, options);
}

std::vector<Indices> Segment(const geometry::PointCloud& cloud, const SegmentOptions& options) {
  if (options.method == SegmentMethod::kRegionGrowing) {
    return SegmentByRegionGrowing(cloud.points, cloud.normals, options);
  }
  if (options.method == SegmentMethod::kConvexity) return SegmentByConvexity(cloud, options);
  return SegmentByMesh(cloud.points, options);
}

}  // namespace rangegrasp::perception
