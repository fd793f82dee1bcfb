#include "grasp/view_obstacles.h"

#include <utility>

#include "grasp/detector.h"
#include "grasp/unseen.h"

namespace rangegrasp::grasp {
namespace {

/// Of what is unseen: half of a finger's width, so that one finds its way between two cells.
constexpr double kCell_m = 0.010;

}  // namespace

Obstacles ObstaclesOfViews(const perception::Scene& scene, std::size_t target,
                           const geometry::Observation& observation,
                           const ObstacleOptions& options) {
  Obstacles obstacles = ObstaclesOf(scene, target, PlacesOf(observation), options);
  if (observation.views.size() < 2 || obstacles.unseen_C.empty()) return obstacles;
  geometry::TriangleMesh unseen = UnseenByAll(observation, obstacles.unseen_C, kCell_m);
  obstacles.unseen_C.clear();
  if (!unseen.triangles.empty()) obstacles.unseen_C.push_back(std::move(unseen));
  return obstacles;
}

}  // namespace rangegrasp::grasp
