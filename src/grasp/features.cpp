#include "grasp/features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "base/linear_algebra.h"
#include "geometry/kd_tree.h"
#include "geometry/plane.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;
using geometry::Points;
using geometry::SeenSpace;
using robot::HandModel;

constexpr double kSeenCell_m = 0.006;  // about three samples of a scan
constexpr double kMaxCells = 1e7;      // a larger scene has larger cells
constexpr double kAround_m = 0.06;     // margin around the measured points
constexpr double kOnTable_m = 0.004;   // lower points are the table
constexpr double kWayStep_m = 0.01;
constexpr int kWaySteps = 7;
constexpr double kNeighbor_m = 0.05;  // larger distances count as this
constexpr double kAdjacent_m = 0.012;
constexpr double kPadHalf_m = 0.008;
constexpr double kContact_m = 0.012;  // from a pad's middle
constexpr double kFarthest_m = 0.2;   // an object extends at most this far into its shadow
constexpr std::size_t kHandPoints = 48;

enum class Space { kFree, kUnseen, kOwn, kOther, kTable };
constexpr std::size_t kSpaces = 5;

/// Shares of the kinds of space that were met.
class Shares {
 public:
  void Add(Space space) {
    ++counts_[static_cast<std::size_t>(space)];
    ++all_;
  }
  double Of(Space space) const {
    return all_ == 0 ? 0.0 : static_cast<double>(counts_[static_cast<std::size_t>(space)]) / all_;
  }

 private:
  std::array<int, kSpaces> counts_{};
  int all_ = 0;
};

/// The space beyond one end of the object.
struct Side {
  Shares beyond;
  double unseen_m = 0.0;   ///< how far unseen space reaches from there
  double missing_m = 0.0;  ///< distance from the last measured points to the pads
};

/// The measured surface where a pad closes.
struct Contact {
  double seen_m = kNeighbor_m;  ///< its distance from the pad
  double face = 0.0;            ///< components of its unit normal: outward (face) and upward
  double up = 0.0;
};

/// Points of the hand's shapes on one side, thinned.
Points PointsOf(const HandModel::State& state, bool thumb) {
  Points all;
  for (std::size_t i = 0; i < state.shapes.size(); ++i) {
    if (!state.is_finger[i] || (state.is_thumb[i] != 0) != thumb) continue;
    const auto mesh = geometry::Tessellate(state.shapes[i]);
    all.insert(all.end(), mesh.vertices.begin(), mesh.vertices.end());
  }
  Points thin;
  const std::size_t step = std::max<std::size_t>(1, all.size() / kHandPoints);
  for (std::size_t i = 0; i < all.size(); i += step) thin.push_back(all[i]);
  return thin;
}

using Tree = std::unique_ptr<geometry::KdTree>;  ///< null: of no points

Tree TreeOf(const Points& points) {
  return points.empty() ? nullptr : std::make_unique<geometry::KdTree>(points);
}

/// The distance of the nearest point of a tree from any of the points, if below `nearest_m`.
double NearestTo(const Tree& tree, const Points& points_C, double nearest_m) {
  if (!tree) return nearest_m;
  std::vector<geometry::KdTree::Neighbor> found;
  for (const Vector3d& p : points_C) {
    tree->Nearest(p, 1, found);
    nearest_m = std::min(nearest_m, std::sqrt(found.front().squared_distance));
  }
  return nearest_m;
}

/// What was measured of an object and around it.
struct ObjectSpace {
  const perception::Scene& scene;
  const perception::PerceivedObject& object;
  const HandModel& hand;
  Vector3d up;
  SeenSpace seen;
  std::vector<std::uint8_t> things;  ///< per cell: 1 own points, 2 another's
  Points own, own_normals, others, wall;
  Tree own_tree, other_tree, wall_tree;  ///< of these points
  double adjacent = 0.0;  ///< share of the object's points that are next to another thing
  double shadow = 0.0;    ///< share of them that are above unseen space
  Vector3d axis = Vector3d::Zero();         ///< the measured object's longest one
  std::vector<Points> thumbs_H, fingers_H;  ///< per state of the hand

  static SeenSpace SpaceAround(const geometry::Observation& observation,
                               const perception::Scene& scene,
                               const perception::PerceivedObject& object) {
    Eigen::AlignedBox3d box = geometry::BoundsOf(object.completed_C);
    for (const auto i : object.points) box.extend(scene.cloud.points[i]);
    const Vector3d around = Vector3d::Constant(kAround_m + kFarthest_m / 2.0);
    box = {Vector3d(box.min() - around), Vector3d(box.max() + around)};
    return {box, std::max(kSeenCell_m, std::cbrt(box.volume() / kMaxCells)), observation};
  }

  ObjectSpace(const geometry::Observation& observation, const perception::Scene& scene_,
              std::size_t index, const HandModel& hand_)
      : scene(scene_),
        object(scene_.objects[index]),
        hand(hand_),
        up(scene_.table.plane.normal),
        seen(SpaceAround(observation, scene_, object)) {
    std::vector<char> is_own(scene.cloud.size(), 0);
    for (const auto i : object.points) is_own[i] = 1;
    things.assign(static_cast<std::size_t>(seen.Size().prod()), 0);
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
      const Vector3d& p = scene.cloud.points[i];
      (is_own[i] ? own : others).push_back(p);
      if (is_own[i]) own_normals.push_back(scene.cloud.normals[i]);
      if (const auto cell = seen.CellOf(p)) things[seen.Index(*cell)] = is_own[i] ? 1 : 2;
    }
    for (const HandModel::State& state : hand.states) {
      thumbs_H.push_back(PointsOf(state, true));
      fingers_H.push_back(PointsOf(state, false));
    }
    for (const auto i : scene.container) wall.push_back(scene.cloud.points[i]);
    own_tree = TreeOf(own);
    other_tree = TreeOf(others);
    wall_tree = TreeOf(wall);
    if (own.empty()) return;
    Shares below;
    int adjacent_points = 0;
    for (const Vector3d& p : own) {
      below.Add(At(p - 0.5 * scene.table.plane.Distance(p) * up));
      adjacent_points += other_tree && other_tree->CountWithin(p, kAdjacent_m, 1) > 0;
    }
    adjacent = adjacent_points / static_cast<double>(own.size());
    shadow = below.Of(Space::kUnseen);
    axis = base::SymmetricEigen(geometry::Scatter(own, geometry::Centroid(own))).vectors.col(2);
  }

  Space At(const Vector3d& p) const {
    if (scene.table.plane.Distance(p) < kOnTable_m) return Space::kTable;
    const auto cell = seen.CellOf(p);
    if (!cell) return Space::kFree;  // above, or far from the object
    const std::uint8_t thing = things[seen.Index(*cell)];
    if (thing != 0) return thing == 1 ? Space::kOwn : Space::kOther;
    return seen.At(*cell) == SeenSpace::Cell::kFree ? Space::kFree : Space::kUnseen;
  }

  // The measured surface where a pad closes; `out` points away from the object.
  Contact ContactOf(const Vector3d& pad, const Vector3d& out) const {
    Contact contact;
    contact.seen_m = NearestTo(own_tree, {pad}, kNeighbor_m);
    if (!own_tree) return contact;
    std::vector<geometry::KdTree::Neighbor> near;
    own_tree->Within(pad, kContact_m, near);
    Vector3d normal = Vector3d::Zero();
    for (const auto& n : near) normal += own_normals[n.index];
    if (normal.norm() > 1e-9) {
      contact.face = normal.normalized().dot(out);
      contact.up = normal.normalized().dot(up);
    }
    return contact;
  }

  // The space beyond the end that the pads close on, along `out`.
  Side SideOf(const Vector3d& middle, const Vector3d& out, const Vector3d& across,
              double half_m) const {
    Side side;
    double measured = -half_m;
    for (const Vector3d& p : own) {
      const Vector3d d = p - middle;
      if (std::abs(across.dot(d)) < 2.0 * kPadHalf_m) measured = std::max(measured, out.dot(d));
    }
    side.missing_m = half_m - measured;
    bool unseen = true;
    // Rays are free only up to one cell before the point that they meet.
    for (double d = 2.0 * kSeenCell_m; d < kFarthest_m; d += kSeenCell_m) {
      const Space space = At(middle + (half_m + d) * out);
      unseen = unseen && space == Space::kUnseen;
      if (unseen) side.unseen_m = d;
      if (d > 0.04) {
        if (!unseen) break;
        continue;
      }
      for (const double y : {-kPadHalf_m, 0.0, kPadHalf_m}) {
        side.beyond.Add(At(middle + (half_m + d) * out + y * across));
      }
    }
    return side;
  }
};

/// The data that features are computed from.
struct Looked {
  const Grasp& grasp;
  const ObjectSpace& space;
  Vector3d middle;      ///< between the pads
  double off_center_m;  ///< horizontal distance from the object's center
  double height_m;      ///< height of the middle above the table
  Shares thumb_way, thumb_end, fingers_way, fingers_end, between;
  Side thumb_beyond, fingers_beyond;
  Contact at_thumb, at_fingers;
  double thumb_neighbor_m, fingers_neighbor_m, wall_m;
};

using L = const Looked&;
struct Feature {
  std::string_view name;
  double (*of)(L);
};
constexpr Feature kFeatures[] = {
    // The grasp.
    {"width", [](L l) { return l.grasp.width_m; }},
    {"opening", [](L l) { return l.grasp.opening_m; }},
    {"contact_angle", [](L l) { return l.grasp.quality.angles.Larger(); }},
    {"score", [](L l) { return l.grasp.score; }},
    {"pad_height", [](L l) { return l.height_m; }},
    {"off_center", [](L l) { return l.off_center_m; }},
    {"workspace_distance", [](L l) { return l.middle.head<2>().norm(); }},
    // Contacts on the completed object.
    {"above", [](L l) { return l.grasp.quality.above_m; }},
    {"slope", [](L l) { return l.grasp.quality.slope_m; }},
    {"finger_lean", [](L l) { return l.grasp.quality.finger_lean; }},
    {"thumb_lean", [](L l) { return l.grasp.quality.thumb_lean; }},
    {"top_margin", [](L l) { return l.grasp.quality.top_margin_m; }},
    {"contact_area", [](L l) { return l.grasp.quality.contact_m2; }},
    {"room", [](L l) { return l.grasp.quality.room_m; }},
    // The object.
    {"size_long", [](L l) { return l.space.object.size_m.x(); }},
    {"size_short", [](L l) { return l.space.object.size_m.y(); }},
    {"height", [](L l) { return l.space.object.height_m; }},
    {"points",
     [](L l) { return std::log(std::max(1.0, static_cast<double>(l.space.own.size()))); }},
    {"rotational",
     [](L l) { return l.space.object.kind == perception::ObjectKind::kRotational ? 1.0 : 0.0; }},
    // Space on the way of thumb and fingers.
    {"thumb_way_free", [](L l) { return l.thumb_way.Of(Space::kFree); }},
    {"thumb_way_unseen", [](L l) { return l.thumb_way.Of(Space::kUnseen); }},
    {"fingers_way_free", [](L l) { return l.fingers_way.Of(Space::kFree); }},
    {"fingers_way_unseen", [](L l) { return l.fingers_way.Of(Space::kUnseen); }},
    // Space where thumb and fingers end.
    {"thumb_end_unseen", [](L l) { return l.thumb_end.Of(Space::kUnseen); }},
    {"fingers_end_unseen", [](L l) { return l.fingers_end.Of(Space::kUnseen); }},
    // Between the pads.
    {"between_own", [](L l) { return l.between.Of(Space::kOwn); }},
    {"between_unseen", [](L l) { return l.between.Of(Space::kUnseen); }},
    {"between_other", [](L l) { return l.between.Of(Space::kOther); }},
    {"between_free", [](L l) { return l.between.Of(Space::kFree); }},
    // Beyond the object's ends.
    {"thumb_beyond_free", [](L l) { return l.thumb_beyond.beyond.Of(Space::kFree); }},
    {"thumb_beyond_unseen", [](L l) { return l.thumb_beyond.beyond.Of(Space::kUnseen); }},
    {"thumb_beyond_unseen_m", [](L l) { return l.thumb_beyond.unseen_m; }},
    {"thumb_beyond_missing_m", [](L l) { return l.thumb_beyond.missing_m; }},
    {"fingers_beyond_free", [](L l) { return l.fingers_beyond.beyond.Of(Space::kFree); }},
    {"fingers_beyond_unseen", [](L l) { return l.fingers_beyond.beyond.Of(Space::kUnseen); }},
    {"fingers_beyond_unseen_m", [](L l) { return l.fingers_beyond.unseen_m; }},
    {"fingers_beyond_missing_m", [](L l) { return l.fingers_beyond.missing_m; }},
    // Neighbors.
    {"thumb_neighbor_m", [](L l) { return l.thumb_neighbor_m; }},
    {"fingers_neighbor_m", [](L l) { return l.fingers_neighbor_m; }},
    {"adjacent", [](L l) { return l.space.adjacent; }},
    {"shadow", [](L l) { return l.space.shadow; }},
    // The measured surface where the pads close: its distance, and how it faces.
    {"thumb_seen_m", [](L l) { return l.at_thumb.seen_m; }},
    {"thumb_face", [](L l) { return l.at_thumb.face; }},
    {"thumb_up", [](L l) { return l.at_thumb.up; }},
    {"fingers_seen_m", [](L l) { return l.at_fingers.seen_m; }},
    {"fingers_face", [](L l) { return l.at_fingers.face; }},
    {"fingers_up", [](L l) { return l.at_fingers.up; }},
    // The measured object's longest axis, and an open box's walls.
    {"axis_up", [](L l) { return std::abs(l.space.axis.dot(l.space.up)); }},
    {"hand_wall_m", [](L l) { return l.wall_m; }},
};
constexpr auto kNames = [] {
  std::array<std::string_view, std::size(kFeatures)> names;
  std::ranges::transform(kFeatures, names.begin(), &Feature::name);
  return names;
}();

Looked LookAt(const Grasp& grasp, const ObjectSpace& space) {
  const HandModel& hand = space.hand;
  const std::size_t open = hand.IndexAtGap(grasp.opening_m);
  const HandModel::State& closed = hand.AtGap(grasp.width_m);
  const Vector3d thumb = grasp.X_CH * closed.thumb_pad_H;
  const Vector3d fingers = grasp.X_CH * closed.finger_pad_H;
  const Vector3d middle = 0.5 * (thumb + fingers);
  const Vector3d approach = grasp.X_CG.linear().col(2);
  Vector3d x = thumb - fingers;
  x = x.norm() > 1e-6 ? Vector3d(x.normalized()) : Vector3d(grasp.X_CG.linear().col(0));
  const Vector3d across = approach.cross(x).normalized();

  Points thumb_C, fingers_C;
  for (const Vector3d& p : space.thumbs_H[open]) thumb_C.push_back(grasp.X_CH * p);
  for (const Vector3d& p : space.fingers_H[open]) fingers_C.push_back(grasp.X_CH * p);
  const auto on_way = [&](const Points& points, int from, int to) {
    Shares shares;
    for (int step = from; step < to; ++step) {
      for (const Vector3d& p : points) shares.Add(space.At(p - step * kWayStep_m * approach));
    }
    return shares;
  };
  Shares between;
  const double half_m = 0.5 * grasp.width_m;
  for (double along = -half_m; along <= half_m; along += kSeenCell_m) {
    for (const double y : {-kPadHalf_m, 0.0, kPadHalf_m}) {
      for (const double z : {-kPadHalf_m, 0.0, kPadHalf_m}) {
        between.Add(space.At(middle + along * x + y * across + z * approach));
      }
    }
  }
  const Vector3d off = middle - space.object.center_C;
  return {.grasp = grasp,
          .space = space,
          .middle = middle,
          .off_center_m = (off - space.up.dot(off) * space.up).norm(),
          .height_m = space.scene.table.plane.Distance(middle),
          .thumb_way = on_way(thumb_C, 1, kWaySteps),
          .thumb_end = on_way(thumb_C, 0, 1),
          .fingers_way = on_way(fingers_C, 1, kWaySteps),
          .fingers_end = on_way(fingers_C, 0, 1),
          .between = between,
          .thumb_beyond = space.SideOf(middle, x, across, half_m),
          .fingers_beyond = space.SideOf(middle, -x, across, half_m),
          .at_thumb = space.ContactOf(thumb, x),
          .at_fingers = space.ContactOf(fingers, -x),
          .thumb_neighbor_m = NearestTo(space.other_tree, thumb_C, kNeighbor_m),
          .fingers_neighbor_m = NearestTo(space.other_tree, fingers_C, kNeighbor_m),
          .wall_m = NearestTo(space.wall_tree, thumb_C,
                              NearestTo(space.wall_tree, fingers_C, kNeighbor_m))};
}

}  // namespace

std::span<const std::string_view> FeatureNames() { return kNames; }

std::vector<std::vector<double>> FeaturesOf(const geometry::Observation& observation,
                                            const perception::Scene& scene, std::size_t object,
                                            const HandModel& hand, std::span<const Grasp> grasps) {
  const ObjectSpace space(observation, scene, object, hand);
  std::vector<std::vector<double>> features;
  for (const Grasp& grasp : grasps) {
    const Looked looked = LookAt(grasp, space);
    auto& values = features.emplace_back();
    for (const Feature& feature : kFeatures) values.push_back(feature.of(looked));
  }
  return features;
}

}  // namespace rangegrasp::grasp
