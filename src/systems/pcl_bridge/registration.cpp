#include "pcl_bridge/registration.h"

#include <pcl/common/io.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "geometry/kd_tree.h"
#include "pcl_bridge/internal/pcl_cloud.h"

namespace rangegrasp::pcl_bridge {

using PclOriented = pcl::PointCloud<pcl::PointNormal>;

struct PlaneTarget::Data {
  Data(const geometry::Points& surface, PclOriented::Ptr with_normals)
      : points(surface), tree(points), oriented(std::move(with_normals)) {}

  geometry::Points points;
  geometry::KdTree tree;
  PclOriented::Ptr oriented;
};

namespace {

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

/// Searches go a little further than necessary, so that rounding leaves no pair out.
constexpr double kFurther = 1.001;

/// Finds the nearest point within a distance with the project's own tree. The library's tree
/// starts and ends a team of threads for each query, which takes as long as the query. The
/// registration asks for its points in the same order in each iteration: the search begins with
/// the previous answer.
class NearestPoint : public pcl::search::KdTree<pcl::PointNormal> {
 public:
  NearestPoint(const PlaneTarget::Data& target, std::size_t queries, double max_m)
      : target_(target), max_m_(max_m), before_(queries, 0) {}

  using pcl::search::KdTree<pcl::PointNormal>::nearestKSearch;
  /// The registration asks for one point, and leaves it out beyond max_m.
  int nearestKSearch(const pcl::PointNormal& point, int /*k*/, pcl::Indices& indices,
                     std::vector<float>& squared_distances) const override {
    thread_local std::vector<geometry::KdTree::Neighbor> nearest;
    const Eigen::Vector3d query = point.getVector3fMap().cast<double>();
    std::uint32_t& before = before_[next_];
    next_ = next_ + 1 == before_.size() ? 0 : next_ + 1;
    const double max_m = std::min(max_m_, kFurther * (target_.points[before] - query).norm());
    target_.tree.Nearest(query, 1, nearest, max_m);
    if (nearest.empty()) nearest.push_back({0, std::numeric_limits<double>::max()});
    before = nearest.front().index;
    indices.assign(1, static_cast<pcl::index_t>(before));
    squared_distances.assign(1, static_cast<float>(nearest.front().squared_distance));
    return 1;
  }

 private:
  const PlaneTarget::Data& target_;
  double max_m_;
  mutable std::vector<std::uint32_t> before_;
  mutable std::size_t next_ = 0;
};

}  // namespace

PlaneTarget::PlaneTarget(const geometry::PointCloud& surface) {
  Demand(surface.size() >= 3 && surface.normals.size() == surface.size(),
         "PlaneTarget: needs 3 points or more, and a normal for each");
  const PclOriented::Ptr oriented(new PclOriented);
  for (std::size_t i = 0; i < surface.size(); ++i) {
    Demand(surface.points[i].allFinite() && surface.normals[i].allFinite(),
           "PlaneTarget: points and normals must be finite");
    pcl::PointNormal p;
    p.getVector3fMap() = surface.points[i].cast<float>();
    p.getNormalVector3fMap() = surface.normals[i].cast<float>();
    oriented->push_back(p);
  }
  data_ = std::make_shared<Data>(surface.points, oriented);
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
  method.setInputTarget(target.data().oriented);
  method.setSearchMethodTarget(
      pcl::make_shared<NearestPoint>(target.data(), points.size(),
                                     kFurther * options.max_pair_distance_m),
      true);
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
