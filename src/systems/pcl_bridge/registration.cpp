#include "pcl_bridge/registration.h"

#include <pcl/common/io.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <utility>
#include <vector>

#include "geometry/kd_tree.h"
#include "pcl_bridge/internal/pcl_cloud.h"

namespace rangegrasp::pcl_bridge {
namespace {

using PclOriented = pcl::PointCloud<pcl::PointNormal>;

/// Thrown if the pairs do not determine the pose: the library would continue with NaN and end the
/// process by an assertion.
struct Undetermined {};
using LeastSquares =
    pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal, pcl::PointNormal,
                                                               double>;
struct Estimation : LeastSquares {
  using LeastSquares::estimateRigidTransformation;
  void estimateRigidTransformation(const PclOriented& source, const PclOriented& target,
                                   const pcl::Correspondences& pairs, Matrix4& X) const override {
    LeastSquares::estimateRigidTransformation(source, target, pairs, X);
    if (!X.allFinite()) throw Undetermined();
  }
};

using PointToPlane =
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal, double>;

/// Finds the nearest point with the project's own tree. The library's tree starts and ends a team
/// of threads for each query, which takes as long as the query.
class NearestPoint : public pcl::search::KdTree<pcl::PointNormal> {
 public:
  explicit NearestPoint(geometry::Points points) : points_(std::move(points)), tree_(points_) {}

  using pcl::search::KdTree<pcl::PointNormal>::nearestKSearch;
  int nearestKSearch(const pcl::PointNormal& point, int k, pcl::Indices& indices,
                     std::vector<float>& squared_distances) const override {
    thread_local std::vector<geometry::KdTree::Neighbor> nearest;
    tree_.Nearest(point.getVector3fMap().cast<double>(), static_cast<std::size_t>(k), nearest);
    indices.clear();
    squared_distances.clear();
    for (const auto& neighbor : nearest) {
      indices.push_back(static_cast<pcl::index_t>(neighbor.index));
      squared_distances.push_back(static_cast<float>(neighbor.squared_distance));
    }
    return static_cast<int>(nearest.size());
  }

 private:
  geometry::Points points_;
  geometry::KdTree tree_;
};

}  // namespace

struct PlaneTarget::Data {
  PclOriented::Ptr points{new PclOriented};
  pcl::search::KdTree<pcl::PointNormal>::Ptr tree;
};

PlaneTarget::PlaneTarget(const geometry::PointCloud& surface) {
  Demand(surface.size() >= 3 && surface.normals.size() == surface.size(),
         "PlaneTarget: needs 3 points or more, and a normal for each");
  auto data = std::make_shared<Data>();
  for (std::size_t i = 0; i < surface.size(); ++i) {
    Demand(surface.points[i].allFinite() && surface.normals[i].allFinite(),
           "PlaneTarget: points and normals must be finite");
    pcl::PointNormal p;
    p.getVector3fMap() = surface.points[i].cast<float>();
    p.getNormalVector3fMap() = surface.normals[i].cast<float>();
    data->points->push_back(p);
  }
  data->tree = pcl::make_shared<NearestPoint>(surface.points);
  data_ = std::move(data);
}

Eigen::Isometry3d RegisterPointToPlane(geometry::PointSpan source, const PlaneTarget& target,
                                       const Eigen::Isometry3d& X_TS,
                                       const RegistrationOptions& options) {
  const FinitePoints finite(source, Eigen::Vector3d::Zero());
  const PclCloud& points = *finite.points;
  Demand(points.size() >= 3, "RegisterPointToPlane: the source needs 3 points or more");
  const PclOriented::Ptr oriented(new PclOriented);
  pcl::copyPointCloud(points, *oriented);
  PointToPlane method;
  method.setInputSource(oriented);
  method.setInputTarget(target.data().points);
  method.setSearchMethodTarget(target.data().tree, true);
  method.setTransformationEstimation(pcl::make_shared<Estimation>());
  method.setTransformationEpsilon(options.min_step_m * options.min_step_m);
  method.setTransformationRotationEpsilon(std::cos(options.min_step_rad));
  method.setMaxCorrespondenceDistance(options.max_pair_distance_m);
  method.setMaximumIterations(options.max_iterations);
  try {
    PclOriented aligned;
    method.align(aligned, X_TS.matrix());
  } catch (const Undetermined&) {
    return X_TS;
  }
  Eigen::Isometry3d found(method.getFinalTransformation());
  found.linear() = Eigen::Quaterniond(found.linear()).normalized().toRotationMatrix();
  return found;
}

}  // namespace rangegrasp::pcl_bridge
