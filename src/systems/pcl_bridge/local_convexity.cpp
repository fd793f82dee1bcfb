#include "pcl_bridge/local_convexity.h"

#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/units.h"
#include "geometry/union_find.h"
#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {
namespace {

using Clustering = pcl::SupervoxelClustering<pcl::PointXYZ>;
using Supervoxels = std::map<std::uint32_t, pcl::Supervoxel<pcl::PointXYZ>::Ptr>;
using Convexity = pcl::LCCPSegmentation<pcl::PointXYZ>;

void Check(const Cloud& cloud, const LocalConvexityOptions& options) {
  Demand(options.voxel_m > 0.0, "SegmentByLocalConvexity: voxel_m must be > 0");
  Demand(options.seed_m > options.voxel_m, "SegmentByLocalConvexity: seed_m must be > voxel_m");
  Demand(options.normal_importance >= 0.0 && options.spatial_importance >= 0.0,
         "SegmentByLocalConvexity: importances must be >= 0");
  Demand(options.concavity_tolerance_rad >= 0.0 && options.concavity_tolerance_rad <= base::kPi,
         "SegmentByLocalConvexity: concavity_tolerance_rad must be in [0, pi]");
  Demand(
      options.common_neighbors >= 0 && options.step_voxels >= 0.0 && options.min_supervoxels >= 0,
      "SegmentByLocalConvexity: common_neighbors, step_voxels and min_supervoxels must be >= 0");
  if (!options.camera_depth) return;
  Demand(std::ranges::all_of(*cloud.data().finite, [](const auto& p) { return p.z > 0.0F; }),
         "SegmentByLocalConvexity: with camera_depth every point's z must exceed the origin's");
}

/// The library's labels of the supervoxels in ascending order: their positions are ours.
std::vector<std::uint32_t> Labels(const Supervoxels& found) {
  std::vector<std::uint32_t> labels;
  for (const auto& [label, supervoxel] : found) labels.push_back(label);
  return labels;
}

std::int32_t PositionOf(const std::vector<std::uint32_t>& labels, std::uint32_t label) {
  const auto at = std::ranges::lower_bound(labels, label);
  return at != labels.end() && *at == label ? static_cast<std::int32_t>(at - labels.begin()) : -1;
}

std::vector<SupervoxelEdge> FindEdges(const Supervoxels& found,
                                      const std::multimap<std::uint32_t, std::uint32_t>& adjacency,
                                      const std::vector<std::uint32_t>& labels,
                                      const LocalConvexityOptions& options) {
  Convexity convexity;
  convexity.setConcavityToleranceThreshold(
      static_cast<float>(base::ToDeg(options.concavity_tolerance_rad)));
  convexity.setSanityCheck(options.sanity_check);
  convexity.setSmoothnessCheck(options.step_voxels > 0.0, static_cast<float>(options.voxel_m),
                               static_cast<float>(options.seed_m),
                               static_cast<float>(options.step_voxels));
  convexity.setKFactor(static_cast<std::uint32_t>(options.common_neighbors));
  convexity.setInputSupervoxels(found, adjacency);
  convexity.segment();
  Convexity::SupervoxelAdjacencyList graph;
  convexity.getSVAdjacencyList(graph);
  std::vector<SupervoxelEdge> edges;
  for (auto [edge, end] = boost::edges(graph); edge != end; ++edge) {
    const auto [a, b] = std::minmax({PositionOf(labels, graph[boost::source(*edge, graph)]),
                                     PositionOf(labels, graph[boost::target(*edge, graph)])});
    edges.push_back({a, b, graph[*edge].is_valid});
  }
  std::ranges::sort(edges, {}, [](const SupervoxelEdge& e) { return std::pair(e.a, e.b); });
  return edges;
}

/// Joins every set of at most `max_small` members with its largest neighbor: smallest set first.
void JoinSmall(const std::vector<SupervoxelEdge>& edges, std::uint32_t max_small,
               geometry::UnionFind& sets) {
  const auto n = static_cast<std::uint32_t>(sets.size());
  std::vector<std::uint32_t> size(n, 0);  // of the set with this root
  for (std::uint32_t i = 0; i < n; ++i) ++size[sets.Find(i)];
  std::vector<std::set<std::uint32_t>> neighbors(n);  // roots
  for (const auto& edge : edges) {
    const std::uint32_t a = sets.Find(static_cast<std::uint32_t>(edge.a));
    const std::uint32_t b = sets.Find(static_cast<std::uint32_t>(edge.b));
    if (a == b) continue;
    neighbors[a].insert(b);
    neighbors[b].insert(a);
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> small;  // size and root
  const auto consider = [&](std::uint32_t root) {
    if (size[root] <= max_small && !neighbors[root].empty()) small.emplace(size[root], root);
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    if (sets.Find(i) == i) consider(i);
  }
  while (!small.empty()) {
    const std::uint32_t root = small.begin()->second;
    const std::uint32_t into =
        *std::ranges::max_element(neighbors[root], {}, [&](std::uint32_t r) { return size[r]; });
    small.erase({size[root], root});
    small.erase({size[into], into});
    sets.Unite(root, into);
    const std::uint32_t kept = sets.Find(into);
    const std::uint32_t gone = kept == into ? root : into;
    size[kept] += size[gone];
    for (const auto other : neighbors[gone]) {
      neighbors[other].erase(gone);
      if (other == kept) continue;
      neighbors[other].insert(kept);
      neighbors[kept].insert(other);
    }
    consider(kept);
  }
}

/// The segment of every supervoxel; returns how many there are.
int GrowSegments(LocalConvexity& result, int min_supervoxels) {
  geometry::UnionFind sets(result.supervoxels.size());
  for (const auto& edge : result.edges) {
    if (!edge.connects) continue;
    sets.Unite(static_cast<std::uint32_t>(edge.a), static_cast<std::uint32_t>(edge.b));
  }
  JoinSmall(result.edges, static_cast<std::uint32_t>(min_supervoxels), sets);
  std::vector<std::int32_t> segment;
  const int segments =
      geometry::LabelBySize(sets, std::vector<bool>(result.supervoxels.size(), true), segment);
  for (std::size_t i = 0; i < segment.size(); ++i) result.supervoxels[i].segment = segment[i];
  return segments;
}

void LabelPoints(const Cloud& cloud, const Clustering& clustering,
                 const std::vector<std::uint32_t>& labels, LocalConvexity& result) {
  const auto labeled = clustering.getLabeledCloud();
  for (std::size_t k = 0; k < labeled->size(); ++k) {
    const std::int32_t at = PositionOf(labels, (*labeled)[k].label);
    if (at < 0) continue;
    const std::size_t i = cloud.data().source[k];
    result.supervoxel[i] = at;
    result.segment[i] = result.supervoxels[static_cast<std::size_t>(at)].segment;
  }
}

}  // namespace

LocalConvexity SegmentByLocalConvexity(const Cloud& cloud, const LocalConvexityOptions& options) {
  Check(cloud, options);
  LocalConvexity result;
  result.segment.assign(cloud.size(), -1);
  result.supervoxel.assign(cloud.size(), -1);
  if (cloud.data().finite->empty()) return result;
  Clustering clustering(static_cast<float>(options.voxel_m), static_cast<float>(options.seed_m));
  clustering.setUseSingleCameraTransform(options.camera_depth);
  clustering.setColorImportance(0.0F);  // a cloud has no color
  clustering.setNormalImportance(static_cast<float>(options.normal_importance));
  clustering.setSpatialImportance(static_cast<float>(options.spatial_importance));
  clustering.setInputCloud(cloud.data().finite);
  Supervoxels found;
  clustering.extract(found);
  for (const auto& [label, supervoxel] : found) {
    result.supervoxels.push_back(
        {supervoxel->centroid_.getVector3fMap().cast<double>() + cloud.origin(),
         supervoxel->normal_.getNormalVector3fMap().cast<double>().normalized(), 0});
  }
  std::multimap<std::uint32_t, std::uint32_t> adjacency;
  clustering.getSupervoxelAdjacency(adjacency);
  const std::vector<std::uint32_t> labels = Labels(found);
  result.edges = FindEdges(found, adjacency, labels, options);
  result.segments = GrowSegments(result, options.min_supervoxels);
  LabelPoints(cloud, clustering, labels, result);
  return result;
}

}  // namespace rangegrasp::pcl_bridge
