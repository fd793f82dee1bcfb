#pragma once

#include <optional>

#include "geometry/plane.h"
#include "pcl_bridge/cloud.h"
#include "pcl_bridge/surface_normals.h"

/// Models by RANSAC. The library draws from a generator that starts from the same state in every
/// call, single-threaded: the same input gives the same output.
namespace rangegrasp::pcl_bridge {

struct PlaneOptions {
  int max_draws = 100;               ///< >= 1 (dissertation, section 4.2.1)
  double inlier_distance_m = 0.002;  ///< > 0
  /// (0, 1): drawing ends early once a sample of inliers alone was drawn with this probability,
  /// were the share of inliers the best one found. The library's own value.
  double confidence = 0.99;
};

/// The plane with the most points within the distance, refitted to them by least squares
/// (SACMODEL_PLANE). Its normal points to the side of the cloud's origin. O(draws n).
/// @return nullopt if no three points span a plane.
/// @throws std::invalid_argument if an option is out of range.
std::optional<geometry::PlaneFit> FitPlane(const Cloud& cloud, const PlaneOptions& options = {});

struct Cylinder {
  Eigen::Vector3d point =
      Eigen::Vector3d::Zero();  ///< on the axis [m], beside the mean of the inliers
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

struct CylinderFit {
  Cylinder cylinder;
  geometry::Indices inliers;  ///< ascending
};

struct CylinderOptions {
  /// >= 1. Two points with normals make a hypothesis; where one point in four is on the cylinder,
  /// 1000 draws miss a clean pair with probability (1 - 1/16)^1000 < 1e-28: the rest is for noisy
  /// normals.
  int max_draws = 1000;
  double inlier_distance_m = 0.002;  ///< > 0; as the plane's
  /// [0, 1]: the distance of a point is the weighted mean w angle + (1 - w) distance of its
  /// normal's angle [rad] and its place's distance [m] to the cylinder. Larger throws out
  /// neighboring surfaces sooner and tolerates less noise in the normals.
  double normal_weight = 0.01;
  double min_radius_m = 0.005;  ///< >= 0
  double max_radius_m = 0.2;    ///< > min_radius_m
  double confidence = 0.99;     ///< (0, 1), as the plane's
};

/// The cylinder (unbounded along its axis) with the most points within the distance, refitted to
/// them by Levenberg-Marquardt (SACMODEL_CYLINDER). O(draws n).
/// @param normals  of this cloud; points without one are no inliers.
/// @return nullopt if no pair of points made a cylinder with a radius in the range.
/// @throws std::invalid_argument if an option is out of range or the normals are not the cloud's.
std::optional<CylinderFit> FitCylinder(const Cloud& cloud, const Normals& normals,
                                       const CylinderOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
