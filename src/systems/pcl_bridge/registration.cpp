#include "pcl_bridge/registration.h"

#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "geometry/kd_tree.h"
#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {
namespace {

using PclOriented = pcl::PointCloud<pcl::PointNormal>;

/// The library says that it has converged when its iterations are used up.
template <typename Base>
struct Counting : Base {
  bool ConvergedEarly() const {
    return this->converged_ && this->nr_iterations_ < this->max_iterations_;
  }
};
/// The pairs leave the pose open: the library would go on with NaN, and end the process in an
/// assertion.
struct Undetermined {};
struct Estimation
    : pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal, pcl::PointNormal,
                                                                 double> {
  using pcl::registration::TransformationEstimationPointToPlaneLLS<
      pcl::PointNormal, pcl::PointNormal, double>::estimateRigidTransformation;
  void estimateRigidTransformation(const PclOriented& source, const PclOriented& target,
                                   const pcl::Correspondences& pairs, Matrix4& X) const override {
    TransformationEstimationPointToPlaneLLS::estimateRigidTransformation(source, target, pairs, X);
    if (!X.allFinite()) throw Undetermined();
  }
};

using PointToPlane =
    Counting<pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal, double>>;
using Generalized =
    Counting<pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double>>;

void CheckRegistration(const RegistrationOptions& options) {
  Demand(options.max_pair_distance_m > 0.0, "max_pair_distance_m must be > 0");
  Demand(options.max_iterations >= 1, "max_iterations must be >= 1");
  Demand(options.min_step_m > 0.0 && options.min_step_rad > 0.0, "min steps must be > 0");
}

PclOriented::Ptr ToOriented(const PclCloud& points, const PclNormals* normals) {
  const PclOriented::Ptr oriented(new PclOriented);
  oriented->reserve(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    pcl::PointNormal p;
    p.getVector3fMap() = points[k].getVector3fMap();
    if (normals != nullptr) p.getNormalVector3fMap() = (*normals)[k].getNormalVector3fMap();
    oriented->push_back(p);
  }
  return oriented;
}

/// Aligns what the library holds relative to each cloud's origin, and takes the result back.
template <typename Method, typename Points>
Registration Align(Method& method, const Cloud& source, const Eigen::Vector3d& target_origin,
                   const Eigen::Isometry3d& X_TS, const RegistrationOptions& options) {
  const Eigen::Translation3d to_target(target_origin);
  const Eigen::Translation3d to_source(source.origin());
  method.setMaxCorrespondenceDistance(options.max_pair_distance_m);
  method.setMaximumIterations(options.max_iterations);
  Points aligned;
  Registration result;
  try {
    method.align(aligned, (to_target.inverse() * X_TS * to_source).matrix());
  } catch (const Undetermined&) {
    return {X_TS, std::numeric_limits<double>::infinity(), false};
  }
  result.X_TS =
      to_target * Eigen::Isometry3d(method.getFinalTransformation()) * to_source.inverse();
  result.X_TS.linear() = Eigen::Quaterniond(result.X_TS.linear()).normalized().toRotationMatrix();
  const double score =
      method.getFitnessScore(options.max_pair_distance_m * options.max_pair_distance_m);
  result.rms_m = score < std::numeric_limits<double>::max()
                     ? std::sqrt(score)
                     : std::numeric_limits<double>::infinity();
  result.converged = method.ConvergedEarly();
  return result;
}

void SetSteps(const RegistrationOptions& options, PointToPlane& method) {
  method.setTransformationEstimation(pcl::make_shared<Estimation>());
  method.setTransformationEpsilon(options.min_step_m * options.min_step_m);
  method.setTransformationRotationEpsilon(std::cos(options.min_step_rad));
}

}  // namespace

namespace {

/// Finds the one nearest point with the project's own tree. The library's opens and closes a team
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

Registration RegisterPointToPlane(const Cloud& source, const PlaneTarget& target,
                                  const Eigen::Isometry3d& X_TS,
                                  const RegistrationOptions& options) {
  CheckRegistration(options);
  Demand(source.data().finite->size() >= 3,
         "RegisterPointToPlane: the source needs 3 points or more");
  PointToPlane method;
  method.setInputSource(ToOriented(*source.data().finite, nullptr));
  method.setInputTarget(target.data().points);
  method.setSearchMethodTarget(target.data().tree, true);
  SetSteps(options, method);
  return Align<PointToPlane, PclOriented>(method, source, Eigen::Vector3d::Zero(), X_TS, options);
}

Registration RegisterPointToPlane(const Cloud& source, const Cloud& target,
                                  const Eigen::Isometry3d& X_TS,
                                  const PointToPlaneOptions& options) {
  CheckRegistration(options);
  const OrientedCloud oriented =
      WithNormals(target, EstimateNormals(target, {.radius_m = options.normal_radius_m}));
  Demand(source.data().finite->size() >= 3 && oriented.normals->size() >= 3,
         "RegisterPointToPlane: source and target need 3 points with normals or more");
  PointToPlane method;
  method.setInputSource(ToOriented(*source.data().finite, nullptr));
  method.setInputTarget(ToOriented(*oriented.cloud.data().finite, oriented.normals.get()));
  SetSteps(options, method);
  return Align<PointToPlane, PclOriented>(method, source, target.origin(), X_TS, options);
}

Registration RegisterGeneralized(const Cloud& source, const Cloud& target,
                                 const Eigen::Isometry3d& X_TS, const GeneralizedOptions& options) {
  CheckRegistration(options);
  Demand(options.neighbors >= 4, "RegisterGeneralized: neighbors must be >= 4");
  const auto enough = static_cast<std::size_t>(options.neighbors);
  Demand(source.data().finite->size() >= enough && target.data().finite->size() >= enough,
         "RegisterGeneralized: source and target need as many points as neighbors or more");
  Generalized method;
  method.setInputSource(source.data().finite);
  method.setInputTarget(target.data().finite);
  method.setCorrespondenceRandomness(options.neighbors);
  method.setTransformationEpsilon(options.min_step_m);
  method.setRotationEpsilon(options.min_step_rad);
  return Align<Generalized, PclCloud>(method, source, target.origin(), X_TS, options);
}

}  // namespace rangegrasp::pcl_bridge
