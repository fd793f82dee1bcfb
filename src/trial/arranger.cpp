#include "trial/arranger.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/units.h"
#include "base/words.h"
#include "grasp/detector.h"
#include "sim/resting_poses.h"
#include "trial/internal/arranging.h"

namespace rangegrasp::trial {
namespace {

using internal::OutOfView;
using internal::PlaceInDisc;
using internal::RandomRotation;
using internal::Resting;
using internal::Shuffle;

// Objects of an arrangement of several are at rest once they have been slow for this time.
constexpr double kRestTime_s = 0.3;

// The indices of a world's objects.
auto Numbers(const sim::World& world) { return std::views::iota(0, world.objects()); }

// How many other objects the target (object 0) touches.
int Touching(const sim::World& world) {
  // Strictly less: objects further apart are reported at the limit.
  const auto touches = [&](int other) {
    return world.ObjectDistance(0, other, kTouch_m) < kTouch_m;
  };
  return static_cast<int>(std::ranges::count_if(std::views::iota(1, world.objects()), touches));
}

bool AnyTouchesArm(const sim::World& world) {
  return std::ranges::any_of(
      Numbers(world), [&](int object) { return world.RobotDistance(object, kTouch_m) < kTouch_m; });
}

bool Overlaps(const sim::World& world) {
  for (const int a : Numbers(world)) {
    if (world.SceneDistance(a, 0.0) < -kMaxPenetration_m) return true;
    for (int b = a + 1; b < world.objects(); ++b) {
      if (world.ObjectDistance(a, b, 0.0) < -kMaxPenetration_m) return true;
    }
  }
  return false;
}

// Highest point of all objects except the target.
double OthersTop(const sim::World& world) {
  double top = 0.0;
  for (int other = 1; other < world.objects(); ++other) {
    top = std::max(top, world.ObjectTop(other));
  }
  return top;
}

bool OverWorkspace(const robot::Robot& robot, const Eigen::Vector3d& p_W, double margin_m) {
  return WorkspaceOf(robot, margin_m).Contains(p_W) &&
         (robot.X_WWorkspace.inverse() * p_W).z() > 0.0;
}

// The target is the topmost object if it is higher than all others by this: below it, the scanner,
// whose calibration may be off by millimetres, cannot tell which is the highest.
constexpr double kTopmost_m = 0.005;

// touching: minimum number of objects that the target touches.
constexpr int kMinTouching = 2;

// Why a settled arrangement of several objects is not acceptable.
std::optional<Redraw> WrongAmongOthers(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner,
                                       const sim::World& world) {
  if (world.ObjectTop(0) < OthersTop(world) + kTopmost_m) return Redraw::kNotHighest;
  const int min_touching = options.arranger == kTouching ? kMinTouching : 1;
  if (Touching(world) < min_touching) return Redraw::kTouchesFew;
  // A box stays where it stands, even if the arm does not reach all of it.
  if (!world.container() && !OverWorkspace(robot, world.ObjectCenterOfMass(0), 0.0)) {
    return Redraw::kOutOfReach;
  }
  if (AnyTouchesArm(world)) return Redraw::kTouchesArm;
  if (Overlaps(world)) return Redraw::kOverlaps;
  if (!OutOfView(world, robot.X_WScanner, scanner).empty()) return Redraw::kOutOfView;
  return std::nullopt;
}

constexpr const char* kOrFewer = ", or lower clutter.min_others and clutter.max_others";

// Whether the number of other objects is random; otherwise all are in the scene.
bool DrawsOthers(const Options& options) {
  return options.arranger == kTouching || options.arranger == kSideBySide ||
         options.clutter.draw_others;
}

// Why there are too few objects; empty if there are enough.
std::string LackOfObjects(const Options& options) {
  const int others = DrawsOthers(options) ? options.clutter.max_others : 1;
  if (options.objects.size() > static_cast<std::size_t>(others)) return "";
  return fmt::format(
      "{} needs {} objects next to the target, but objects lists {} besides it; list more{}",
      options.arranger, others, options.objects.size() - 1, others > 1 ? kOrFewer : "");
}

bool IsAlwaysThere(const Options& options, const std::string& object) {
  return std::ranges::find(options.clutter.always, object) != options.clutter.always.end();
}

// scattered: the objects that may be drawn in addition to the target and those that are always
// there.
std::vector<std::string> ScatteredChoice(const Options& options, const std::string& target) {
  std::vector<std::string> choice;
  AddOnce(options.clutter.others.empty() ? options.objects : options.clutter.others, choice);
  std::erase_if(choice, [&](const std::string& name) {
    return name == target || IsAlwaysThere(options, name);
  });
  return choice;
}

// scattered: why there are too few objects; empty if there are enough.
std::string LackOfScattered(const Options& options) {
  const int others = options.clutter.max_others;
  for (const std::string& target : options.objects) {
    const std::size_t count = ScatteredChoice(options, target).size();
    if (count >= static_cast<std::size_t>(others)) continue;
    return fmt::format(
        "{} needs {} objects, but clutter.others (default: objects) lists {} besides {} and "
        "clutter.always; list more{}",
        options.arranger, others, count, target, kOrFewer);
  }
  return "";
}

class WorldArranger : public Arranger {
 protected:
  WorldArranger(const Options& options, const robot::Robot& robot,
                const sensing::LineScannerOptions& scanner)
      : options_(options), robot_(robot), scanner_(scanner) {}

  // Keeps a random number of them, in random order.
  void DrawSome(std::vector<std::string>& others, base::Rng& rng) const {
    const ClutterOptions& clutter = options_.clutter;
    const auto range = static_cast<std::size_t>(clutter.max_others - clutter.min_others + 1);
    const std::size_t count = static_cast<std::size_t>(clutter.min_others) + rng.Index(range);
    Shuffle(others, rng);
    others.resize(count);
  }

  // The target first, then the other objects: all, or a random number of them.
  sim::World WorldWithOthers(const std::string& target, bool all, base::Rng& rng) const {
    std::vector<std::string> names = options_.objects;
    std::erase(names, target);
    if (!all) DrawSome(names, rng);
    names.insert(names.begin(), target);
    return WorldOf(options_, names);
  }

  bool AllInView(const sim::World& world) const {
    return OutOfView(world, robot_.X_WScanner, scanner_).empty();
  }

  const Options& options_;
  const robot::Robot& robot_;
  const sensing::LineScannerOptions& scanner_;
};

// Maximum number of draws until an arrangement rests in view. None of the 120 trials of
// laser_single needs a second one (seed 1). A scene in which all draws fail is out of the sensor's
// view.
constexpr int kMaxDraws = 50;

class SingleArranger : public WorldArranger {
 public:
  SingleArranger(const Options& options, const robot::Robot& robot,
                 const sensing::LineScannerOptions& scanner)
      : WorldArranger(options, robot, scanner), resting_(options, robot, options.objects) {}

  std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                     Redraws& redraws) const override {
    Arrangement trial{WorldOf(options_, {target})};
    trial.world.SetArm(robot_.home);
    for (int draw = 0; draw < kMaxDraws; ++draw) {
      const auto wrong = DropAndPutDown(rng, trial);
      if (!wrong) return trial;
      ++redraws[*wrong];
    }
    return std::nullopt;
  }
  int MaxObjects() const override { return 1; }

 private:
  // @return nullopt if it rests where it was put down, on the face of its drop and in view.
  std::optional<Redraw> DropAndPutDown(base::Rng& rng, Arrangement& trial) const {
    const auto rest = resting_.Drop(trial.world, trial.target, rng);
    if (!rest) return Redraw::kOtherPose;
    trial.pose_class = rest->pose->label;
    const base::Pose X_WO =
        resting_.PutDown(*rest->face, robot_.workspace_radius_m, trial.world, trial.target, rng);
    if (!trial.world.Settle()) return Redraw::kNotAtRest;
    if (!Resting::IsAsPutDown(X_WO, trial.world, trial.target)) return Redraw::kOtherPose;
    if (!AllInView(trial.world)) return Redraw::kOutOfView;
    return std::nullopt;
  }

  Resting resting_;
};

// Maximum number of places that are tried for one object among those already put down.
constexpr int kMaxPlaces = 100;
// Maximum number of drops of an object that should lie but comes to stand.
constexpr int kMaxDrops = 20;

class ScatteredArranger : public WorldArranger {
 public:
  ScatteredArranger(const Options& options, const robot::Robot& robot,
                    const sensing::LineScannerOptions& scanner)
      : WorldArranger(options, robot, scanner),
        clutter_(options.clutter),
        resting_(options, robot, AllObjects(options)) {}

  std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                     Redraws& redraws) const override {
    Arrangement trial{WorldWith(target, rng)};
    trial.world.SetArm(robot_.home);
    for (int draw = 0; draw < clutter_.max_draws; ++draw) {
      const auto wrong = PutDownAll(rng, trial);
      if (!wrong) return trial;
      ++redraws[*wrong];
    }
    return std::nullopt;
  }
  int MaxObjects() const override {
    return 1 + static_cast<int>(clutter_.always.size()) + clutter_.max_others;
  }

 private:
  /// The target first, then the objects that are always there, then others.
  sim::World WorldWith(const std::string& target, base::Rng& rng) const {
    std::vector<std::string> names{target};
    AddOnce(clutter_.always, names);
    std::vector<std::string> others = ScatteredChoice(options_, target);
    DrawSome(others, rng);
    AddOnce(others, names);
    return WorldOf(options_, names);
  }

  /// @return why the arrangement must be redrawn, if it must.
  std::optional<Redraw> PutDownAll(base::Rng& rng, Arrangement& trial) const {
    sim::World& world = trial.world;
    for (const int object : Numbers(world)) world.ParkObject(object);
    std::vector<sim::AtRest> rests;
    for (const int object : Numbers(world)) {
      const auto rest = PoseFor(world, object, rng);
      if (!rest) return Redraw::kOtherPose;
      rests.push_back(*rest);
    }
    std::vector<base::Pose> poses_W;
    for (const int object : Numbers(world)) {
      const auto X_WO =
          PlaceBeside(*rests[static_cast<std::size_t>(object)].face, object, rng, world);
      if (!X_WO) return Redraw::kDoesNotFit;
      poses_W.push_back(*X_WO);
    }
    if (!world.Settle(clutter_.settle_limit_s)) return Redraw::kNotAtRest;
    for (const int object : Numbers(world)) {
      const base::Pose& X_WO = poses_W[static_cast<std::size_t>(object)];
      if (!Resting::IsAsPutDown(X_WO, world, object)) return Redraw::kOtherPose;
      if (world.RobotDistance(object, kTouch_m) < kTouch_m) {
        return Redraw::kTouchesArm;
      }
    }
    if (!AllInView(world)) return Redraw::kOutOfView;
    trial.pose_class = rests.front().pose->label;
    trial.touching = Touching(world);
    return std::nullopt;
  }

  /// @return nullopt if no permitted pose was found.
  std::optional<sim::AtRest> PoseFor(sim::World& world, int object, base::Rng& rng) const {
    const auto& share = clutter_.standing_share;
    const bool chosen = share && !options_.as_drawn && MayBeTarget(world, object);
    if (chosen && rng.Uniform(0.0, 1.0) < *share) {
      return resting_.Standing(world.object_name(object), rng);
    }
    for (int drop = 0; drop < kMaxDrops; ++drop) {
      const auto rest = resting_.ComeToRest(world, object, rng);
      world.ParkObject(object);
      if (!rest || !chosen || !Resting::Stands(*rest->face)) return rest;
    }
    return std::nullopt;
  }

  bool MayBeTarget(const sim::World& world, int object) const {
    return object == 0 || IsAlwaysThere(options_, world.object_name(object));
  }

  /// A place where it does not penetrate the objects before it. It may touch them.
  std::optional<base::Pose> PlaceBeside(const sim::RestingFace& face, int object, base::Rng& rng,
                                        sim::World& world) const {
    const auto is_outside = [&](int other) {
      return world.ObjectDistance(object, other, 0.0) >= 0.0;
    };
    for (int place = 0; place < kMaxPlaces; ++place) {
      const base::Pose X_WO = resting_.PutDown(face, RadiusFor(world, object), world, object, rng);
      if (std::ranges::all_of(std::views::iota(0, object), is_outside)) return X_WO;
    }
    return std::nullopt;
  }

  /// An object that may be a target must lie within reach of the arm.
  double RadiusFor(const sim::World& world, int object) const {
    return MayBeTarget(world, object)
               ? robot_.workspace_radius_m
               : std::max(robot_.workspace_radius_m, clutter_.scatter_radius_m);
  }

  const ClutterOptions& clutter_;
  Resting resting_;
};

// Maximum number of drops until an object lies in a stable pose and lower than the target.
constexpr int kMaxLowerDrops = 5;
// Start distance of a slide. It is free of contact: the longest object (0.3 m) may have another one
// next to it.
constexpr double kSlide_m = 0.7;
// An object that slides up to others stops within this share of kTouch_m.
constexpr double kSlideShare = 0.1;
// Maximum number of steps of a slide. Each step is as long as the distance known to be free.
constexpr int kMaxSlideSteps = 500;

class SideBySideArranger : public WorldArranger {
 public:
  SideBySideArranger(const Options& options, const robot::Robot& robot,
                     const sensing::LineScannerOptions& scanner)
      : WorldArranger(options, robot, scanner), resting_(options, robot, options.objects) {}

  std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                     Redraws& redraws) const override {
    for (int draw = 0; draw < options_.clutter.max_draws; ++draw) {
      Arrangement trial{WorldWithOthers(target, /*all=*/false, rng)};
      trial.world.SetArm(robot_.home);
      const auto wrong = PutTogether(rng, trial);
      if (!wrong) return trial;
      ++redraws[*wrong];
    }
    return std::nullopt;
  }
  int MaxObjects() const override { return 1 + options_.clutter.max_others; }

 private:
  // @return why the arrangement must be redrawn, if it must.
  std::optional<Redraw> PutTogether(base::Rng& rng, Arrangement& trial) const {
    sim::World& world = trial.world;
    std::vector<base::Pose> alone_W;  // how each comes to rest when it is alone on the table
    double max_top_m = std::numeric_limits<double>::infinity();
    for (const int object : Numbers(world)) {
      const auto rest = DropLower(object, max_top_m, world, rng);
      if (!rest) return object == 0 ? Redraw::kOtherPose : Redraw::kNotHighest;
      if (object == 0) {
        trial.pose_class = rest->pose->label;
        max_top_m = world.ObjectTop(object);
      }
      alone_W.push_back(world.ObjectPose(object));
      world.ParkObject(object);
    }
    const Eigen::Vector3d place_W =
        PlaceInDisc(robot_.X_WWorkspace, robot_.workspace_radius_m, rng);
    for (const int object : Numbers(world)) {
      world.PlaceObject(object, alone_W[static_cast<std::size_t>(object)]);
      if (object == 0) {
        MoveTo(place_W, object, world);
      } else if (!SlideTo(place_W, object, rng, world)) {
        return Redraw::kDoesNotFit;
      }
    }
    if (const auto wrong = Settle(alone_W, world)) return wrong;
    trial.touching = Touching(world);
    return WrongAmongOthers(options_, robot_, scanner_, world);
  }

  // @return nullopt, and the object is parked, if no drop ends in a stable pose lower than
  // max_top_m.
  std::optional<sim::AtRest> DropLower(int object, double max_top_m, sim::World& world,
                                       base::Rng& rng) const {
    for (int drop = 0; drop < kMaxLowerDrops; ++drop) {
      const auto rest = resting_.ComeToRest(world, object, rng);
      if (rest && world.ObjectTop(object) < max_top_m) return rest;
      world.ParkObject(object);
    }
    return std::nullopt;
  }

  // Moves its center of mass over the place, without rotation.
  static void MoveTo(const Eigen::Vector3d& place_W, int object, sim::World& world) {
    base::Pose X_WO = world.ObjectPose(object);
    X_WO.translation().head<2>() += (place_W - world.ObjectCenterOfMass(object)).head<2>();
    world.PlaceObject(object, X_WO);
  }

  // Slides the object from a random side towards the target until it touches another object.
  bool SlideTo(const Eigen::Vector3d& target_W, int object, base::Rng& rng,
               sim::World& world) const {
    const double side = rng.Uniform(0.0, 2.0 * base::kPi);
    const Eigen::Vector3d from(std::cos(side), std::sin(side), 0.0);
    const double gap_m = kSlideShare * kTouch_m;
    double away_m = kSlide_m;
    for (int step = 0; step < kMaxSlideSteps && away_m > 0.0; ++step) {
      MoveTo(target_W + away_m * from, object, world);
      double free_m = kSlide_m;
      for (int other = 0; other < object; ++other) {
        free_m = std::min(free_m, world.ObjectDistance(object, other, kSlide_m));
      }
      if (free_m < gap_m) return true;
      away_m -= free_m - 0.5 * gap_m;
    }
    return false;
  }

  std::optional<Redraw> Settle(const std::vector<base::Pose>& alone_W, sim::World& world) const {
    const ClutterOptions& clutter = options_.clutter;
    if (!world.Settle(clutter.settle_limit_s, clutter.rest_speed_m_s, kRestTime_s)) {
      return Redraw::kNotAtRest;
    }
    for (const int object : Numbers(world)) {
      const base::Pose& X_WO = alone_W[static_cast<std::size_t>(object)];
      if (!Resting::IsAsPutDown(X_WO, world, object)) return Redraw::kOtherPose;
    }
    return std::nullopt;
  }

  Resting resting_;
};

// Maximum number of rotations that are tried until an object fits between the box's walls.
constexpr int kMaxTurns = 50;
// Interval at which a falling target is checked: it falls 30 mm in 80 ms.
constexpr double kLook_s = 0.1;
// touching: radius of the disc over which objects are dropped, an area two hands wide.
constexpr double kTouchingRadius_m = 0.06;
constexpr double kMouthRadius_m = 0.08;  // of the bag of a pile
// Height of a hand, or of the bag's mouth above the pile, from which objects are dropped.
constexpr double kHeapDrop_m = 0.03;
// Time between the drops of two objects. By then the first one has left its place.
constexpr double kInterval_s = 0.15;
// Maximum number of times that objects which roll off are put back in one heap.
constexpr std::size_t kMaxPutBack = 12;
// Maximum number of drops of the target onto the same heap.
constexpr int kTargetDrops = 8;

// Makes one arrangement of dropped objects.
class Heap {
 public:
  Heap(const Options& options, const robot::Robot& robot,
       const sensing::LineScannerOptions& scanner, sim::World& world)
      : options_(options),
        clutter_(options.clutter),
        robot_(robot),
        scanner_(scanner),
        world_(world),
        container_(world.container()) {}

  // Drops all objects except the target (object 0). @return why they must be redrawn, if they must.
  std::optional<Redraw> DropOthers(base::Rng& rng) {
    for (const int object : Numbers(world_)) world_.ParkObject(object);
    world_.SetArm(robot_.home);
    center_W_ = PlaceInDisc(robot_.X_WWorkspace, CenterRadius(), rng);
    const auto others = Others();
    std::vector<int> order(others.begin(), others.end());
    Shuffle(order, rng);
    world_.StepCoarsely(true);
    return DropAll(std::move(order), rng);
  }

  // Drops the target onto the others. @return why it must be redrawn, if it must.
  std::optional<Redraw> DropTarget(base::Rng& rng) {
    world_.StepCoarsely(true);
    center_W_ = MiddleOfOthers();
    if (!LetGo(kTarget, rng)) return Redraw::kDoesNotFit;
    if (const auto wrong = SettleTarget()) return wrong;
    world_.StepCoarsely(false);
    if (const auto wrong = Settle()) return wrong;
    return WrongAmongOthers(options_, robot_, scanner_, world_);
  }

  static constexpr int kTarget = 0;

 private:
  std::ranges::iota_view<int, int> Others() const { return {kTarget + 1, world_.objects()}; }

  // The bag and the box are at the center; a few objects lie anywhere within reach.
  double CenterRadius() const {
    if (options_.arranger != kTouching) return 0.0;
    return std::max(0.0, robot_.workspace_radius_m - kTouchingRadius_m);
  }

  // Places the object above those below it, with a random rotation and at rest. False if it does
  // not fit into the box.
  bool LetGo(int object, base::Rng& rng) {
    for (int turn = 0; turn < kMaxTurns; ++turn) {
      const Eigen::Matrix3d R_WO = RandomRotation(rng).toRotationMatrix();
      world_.PlaceObject(object, base::MakePose(R_WO, robot_.X_WWorkspace.translation()));
      const Eigen::AlignedBox3d bounds = world_.ObjectBounds(object);
      const auto middle_W = MiddleFor(bounds.sizes(), rng);
      if (!middle_W) continue;
      Eigen::Vector3d shift = *middle_W - bounds.center();
      shift.z() = 0.0;
      const Eigen::AlignedBox3d there = bounds.translated(shift);
      shift.z() = TopBelow(object, there) + kHeapDrop_m - there.min().z();
      world_.PlaceObject(object, base::MakePose(R_WO, robot_.X_WWorkspace.translation() + shift));
      return true;
    }
    world_.ParkObject(object);
    return false;
  }

  // Center from which an object of this size is dropped; nullopt if it does not fit.
  std::optional<Eigen::Vector3d> MiddleFor(const Eigen::Vector3d& size, base::Rng& rng) const {
    if (!container_) {
      const double radius = options_.arranger == kTouching ? kTouchingRadius_m : kMouthRadius_m;
      const base::Pose X_WC = base::MakePose(robot_.X_WWorkspace.linear(), center_W_);
      return PlaceInDisc(X_WC, radius, rng);
    }
    // The box is aligned with W in all scenes so far. In a rotated box less space would be used.
    const Eigen::Vector2d room = container_->half_m.head<2>() - 0.5 * size.head<2>();
    if (room.minCoeff() < 0.0) return std::nullopt;
    const double x = rng.Uniform(-room.x(), room.x());
    const double y = rng.Uniform(-room.y(), room.y());
    return container_->X_WI * Eigen::Vector3d(x, y, 0.0);
  }

  // Mean center of mass of the others, onto which the target falls.
  Eigen::Vector3d MiddleOfOthers() const {
    Eigen::Vector3d sum_W = Eigen::Vector3d::Zero();
    for (const int other : Others()) sum_W += world_.ObjectCenterOfMass(other);
    return sum_W / (world_.objects() - 1);
  }

  // Highest point of the table, box or objects below an object with these bounds.
  double TopBelow(int object, const Eigen::AlignedBox3d& bounds) const {
    double top = robot_.X_WWorkspace.translation().z();
    if (container_) top = container_->X_WI.translation().z() - container_->half_m.z();
    for (const int other : Numbers(world_)) {
      if (other == object || world_.parked(other)) continue;
      const Eigen::AlignedBox3d other_bounds = world_.ObjectBounds(other);
      const bool below =
          (other_bounds.min().head<2>().array() <= bounds.max().head<2>().array()).all() &&
          (other_bounds.max().head<2>().array() >= bounds.min().head<2>().array()).all();
      if (below) top = std::max(top, other_bounds.max().z());
    }
    return top;
  }

  // Drops the objects of the queue. An object that rolls away is dropped again.
  std::optional<Redraw> DropAll(std::vector<int> queue, base::Rng& rng) {
    const std::size_t max_drops = kMaxPutBack + queue.size();
    for (std::size_t next = 0; next < queue.size(); ++next) {
      if (next >= max_drops) return Redraw::kLeftTable;
      if (!LetGo(queue[next], rng)) return Redraw::kDoesNotFit;
      const double end_s = world_.time_s() + kInterval_s;
      while (world_.time_s() < end_s) world_.Step();
      TakeAway(queue);
      if (next + 1 < queue.size()) continue;
      if (Settle() == Redraw::kNotAtRest) return Redraw::kNotAtRest;
      TakeAway(queue);
      for (const int unseen : OutOfView(world_, robot_.X_WScanner, scanner_)) {
        PutBack(unseen, queue);
      }
    }
    return std::nullopt;
  }

  void PutBack(int object, std::vector<int>& queue) {
    world_.ParkObject(object);
    queue.push_back(object);
  }

  // Parks the objects that left the heap's area and appends them to the queue.
  void TakeAway(std::vector<int>& queue) {
    for (const int object : Others()) {
      if (!world_.parked(object) && Lost(object)) PutBack(object, queue);
    }
  }

  // Settles like Settle(), but stops as soon as the target is no longer the highest. This makes a
  // failed drop cheap: a target that has fallen lower hardly ever rises again.
  std::optional<Redraw> SettleTarget() {
    const double end_s = world_.time_s() + clutter_.settle_limit_s;
    double rested_s = 0.0;
    while (world_.time_s() < end_s) {
      const bool rests = world_.Settle(kLook_s, clutter_.rest_speed_m_s, kLook_s);
      rested_s = rests ? rested_s + kLook_s : 0.0;
      if (rested_s >= kRestTime_s) {
        return AnyLost() ? std::optional(Redraw::kLeftTable) : std::nullopt;
      }
      if (Lost(kTarget)) return Redraw::kLeftTable;
      if (world_.ObjectTop(kTarget) + kTouch_m < OthersTop(world_)) {
        return Redraw::kNotHighest;
      }
    }
    return Redraw::kNotAtRest;
  }

  // Simulates until all objects are at rest or one has left the heap's area.
  std::optional<Redraw> Settle() {
    const double end_s = world_.time_s() + clutter_.settle_limit_s;
    while (world_.time_s() < end_s) {
      const bool rests = world_.Settle(2.0 * kRestTime_s, clutter_.rest_speed_m_s, kRestTime_s);
      if (AnyLost()) return Redraw::kLeftTable;
      if (rests) return std::nullopt;
    }
    return Redraw::kNotAtRest;
  }

  bool AnyLost() const {
    return std::ranges::any_of(Numbers(world_),
                               [&](int object) { return !world_.parked(object) && Lost(object); });
  }

  bool Lost(int object) const {
    const Eigen::Vector3d center_W = world_.ObjectCenterOfMass(object);
    if (!container_) return !OverWorkspace(robot_, center_W, options_.workspace_margin_m);
    const Eigen::Vector3d center_I = container_->X_WI.inverse() * center_W;
    return (center_I.head<2>().cwiseAbs().array() > container_->half_m.head<2>().array()).any();
  }

  const Options& options_;
  const ClutterOptions& clutter_;
  const robot::Robot& robot_;
  const sensing::LineScannerOptions& scanner_;
  sim::World& world_;
  std::optional<sim::Container> container_;
  Eigen::Vector3d center_W_ = Eigen::Vector3d::Zero();
};

class ClutterArranger : public WorldArranger {
 public:
  ClutterArranger(const Options& options, const robot::Robot& robot,
                  const sensing::LineScannerOptions& scanner)
      : WorldArranger(options, robot, scanner) {
    for (const std::string& object : options.objects) {
      resting_poses_[object] =
          sim::StableRestingPoses(ObjectModelOf(options, object), options.min_tipping_rad);
    }
  }

  std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                     Redraws& redraws) const override {
    const bool all = !DrawsOthers(options_);
    Arrangement trial{WorldWithOthers(target, all, rng)};
    Heap heap(options_, robot_, scanner_, trial.world);
    for (int draw = 0; draw < options_.clutter.max_draws; ++draw) {
      // Draws other objects, too: among some objects the target can hardly be the highest.
      if (draw > 0 && !all) trial.world = WorldWithOthers(target, all, rng);
      if (const auto wrong = heap.DropOthers(rng)) {
        ++redraws[*wrong];
        continue;
      }
      const auto others = trial.world.Save();
      for (int drop = 0; drop < kTargetDrops; ++drop) {
        if (drop > 0) trial.world.Restore(*others);
        if (const auto wrong = heap.DropTarget(rng)) {
          ++redraws[*wrong];
          continue;
        }
        const auto rest = sim::FaceAtRest(resting_poses_.at(target),
                                          trial.world.ObjectPose(Heap::kTarget).linear());
        trial.pose_class = rest ? rest->pose->label : "leaning";
        trial.touching = Touching(trial.world);
        return trial;
      }
    }
    return std::nullopt;
  }
  int MaxObjects() const override {
    return DrawsOthers(options_) ? 1 + options_.clutter.max_others
                                 : static_cast<int>(options_.objects.size());
  }

 private:
  std::map<std::string, std::vector<sim::RestingPose>> resting_poses_;
};

// A key of `clutter` and the arrangements that read it.
struct ClutterKey {
  const char* name;
  std::vector<const char*> readers;
  bool counts_others = false;  ///< also read by those that draw the number of others
};

// All but box_wall_mm, which belongs to the scene.
const std::vector<ClutterKey>& ClutterKeys() {
  static const std::vector<const char*> kJudged = {kTouching, kSideBySide, kBox, kPile};
  static const std::vector<const char*> kAll = {kScattered, kTouching, kSideBySide, kBox, kPile};
  static const std::vector<const char*> kCounting = {kScattered, kTouching, kSideBySide};
  static const std::vector<ClutterKey> kKeys = {
      {"always", {kScattered}},         {"others", {kScattered}},
      {"standing_share", {kScattered}}, {"scatter_radius_mm", {kScattered}},
      {"min_others", kCounting, true},  {"max_others", kCounting, true},
      {"draw_others", {kBox, kPile}},   {"max_draws", kAll},
      {"settle_limit_s", kAll},         {"rest_speed_mm_s", kJudged}};
  return kKeys;
}

// Whatever the arrangement: the walls are those of the scene.
void CheckWalls(const base::YamlMap& map, const Options& options) {
  if (!options.physics.box_wall_m) return;
  try {
    WorldOf(options, {});
  } catch (const base::InputError& error) {
    map.Inner("clutter").Fail("box_wall_mm", error.what());
  }
}

}  // namespace

int Total(const Redraws& redraws) {
  int total = 0;
  for (const auto& [reason, count] : redraws) total += count;
  return total;
}

std::string Text(const Redraws& redraws) {
  std::vector<std::string> counts;
  for (const auto& [reason, count] : redraws) {
    counts.push_back(fmt::format("{} x{}", base::Word(reason), count));
  }
  return base::Join(counts);
}

sim::World WorldOf(const Options& options, const std::vector<std::string>& objects) {
  std::vector<sim::ObjectModel> models;
  for (const std::string& object : objects) models.push_back(ObjectModelOf(options, object));
  return sim::World(options.scene, models, options.physics);
}

void CheckArrangement(const base::YamlMap& map, const Options& options) {
  CheckWalls(map, options);
  const std::string& kind = options.arranger;
  if (kind == kSingle) return;
  const auto lack = kind == kScattered ? LackOfScattered(options) : LackOfObjects(options);
  if (!lack.empty()) map.Fail("arrangement", lack);
  if (kind == kTouching && options.clutter.max_others < kMinTouching) {
    map.Inner("clutter").Fail(
        "max_others",
        fmt::format("must be at least {}: the target must touch that many objects", kMinTouching));
  }
  if (kind == kBox && !WorldOf(options, {}).container()) {
    map.Fail("arrangement", options.scene.string() +
                                " has no box; box needs a scene such as scenes/tabletop_box.xml "
                                "(marked by a box-shaped site \"container\" that fills its "
                                "interior)");
  }
}

std::vector<base::Finding> IgnoredKeys(const base::YamlMap& map, const Options& options) {
  std::vector<base::Finding> ignored;
  for (const ClutterKey& key : ClutterKeys()) {
    const auto place = map.Inner("clutter").PlaceOf(key.name);
    const bool read = std::ranges::find(key.readers, options.arranger) != key.readers.end() ||
                      (key.counts_others && DrawsOthers(options));
    if (!place || read) continue;
    ignored.push_back(
        {.error = false,
         .where = *place,
         .element = std::string("key 'clutter.") + key.name + "'",
         .what = "has no effect with `arrangement: " + options.arranger + "`",
         .cure =
             fmt::format("remove it, or set `arrangement` to {}{}", fmt::join(key.readers, " or "),
                         key.counts_others ? "; box and pile need draw_others: true" : "")});
  }
  return ignored;
}

std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner) {
  const std::string& kind = options.arranger;
  if (kind == kSingle) return std::make_unique<SingleArranger>(options, robot, scanner);
  if (kind == kScattered) return std::make_unique<ScatteredArranger>(options, robot, scanner);
  if (kind == kSideBySide) return std::make_unique<SideBySideArranger>(options, robot, scanner);
  return std::make_unique<ClutterArranger>(options, robot, scanner);
}

}  // namespace rangegrasp::trial
