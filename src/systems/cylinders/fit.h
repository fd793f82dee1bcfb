#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/cylinder.h"
#include "cylinders/rims.h"
#include "geometry/point_cloud.h"

/// Fits of one cylinder to the points of its seen side, compared by tables 4.3 and 4.4.

namespace rangegrasp::cylinders {

/// The barrel of a cylinder, unbounded along its axis.
struct Barrel {
  Line axis;
  double radius_m = 0.0;

  /// Distance of p from the barrel [m], below 0 inside: the euclidean distance of section 2.5.1 to
  /// the wall of eq. 2.14, |(I - d d^T)(p - c)| - r.
  double Distance(const Eigen::Vector3d& p) const { return axis.Distance(p) - radius_m; }
};

/// What every fit is given: points of one object, as one sensor sees them.
struct FitInput {
  geometry::PointSpan points;                     ///< [m], finite
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< where the sensor stood
  Eigen::Vector3d up = Eigen::Vector3d::UnitX();  ///< unit; out of the table
};

/// Angle between two axes, whatever their signs [rad], 0 to pi / 2.
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Noise of a range sensor's points: along the ray and square to it [m], standard deviations.
struct RayNoise {
  double along_m = 0.0;
  double across_m = 0.0;
};

/// How a ray meets a barrel, by the ray alone, so that the noise of the point on it plays no part:
/// of the ray's unit vector the part along the surface's normal there, and that along the surface
/// and square to the axis.
struct Incidence {
  double radial = 1.0;      ///< 0 to 1; 0 at the outline and beyond
  double tangential = 0.0;  ///< 0 to 1
};
Incidence IncidenceOf(const Barrel& barrel, const Eigen::Vector3d& eye, const Eigen::Vector3d& p);

/// What noise does to a point's distance from the barrel that it lies on, to second order: with s_n
/// and s_t the noise along the normal and along the tangent square to the axis,
///   mean = s_t^2 / (2 r)   (a step along the tangent leads out of a circle),
///   variance = s_n^2 + s_t^4 / (2 r^2).
struct DistanceNoise {
  double mean_m = 0.0;
  double variance_m2 = 0.0;
};
DistanceNoise DistanceNoiseOf(const RayNoise& noise, const Incidence& incidence, double radius_m);

// Least-squares fitting of a cylinder (LSF), the method that the dissertation compares with
/// (sections 2.5.1 and 4.4).

/// A point of the axis c [m], its direction d (any length), the radius r [m]. Seven numbers for
/// five freedoms, as published: Levenberg-Marquardt's damping holds those that change nothing.
using BarrelParameters = Eigen::Matrix<double, 7, 1>;

/// The residual of a point, |(I - d d^T / d^T d)(p - c)| - r [m], and its derivatives by the
/// parameters.
double BarrelResidual(const BarrelParameters& x, const Eigen::Vector3d& p,
                      BarrelParameters* gradient = nullptr);

/// The barrel with the least sum of squared distances of all points, the seen end's too, by
/// Levenberg-Marquardt (MINPACK's, in Eigen) from the start as published: the mean (of one side it
/// lies near the wall), the direction of the largest variance (PCA), the mean distance from that
/// line. O(iterations n).
/// @return nullopt for fewer than seven points, or where the start or the result is no cylinder.
/// @param iterations  at most, >= 1; the dissertation's 100 (section 4.4)
/// @throws std::invalid_argument if iterations < 1.
std::optional<Barrel> FitLeastSquares(geometry::PointSpan points, int iterations = 100);

// Random circle fitting of one cylinder's points (RCF): rim, circle, axis (sections 4.2.2 to
/// 4.2.4), without the search among other objects.

/// Which curvature points are of the rim of the upper end.
enum class RimGate {
  kSigned,   ///< n_x > n_y and n_x > n_z, as printed: the wall's outline on one side passes, too
  kHalfway,  ///< the normal is about halfway between the end's and the wall's
};

struct RcfOptions {
  double neighborhood_m = 0.005;           ///< > 0; section 4.2.2; table 4.4 takes 3 mm
  double curvature_rad = base::Deg(20.0);  ///< section 4.2.3
  /// A normal that is estimated across the rim is halfway where the point is on the rim itself: the
  /// circle is then that of the rim and not that of a band within it.
  RimGate gate = RimGate::kHalfway;
  double halfway_rad = base::Deg(20.0);  ///< half of kHalfway's range about 45 deg
  int draws = 100;                       ///< >= 1; the iterations of tables 4.3 and 4.4
  double tolerance_m = 0.002;            ///< > 0; of the barrel (section 4.2.4)
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

/// Whether a normal, in the frame of SensorAxes, is that of a "top curvature point".
bool PassesGate(const Eigen::Vector3d& n_S, const RcfOptions& options);

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
std::optional<Barrel> FitRcf(const FitInput& input, const RcfPreparation& prepared,
                             const RcfOptions& options, base::Rng& rng);

// A barrel refined by orthogonal distances, each weighed by what a range sensor's noise makes of
/// it. An addition to the dissertation.

struct RefineOptions {
  /// Distances are weighed by their variance at their incidence: the outline, where noise runs
  /// along the surface, says most of the radius. False: all alike.
  bool weigh_incidence = true;
  /// Tukey's biweight: distances beyond so many standard deviations do not count. 4.685 keeps 95 %
  /// of least squares' efficiency where the noise is normal (Huber 1981).
  double cut_sigmas = 4.685;
  /// Points nearer to a seen end than this many noises along the ray are left out.
  double end_margin_sigmas = 4.0;
  /// An end is seen where this share of the points lies within the barrel by more than
  /// inner_share of its radius.
  double end_share = 0.01;
  double inner_share = 0.25;
  int rounds = 60;       ///< >= 1; weights, then a Gauss-Newton step
  double rest_m = 1e-9;  ///< ends where no point of the barrel moves by more
};

/// The barrel near `start` with the least robust, weighted sum of squared distances. The noise is
/// estimated from the points' own distances in each round; DistanceNoise's mean is taken off. The
/// seen end and its rim are left out: the loss cannot tell them from the wall. O(rounds n).
/// @param start  off by less than about a quarter of the radius.
/// @return nullopt for fewer than seven points within the cut, or where the result is no cylinder.
/// @throws std::invalid_argument if an option is out of range.
std::optional<Barrel> FitRefined(const FitInput& input, const Barrel& start,
                                 const RefineOptions& options = {});

}  // namespace rangegrasp::cylinders
