#pragma once

#include <Eigen/Core>
#include <optional>

#include "cylinders/fit.h"

/// Least-squares fitting of a cylinder (LSF), the method that the dissertation compares with
/// (sections 2.5.1 and 4.4).
namespace rangegrasp::cylinders {

/// All parameters of a barrel as one vector: a point of the axis c [m], its direction d (any
/// length), the radius r [m]. Seven numbers for five freedoms, as published: Levenberg-Marquardt's
/// damping holds those that change nothing.
using BarrelParameters = Eigen::Matrix<double, 7, 1>;

/// The residual of a point, |(I - d d^T / d^T d)(p - c)| - r [m], and its derivatives by the
/// parameters.
double BarrelResidual(const BarrelParameters& x, const Eigen::Vector3d& p,
                      BarrelParameters* gradient = nullptr);

/// The start as published: the mean, the direction of the largest variance (PCA), the mean distance
/// from that line. Of one side of a cylinder the mean lies near the wall: the start is far off.
/// @return nullopt for fewer than two points, or where all are one.
std::optional<Barrel> StartByComponents(geometry::PointSpan points);

struct LeastSquaresOptions {
  int iterations = 100;  ///< >= 1 (section 4.4)
};

/// The barrel with the least sum of squared distances of all points, by Levenberg-Marquardt from
/// StartByComponents (MINPACK's, in Eigen). All points count alike: those of the seen end, too.
/// O(iterations n).
/// @return nullopt for fewer than seven points, or where the start or the result is no cylinder.
/// @throws std::invalid_argument if iterations < 1.
std::optional<BarrelFit> FitLeastSquares(geometry::PointSpan points,
                                         const LeastSquaresOptions& options = {});

}  // namespace rangegrasp::cylinders
