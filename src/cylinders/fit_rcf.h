#pragma once

#include <optional>
#include <vector>

#include "core/rng.h"
#include "core/units.h"
#include "cylinders/circle_fit.h"
#include "cylinders/fit.h"

/// Random circle fitting of one cylinder's points (RCF): rim, circle, axis (sections 4.2.2 to
/// 4.2.4), without the search among other objects.
namespace rangegrasp::cylinders {

struct RcfOptions {
  double neighborhood_m = 0.005;           ///< > 0; section 4.2.2; table 4.4 takes 3 mm
  double curvature_rad = core::Deg(20.0);  ///< section 4.2.3
  RandomCircleOptions circle;              ///< its draws are the iterations of tables 4.3, 4.4
  double tolerance_m = 0.002;              ///< > 0; of rim and barrel (eq. 4.26)
};

/// What is computed before the first triple is drawn: the "ppt" of table 4.3.
struct RcfPreparation {
  geometry::Points normals;  ///< unit, towards the eye; one a point
  std::vector<bool> curved;  ///< whether a point is a strong curvature point (eq. 4.13)
  geometry::Indices rim;     ///< "top curvature points": curved, and facing up; ascending
};
/// O(n m) for neighborhoods of m points.
/// @throws std::invalid_argument if an option is out of range or a point is not finite.
RcfPreparation PrepareRcf(const FitInput& input, const RcfOptions& options);

/// The angle of eq. 4.13 [rad]: of the normal of point i to those of its neighbors. The equation's
/// sum of cosines is read as their mean: a sum of more than one cosine has no arc cosine.
double MeanNormalAngle(const geometry::Points& normals, std::size_t i,
                       const std::vector<std::uint32_t>& neighbors);

/// "Top curvature points": n_x > n_y and n_x > n_z in a frame whose x axis is `up` and whose z axis
/// points to the eye. Sizes are compared: read with signs, the wall's left outline would face up.
bool FacesUp(const Eigen::Vector3d& normal, const Eigen::Vector3d& up,
             const Eigen::Vector3d& to_eye);

/// The circle through the rim, the barrel (points within the tolerance of the cylinder that stands
/// on the circle, not curved), and the axis through p - n r of the barrel (algorithm 1). The radius
/// is the circle's.
/// @return nullopt if there is no rim, no circle or no barrel.
std::optional<BarrelFit> FitRcf(const FitInput& input, const RcfPreparation& prepared,
                                const RcfOptions& options, core::Rng& rng);

}  // namespace rangegrasp::cylinders
