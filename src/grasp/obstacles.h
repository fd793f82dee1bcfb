#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/words.h"
#include "geometry/mesh.h"
#include "geometry/observation.h"
#include "perception/scene.h"

namespace rangegrasp::grasp {

/// What a motion must keep clear of besides the perceived objects. The dissertation's planner gets
/// the completed objects alone (section 5.1.4).
struct ObstacleAdditions {
  bool leftovers = true;  ///< points of no object: outliers, small segments, needles
  bool unseen = true;     ///< space that no sensor saw behind objects: something may stand there
};
constexpr std::array<base::Addition<ObstacleAdditions>, 2> AdditionsOf(const ObstacleAdditions*) {
  using A = ObstacleAdditions;
  return {{
      {"leftover_obstacles", &A::leftovers,
       "motions avoid measured points that belong to no object"},
      {"unseen_obstacles", &A::unseen,
       "motions avoid the unseen space behind objects other than the target"},
  }};
}
static_assert(base::AllAdditionsListed<ObstacleAdditions>());

struct ObstacleOptions : ObstacleAdditions {
  int min_points = 3;  ///< what is 10 mm wide gives so many even between coarse profiles
  /// Within so many gaps between neighboring points they are of one thing; smaller groups that are
  /// so near to the target are its own.
  double link_gaps = 3.0;
  /// Such a thing is filled by hulls in cells of this edge, which close no gap that a finger fits
  /// into. Smaller: more of them to check against.
  double cell_m = 0.02;
  /// Points within so many gaps of an object's outline, as seen from the sensor, are mixed points.
  double mixed_gaps = 1.5;
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

/// Of the shadows of single views, what no view saw. Within the bounds of what was measured, by
/// cells of cell_m (SeenSpace): a cell counts if its middle lies in one of the shadows and no ray
/// went through it.
/// @param shadows_C  convex and closed, of any of the views
/// @return upright boxes, each closed, as one mesh; none if all of it was seen.
geometry::TriangleMesh UnseenByAll(const geometry::Observation& observation,
                                   std::span<const geometry::TriangleMesh> shadows_C,
                                   double cell_m);

/// ObstaclesOf for all views of an observation. Of several, space is unseen if none of them
/// saw it (UnseenByAll).
/// @param target  position in scene.objects
Obstacles ObstaclesOfViews(const perception::Scene& scene, std::size_t target,
                           const geometry::Observation& observation,
                           const ObstacleOptions& options);

}  // namespace rangegrasp::grasp
