#include "pcl_pipeline.h"

#include <stdexcept>

#include "base/stopwatch.h"
#include "pcl_bridge/cloud.h"
#include "pcl_bridge/pcl_segmentation.h"

namespace rangegrasp::bench {
namespace {

/// Equals perception's PreprocessOptions::table_clearance_m, so that both use the same points.
constexpr double kTableClearance_m = 0.004;

geometry::Indices Above(geometry::PointSpan points, const geometry::Plane& plane) {
  geometry::Indices above;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (plane.Distance(points[i]) > kTableClearance_m) above.push_back(i);
  }
  return above;
}

}  // namespace

PclSeconds RunPcl(geometry::PointSpan points, const Eigen::Vector3d& sensor_origin,
                  bool whole_cloud) {
  const pcl_bridge::Cloud all(points, sensor_origin);
  PclSeconds seconds;
  base::Stopwatch watch;
  const auto fit = pcl_bridge::FitPlane(all);
  if (!fit) throw std::runtime_error("the cloud has no plane");
  const auto cloud = whole_cloud ? all : all.Select(Above(points, fit->plane));
  seconds.plane = watch.Restart();
  const auto kept = cloud.Select(pcl_bridge::StatisticalFilter(cloud));
  seconds.filter = watch.Restart();
  pcl_bridge::EstimateNormals(kept);
  seconds.normals = watch.Restart();
  seconds.found_clusters = pcl_bridge::EuclideanClusters(kept).size();
  seconds.clusters = watch.Restart();
  seconds.points = cloud.size();
  return seconds;
}

}  // namespace rangegrasp::bench
