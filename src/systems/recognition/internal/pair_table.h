#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "base/frames.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::recognition::internal {

/// Point pair features (Drost et al. 2010, "Model globally, match locally"): pairs of a model's
/// points with normals by their distance and three angles, and what pairs of a scene vote for. Our
/// own voting, for the library's (PPFRegistration) keeps one pose alone of all that are voted for.
class PairTable {
 public:
  /// @param surface_B  thinned to about spacing_m
  PairTable(const geometry::PointCloud& surface_B, double spacing_m);

  struct Voted {
    base::Pose X_CB;
    double votes = 0.0;
  };
  /// The poses that pairs of `reference` with the scene's other points vote for most: at most
  /// `peaks` of them.
  void Vote(const geometry::PointCloud& scene_C, std::uint32_t reference, std::size_t peaks,
            std::vector<Voted>& voted) const;

  double diameter_m() const { return diameter_m_; }
  double spacing_m() const { return spacing_m_; }

 private:
  struct Pair {
    std::uint16_t reference;
    float angle;  // of the second point about the reference's normal
  };
  struct Bucket {
    std::vector<Pair> pairs;  ///< as many as vote
    float all = 0.0f;         ///< that have this feature
  };
  static void Thin(Bucket& bucket);
  std::uint32_t Key(const Eigen::Vector3d& p, const Eigen::Vector3d& n, const Eigen::Vector3d& q,
                    const Eigen::Vector3d& m) const;

  double spacing_m_;
  double diameter_m_ = 0.0;
  geometry::PointCloud points_B_;
  std::unordered_map<std::uint32_t, Bucket> pairs_;
};

}  // namespace rangegrasp::recognition::internal
