#pragma once

#include "cylinders/cylinder.h"
#include "cylinders/rims.h"

/// Fits of one cylinder to the points of its visible side, compared in tables 4.3 and 4.4.

namespace rangegrasp::cylinders {

/// The lateral surface of a cylinder, unbounded along its axis.
struct Barrel {
  Line axis;
  double radius_m = 0.0;

  /// Signed distance of p from the barrel [m], negative inside: the Euclidean distance of section
  /// 2.5.1 to the wall of eq. 2.14, |(I - d d^T)(p - c)| - r.
  double Distance(const Eigen::Vector3d& p) const { return axis.Distance(p) - radius_m; }
};

/// Input of every fit: points of one object, seen by one sensor.
struct FitInput {
  geometry::PointSpan points;                     ///< [m], finite
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< position of the sensor
  Eigen::Vector3d up = Eigen::Vector3d::UnitX();  ///< unit vector away from the table
};

/// Angle between two axes, regardless of their signs [rad], 0 to pi / 2.
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Standard deviations of a range sensor's noise along the ray and perpendicular to it [m].
struct RayNoise {
  double along_m = 0.0;
  double across_m = 0.0;
};

/// Incidence of a ray on a barrel, whatever the noise of the measured point: components of the
/// ray's unit vector along the surface normal and along the tangent perpendicular to the axis.
struct Incidence {
  double radial = 1.0;      ///< 0 to 1; 0 at the outline and beyond
  double tangential = 0.0;  ///< 0 to 1
};
Incidence IncidenceOf(const Barrel& barrel, const Eigen::Vector3d& eye, const Eigen::Vector3d& p);

/// Effect of noise on the distance from the barrel of a point that lies on it, to second order.
/// With s_n and s_t the noise along the normal and along the tangent perpendicular to the axis,
///   mean = s_t^2 / (2 r)   (a step along the tangent leads out of a circle),
///   variance = s_n^2 + s_t^4 / (2 r^2).
struct DistanceNoise {
  double mean_m = 0.0;
  double variance_m2 = 0.0;
};
DistanceNoise DistanceNoiseOf(const RayNoise& noise, const Incidence& incidence, double radius_m);

// Least-squares fitting of a cylinder (LSF), the method that the dissertation compares with
// (sections 2.5.1 and 4.4).

/// A point of the axis c [m], its direction d (any length), the radius r [m]. As published, the
/// damping of Levenberg-Marquardt holds the two redundant ones.
using BarrelParameters = Eigen::Matrix<double, 7, 1>;

/// The residual of a point, |(I - d d^T / d^T d)(p - c)| - r [m], and its derivatives with respect
/// to the parameters.
double BarrelResidual(const BarrelParameters& x, const Eigen::Vector3d& p,
                      BarrelParameters* gradient = nullptr);

/// Fits the barrel with the least sum of squared distances of all points, including those of the
/// visible end, by Levenberg-Marquardt (MINPACK's, in Eigen). It starts as published: the mean of
/// the points (near the wall if only one side is seen), the direction of the largest variance
/// (PCA), and the mean distance from that line. O(iterations n).
/// @return nullopt for fewer than seven points, or if the start or the result is no cylinder.
/// @param iterations  maximum number, >= 1; 100 in the dissertation (section 4.4)
std::optional<Barrel> FitLeastSquares(geometry::PointSpan points, int iterations = 100);

// Random circle fitting (RCF) of one cylinder's points: rim, circle, axis (sections 4.2.2 to
// 4.2.4), without the search among other objects.

/// Results computed before the first triple is drawn: the "ppt" of table 4.3.
struct RcfPreparation {
  geometry::Points normals;  ///< unit vectors towards the eye; one per point
  std::vector<bool> curved;  ///< true for strong curvature points (eq. 4.13)
};
/// O(n m) for neighborhoods of m points.
/// @param neighborhood_m  > 0; 5 mm in section 4.2.2, 3 mm in table 4.4
RcfPreparation PrepareRcf(const FitInput& input, double neighborhood_m);

/// True if a normal, in the frame of SensorAxes, is that of a "top curvature point". As printed,
/// n_x > n_y and n_x > n_z; the wall's outline on one side also passes. Otherwise it is halfway
/// between the normals of the end and the wall, as that of a point on the rim itself.
bool PassesGate(const Eigen::Vector3d& n_S, bool as_printed);

/// The circle perpendicular to the axis with the least sum of distances of the rim points (eq.
/// 4.24, projected along the axis), by reweighted least squares from `start`. The text calculates
/// "the circle centre c_m again" on the axis; here the radius is also estimated from the whole rim.
/// @return nullopt if the iteration does not lead to a circle.
std::optional<Circle> CircleOnAxis(geometry::PointSpan rim, const Eigen::Vector3d& axis,
                                   const Circle& start);

/// Fits the circle through the rim, gathers the wall (uncurved points within the tolerance of the
/// cylinder on that circle), fits the axis through p - n r of the wall (algorithm 1), and then the
/// circle again.
/// @param draws  >= 1; the iterations of tables 4.3 and 4.4
/// @param as_printed  as in the text, without our additions
/// @return nullopt if there is no rim, no circle or no wall.
std::optional<Barrel> FitRcf(const FitInput& input, const RcfPreparation& prepared, int draws,
                             bool as_printed, base::Rng& rng);

// Refinement of a barrel by orthogonal distances, each weighted by the variance that a range
// sensor's noise gives it. An addition to the dissertation.

/// The barrel near `start` with the least robust sum of squared distances, each weighted by its
/// variance at its incidence: the outline, where noise runs along the surface, contributes most to
/// the radius. The noise is estimated from the distances in each round; DistanceNoise's mean is
/// subtracted. The visible end and its rim are left out. O(rounds n).
/// @param start  its error must be less than about a quarter of the radius
/// @return nullopt for fewer than seven points within the cut, or if the result is no cylinder.
std::optional<Barrel> FitRefined(const FitInput& input, const Barrel& start);

}  // namespace rangegrasp::cylinders
