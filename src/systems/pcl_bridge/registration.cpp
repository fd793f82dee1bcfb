#include "pcl_bridge/registration.h"

#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "geometry/kd_tree.h"
#include "pcl_bridge/internal/cloud_data.h"

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

/// A surface's points with their search tree.
struct Surface {
  explicit Surface(geometry::Points surface) : points(std::move(surface)), tree(points) {}

  geometry::Points points;
  geometry::KdTree tree;
};

/// Finds the nearest point with the project's own tree, since the library's starts and ends a team
/// of threads for each query, which takes as long as the query. No point further away than the
/// limit is looked for: a query without one answers with an infinite distance.
class NearestPoint : public pcl::search::KdTree<pcl::PointNormal> {
 public:
  NearestPoint(std::shared_ptr<const Surface> surface, double limit_m)
      : surface_(std::move(surface)), limit_m_(limit_m) {}

  using pcl::search::KdTree<pcl::PointNormal>::nearestKSearch;
  int nearestKSearch(const pcl::PointNormal& point, int k, pcl::Indices& indices,
                     std::vector<float>& squared_distances) const override {
    thread_local std::vector<geometry::KdTree::Neighbor> nearest;
    surface_->tree.Nearest(point.getVector3fMap().cast<double>(), static_cast<std::size_t>(k),
                           nearest, limit_m_);
    indices.assign(static_cast<std::size_t>(k), 0);
    squared_distances.assign(static_cast<std::size_t>(k), std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      indices[i] = static_cast<pcl::index_t>(nearest[i].index);
      squared_distances[i] = static_cast<float>(nearest[i].squared_distance);
    }
    return k;
  }

 private:
  std::shared_ptr<const Surface> surface_;
  double limit_m_;
};

}  // namespace

struct PlaneTarget::Data {
  PclOriented::Ptr points{new PclOriented};
  std::shared_ptr<const Surface> surface;
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
  data->surface = std::make_shared<Surface>(surface.points);
  data_ = std::move(data);
}

Eigen::Isometry3d RegisterPointToPlane(const Cloud& source, const PlaneTarget& target,
                                       const Eigen::Isometry3d& X_TS,
                                       const RegistrationOptions& options) {
  Demand(options.max_pair_distance_m > 0.0, "max_pair_distance_m must be > 0");
  Demand(options.max_iterations >= 1, "max_iterations must be >= 1");
  Demand(options.min_step_m > 0.0 && options.min_step_rad > 0.0, "min steps must be > 0");
  const PclCloud& points = *source.data().finite;
  Demand(points.size() >= 3, "RegisterPointToPlane: the source needs 3 points or more");
  const PclOriented::Ptr oriented(new PclOriented);
  for (const pcl::PointXYZ& point : points) {
    pcl::PointNormal p;
    p.getVector3fMap() = point.getVector3fMap();
    oriented->push_back(p);
  }
  PointToPlane method;
  method.setInputSource(oriented);
  method.setInputTarget(target.data().points);
  // The library compares squared distances as floats.
  constexpr double kSlack = 1.0 + 1e-6;
  method.setSearchMethodTarget(
      pcl::make_shared<NearestPoint>(target.data().surface, kSlack * options.max_pair_distance_m),
      true);
  method.setTransformationEstimation(pcl::make_shared<Estimation>());
  method.setTransformationEpsilon(options.min_step_m * options.min_step_m);
  method.setTransformationRotationEpsilon(std::cos(options.min_step_rad));
  method.setMaxCorrespondenceDistance(options.max_pair_distance_m);
  method.setMaximumIterations(options.max_iterations);
  // The library's source points are relative to their origin.
  const Eigen::Translation3d to_source(source.origin());
  try {
    PclOriented aligned;
    method.align(aligned, (X_TS * to_source).matrix());
  } catch (const Undetermined&) {
    return X_TS;
  }
  Eigen::Isometry3d found =
      Eigen::Isometry3d(method.getFinalTransformation()) * to_source.inverse();
  found.linear() = Eigen::Quaterniond(found.linear()).normalized().toRotationMatrix();
  return found;
}

}  // namespace rangegrasp::pcl_bridge
