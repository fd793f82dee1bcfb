#include "pcl_bridge/clusters.h"

#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/region_growing.h>

#include <limits>

#include "base/units.h"
#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {
namespace {

using Tree = pcl::search::KdTree<pcl::PointXYZ>;

std::vector<pcl::PointIndices> Grow(const OrientedCloud& oriented,
                                    const RegionGrowingOptions& options) {
  pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
  growing.setMinClusterSize(options.min_points);
  growing.setMaxClusterSize(std::numeric_limits<int>::max());
  growing.setSearchMethod(pcl::make_shared<Tree>());
  growing.setNumberOfNeighbours(static_cast<unsigned>(options.neighbors));
  growing.setSmoothnessThreshold(static_cast<float>(options.max_angle_rad));
  growing.setCurvatureThreshold(static_cast<float>(options.max_curvature));
  growing.setInputCloud(oriented.cloud.data().finite);
  growing.setInputNormals(oriented.normals);
  std::vector<pcl::PointIndices> regions;
  growing.extract(regions);
  return regions;
}

}  // namespace

std::vector<geometry::Indices> EuclideanClusters(const Cloud& cloud,
                                                 const EuclideanClusterOptions& options) {
  Demand(options.tolerance_m > 0.0, "EuclideanClusters: tolerance_m must be > 0");
  Demand(options.min_points >= 1, "EuclideanClusters: min_points must be >= 1");
  if (cloud.data().finite->empty()) return {};
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(options.tolerance_m);
  extraction.setMinClusterSize(options.min_points);
  extraction.setSearchMethod(pcl::make_shared<Tree>());
  extraction.setInputCloud(cloud.data().finite);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  return ToSource(cloud, clusters);
}

std::vector<geometry::Indices> GrowRegions(const Cloud& cloud, const Normals& normals,
                                           const RegionGrowingOptions& options) {
  Demand(options.neighbors >= 1, "GrowRegions: neighbors must be >= 1");
  Demand(options.max_angle_rad > 0.0 && options.max_angle_rad <= base::kPi / 2.0,
         "GrowRegions: max_angle_rad must be in (0, pi / 2]");
  Demand(options.max_curvature > 0.0, "GrowRegions: max_curvature must be > 0");
  Demand(options.min_points >= 1, "GrowRegions: min_points must be >= 1");
  const OrientedCloud oriented = WithNormals(cloud, normals);
  if (oriented.normals->empty()) return {};
  return ToSource(oriented.cloud, Grow(oriented, options));
}

}  // namespace rangegrasp::pcl_bridge
