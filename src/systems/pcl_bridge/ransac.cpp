#include "pcl_bridge/ransac.h"

#include <pcl/ModelCoefficients.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {
namespace {

struct Model {
  Eigen::VectorXd values;  ///< in the library's frame; empty where there is none
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

template <typename Options>
void CheckRansac(const Options& options) {
  Demand(options.max_draws >= 1, "max_draws must be >= 1");
  Demand(options.inlier_distance_m > 0.0, "inlier_distance_m must be > 0");
  Demand(options.confidence > 0.0 && options.confidence < 1.0, "confidence must be in (0, 1)");
}

/// The plane p . values(0..2) + values(3) = 0, for p = point - origin.
geometry::Plane ToPlane(const Eigen::VectorXd& values, const Eigen::Vector3d& origin) {
  const double length = values.head<3>().norm();
  geometry::Plane plane{values.head<3>() / length, values(3) / length};
  if (plane.offset_m < 0.0) plane = {-plane.normal, -plane.offset_m};
  plane.offset_m -= plane.normal.dot(origin);
  return plane;
}

/// A point of the axis, its direction, the radius.
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

std::optional<geometry::PlaneFit> FitPlane(const Cloud& cloud, const PlaneOptions& options) {
  CheckRansac(options);
  const auto& points = cloud.data().finite;
  if (points->size() < 3) return std::nullopt;
  pcl::SACSegmentation<pcl::PointXYZ> sac;
  const Model model = Fit(sac, pcl::SACMODEL_PLANE, points, options);
  if (model.values.size() == 0) return std::nullopt;
  return geometry::PlaneFit{ToPlane(model.values, cloud.origin()),
                            ToSource(cloud, model.inliers.indices)};
}

std::optional<CylinderFit> FitCylinder(const Cloud& cloud, const Normals& normals,
                                       const CylinderOptions& options) {
  CheckRansac(options);
  Demand(options.normal_weight >= 0.0 && options.normal_weight <= 1.0,
         "FitCylinder: normal_weight must be in [0, 1]");
  Demand(options.min_radius_m >= 0.0 && options.max_radius_m > options.min_radius_m,
         "FitCylinder: radii must hold 0 <= min_radius_m < max_radius_m");
  const OrientedCloud oriented = WithNormals(cloud, normals);
  const auto& points = oriented.cloud.data().finite;
  if (points->size() < 2) return std::nullopt;
  pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> sac;
  sac.setInputNormals(oriented.normals);
  sac.setNormalDistanceWeight(options.normal_weight);
  sac.setRadiusLimits(options.min_radius_m, options.max_radius_m);
  const Model model = Fit(sac, pcl::SACMODEL_CYLINDER, points, options);
  if (model.inliers.indices.empty()) return std::nullopt;
  const Eigen::Vector3d mean = Mean(*points, model.inliers.indices);
  return CylinderFit{ToCylinder(model.values, mean, cloud.origin()),
                     ToSource(oriented.cloud, model.inliers.indices)};
}

}  // namespace rangegrasp::pcl_bridge
