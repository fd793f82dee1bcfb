#include "pcl_pipeline.h"

#include <pcl/features/normal_3d.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "core/stopwatch.h"

namespace rangegrasp::bench {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Tree = pcl::search::KdTree<pcl::PointXYZ>;

Cloud::Ptr ToPcl(geometry::PointSpan points) {
  auto cloud = Cloud::Ptr(new Cloud);
  cloud->reserve(points.size());
  for (const auto& p : points) {
    const Eigen::Vector3f f = p.cast<float>();
    cloud->push_back({f.x(), f.y(), f.z()});
  }
  return cloud;
}

pcl::ModelCoefficients FitPlane(const Cloud::ConstPtr& cloud) {
  pcl::SACSegmentation<pcl::PointXYZ> plane;
  plane.setModelType(pcl::SACMODEL_PLANE);
  plane.setMethodType(pcl::SAC_RANSAC);
  plane.setMaxIterations(100);
  plane.setDistanceThreshold(0.002);
  plane.setOptimizeCoefficients(true);
  plane.setInputCloud(cloud);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients coefficients;
  plane.segment(inliers, coefficients);
  return coefficients;
}

Cloud::Ptr Above(const Cloud& cloud, const pcl::ModelCoefficients& plane) {
  Eigen::Vector4f p(plane.values[0], plane.values[1], plane.values[2], plane.values[3]);
  if (p.z() < 0.0F) p = -p;
  auto above = Cloud::Ptr(new Cloud);
  for (const auto& point : cloud) {
    if (p.head<3>().dot(point.getVector3fMap()) + p.w() > 0.004F) above->push_back(point);
  }
  return above;
}

Cloud::Ptr Filter(const Cloud::ConstPtr& cloud) {
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setMeanK(50);
  filter.setStddevMulThresh(1.0);
  filter.setInputCloud(cloud);
  auto kept = Cloud::Ptr(new Cloud);
  filter.filter(*kept);
  return kept;
}

void EstimateNormals(const Cloud::ConstPtr& cloud) {
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(Tree::Ptr(new Tree));
  estimation.setRadiusSearch(0.005);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
}

std::size_t CountClusters(const Cloud::ConstPtr& cloud) {
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(0.005);
  extraction.setMinClusterSize(40);
  extraction.setSearchMethod(Tree::Ptr(new Tree));
  extraction.setInputCloud(cloud);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  return clusters.size();
}

}  // namespace

PclSeconds RunPcl(geometry::PointSpan points, bool whole_cloud) {
  const auto all = ToPcl(points);
  PclSeconds seconds;
  core::Stopwatch watch;
  const auto plane = FitPlane(all);
  const auto cloud = whole_cloud ? all : Above(*all, plane);
  seconds.plane = watch.Restart();
  const auto kept = Filter(cloud);
  seconds.filter = watch.Restart();
  EstimateNormals(kept);
  seconds.normals = watch.Restart();
  seconds.found_clusters = CountClusters(kept);
  seconds.clusters = watch.Restart();
  seconds.points = cloud->size();
  return seconds;
}

}  // namespace rangegrasp::bench
