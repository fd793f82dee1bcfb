#include "robot/collision/collider.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace rangegrasp::collision {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Kind = geometry::Shape::Kind;

/// Facets with 12 sides lie up to r (1 - cos 15 deg) = 0.27 to 0.34 mm inside a finger of 8 to 10
/// mm radius. Grown by half of that, they lie as much outside as inside. If larger, a free grasp
/// counts as a hit; if smaller, a hit is missed.
constexpr double kFacet_m = 0.00015;

bool IsMesh(Kind kind) { return kind == Kind::kConvex || kind == Kind::kMesh; }

geometry::Shape Faceted(const geometry::Shape& shape, const SolidOptions& options) {
  geometry::Shape bare = geometry::Grown(shape, options.margin_m + kFacet_m);
  bare.X_BS = base::Pose::Identity();
  return {.kind = Kind::kMesh,
          .X_BS = shape.X_BS,
          .mesh = geometry::Tessellate(bare, options.sides),
          .name = {}};
}

std::shared_ptr<fcl::CollisionGeometryd> MakeTree(const geometry::TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
  auto tree = std::make_shared<fcl::BVHModel<fcl::OBBd>>();
  tree->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size()));
  tree->addSubModel(mesh.vertices, triangles);
  tree->endModel();
  return tree;
}

std::shared_ptr<fcl::CollisionGeometryd> MakePrimitive(Kind kind, const Vector3d& size) {
  switch (kind) {
    case Kind::kSphere:
      return std::make_shared<fcl::Sphered>(size[0]);
    case Kind::kCapsule:
      return std::make_shared<fcl::Capsuled>(size[0], 2.0 * size[1]);
    case Kind::kCylinder:
      return std::make_shared<fcl::Cylinderd>(size[0], 2.0 * size[1]);
    case Kind::kEllipsoid:
      return std::make_shared<fcl::Ellipsoidd>(size);
    default:
      return std::make_shared<fcl::Boxd>(2.0 * size);
  }
}

std::shared_ptr<fcl::CollisionGeometryd> MakeGeometry(const geometry::Shape& shape) {
  if (IsMesh(shape.kind)) return shape.mesh.triangles.empty() ? nullptr : MakeTree(shape.mesh);
  auto primitive = MakePrimitive(shape.kind, shape.size);
  primitive->computeLocalAABB();
  return primitive;
}

/// Lets a grasp that was placed exactly at the table's clearance pass in spite of rounding.
constexpr double kRounding_m = 1e-6;

const base::Pose kWorld = base::Pose::Identity();

/// For a solid that need not be at its own X_BS.
PlacedSolid PlaceAt(const Solid& solid, const base::Pose& X_WS) {
  return {&solid, X_WS, solid.BoxAt(X_WS)};
}

bool HitsAny(const PlacedSolid& part, const std::vector<PlacedSolid>& others) {
  return std::ranges::any_of(others, [&](const PlacedSolid& other) { return Hit(part, other); });
}

std::vector<PlacedSolid> PlaceAll(const std::vector<Solid>& solids, const base::Pose& X_WB) {
  std::vector<PlacedSolid> placed;
  for (const Solid& solid : solids) placed.push_back(Place(solid, X_WB));
  return placed;
}

}  // namespace

Solid::Solid(geometry::Shape shape, const SolidOptions& options)
    : shape_(options.sides > 0 ? Faceted(shape, options)
                               : geometry::Grown(std::move(shape), options.margin_m)),
      box_(geometry::BoundsOf(shape_.mesh.vertices)),
      geometry_(MakeGeometry(shape_)) {}

Solid::Solid(geometry::TriangleMesh mesh)
    : Solid(geometry::Shape{.kind = Kind::kMesh, .mesh = std::move(mesh), .name = {}}) {}

AlignedBox3d Solid::BoxAt(const base::Pose& X_WS) const {
  if (IsMesh(shape_.kind)) return box_.isEmpty() ? box_ : box_.transformed(X_WS);
  Vector3d half;
  for (int i = 0; i < 3; ++i) half[i] = geometry::Support(shape_, X_WS.linear().row(i).transpose());
  return {X_WS.translation() - half, X_WS.translation() + half};
}

double Solid::LowestAt(const base::Pose& X_WS) const {
  return X_WS.translation().z() - geometry::Support(shape_, -X_WS.linear().row(2).transpose());
}

bool Solid::Touches(const base::Pose& X_WS, const Solid& other, const base::Pose& X_WOther) const {
  if (IsEmpty() || other.IsEmpty()) return false;
  const fcl::CollisionRequestd first_contact;
  fcl::CollisionResultd result;
  return fcl::collide(geometry_.get(), X_WS, other.geometry_.get(), X_WOther, first_contact,
                      result) > 0;
}

PlacedSolid Place(const Solid& solid, const base::Pose& X_WB) {
  return PlaceAt(solid, X_WB * solid.X_BS());
}

bool Hit(const PlacedSolid& a, const PlacedSolid& b) {
  return a.box_W.intersects(b.box_W) && a.solid->Touches(a.X_WS, *b.solid, b.X_WS);
}

HandSolids::HandSolids(const robot::HandModel& hand, const SolidOptions& options) : hand_(&hand) {
  for (const geometry::Shape& shape : hand.states.front().shapes) {
    solids_.emplace_back(shape, options);
  }
}

std::vector<PlacedSolid> HandSolids::At(const base::Pose& X_WH, std::size_t state) const {
  std::vector<PlacedSolid> placed;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    placed.push_back(PlaceAt(solids_[i], X_WH * hand_->states[state].shapes[i].X_BS));
  }
  return placed;
}

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

/// Whether an obstacle has a vertex inside a shape: a small obstacle's surface need not cross it.
bool HandCollider::Swallows(const base::Pose& X_CH, std::size_t state,
                            const std::vector<PlacedSolid>& grown,
                            const PlacedSolid& obstacle) const {
  for (std::size_t i = 0; i < grown.size(); ++i) {
    const AlignedBox3d& box = grown[i].box_W;
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
  return std::ranges::any_of(obstacles_, [&](const Solid& solid) {
    const PlacedSolid obstacle = PlaceAt(solid, base::Pose::Identity());
    return HitsAny(obstacle, grown) || Swallows(X_CH, state, grown, obstacle);
  });
}

bool HandCollider::HitsOwn(const base::Pose& X_CH, std::size_t state) const {
  return HitsAny(PlaceAt(own_, base::Pose::Identity()), bare_.At(X_CH, state));
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

RobotCollider::RobotCollider(const robot::Robot& robot, double margin_m, double cell_margin_m)
    : robot_(robot), grown_hand_(robot.hand(), {margin_m}), bare_hand_(robot.hand(), {}) {
  for (const robot::Link& link : robot.links()) {
    std::vector<Solid>& solids = links_.emplace_back();
    for (const geometry::Shape& shape : link.shapes) {
      solids.emplace_back(shape, SolidOptions{margin_m});
    }
    fixed_.push_back((fixed_.empty() || fixed_.back()) && link.joint < 0);
  }
  fixed_.push_back(false);
  for (const geometry::Shape& shape : robot.workcell()) {
    workcell_solids_.emplace_back(shape);
    grown_workcell_solids_.emplace_back(shape, SolidOptions{cell_margin_m});
  }
  workcell_ = PlaceAll(workcell_solids_, kWorld);
  grown_workcell_ = PlaceAll(grown_workcell_solids_, kWorld);
}

void RobotCollider::SetScene(double table_z_m, std::span<const geometry::TriangleMesh> obstacles_W,
                             const geometry::TriangleMesh& target_W) {
  table_z_m_ = table_z_m;
  obstacle_solids_.clear();
  for (const geometry::TriangleMesh& mesh : obstacles_W) obstacle_solids_.emplace_back(mesh);
  obstacles_ = PlaceAll(obstacle_solids_, kWorld);
  target_ = Solid(target_W);
}

void RobotCollider::PlaceRobot(const std::vector<base::Pose>& links_W, const base::Pose& X_WH,
                               const Contacts& contacts) {
  placed_.resize(links_.size() + 1);
  for (std::size_t i = 0; i < links_.size(); ++i) placed_[i] = PlaceAll(links_[i], links_W[i]);
  const HandSolids& hand = contacts.hand_margin ? grown_hand_ : bare_hand_;
  placed_.back() = hand.At(X_WH, contacts.hand_state);
}

bool RobotCollider::IsBelowTable(const PlacedSolid& part) const {
  return part.box_W.min().z() < table_z_m_ && part.solid->LowestAt(part.X_WS) < table_z_m_;
}

std::optional<Touch> RobotCollider::TouchOfTable(const Contacts& contacts) const {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool may_touch = i == links_.size() && contacts.may_touch_table;
    if (fixed_[i] || may_touch || robot_.IgnoresTable(i)) continue;
    for (const PlacedSolid& part : placed_[i]) {
      if (IsBelowTable(part)) return Touch{i, Touch::Other::kTable};
    }
  }
  return std::nullopt;
}

std::optional<Touch> RobotCollider::TouchOfItself() const {
  for (const std::array<int, 2>& pair : robot_.self_pairs()) {
    const std::size_t a = pair[0], b = pair[1];
    for (const PlacedSolid& part : placed_[a]) {
      if (HitsAny(part, placed_[b])) return Touch{a, Touch::Other::kRobot, b};
    }
  }
  return std::nullopt;
}

std::optional<Touch> RobotCollider::TouchOfScene(const Contacts& contacts) const {
  const PlacedSolid target = Place(target_, kWorld);
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (fixed_[i]) continue;
    const bool hand = i == links_.size();
    const bool with_target = contacts.target == Contacts::Target::kObstacle ||
                             (contacts.target == Contacts::Target::kHandMayTouch && !hand);
    const auto& workcell = hand && contacts.cell_margin ? grown_workcell_ : workcell_;
    for (const PlacedSolid& part : placed_[i]) {
      for (std::size_t k = 0; k < workcell.size(); ++k) {
        if (!robot_.Ignores(i, k) && Hit(part, workcell[k])) {
          return Touch{i, Touch::Other::kWorkcell, k};
        }
      }
      for (std::size_t k = 0; k < obstacles_.size(); ++k) {
        if (Hit(part, obstacles_[k])) return Touch{i, Touch::Other::kObstacle, k};
      }
      if (with_target && Hit(part, target)) return Touch{i, Touch::Other::kTarget};
    }
  }
  return std::nullopt;
}

/// Checks the held object, with its frame at X_WT, against the work cell; with the margin also at
/// the lowest height that it may reach.
std::optional<Touch> RobotCollider::HeldInWorkcell(const base::Pose& X_WT,
                                                   const Contacts& contacts) const {
  const auto& workcell = contacts.cell_margin ? grown_workcell_ : workcell_;
  const double below_m = contacts.cell_margin ? contacts.held_below_m : 0.0;
  for (const double z_m : {0.0, -below_m}) {
    const PlacedSolid held = Place(target_, X_WT * Eigen::Translation3d(0.0, 0.0, z_m));
    for (std::size_t k = 0; k < workcell.size(); ++k) {
      if (Hit(held, workcell[k])) return Touch{placed_.size(), Touch::Other::kWorkcell, k};
    }
    if (below_m <= 0.0) break;
  }
  return std::nullopt;
}

/// Checks the held object against table, work cell, obstacles and the arm (not the hand).
std::optional<Touch> RobotCollider::TouchOfHeld(const base::Pose& X_WH,
                                                const Contacts& contacts) const {
  if (target_.IsEmpty()) return std::nullopt;
  const std::size_t self = placed_.size();
  const PlacedSolid held = Place(target_, X_WH * contacts.X_HT);
  if (!contacts.may_touch_table && IsBelowTable(held)) return Touch{self, Touch::Other::kTable};
  if (const auto touch = HeldInWorkcell(X_WH * contacts.X_HT, contacts)) return touch;
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    const bool ignored = !contacts.held_ignores.empty() && contacts.held_ignores[k];
    if (!ignored && Hit(held, obstacles_[k])) return Touch{self, Touch::Other::kObstacle, k};
  }
  for (std::size_t k = 0; k + 1 < placed_.size(); ++k) {
    if (HitsAny(held, placed_[k])) return Touch{self, Touch::Other::kRobot, k};
  }
  return std::nullopt;
}

std::optional<Touch> RobotCollider::FirstTouch(const std::vector<base::Pose>& links_W,
                                               const Contacts& contacts) {
  const base::Pose X_WH = links_W.back() * robot_.X_FH;
  PlaceRobot(links_W, X_WH, contacts);
  if (const auto touch = TouchOfTable(contacts)) return touch;
  if (const auto touch = TouchOfItself()) return touch;
  if (const auto touch = TouchOfScene(contacts)) return touch;
  if (contacts.target == Contacts::Target::kHeld) return TouchOfHeld(X_WH, contacts);
  return std::nullopt;
}

std::string RobotCollider::NameOfPart(std::size_t part) const {
  if (part < links_.size()) return robot_.links()[part].name;
  return part == links_.size() ? "the hand" : "the held object";
}

std::string RobotCollider::TextOf(const Touch& touch) const {
  const auto with = [&](const std::string& other) {
    return NameOfPart(touch.part) + " and " + other;
  };
  switch (touch.other) {
    case Touch::Other::kTable:
      return with("the table");
    case Touch::Other::kRobot:
      return with(NameOfPart(touch.index));
    case Touch::Other::kWorkcell:
      return with(robot_.workcell()[touch.index].name);
    case Touch::Other::kObstacle:
      return with("what was seen beside the object");
    case Touch::Other::kTarget:
      return with("the object");
  }
  return {};
}

std::vector<char> RobotCollider::TouchedByTarget(const base::Pose& X_WH,
                                                 const base::Pose& X_HT) const {
  std::vector<char> touched(obstacles_.size(), 0);
  const PlacedSolid held = Place(target_, X_WH * X_HT);
  for (std::size_t i = 0; i < obstacles_.size(); ++i) touched[i] = Hit(held, obstacles_[i]);
  return touched;
}

double RobotCollider::LowestOfHand(const base::Pose& X_WH, std::size_t state) const {
  double lowest = X_WH.translation().z();
  for (const PlacedSolid& part : bare_hand_.At(X_WH, state)) {
    lowest = std::min(lowest, part.solid->LowestAt(part.X_WS));
  }
  return lowest;
}

}  // namespace rangegrasp::collision
