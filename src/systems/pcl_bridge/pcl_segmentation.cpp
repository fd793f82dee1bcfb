#include "pcl_bridge/pcl_segmentation.h"

#include <pcl/ModelCoefficients.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <algorithm>
#include <map>
#include <memory>
#include <ranges>
#include <set>

#include "geometry/graph.h"
#include "pcl_bridge/internal/cloud_data.h"

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

struct Model {
  Eigen::VectorXd values;  ///< in the library's frame; empty without a model
  pcl::PointIndices inliers;
};

/// @param options  PlaneOptions or CylinderOptions.
template <typename Options>
Model Fit(pcl::SACSegmentation<pcl::PointXYZ>& sac, int model_type, const PclCloud::Ptr& points,
          const Options& options) {
  sac.setModelType(model_type);
  sac.setMethodType(pcl::SAC_RANSAC);
  sac.setMaxIterations(options.max_draws);
  sac.setDistanceThreshold(options.inlier_distance_m);
  sac.setProbability(options.confidence);
  sac.setOptimizeCoefficients(true);
  sac.setInputCloud(points);
  Model model;
  pcl::ModelCoefficients found;
  sac.segment(model.inliers, found);
  model.values = Eigen::Map<const Eigen::VectorXf>(found.values.data(),
                                                   static_cast<Eigen::Index>(found.values.size()))
                     .cast<double>();
  return model;
}

/// Converts the plane p . values(0..2) + values(3) = 0, with p = point - origin.
geometry::Plane ToPlane(const Eigen::VectorXd& values, const Eigen::Vector3d& origin) {
  const double length = values.head<3>().norm();
  geometry::Plane plane{values.head<3>() / length, values(3) / length};
  if (plane.offset_m < 0.0) plane = plane.Flipped();
  plane.offset_m -= plane.normal.dot(origin);
  return plane;
}

/// @param values  a point on the axis, the axis direction, the radius.
Cylinder ToCylinder(const Eigen::VectorXd& values, const Eigen::Vector3d& mean,
                    const Eigen::Vector3d& origin) {
  Cylinder cylinder;
  cylinder.axis = values.segment<3>(3).normalized();
  const Eigen::Vector3d point = values.head<3>();
  cylinder.point = origin + point + cylinder.axis * cylinder.axis.dot(mean - point);
  cylinder.radius_m = values(6);
  return cylinder;
}

Eigen::Vector3d Mean(const PclCloud& points, const pcl::Indices& indices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto k : indices) {
    sum += points[static_cast<std::size_t>(k)].getVector3fMap().cast<double>();
  }
  return sum / static_cast<double>(indices.size());
}

}  // namespace

std::vector<geometry::Indices> EuclideanClusters(const Cloud& cloud,
                                                 const EuclideanClusterOptions& options) {
  if (cloud.data().finite->empty()) return {};
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(options.tolerance_m);
  extraction.setMinClusterSize(options.min_points);
  extraction.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  extraction.setInputCloud(cloud.data().finite);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  std::vector<geometry::Indices> source;
  for (const auto& cluster : clusters) source.push_back(ToSource(cloud, cluster.indices));
  return source;
}

LocalConvexity SegmentByLocalConvexity(const Cloud& cloud, const LocalConvexityOptions& options) {
  if (options.camera_depth) {
    Demand(std::ranges::all_of(*cloud.data().finite, [](const auto& p) { return p.z > 0.0F; }),
           "SegmentByLocalConvexity: with camera_depth every point's z must exceed the origin's");
  }
  LocalConvexity result;
  result.segment.assign(cloud.size(), -1);
  result.supervoxel.assign(cloud.size(), -1);
  if (cloud.data().finite->empty()) return result;
  Clustering clustering(static_cast<float>(options.voxel_m), static_cast<float>(options.seed_m));
  clustering.setUseSingleCameraTransform(options.camera_depth);
  clustering.setColorImportance(0.0F);  // a cloud has no color
  clustering.setNormalImportance(kNormalImportance);
  clustering.setSpatialImportance(kSpatialImportance);
  clustering.setInputCloud(cloud.data().finite);
  Supervoxels found;
  clustering.extract(found);
  std::multimap<std::uint32_t, std::uint32_t> adjacency;
  clustering.getSupervoxelAdjacency(adjacency);
  // The library's labels of the supervoxels in ascending order. Their positions are our labels.
  const auto keys = std::views::keys(found);
  const std::vector<std::uint32_t> labels(keys.begin(), keys.end());
  result.edges = FindEdges(found, adjacency, labels, options);
  geometry::UnionFind sets(labels.size());
  for (const auto& edge : result.edges) {
    if (edge.connects) sets.Unite(edge.a, edge.b);
  }
  JoinSmall(result.edges, options.min_supervoxels, sets);
  result.segments = geometry::LabelBySize(sets, std::vector<bool>(labels.size(), true),
                                          result.supervoxel_segment);
  const auto labeled = clustering.getLabeledCloud();
  for (std::size_t k = 0; k < labeled->size(); ++k) {
    const std::int32_t at = PositionOf(labels, (*labeled)[k].label);
    if (at < 0) continue;
    const std::size_t i = cloud.data().source[k];
    result.supervoxel[i] = at;
    result.segment[i] = result.supervoxel_segment[at];
  }
  return result;
}

std::optional<geometry::PlaneFit> FitPlane(const Cloud& cloud, const PlaneOptions& options) {
  const auto& points = cloud.data().finite;
  if (points->size() < 3) return std::nullopt;
  pcl::SACSegmentation<pcl::PointXYZ> sac;
  const Model model = Fit(sac, pcl::SACMODEL_PLANE, points, options);
  if (model.values.size() == 0) return std::nullopt;
  return geometry::PlaneFit{ToPlane(model.values, cloud.origin()),
                            ToSource(cloud, model.inliers.indices)};
}

std::optional<CylinderFit> FitCylinder(const Cloud& cloud, const geometry::Points& normals,
                                       const CylinderOptions& options) {
  Demand(normals.size() == cloud.size(), "there must be one normal for each point of the cloud");
  // The library's sorts and fits do not tolerate NaN.
  const geometry::Indices with_normal =
      geometry::PositionsWhere(normals, [](const auto& n) { return n.allFinite(); });
  const Cloud oriented = cloud.Select(with_normal);
  const auto& points = oriented.data().finite;
  if (points->size() < 2) return std::nullopt;
  const pcl::PointCloud<pcl::Normal>::Ptr converted(new pcl::PointCloud<pcl::Normal>);
  for (const std::uint32_t i : oriented.data().source) {
    const Eigen::Vector3f n = normals[with_normal[i]].cast<float>();
    converted->push_back({n.x(), n.y(), n.z(), 0.0F});
  }
  pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> sac;
  sac.setInputNormals(converted);
  sac.setNormalDistanceWeight(options.normal_weight);
  sac.setRadiusLimits(options.min_radius_m, options.max_radius_m);
  const Model model = Fit(sac, pcl::SACMODEL_CYLINDER, points, options);
  if (model.inliers.indices.empty()) return std::nullopt;
  geometry::Indices inliers = ToSource(oriented, model.inliers.indices);
  for (std::uint32_t& i : inliers) i = with_normal[i];
  const Eigen::Vector3d mean = Mean(*points, model.inliers.indices);
  return CylinderFit{ToCylinder(model.values, mean, cloud.origin()), std::move(inliers)};
}

}  // namespace rangegrasp::pcl_bridge
