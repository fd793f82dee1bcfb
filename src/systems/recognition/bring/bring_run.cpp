#include "recognition/bring/bring_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "base/words.h"
#include "geometry/mesh.h"
#include "grasp/obstacles.h"
#include "grasp/score_model.h"
#include "perception/perceive.h"
#include "recognition/views/wrist_scanner.h"
#include "sim/bodies.h"

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;
using grasp::Grasp;
using grasp::NamedGrasps;
using trial::Attempt;
using trial::Outcome;
using trial::Sensed;

/// A smaller force does not count as a touch.
constexpr double kTouch_N = 0.05;
/// Failed grasps at one place after which an object that is only in the way is left. What slips
/// needs more friction than there is: of 45 repeated grasps of prisms that had slipped, 1 held.
constexpr int kTriesToClear = 2;
/// Objects whose centers are this close in two views count as the same.
constexpr double kSamePlace_m = 0.03;
/// Objects this near to the wanted one may be in the way.
constexpr double kNear_m = 0.08;

/// Accepts the best of all known objects even if its identity is uncertain.
recognition::RecognitionOptions Lenient(recognition::RecognitionOptions options) {
  options.margin = 0.005;
  options.max_violations = 0.12;
  options.max_rms = 0.35;
  options.max_hugging = 0.2;
  options.min_share_seen = 0.2;
  return options;
}

/// Numbers of failed tries, by the object's place.
class TriesByPlace {
 public:
  int At(const Vector3d& center_W) {
    const auto found = Find(center_W);
    return found == tries_.end() ? 0 : found->second;
  }
  void Add(const Vector3d& center_W) {
    auto found = Find(center_W);
    if (found == tries_.end()) found = tries_.insert(found, {center_W, 0});
    ++found->second;
  }
  void Clear() { tries_.clear(); }

 private:
  std::vector<std::pair<Vector3d, int>>::iterator Find(const Vector3d& center_W) {
    return std::ranges::find_if(
        tries_, [&](const auto& one) { return (one.first - center_W).norm() <= kSamePlace_m; });
  }
  std::vector<std::pair<Vector3d, int>> tries_;
};

class Run {
 public:
  Run(const Setup& setup, std::string wanted, std::optional<int> target, std::uint64_t seed,
      sim::World& world, trial::Recorder& recorder)
      : setup_(setup),
        options_(setup.options),
        wanted_(std::move(wanted)),
        target_(target),
        seed_(seed),
        world_(world),
        recorder_(recorder) {
    const trial::Options& cell = setup.cell.options;
    const auto wrist = trial::Of<views::WristViewOptions>(cell, views::kWristViews);
    if (!wrist.sensor.empty() && options_.max_looks > 1) {
      wrist_.emplace(cell, setup.cell.robot, seed);
    }
    if (const auto score = grasp::ScoreModelOf(cell); !score.empty()) score_.emplace(score);
  }

  Bring Go() {
    Say("I am to bring the {}.", Title(wanted_));
    std::optional<Said> said;
    while (!said && !broken_) said = Next();
    result_.said = broken_ ? Said::kBroken : *said;
    return std::move(result_);
  }

 private:
  // A look, and an attempt if there is something to grasp. @return the run's result, if it ends
  std::optional<Said> Next() {
    Look();
    if (broken_) return std::nullopt;
    if (const auto seen = known_.Find(wanted_)) return BringIt(*seen);
    if (known_.scene.objects.empty() && looks_here_ > 1) return NotThere();
    if (looks_here_ < options_.max_looks && !exhausted_) {
      Say("I do not see the {}. I look again.", Title(wanted_));
      return std::nullopt;
    }
    if (!MayHide()) return NotThere();
    if (const auto seen = FindDoubtful()) {
      Say("I am not sure, but this may be the {}.", Title(wanted_));
      return BringIt(*seen);
    }
    if (ClearAway(TopmostFirst())) return std::nullopt;
    return NotThere();
  }

  Said NotThere() {
    Say("I have looked everywhere I can. There is no {} here.", Title(wanted_));
    return Said::kNotThere;
  }

  // Whether an unknown object may be the wanted one, or unseen space may contain it.
  bool MayHide() const {
    const bool all_known =
        std::ranges::all_of(known_.found, [](const auto& found) { return found.has_value(); });
    const robot::Robot& robot = setup_.cell.robot;
    return !all_known ||
           HidingArea(sensed_.observation, known_, setup_.library, robot.X_WWorkspace.translation(),
                      robot.workspace_radius_m) >= SmallestFootprint(setup_.library.Find(wanted_));
  }

  // An unknown object may be the wanted one: check this before it is put aside.
  std::optional<std::size_t> FindDoubtful() {
    perception::Scene unknown = known_.scene;
    unknown.objects.clear();
    for (std::size_t i = 0; i < known_.found.size(); ++i) {
      if (!known_.found[i]) unknown.objects.push_back(known_.scene.objects[i]);
    }
    base::Stopwatch watch;
    const auto found = recognition::Recognize(sensed_.observation, unknown, setup_.library,
                                              Lenient(options_.recognition));
    result_.look_s += watch.Seconds();
    const auto wanted = std::ranges::find(found, wanted_, &recognition::FoundObject::object);
    if (wanted == found.end()) return std::nullopt;
    PutKnown(*wanted, setup_.library.Find(wanted_).mesh_B, known_);
    return known_.Find(wanted_);
  }

  std::optional<Said> BringIt(std::size_t seen) {
    if (tries_ >= options_.max_tries) {
      Say("I have tried {}. I cannot take the {}.", base::Counted(tries_, "time"), Title(wanted_));
      return Said::kCannot;
    }
    const Attempt& attempt = TryAt(seen, true);
    if (broken_) return std::nullopt;
    if (attempt.log && attempt.log->hand_over) {
      Say("Here you are: the {}.", Title(wanted_));
      return Said::kHereYouAre;
    }
    if (attempt.log) {
      ++tries_;
      idle_ = 0;
      Say("It has slipped out of my hand. I look again.");
      AfterGrasp();
      return std::nullopt;
    }
    // Another viewpoint rarely reveals a motion (1 of 45 times in piles), but a clearer table does.
    if (ClearAway(NearTo(known_.scene.objects[seen]))) return std::nullopt;
    if (++idle_ < options_.max_looks) {
      LookForAWay();
      return std::nullopt;
    }
    Say("I see the {}, and cannot get at it.", Title(wanted_));
    return Said::kCannot;
  }

  // The table is unchanged. Another viewpoint may reveal more of it.
  void LookForAWay() {
    blocked_.Clear();
    const bool another = wrist_ && looks_here_ < options_.max_looks && !exhausted_;
    Say("I see no way to take the {}. I look {}.", Title(wanted_),
        another ? "from another side" : "again");
    if (!another) GoHome();
  }

  // Puts aside the first object that can be grasped; objects that slipped come last.
  // @return false if none can be grasped
  bool ClearAway(std::vector<std::size_t> order) {
    std::ranges::stable_sort(order, std::less{}, [&](std::size_t object) {
      return failed_.At(known_.scene.objects[object].center_C);
    });
    const int max = kTriesToClear * static_cast<int>(setup_.cell.options.objects.size());
    for (const std::size_t object : order) {
      const Vector3d center_W = known_.scene.objects[object].center_C;
      if (failed_.At(center_W) >= kTriesToClear || blocked_.At(center_W) > 0) continue;
      if (clear_tries_ >= max) return false;
      Say("I put {} aside.", NameOf(object));
      const Attempt& attempt = TryAt(object, false);
      if (broken_) return true;
      if (!attempt.log) {
        blocked_.Add(center_W);
        continue;
      }
      ++clear_tries_;
      const bool felt = attempt.log->aperture.feels_object_after_carry;
      if (!felt) failed_.Add(center_W);
      result_.cleared += felt;
      idle_ = 0;
      AfterGrasp();
      return true;
    }
    return false;
  }

  // One object, put first in the scene, with its grasps, as a detector returns them: its named ones
  // for the use, if it is known, then chapter 5's, first those that leave keep-free parts free.
  // @param use  intended use; empty: any
  trial::Detected GraspsFor(std::size_t object, const std::string& use) const {
    const trial::Options& options = setup_.cell.options;
    const robot::Robot& robot = setup_.cell.robot;
    perception::Scene scene = known_.scene;
    const auto at = scene.objects.begin() + static_cast<std::ptrdiff_t>(object);
    std::rotate(scene.objects.begin(), at, at + 1);
    const auto obstacles =
        grasp::ObstaclesOfViews(scene, 0, sensed_.observation, options.obstacles);
    auto grasps = grasp::PlanGrasps(scene, 0, robot.hand(), grasp::Arm(robot), options.grasp,
                                    obstacles.measured_C);
    if (score_) score_->Rank(sensed_.observation, scene, 0, robot.hand(), grasps);
    std::vector<std::string> names;
    if (const auto& found = known_.found[object]) {
      const NamedGrasps& known = setup_.grasps.at(found->object);
      if (!known.keep_free_O.empty()) {
        std::ranges::stable_partition(grasps, [&](const Grasp& grasp) {
          return !grasp.collides &&
                 !grasp::TouchesKeptFree(grasp, known, found->X_CB, robot.hand());
        });
      }
      const auto poses_CB =
          recognition::EqualPoses(found->X_CB, setup_.library.Find(found->object).symmetry);
      const auto named = grasp::PlaceNamedGrasps(known, use, poses_CB, scene, 0, robot.hand(),
                                                 options.grasp, obstacles.measured_C);
      for (const grasp::PlacedGrasp& placed : named) {
        grasps.insert(grasps.begin() + static_cast<std::ptrdiff_t>(names.size()), placed.grasp);
        names.push_back(known.grasps[placed.named].name);
      }
    }
    trial::Detected detected;
    detected.segments = static_cast<int>(scene.segments.size());
    detected.kept = scene.cloud.size();
    detected.detection = grasp::DetectionFrom(scene, grasps);
    detected.detection.obstacles = obstacles;
    for (std::size_t i = 0; i < names.size(); ++i) detected.detection.grasps[i].name = names[i];
    return detected;
  }

  // Adds a step to the result. The run ends if the attempt or the physics engine failed.
  const Attempt& TryAt(std::size_t object, bool wanted) {
    const std::size_t number = result_.steps.size();
    recorder_.SetAttempt(static_cast<int>(number) + 1);
    Step& step = result_.steps.emplace_back();
    step.at_wanted = wanted;
    const auto& found = known_.found[object];
    if (found) step.taken_for = found->object;
    auto detected = GraspsFor(object, wanted ? options_.use : "");
    if (wanted) TriedLast(detected.detection);
    const trial::FixedDetector detector(std::move(detected));
    trial::AttemptOptions attempt;
    attempt.seed = base::DeriveSeed(base::DeriveSeed(seed_, "attempt"), std::uint64_t{number});
    attempt.sensed = &sensed_;
    attempt.q_start = world_.ArmPositions();
    attempt.detector = &detector;
    attempt.observer = Watching(step);
    if (wanted) {
      attempt.user = trial::UserOf(options_.hand_over, setup_.cell.robot, attempt.seed);
    }
    step.attempt = trial::RunAttempt(setup_.cell, world_, attempt);
    if (const auto* chosen = step.attempt.Grasp()) {
      step.grasp = chosen->name;
      if (wanted) {
        executed_W_.push_back(chosen->X_CH);
        step.asked_upright = found && grasp::IsUpright(setup_.grasps.at(found->object), found->X_CB,
                                                       known_.scene.table.plane.normal);
      }
    }
    broken_ = step.attempt.outcome == Outcome::kCrashed || !trial::IsFinite(world_);
    if (broken_) result_.detail = step.attempt.stage + ": " + step.attempt.detail;
    return step.attempt;
  }

  // Puts grasps similar to those that failed at the wanted object behind the others.
  void TriedLast(grasp::Detection& detection) const {
    std::ranges::stable_partition(detection.grasps, [&](const grasp::DetectedGrasp& grasp) {
      return std::ranges::none_of(executed_W_, [&](const base::Pose& tried) {
        return (tried.translation() - grasp.X_CH.translation()).norm() < kOtherGrasp_m;
      });
    });
  }

  // Ground truth: whether the hand presses on keep-free parts of the wanted object after lifting.
  sim::ExecutionObserver Watching(Step& step) const {
    sim::ExecutionObserver watching = recorder_.Observer();
    const auto show = watching.on_moment;
    watching.on_moment = [this, show, &step](const std::string& moment, sim::World& world) {
      if (moment == "lifted" && target_) step.touched_kept_free = PressesOnKeptFree(world);
      if (show) show(moment, world);
    };
    return watching;
  }

  bool PressesOnKeptFree(const sim::World& world) const {
    const base::Pose X_OW = world.ObjectPose(*target_).inverse();
    const auto& boxes_O = setup_.grasps.at(wanted_).keep_free_O;
    return std::ranges::any_of(
        sim::HandForces(world, kTouch_N), [&](const sim::ContactForce& contact) {
          return std::ranges::any_of(boxes_O, [&](const Eigen::AlignedBox3d& box_O) {
            return box_O.contains(X_OW * contact.point_W);
          });
        });
  }

  // An attendant removes the objects at the delivery place.
  void AfterGrasp() {
    GoHome();
    if (broken_) return;
    for (int object = 0; object < world_.objects(); ++object) {
      if (trial::IsAtDelivery(world_, object)) world_.ParkObject(object);
    }
    blocked_.Clear();
  }

  // All earlier views are outdated.
  void GoHome() {
    result_.homing_s += trial::GoHome(setup_.cell, world_);
    looks_here_ = 0;
    exhausted_ = false;
    broken_ = !trial::IsFinite(world_);
  }

  void Look() {
    base::Stopwatch watch;
    const auto number = static_cast<std::uint64_t>(++result_.looks);
    const std::uint64_t seed = base::DeriveSeed(base::DeriveSeed(seed_, "look"), number);
    if (looks_here_ == 0 || !wrist_) {
      sensed_ = trial::Look(setup_.cell, world_, seed);
    } else if (!LookFromTheWrist()) {
      exhausted_ = true;
    }
    ++looks_here_;
    broken_ = !trial::IsFinite(world_);
    if (broken_) return;
    base::Rng rng = trial::StageStream(seed, "perceive");
    const auto& options = setup_.cell.options;
    auto scene =
        perception::Perceive(sensed_.observation, options.perception, rng,
                             trial::WorkspaceOf(setup_.cell.robot, options.workspace_margin_m));
    if (looks_here_ == 1 || !wrist_) found_ = recognition::AsFirstSeen(std::move(found_));
    found_ = recognition::Recognize(sensed_.observation, scene, setup_.library,
                                    options_.recognition, recognition::SureOnes(found_));
    known_ = Understand(std::move(scene), found_, setup_.library);
    result_.look_s += watch.Seconds();
    Say("{}", WhatISee());
  }

  // Looks at the first unknown object, otherwise at the highest one. False: there is nothing new.
  bool LookFromTheWrist() {
    const auto unknown =
        std::ranges::find_if(known_.found, [](const auto& found) { return !found; });
    const auto& objects = known_.scene.objects;
    const auto region_W =
        unknown != known_.found.end()
            ? wrist_->RegionAbout(
                  objects[static_cast<std::size_t>(unknown - known_.found.begin())].center_C,
                  sensed_.observation)
            : wrist_->RegionOfHighest(sensed_.observation);
    if (!region_W) return false;
    Eigen::VectorXd q = world_.ArmPositions();
    const auto look = wrist_->AddBestView(*region_W, world_, q, sensed_);
    if (!look) return false;
    result_.moved_s += look->way_s;
    return look->arrived;
  }

  std::string WhatISee() const {
    std::vector<std::string> names;
    int unknown = 0;
    for (const auto& found : known_.found) {
      if (found) names.push_back("the " + Title(found->object));
      unknown += !found;
    }
    if (unknown > 0) {
      names.push_back((unknown == 1 ? "a thing" : fmt::format("{} things", unknown)) +
                      " that I do not know");
    }
    if (names.empty()) return "I look: the table is empty.";
    return "I look, and see " + base::Join(names) + ".";
  }

  std::vector<std::size_t> TopmostFirst() const {
    std::vector<std::size_t> order(known_.scene.objects.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    return order;
  }

  // Other objects near the wanted one, which may be in the way, topmost first.
  std::vector<std::size_t> NearTo(const perception::PerceivedObject& wanted) const {
    const auto box_C = geometry::BoundsOf(wanted.completed_C);
    auto near = TopmostFirst();
    std::erase_if(near, [&](std::size_t i) {
      const perception::PerceivedObject& other = known_.scene.objects[i];
      return &other == &wanted ||
             box_C.exteriorDistance(geometry::BoundsOf(other.completed_C)) > kNear_m;
    });
    return near;
  }

  std::string Title(const std::string& object) const { return setup_.library.Find(object).title; }
  std::string NameOf(std::size_t object) const {
    const auto& found = known_.found[object];
    return found ? "the " + Title(found->object) : "something that I do not know";
  }
  template <typename... T>
  void Say(fmt::format_string<T...> text, T&&... args) {
    result_.words.push_back(fmt::format(text, std::forward<T>(args)...));
  }

  /// Hands this far apart grasp in different ways: half of a fingertip's width.
  static constexpr double kOtherGrasp_m = 0.010;

  const Setup& setup_;
  const BringOptions& options_;
  const std::string wanted_;
  const std::optional<int> target_;  // ground truth
  const std::uint64_t seed_;
  sim::World& world_;
  trial::Recorder& recorder_;
  Bring result_;
  Sensed sensed_;
  std::vector<recognition::FoundObject> found_;  // in the looks at the current table
  Understanding known_;
  std::vector<base::Pose> executed_W_;        // hand poses of executed grasps of the wanted object
  TriesByPlace failed_;                       // executed grasps of others that failed
  TriesByPlace blocked_;                      // no grasp or motion on the current table
  std::optional<views::WristScanner> wrist_;  // if there is a sensor on the wrist
  std::optional<grasp::ScoreModel> score_;    // for chapter 5's grasps; absent: rules
  int looks_here_ = 0;                        // since the table changed
  bool exhausted_ = false;                    // no further look shows anything new
  bool broken_ = false;                       // the physics engine or an attempt failed
  int tries_ = 0;
  int clear_tries_ = 0;
  int idle_ = 0;  // failed attempts at the wanted object on the current table
};

/// The outcome of a run by ground truth (docs/known-objects.md).
std::string Judge(const Bring& run, std::optional<int> target, const sim::World& world) {
  switch (run.said) {
    case Said::kBroken: {
      const bool physics = !trial::IsFinite(world);
      return std::string(base::Word(physics ? Outcome::kInvalidPhysics : Outcome::kCrashed));
    }
    case Said::kNotThere:
      if (!target) return kSaidAbsent;
      return world.parked(*target) ? kClearedAway : kNotFound;
    case Said::kHereYouAre: {
      const Attempt& last = run.steps.back().attempt;
      const std::string word = trial::HandOverOutcome(last);
      const bool right = target && last.log->target == *target;
      return word == trial::kHandedOver && !right ? kWrongObject : word;
    }
    case Said::kCannot:
      break;
  }
  for (auto step = run.steps.rbegin(); step != run.steps.rend(); ++step) {
    if (step->at_wanted) return std::string(base::Word(step->attempt.outcome));
  }
  return kNotFound;
}

}  // namespace

Bring BringObject(const Setup& setup, const std::string& wanted, std::optional<int> target,
                  std::uint64_t seed, sim::World& world, trial::Recorder& recorder) {
  Bring run = Run(setup, wanted, target, seed, world, recorder).Go();
  run.outcome = Judge(run, target, world);
  if (target) run.friction = world.glove_friction(*target).static_mu;
  return run;
}

}  // namespace rangegrasp::bring
