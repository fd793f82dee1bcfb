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

/// Obstacles of a motion besides the perceived objects. The dissertation's planner gets only the
/// completed objects (section 5.1.4).
struct ObstacleAdditions {
  bool leftovers = true;  ///< points that belong to no object: outliers, small segments, needles
  bool unseen = true;     ///< space behind objects that no sensor saw: something may stand there
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
  int min_points = 3;  ///< a 10 mm wide thing gives this many even between coarse profiles
  /// Neighboring points within this many gaps belong to one thing. A group this near to the target
  /// and smaller than it belongs to the target.
  double link_gaps = 3.0;
  /// Such a thing is filled by convex hulls in cells of this edge length, which close no gap that a
  /// finger fits into. Smaller cells give more hulls to check.
  double cell_m = 0.02;
  /// Points within this many gaps of an object's outline, seen from the sensor, are mixed points.
  double mixed_gaps = 1.5;
};

/// Obstacles of a motion besides the perceived objects; surfaces are in C.
struct Obstacles {
  /// One per group of points that belong to no object, made of convex closed surfaces that may
  /// intersect.
  std::vector<geometry::TriangleMesh> measured_C;
  /// Space that was not seen: the shadows of all objects but the target, down to the table, convex
  /// and closed. Something may be there or not.
  std::vector<geometry::TriangleMesh> unseen_C;
};

/// The gap between neighboring points [m] (Sampling::gap_m), measured here if the scene's lengths
/// were not adapted to it.
double GapOf(const perception::Scene& scene);

/// @param target  position in scene.objects
/// @param places_C  positions of the sensors, at least one [m]
/// O(n log n) for n points above the table.
Obstacles ObstaclesOf(const perception::Scene& scene, std::size_t target,
                      const geometry::Points& places_C, const ObstacleOptions& options);

/// The part of the shadows of single views that no view saw, within the bounds of the measured
/// points. It consists of cells of cell_m (SeenSpace) whose middle lies in a shadow and which no
/// ray crossed.
/// @param shadows_C  convex and closed, of any of the views
/// @return closed upright boxes as one mesh; empty if everything was seen.
geometry::TriangleMesh UnseenByAll(const geometry::Observation& observation,
                                   std::span<const geometry::TriangleMesh> shadows_C,
                                   double cell_m);

/// ObstaclesOf for all views of an observation. With several views, space is unseen if none of them
/// saw it (UnseenByAll).
/// @param target  position in scene.objects
Obstacles ObstaclesOfViews(const perception::Scene& scene, std::size_t target,
                           const geometry::Observation& observation,
                           const ObstacleOptions& options);

}  // namespace rangegrasp::grasp
