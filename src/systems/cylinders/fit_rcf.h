#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/circle_fit.h"
#include "cylinders/fit.h"

/// Random circle fitting of one cylinder's points (RCF): rim, circle, axis (sections 4.2.2 to
/// 4.2.4), without the search among other objects.
namespace rangegrasp::cylinders {

/// Which curvature points are of the rim of the upper end.
enum class RimGate {
  kSigned,   ///< n_x > n_y and n_x > n_z, as printed: the wall's outline on one side passes, too
  kSizes,    ///< n_x > |n_y| and n_x > |n_z|: a band of the end inside the rim passes, too
  kHalfway,  ///< the normal is about halfway between the end's and the wall's
};
constexpr std::array<std::string_view, 3> WordsOf(RimGate) {
  return {"signed", "sizes", "halfway"};
}

struct RcfOptions {
  double neighborhood_m = 0.005;           ///< > 0; section 4.2.2; table 4.4 takes 3 mm
  double curvature_rad = base::Deg(20.0);  ///< section 4.2.3
  /// A normal that is estimated across the rim lies between the end's and the wall's, halfway where
  /// the point is on the rim itself: the circle is then that of the rim and not that of a band
  /// within it.
  RimGate gate = RimGate::kHalfway;
  /// Half of kHalfway's range about 45 deg. Smaller: nearer to the rim, and fewer points.
  double halfway_rad = base::Deg(20.0);
  /// Its draws are the iterations of tables 4.3 and 4.4. A sphere passes through a rim wherever on
  /// the axis its centre is, so that the printed distance leaves the radius open (kSphere).
  RandomCircleOptions circle{100, CircleDistance::kCurve};
  double tolerance_m = 0.002;  ///< > 0; of the barrel (section 4.2.4)
  /// Times that the barrel is gathered and its axis fitted: 1 as printed, along the circle's
  /// normal, which a rim of r 10 mm gives to a few degrees: 2 mm at 30 mm from the rim.
  int barrel_rounds = 8;
  /// Whether the radius is that of CircleOnAxis; false: of the best triple, as printed, which three
  /// points of a rim a millimetre wide decide.
  bool circle_again = true;
};

/// All of it as the text prints it.
RcfOptions RcfAsPrinted();

/// What is computed before the first triple is drawn: the "ppt" of table 4.3. Serves any gate.
struct RcfPreparation {
  geometry::Points normals;  ///< unit, towards the eye; one a point
  std::vector<bool> curved;  ///< whether a point is a strong curvature point (eq. 4.13)
};
/// O(n m) for neighborhoods of m points.
/// @throws std::invalid_argument if an option is out of range or a point is not finite.
RcfPreparation PrepareRcf(const FitInput& input, const RcfOptions& options);

/// Whether a normal is that of a "top curvature point", in a frame whose x axis is `up` and whose
/// z axis points to the eye.
bool PassesGate(const Eigen::Vector3d& normal, const Eigen::Vector3d& up,
                const Eigen::Vector3d& to_eye, const RcfOptions& options);

/// "Top curvature points": curved, and through the gate. Ascending.
geometry::Indices RimOf(const FitInput& input, const RcfPreparation& prepared,
                        const RcfOptions& options);

/// The circle square to the axis with the least sum of distances of the rim (eq. 4.24, seen along
/// the axis), by reweighted least squares from `start`. The text calculates "the circle centre c_m
/// again" on the axis; here the radius, too, comes from all of the rim.
/// @return nullopt where it does not come to a circle.
std::optional<Circle> CircleOnAxis(geometry::PointSpan rim, const Eigen::Vector3d& axis,
                                   const Circle& start);

/// The circle through the rim, the wall (points within the tolerance of the cylinder that stands on
/// the circle, not curved), the axis through p - n r of the wall (algorithm 1), and the circle
/// again.
/// @return nullopt if there is no rim, no circle or no wall.
std::optional<BarrelFit> FitRcf(const FitInput& input, const RcfPreparation& prepared,
                                const RcfOptions& options, base::Rng& rng);

}  // namespace rangegrasp::cylinders
