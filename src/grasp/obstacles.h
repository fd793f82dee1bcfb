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
  /// the target so are its own, and go with it.
  double link_gaps = 3.0;
  /// A point seen within so many gaps of an object's outline, as seen from the sensor, is a mixed
  /// point: the light of the object's edge and of what is behind it.
  double mixed_gaps = 1.5;
  /// Space behind the other objects that the sensor did not see: something may stand there. Behind
  /// the target itself a finger has to go; its completed surface stands for what is there.
  bool unseen = true;
};

/// Surfaces in C, closed and convex each: one about each group of leftover points, and the shadows
/// of the objects but the target down to the table.
/// @param target  position in scene.objects
/// @param places_C  where the sensors stood, at least one [m]
/// O(n log n) for n points above the table.
std::vector<geometry::TriangleMesh> ObstaclesOf(const perception::Scene& scene, std::size_t target,
                                                const geometry::Points& places_C,
                                                const ObstacleOptions& options);

}  // namespace rangegrasp::grasp
