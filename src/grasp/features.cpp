#include "grasp/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/kd_tree.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;
using geometry::Points;
using geometry::SeenSpace;
using robot::HandModel;

constexpr double kSeenCell_m = 0.006;  // about three samples of a scan
constexpr double kAround_m = 0.06;     // of what is looked at beyond the measured points
constexpr double kOnTable_m = 0.004;   // lower is the table
constexpr double kWayStep_m = 0.01;
constexpr int kWaySteps = 7;
constexpr double kNeighbor_m = 0.05;  // further neighbors count as so near
constexpr double kAdjacent_m = 0.012;
constexpr double kPadHalf_m = 0.008;
constexpr double kFarthest_m = 0.2;  // objects extend at most so far into their shadow
constexpr std::size_t kHandPoints = 48;

enum class Space { kFree, kUnseen, kOwn, kOther, kTable };
constexpr std::size_t kSpaces = 5;

/// How often each was met.
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

constexpr std::array<std::string_view, 65> kNames = {
    // The grasp.
    "cylindrical", "rim", "power", "pitch", "width", "opening", "contact_angle", "score", "tilt",
    "closing_slope", "pad_height", "pad_depth", "off_center", "off_center_along",
    "workspace_distance",
    // Its contacts on the completed object.
    "finger_angle", "thumb_angle", "lever", "above", "drag", "slope", "finger_lean", "thumb_lean",
    "top_margin", "contact_area", "room",
    // The object.
    "size_long", "size_short", "height", "base", "points", "rotational", "open", "ridge_or_plane",
    // The way of thumb and fingers.
    "thumb_way_free", "thumb_way_unseen", "thumb_way_own", "thumb_way_other", "fingers_way_free",
    "fingers_way_unseen", "fingers_way_own", "fingers_way_other",
    // Where they stand at its end.
    "thumb_end_unseen", "thumb_end_own", "fingers_end_unseen", "fingers_end_own",
    // Between the pads.
    "between_own", "between_unseen", "between_other", "between_free",
    // Beyond the object's ends.
    "side0_free", "side0_unseen", "side0_other", "side0_unseen_m", "side0_missing_m", "side1_free",
    "side1_unseen", "side1_other", "side1_unseen_m", "side1_missing_m",
    // Neighbors.
    "thumb_neighbor_m", "fingers_neighbor_m", "adjacent", "leaning", "shadow"};

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

}  // namespace

struct FeatureMaker::Impl {
  const perception::Scene& scene;
  const perception::PerceivedObject& object;
  const HandModel& hand;
  Vector3d up;
  Eigen::AlignedBox3d box;
  SeenSpace seen;
  std::vector<std::uint8_t> things;  ///< of a cell: 1 own points, 2 another's
  Points own, others;
  std::unique_ptr<geometry::KdTree> other_tree;
  double adjacent = 0.0, leaning = 0.0, shadow = 0.0;
  std::vector<Points> thumbs_H, fingers_H;  ///< by the hand's state

  static Eigen::AlignedBox3d BoxOf(const perception::Scene& scene,
                                   const perception::PerceivedObject& object) {
    Eigen::AlignedBox3d box;
    for (const auto i : object.points) box.extend(scene.cloud.points[i]);
    for (const Vector3d& p : object.completed_C) box.extend(p);
    const Vector3d around = Vector3d::Constant(kAround_m + kFarthest_m / 2.0);
    return {Vector3d(box.min() - around), Vector3d(box.max() + around)};
  }

  Impl(const geometry::Observation& observation, const perception::Scene& scene_, std::size_t index,
       const HandModel& hand_)
      : scene(scene_),
        object(scene_.objects[index]),
        hand(hand_),
        up(scene_.table.plane.normal),
        box(BoxOf(scene_, object)),
        seen(box, kSeenCell_m) {
    for (const auto& view : observation.views) seen.Add(view);
    std::vector<char> is_own(scene.cloud.size(), 0);
    for (const auto i : object.points) is_own[i] = 1;
    const Eigen::Vector3i size = seen.Size();
    things.assign(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
                      static_cast<std::size_t>(size.z()),
                  0);
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
      const Vector3d& p = scene.cloud.points[i];
      (is_own[i] ? own : others).push_back(p);
      if (const auto cell = CellOf(p)) things[IndexOf(*cell)] = is_own[i] ? 1 : 2;
    }
    for (const HandModel::State& state : hand.states) {
      thumbs_H.push_back(PointsOf(state, true));
      fingers_H.push_back(PointsOf(state, false));
    }
    if (!others.empty()) other_tree = std::make_unique<geometry::KdTree>(others);
    LookAround();
  }

  std::optional<Eigen::Vector3i> CellOf(const Vector3d& p) const {
    const Eigen::Vector3i cell =
        ((p - box.min()) / kSeenCell_m).array().floor().matrix().cast<int>();
    if ((cell.array() < 0).any() || (cell.array() >= seen.Size().array()).any()) {
      return std::nullopt;
    }
    return cell;
  }
  std::size_t IndexOf(const Eigen::Vector3i& cell) const {
    const Eigen::Vector3i size = seen.Size();
    return static_cast<std::size_t>((cell.z() * size.y() + cell.y()) * size.x() + cell.x());
  }

  Space At(const Vector3d& p) const {
    if (scene.table.plane.Distance(p) < kOnTable_m) return Space::kTable;
    const auto cell = CellOf(p);
    if (!cell) return Space::kFree;  // above, or far from the object
    const std::uint8_t thing = things[IndexOf(*cell)];
    if (thing != 0) return thing == 1 ? Space::kOwn : Space::kOther;
    return seen.At(*cell) == SeenSpace::Cell::kFree ? Space::kFree : Space::kUnseen;
  }

  // Of the object's points: how many have another thing next to them, or higher; how much of what
  // is below its outline was not seen.
  void LookAround() {
    Shares below;
    std::vector<geometry::KdTree::Neighbor> near;
    int next_to = 0, under = 0;
    for (const Vector3d& p : own) {
      below.Add(At(p - 0.5 * scene.table.plane.Distance(p) * up));
      if (!other_tree) continue;
      other_tree->Within(p, kAdjacent_m, near);
      if (near.empty()) continue;
      ++next_to;
      under += std::ranges::any_of(
          near, [&](const auto& n) { return up.dot(others[n.index] - p) > 0.5 * kAdjacent_m; });
    }
    const double count = std::max<double>(1.0, static_cast<double>(own.size()));
    adjacent = next_to / count;
    leaning = under / count;
    shadow = below.Of(Space::kUnseen);
  }

  double NeighborOf(const Points& points_C) const {
    double nearest = kNeighbor_m;
    if (!other_tree) return nearest;
    std::vector<geometry::KdTree::Neighbor> found;
    for (const Vector3d& p : points_C) {
      other_tree->Nearest(p, 1, found);
      nearest = std::min(nearest, std::sqrt(found.front().squared_distance));
    }
    return nearest;
  }

  struct Side {
    Shares beyond;
    double unseen_m = 0.0, missing_m = 0.0;
  };
  // Beyond the end that the pads close on, along `out`.
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
    // Rays are free up to a cell before what they meet.
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

  std::vector<double> Of(const Grasp& grasp) const;
};

std::vector<double> FeatureMaker::Impl::Of(const Grasp& grasp) const {
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
  for (const Vector3d& p : thumbs_H[open]) thumb_C.push_back(grasp.X_CH * p);
  for (const Vector3d& p : fingers_H[open]) fingers_C.push_back(grasp.X_CH * p);
  const auto on_way = [&](const Points& points, int from, int to) {
    Shares shares;
    for (int step = from; step < to; ++step) {
      for (const Vector3d& p : points) shares.Add(At(p - step * kWayStep_m * approach));
    }
    return shares;
  };
  const Shares thumb_way = on_way(thumb_C, 1, kWaySteps), thumb_end = on_way(thumb_C, 0, 1);
  const Shares fingers_way = on_way(fingers_C, 1, kWaySteps), fingers_end = on_way(fingers_C, 0, 1);

  Shares between;
  const double half_m = 0.5 * grasp.width_m;
  for (double along = -half_m; along <= half_m; along += kSeenCell_m) {
    for (const double y : {-kPadHalf_m, 0.0, kPadHalf_m}) {
      for (const double z : {-kPadHalf_m, 0.0, kPadHalf_m}) {
        between.Add(At(middle + along * x + y * across + z * approach));
      }
    }
  }
  const Side side0 = SideOf(middle, x, across, half_m);
  const Side side1 = SideOf(middle, -x, across, half_m);
  const Vector3d off = middle - object.center_C;
  const Vector3d level = off - up.dot(off) * up;
  const double height_m = scene.table.plane.Distance(middle);
  return {grasp.type == GraspType::kCylindrical ? 1.0 : 0.0,
          grasp.type == GraspType::kRim ? 1.0 : 0.0,
          grasp.type == GraspType::kPower ? 1.0 : 0.0,
          grasp.pitch_rad,
          grasp.width_m,
          grasp.opening_m,
          grasp.quality.angles.Larger(),
          grasp.score,
          std::acos(std::clamp(-approach.dot(up), -1.0, 1.0)),
          std::abs(x.dot(up)),
          height_m,
          object.height_m - height_m,
          level.norm(),
          std::abs(level.dot(across)),
          middle.head<2>().norm(),
          grasp.quality.angles.finger_rad,
          grasp.quality.angles.thumb_rad,
          grasp.quality.lever_m,
          grasp.quality.above_m,
          grasp.quality.drag_m,
          grasp.quality.slope_m,
          grasp.quality.finger_lean,
          grasp.quality.thumb_lean,
          grasp.quality.top_margin_m,
          grasp.quality.contact_m2,
          grasp.quality.room_m,
          object.size_m.x(),
          object.size_m.y(),
          object.height_m,
          object.base_m,
          std::log(static_cast<double>(std::max<std::size_t>(1, own.size()))),
          object.kind == perception::ObjectKind::kRotational ? 1.0 : 0.0,
          object.open ? 1.0 : 0.0,
          object.top && object.top->ridge ? 1.0 : 0.0,
          thumb_way.Of(Space::kFree),
          thumb_way.Of(Space::kUnseen),
          thumb_way.Of(Space::kOwn),
          thumb_way.Of(Space::kOther),
          fingers_way.Of(Space::kFree),
          fingers_way.Of(Space::kUnseen),
          fingers_way.Of(Space::kOwn),
          fingers_way.Of(Space::kOther),
          thumb_end.Of(Space::kUnseen),
          thumb_end.Of(Space::kOwn),
          fingers_end.Of(Space::kUnseen),
          fingers_end.Of(Space::kOwn),
          between.Of(Space::kOwn),
          between.Of(Space::kUnseen),
          between.Of(Space::kOther),
          between.Of(Space::kFree),
          side0.beyond.Of(Space::kFree),
          side0.beyond.Of(Space::kUnseen),
          side0.beyond.Of(Space::kOther),
          side0.unseen_m,
          side0.missing_m,
          side1.beyond.Of(Space::kFree),
          side1.beyond.Of(Space::kUnseen),
          side1.beyond.Of(Space::kOther),
          side1.unseen_m,
          side1.missing_m,
          NeighborOf(thumb_C),
          NeighborOf(fingers_C),
          adjacent,
          leaning,
          shadow};
}

std::span<const std::string_view> FeatureNames() { return kNames; }

FeatureMaker::FeatureMaker(const geometry::Observation& observation, const perception::Scene& scene,
                           std::size_t object, const HandModel& hand)
    : impl_(std::make_unique<Impl>(observation, scene, object, hand)) {}
FeatureMaker::~FeatureMaker() = default;
FeatureMaker::FeatureMaker(FeatureMaker&&) noexcept = default;

std::vector<double> FeatureMaker::Of(const Grasp& grasp) const { return impl_->Of(grasp); }

}  // namespace rangegrasp::grasp
