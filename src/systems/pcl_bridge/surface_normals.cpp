#include "pcl_bridge/surface_normals.h"

#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>

#include <limits>

#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {

Normals EstimateNormals(const Cloud& cloud, const NormalOptions& options) {
  Demand(options.radius_m > 0.0, "EstimateNormals: radius_m must be > 0");
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Normals normals{geometry::Points(cloud.size(), Eigen::Vector3d::Constant(kNaN)),
                  std::vector<double>(cloud.size(), kNaN)};
  const Cloud::Data& data = cloud.data();
  if (data.finite->empty()) return normals;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(data.finite);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(options.radius_m);
  PclNormals found;
  estimation.compute(found);
  for (std::size_t k = 0; k < found.size(); ++k) {
    normals.directions[data.source[k]] =
        found[k].getNormalVector3fMap().cast<double>().normalized();
    normals.curvature[data.source[k]] = static_cast<double>(found[k].curvature);
  }
  return normals;
}

}  // namespace rangegrasp::pcl_bridge
