#include "pcl_bridge/pcl_segmentation.h"

#include <pcl/ModelCoefficients.h>
#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <algorithm>
#include <limits>
#include <map>
#include <ranges>
#include <set>

#include "geometry/graph.h"
#include "pcl_bridge/internal/pcl_cloud.h"

namespace rangegrasp::pcl_bridge {
namespace {

using Clustering = pcl::SupervoxelClustering<pcl::PointXYZ>;
using Supervoxels = std::map<std::uint32_t, pcl::Supervoxel<pcl::PointXYZ>::Ptr>;
using Convexity = pcl::LCCPSegmentation<pcl::PointXYZ>;

/// The distance measure for growing supervoxels is the sum of (1 - |cos| of the angle between
/// normals) and distance / seed_m with these weights, the library's defaults.
constexpr float kNormalImportance = 1.0F;
constexpr float kSpatialImportance = 0.4F;
/// Connections across a step are left out: the planes are further apart than their angle explains,
/// by more than this many voxels (the library's default).
constexpr float kStepVoxels = 0.1F;
/// A concave connection is kept if the normals differ by less than this (Stein et al. 2014). A
/// larger value connects across shallow creases, a smaller one splits noisy surfaces.
constexpr float kConcavityTolerance_deg = 10.0F;

/// Drawing ends early when an all-inlier sample has been drawn with this probability, based on the
/// best share of inliers so far. The library's default.
constexpr double kConfidence = 0.99;

struct SupervoxelEdge {
  std::int32_t a = 0;  ///< a < b, positions of neighboring supervoxels
  std::int32_t b = 0;
  bool connects = false;  ///< convex, or concave within the tolerance, and not rejected by a test
};

std::int32_t PositionOf(const std::vector<std::uint32_t>& labels, std::uint32_t label) {
  const auto at = std::ranges::lower_bound(labels, label);
  return at != labels.end() && *at == label ? static_cast<std::int32_t>(at - labels.begin()) : -1;
}

std::vector<SupervoxelEdge> FindEdges(const Supervoxels& found,
                                      const std::multimap<std::uint32_t, std::uint32_t>& adjacency,
                                      const std::vector<std::uint32_t>& labels,
                                      const LocalConvexityOptions& options) {
  Convexity convexity;
  convexity.setConcavityToleranceThreshold(kConcavityTolerance_deg);
  // The paper's sanity criterion leaves out connections at which supervoxels touch only in a point.
  // Without it six of ten pairs of touching boxes became one segment. Its extended convexity
  // (setKFactor) split convex boxes at their corners (scans of pcl_segmentation_test.cpp: 40 % of a
  // face lost).
  convexity.setSanityCheck(true);
  convexity.setKFactor(0);
  convexity.setSmoothnessCheck(true, static_cast<float>(options.voxel_m),
                               static_cast<float>(options.seed_m), kStepVoxels);
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

/// Joins every set of at most `max_small` members with its largest neighbor, smallest sets first.
void JoinSmall(const std::vector<SupervoxelEdge>& edges, std::uint32_t max_small,
               geometry::UnionFind& sets) {
  const auto n = static_cast<std::uint32_t>(sets.size());
  std::vector<std::uint32_t> size(n, 0);  // of the set with this root
  for (std::uint32_t i = 0; i < n; ++i) ++size[sets.Find(i)];
  std::vector<std::set<std::uint32_t>> neighbors(n);  // roots
  for (const auto& edge : edges) {
    const std::uint32_t a = sets.Find(edge.a), b = sets.Find(edge.b);
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

Eigen::Vector3d Mean(const PclCloud& points, const pcl::Indices& indices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto k : indices) {
    sum += points[static_cast<std::size_t>(k)].getVector3fMap().cast<double>();
  }
  return sum / static_cast<double>(indices.size());
}

}  // namespace

geometry::Points EstimateNormals(geometry::PointSpan points, const Eigen::Vector3d& origin,
                                 double radius_m) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  geometry::Points normals(points.size(), Eigen::Vector3d::Constant(kNaN));
  const FinitePoints finite(points, origin);
  if (finite.points->empty()) return normals;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(finite.points);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(radius_m);
  pcl::PointCloud<pcl::Normal> found;
  estimation.compute(found);
  for (std::size_t k = 0; k < found.size(); ++k) {
    normals[finite.source[k]] = found[k].getNormalVector3fMap().cast<double>().normalized();
  }
  return normals;
}

std::vector<geometry::Indices> EuclideanClusters(geometry::PointSpan points,
                                                 const Eigen::Vector3d& origin,
                                                 const EuclideanClusterOptions& options) {
  const FinitePoints finite(points, origin);
  if (finite.points->empty()) return {};
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(options.tolerance_m);
  extraction.setMinClusterSize(options.min_points);
  extraction.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  extraction.setInputCloud(finite.points);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  std::vector<geometry::Indices> source;
  for (const auto& cluster : clusters) source.push_back(ToSource(finite.source, cluster.indices));
  return source;
}

std::vector<std::int32_t> SegmentByLocalConvexity(geometry::PointSpan points,
                                                  const Eigen::Vector3d& origin,
                                                  const LocalConvexityOptions& options) {
  const FinitePoints finite(points, origin);
  if (options.camera_depth) {
    Demand(std::ranges::all_of(*finite.points, [](const auto& p) { return p.z > 0.0F; }),
           "SegmentByLocalConvexity: with camera_depth every point's z must exceed the origin's");
  }
  std::vector<std::int32_t> segment(points.size(), -1);
  if (finite.points->empty()) return segment;
  Clustering clustering(static_cast<float>(options.voxel_m), static_cast<float>(options.seed_m));
  clustering.setUseSingleCameraTransform(options.camera_depth);
  clustering.setColorImportance(0.0F);  // a cloud has no color
  clustering.setNormalImportance(kNormalImportance);
  clustering.setSpatialImportance(kSpatialImportance);
  clustering.setInputCloud(finite.points);
  Supervoxels found;
  clustering.extract(found);
  std::multimap<std::uint32_t, std::uint32_t> adjacency;
  clustering.getSupervoxelAdjacency(adjacency);
  // The library's labels of the supervoxels in ascending order. Their positions are our labels.
  const auto keys = std::views::keys(found);
  const std::vector<std::uint32_t> labels(keys.begin(), keys.end());
  const std::vector<SupervoxelEdge> edges = FindEdges(found, adjacency, labels, options);
  geometry::UnionFind sets(labels.size());
  for (const auto& edge : edges) {
    if (edge.connects) sets.Unite(edge.a, edge.b);
  }
  JoinSmall(edges, options.min_supervoxels, sets);
  std::vector<std::int32_t> segment_of;
  geometry::LabelBySize(sets, std::vector<bool>(labels.size(), true), segment_of);
  const auto labeled = clustering.getLabeledCloud();
  for (std::size_t k = 0; k < labeled->size(); ++k) {
    const std::int32_t at = PositionOf(labels, (*labeled)[k].label);
    if (at >= 0) segment[finite.source[k]] = segment_of[static_cast<std::size_t>(at)];
  }
  return segment;
}

std::optional<CylinderFit> FitCylinder(geometry::PointSpan points, const Eigen::Vector3d& origin,
                                       const geometry::Points& normals,
                                       const CylinderOptions& options) {
  Demand(normals.size() == points.size(), "there must be one normal for each point");
  const FinitePoints finite(points, origin);
  // The library's sorts and fits do not tolerate NaN.
  const PclCloud::Ptr oriented(new PclCloud);
  const pcl::PointCloud<pcl::Normal>::Ptr converted(new pcl::PointCloud<pcl::Normal>);
  geometry::Indices source;
  for (std::size_t k = 0; k < finite.source.size(); ++k) {
    const std::uint32_t i = finite.source[k];
    if (!normals[i].allFinite()) continue;
    const Eigen::Vector3f n = normals[i].cast<float>();
    oriented->push_back((*finite.points)[k]);
    converted->push_back({n.x(), n.y(), n.z(), 0.0F});
    source.push_back(i);
  }
  if (oriented->size() < 2) return std::nullopt;
  pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> sac;
  sac.setInputNormals(converted);
  sac.setNormalDistanceWeight(options.normal_weight);
  sac.setRadiusLimits(options.min_radius_m, options.max_radius_m);
  sac.setModelType(pcl::SACMODEL_CYLINDER);
  sac.setMethodType(pcl::SAC_RANSAC);
  sac.setMaxIterations(options.max_draws);
  sac.setDistanceThreshold(options.inlier_distance_m);
  sac.setProbability(kConfidence);
  sac.setOptimizeCoefficients(true);
  sac.setInputCloud(oriented);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients found;
  sac.segment(inliers, found);
  if (inliers.indices.empty()) return std::nullopt;
  // A point on the axis, the axis direction, the radius.
  const Eigen::VectorXd values =
      Eigen::Map<const Eigen::VectorXf>(found.values.data(),
                                        static_cast<Eigen::Index>(found.values.size()))
          .cast<double>();
  CylinderFit cylinder;
  cylinder.axis = values.segment<3>(3).normalized();
  const Eigen::Vector3d point = values.head<3>();
  const Eigen::Vector3d mean = Mean(*oriented, inliers.indices);
  cylinder.point = origin + point + cylinder.axis * cylinder.axis.dot(mean - point);
  cylinder.radius_m = values(6);
  cylinder.inliers = ToSource(source, inliers.indices);
  return cylinder;
}

}  // namespace rangegrasp::pcl_bridge
