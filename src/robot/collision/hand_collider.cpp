#include "robot/collision/hand_collider.h"

#include <algorithm>
#include <limits>

#include "geometry/support.h"

namespace rangegrasp::collision {
namespace {

using Eigen::Vector3d;

/// A grasp that was placed exactly at the table's clearance passes in spite of rounding.
constexpr double kRounding_m = 1e-6;

}  // namespace

HandCollider::HandCollider(const robot::HandModel& hand,
                           std::span<const geometry::TriangleMesh> obstacles_C,
                           const geometry::TriangleMesh& own_C, const geometry::Plane& table_C,
                           const HandColliderOptions& options)
    : hand_(&hand),
      options_(options),
      table_C_(table_C),
      grown_(hand, {options.object_clearance_m, options.sides}),
      bare_(hand, {0.0, options.sides}),
      own_(own_C) {
  for (const geometry::TriangleMesh& mesh : obstacles_C) {
    if (!mesh.triangles.empty()) obstacles_.emplace_back(mesh);
  }
}

/// An obstacle with a vertex inside a shape: surfaces need not cross where it is small.
bool HandCollider::Swallows(const base::Pose& X_CH, std::size_t state,
                            const std::vector<PlacedSolid>& grown,
                            const PlacedSolid& obstacle) const {
  for (std::size_t i = 0; i < grown.size(); ++i) {
    const Eigen::AlignedBox3d& box = grown[i].box_W;
    if (!box.intersects(obstacle.box_W)) continue;
    geometry::Shape shape =
        geometry::Grown(hand_->states[state].shapes[i], options_.object_clearance_m);
    shape.X_BS = X_CH * shape.X_BS;
    for (const Vector3d& p : obstacle.solid->Vertices()) {
      if (box.contains(p) && geometry::Inside(shape, p)) return true;
    }
  }
  return false;
}

bool HandCollider::HitsObstacle(const base::Pose& X_CH, std::size_t state) const {
  if (obstacles_.empty()) return false;
  const std::vector<PlacedSolid> grown = grown_.At(X_CH, state);
  return std::any_of(obstacles_.begin(), obstacles_.end(), [&](const Solid& solid) {
    const PlacedSolid obstacle = PlaceAt(solid, base::Pose::Identity());
    return std::any_of(grown.begin(), grown.end(),
                       [&](const PlacedSolid& part) { return Hit(part, obstacle); }) ||
           Swallows(X_CH, state, grown, obstacle);
  });
}

bool HandCollider::HitsOwn(const base::Pose& X_CH, std::size_t state) const {
  const PlacedSolid own = PlaceAt(own_, base::Pose::Identity());
  const std::vector<PlacedSolid> bare = bare_.At(X_CH, state);
  return std::any_of(bare.begin(), bare.end(),
                     [&](const PlacedSolid& part) { return Hit(part, own); });
}

double HandCollider::TableDistance(const base::Pose& X_CH, std::size_t state) const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const geometry::Shape& shape : hand_->states[state].shapes) {
    lowest = std::min(lowest, table_C_.offset_m - geometry::Support(shape, X_CH, -table_C_.normal));
  }
  return lowest;
}

bool HandCollider::HitsTable(const base::Pose& X_CH, std::size_t state) const {
  return TableDistance(X_CH, state) < options_.table_clearance_m - kRounding_m;
}

}  // namespace rangegrasp::collision
