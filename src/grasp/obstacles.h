#pragma once

#include <vector>

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::grasp {

/// What a motion must keep clear of besides the perceived objects.
struct ObstacleOptions {
  /// What was measured above the table and belongs to no object: outliers that a filter took out,
  /// segments that are too small, needles.
  bool leftovers = true;
  /// Fewer points are noise: what is 10 mm wide gives so many even between coarse profiles.
  int min_points = 3;
  /// Points are of one thing within so many gaps between neighboring points; groups that hang on
  /// the target so, and are smaller than it, are its own and go with it.
  double link_gaps = 3.0;
  /// Such a thing is filled cell by cell of this edge: hulls of less than that close no gap that a
  /// finger fits into. Smaller: more of them to check against.
  double cell_m = 0.02;
  /// A point seen within so many gaps of an object's outline, as seen from the sensor, is a mixed
  /// point: the light of the object's edge and of what is behind it.
  double mixed_gaps = 1.5;
  /// Space behind the other objects that the sensor did not see: something may stand there. Behind
  /// the target itself a finger has to go; its completed surface stands for what is there.
  bool unseen = true;
};

/// What a motion keeps clear of besides the perceived objects; surfaces in C.
struct Obstacles {
  /// One about each group of points that belong to no object, made of convex closed surfaces that
  /// may cut each other.
  std::vector<geometry::TriangleMesh> measured_C;
  /// Space that was not seen: the shadows of the objects but the target down to the table, convex
  /// and closed. Something may be there or not.
  std::vector<geometry::TriangleMesh> unseen_C;
};

/// @param target  position in scene.objects
/// @param places_C  where the sensors stood, at least one [m]
/// O(n log n) for n points above the table.
Obstacles ObstaclesOf(const perception::Scene& scene, std::size_t target,
                      const geometry::Points& places_C, const ObstacleOptions& options);

}  // namespace rangegrasp::grasp
