#include "trial/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <ranges>

#include "base/stopwatch.h"
#include "base/words.h"
#include "robot/timing.h"
#include "sim/world.h"
#include "trial/options.h"
#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

using experiment::Case;
using experiment::Result;
using experiment::Stamp;
using nlohmann::ordered_json;

ordered_json JsonOf(const sim::Audit& a) {
  return {{"penetration_p95_m", a.penetration_p95_m},
          {"penetration_max_m", a.penetration_max_m},
          {"penetration_share", a.penetration_share},
          {"elsewhere_p95_m", a.elsewhere_p95_m},
          {"elsewhere_max_m", a.elsewhere_max_m},
          {"unrest_s", a.unrest_s},
          {"creep_m_s", a.creep_m_s},
          {"creep_rad_s", a.creep_rad_s},
          {"equality_share", a.equality_share},
          {"grip_share", a.grip_share},
          {"drive_limit_s", a.drive_limit_s},
          {"tracking_error_rad", a.tracking_error_rad},
          {"energy_gain_j", a.energy_gain_J},
          {"warnings", a.warnings},
          {"repeated_steps", a.repeated_steps},
          {"unsolved_steps", a.unsolved_steps},
          {"failed", a.failed}};
}

ordered_json JsonOf(const sim::HandOverLog& h) {
  return {{"early", h.early},
          {"felt", h.felt},
          {"felt_n", h.felt_N},
          {"felt_s", h.felt_s},
          {"taken", h.taken}};
}

ordered_json JsonOf(const sim::ExecutionLog& log, const grasp::DetectedGrasp& grasp) {
  ordered_json json = {{"lift_height_m", log.lift_height_m},
                       {"held_after_lift", log.held_after_lift},
                       {"held_after_carry", log.held_after_carry},
                       {"final_distance_m", log.final_distance_m},
                       {"at_rest", log.at_rest},
                       {"touched_by_hand", log.touched_by_hand},
                       {"lean_rad", log.lean_rad},
                       {"on_support", log.on_support},
                       {"tilt_in_hand_rad", log.tilt_in_hand_rad},
                       {"slip_in_hand_m", log.slip_in_hand_m},
                       {"grip_force_n", log.grip_force_N},
                       {"felt_force_n", log.felt_force_N},
                       {"slips_heard", log.slips_heard},
                       {"lift_lag_rad", log.lift_lag_rad},
                       {"tracking_error_m", log.tracking_error_m},
                       {"joints_at_limits", log.joints_at_limits},
                       {"stopped_by_contact", log.stopped_by_contact},
                       {"simulated_s", log.simulated_s},
                       {"aperture",
                        {{"lifted_rad", log.aperture.lifted_rad},
                         {"carried_rad", log.aperture.carried_rad},
                         {"feels_object_after_lift", log.aperture.feels_object_after_lift},
                         {"feels_object_after_carry", log.aperture.feels_object_after_carry}}},
                       {"grasp",
                        {{"pitch_rad", grasp.pitch_rad},
                         {"width_m", grasp.width_m},
                         {"contact_angle_rad", grasp.contact_angle_rad},
                         {"score", grasp.score}}},
                       {"audit", JsonOf(log.audit)}};
  if (log.hand_over) json["hand_over"] = JsonOf(*log.hand_over);
  if (grasp.probability) json["grasp"]["probability"] = *grasp.probability;
  return json;
}

ordered_json JsonOf(const LookRecord& look) {
  return {{"gain_m3", look.gain_m3}, {"unseen_m3", look.unseen_m3}, {"way_s", look.way_s},
          {"arrived", look.arrived}, {"refined", look.refined},     {"deviations", look.deviations},
          {"sigma_m", look.sigma_m}, {"pairs", look.pairs}};
}

std::size_t MeasuredSamples(const geometry::Observation& observation) {
  std::ptrdiff_t count = 0;
  for (const auto& view : observation.views) {
    count += std::ranges::count_if(view.image.points_C,
                                   [](const Eigen::Vector3d& p) { return p.allFinite(); });
  }
  return static_cast<std::size_t>(count);
}

std::string FiguresOf(const sim::ExecutionLog& log) {
  if (log.held_after_carry) {
    return fmt::format("released {:.0f} mm from the delivery place",
                       log.final_distance_m * base::kMmPerM);
  }
  const double lift_mm = std::round(log.lift_height_m * base::kMmPerM);
  return fmt::format(
      "{} {:.0f} mm; while held it slid {:.0f} mm and turned {:.0f} deg; slips felt: {}",
      lift_mm < 0.0 ? "sank by" : "lifted by", std::abs(lift_mm),
      log.slip_in_hand_m * base::kMmPerM, base::ToDeg(log.tilt_in_hand_rad), log.slips_heard);
}

// Why an execution failed: the cause, then the numbers (tables count causes).
std::string WhyOf(const sim::ExecutionLog& log) {
  if (!log.audit.failed.empty()) return log.audit.failed;
  if (!log.stopped_by_contact.empty()) {
    return "the drives felt something in the way or lagged in " +
           base::Join(log.stopped_by_contact, " and ") + "; " +
           (log.joints_at_limits.empty()
                ? ""
                : base::Join(log.joints_at_limits) + " at the end of its range; ") +
           FiguresOf(log);
  }
  if (!log.held_after_carry) {
    return (log.slips_heard > 0 ? "slid out of the hand; " : "lost without a felt slip; ") +
           FiguresOf(log);
  }
  const char* const cause = log.touched_by_hand ? "the hand still touches it; "
                            : !log.on_support   ? "it does not stand on the support; "
                            : !log.at_rest      ? "it still moves; "
                                                : "too far away; ";
  return cause + FiguresOf(log);
}

// Why an attempt has no collision-free grasp.
std::string NoFreeGrasp(const Detected& detected) {
  if (!detected.why_none.empty()) return detected.why_none;
  const std::size_t candidates = detected.detection.grasps.size();
  return candidates == 0 ? "no candidates" : fmt::format("all {} candidates collide", candidates);
}

// Why an attempt has no object.
std::string NoObject(const Detected& detected) {
  return detected.why_none.empty() ? "nothing is perceived" : detected.why_none;
}

std::string NotTheTarget(const Detected& detected, const DetectionVerdict& verdict) {
  if (detected.detection.objects.empty()) return NoObject(detected);
  return fmt::format("{}; share of the object {:.3f}, of the target {:.3f}",
                     verdict.right_target             ? "a part of the target"
                     : verdict.share_of_object == 0.0 ? "another object"
                                                      : "joined with others",
                     verdict.share_of_object, verdict.share_of_target);
}

/// Predicted probability of delivery of the best collision-free grasp; 0 without one.
double BestPromise(const grasp::Detection& detection) {
  const auto best = std::ranges::find(detection.grasps, false, &grasp::DetectedGrasp::collides);
  return best == detection.grasps.end() ? 0.0 : best->probability.value_or(0.0);
}

std::ptrdiff_t FreeGrasps(const grasp::Detection& detection) {
  return std::ranges::count(detection.grasps, false, &grasp::DetectedGrasp::collides);
}

// State of one attempt, passed from stage to stage.
class AttemptRun {
 public:
  AttemptRun(const Cell& cell, sim::World& world, const AttemptOptions& options)
      : cell_(cell),
        world_(world),
        options_(options),
        q_start_(options.q_start.value_or(cell.robot.home)) {}

  Attempt Run() {
    try {
      RunStages();
    } catch (const DetectorFailed& e) {
      End(Outcome::kDetectorFailed, e.what());
    } catch (const std::exception& e) {
      End(Outcome::kCrashed, e.what());
    }
    result_.text.outcome = result_.outcome;
    result_.text.detail = result_.detail;
    if (undetected_) {
      Begin("perceive");
      End(undetected_->outcome, undetected_->detail);
    }
    return std::move(result_);
  }

 private:
  struct Ended {
    Outcome outcome;
    std::string detail;
  };

  void End(Outcome outcome, const std::string& detail) {
    result_.outcome = outcome;
    result_.detail = detail;
  }
  void Begin(const char* stage) {
    result_.stage = stage;
    watch_.Restart();
  }
  void Timed(const char* stage) {
    experiment::AddSeconds(stage, watch_.Restart(), result_.seconds);
  }
  base::Rng Stream(std::string_view stage) const { return StageStream(options_.seed, stage); }

  void RunStages() {
    // Called also for an attempt that ends before anything moves.
    if (options_.observer.on_moment) options_.observer.on_moment("start", world_);
    Begin("scan");
    std::optional<Sensed> own;
    if (!options_.sensed) {
      own = LookAround();
      Timed("scan");
    }
    const Sensed& sensed = own ? *own : *options_.sensed;
    result_.scan_points = MeasuredSamples(sensed.observation);
    if (options_.on_sensed) options_.on_sensed(sensed);

    Begin("perceive");
    if (sensed.observation.views.size() != considered_views_) Consider(sensed.observation);
    if (options_.prefer) options_.prefer(result_.detected.detection);
    if (own) {  // the verdict is on the views of the kept detection
      own->observation.views.resize(detected_views_);
      own->truth.resize(detected_views_);
    }
    result_.target =
        options_.target ? options_.target : AimedAt(result_.detected.detection, sensed, world_);
    if (!Accept(sensed)) return;

    Move();
  }

  // Scans from as many viewpoints as the experiment specifies.
  Sensed LookAround() {
    Sensed first = Look(cell_, world_, options_.seed);
    const auto& further = FurtherLooking();
    if (!further || !further->wanted(cell_.options)) return first;
    Timed("scan");
    const Promise promise = [this](const Sensed& sensed) {
      Timed("look");
      Begin("perceive");
      const double best = Consider(sensed.observation);
      Begin("scan");
      return best;
    };
    LookedAround around = further->look(cell_, std::move(first), world_, options_.seed, promise);
    q_start_ = around.q;
    result_.looks = std::move(around.looks);
    Timed("look");
    if (options_.observer.on_moment) options_.observer.on_moment("looked", world_);
    return std::move(around.sensed);
  }

  void Move() {
    base::Rng rng = Stream("plan");
    Begin("plan");
    const grasp::Move move =
        grasp::PlanMove(result_.detected.detection, q_start_, cell_.options,
                        cell_.options.grasp.friction_cone_rad, cell_.robot, rng);
    Timed("plan");
    result_.plans = move.tried;
    result_.blind = move.blind;
    result_.brushes = move.brushes;
    if (!move.plan) return End(Outcome::kNoPath, move.failures);
    result_.executed = move.grasp;
    Execute(*move.plan);
  }

  // Detects, and keeps the detection unless one from fewer views has a better best grasp.
  // @return predicted probability of this detection's best grasp
  double Consider(const geometry::Observation& observation) {
    base::Rng rng = Stream("perceive");
    const Detector& detector = options_.detector ? *options_.detector : *cell_.detector;
    Detected detected = detector.Detect(observation, rng, options_.turn);
    for (const auto& [stage, seconds] : detected.seconds) {
      experiment::AddSeconds(stage, seconds, result_.seconds);
    }
    const double promise = BestPromise(detected.detection);
    considered_views_ = observation.views.size();
    if (detected_views_ == 0 || promise >= BestPromise(result_.detected.detection)) {
      result_.detected = std::move(detected);
      detected_views_ = considered_views_;
    }
    return promise;
  }

  // Whether there is a grasp to plan for. If not, the attempt has ended.
  bool Accept(const Sensed& sensed) {
    if (options_.target ? !MayTake(sensed) : !IsAnything()) return false;
    if (FreeGrasps(result_.detected.detection) == 0) {
      Begin("grasp");
      End(Outcome::kNoGrasp, NoFreeGrasp(result_.detected));
      return false;
    }
    result_.text.detected = true;
    result_.accepted = !undetected_;
    return true;
  }

  // The judge's verdict on the detection. With by_text, an attempt that fails it continues if the
  // first object contains a part of the target.
  bool MayTake(const Sensed& sensed) {
    const grasp::Detection& detection = result_.detected.detection;
    const auto verdict =
        JudgeDetection(detection, sensed,
                       {static_cast<std::uint32_t>(*options_.target) + 1, cell_.TablePlane(),
                        cell_.options.perception.preprocess.table_clearance_m});
    if (verdict.right_target && verdict.segmented) return true;
    const bool none = detection.objects.empty();
    End(none || verdict.right_target ? Outcome::kNotSegmented : Outcome::kWrongTarget,
        NotTheTarget(result_.detected, verdict));
    if (!options_.by_text || verdict.share_of_object == 0.0) return false;
    undetected_ = Ended{result_.outcome, result_.detail};
    return true;
  }

  bool IsAnything() {
    const bool none = result_.detected.detection.objects.empty();
    if (!none && result_.detected.has_turn && result_.target) return true;
    End(Outcome::kNotSegmented,
        none ? NoObject(result_.detected) : "no object that may be grasped");
    return false;
  }

  void Execute(const planning::PickPlan& plan) {
    base::Rng rng = Stream("execute");
    const std::vector<Eigen::Vector3d> before_W = CentersOf(world_);
    Begin("execute");
    const grasp::DetectedGrasp& grasp = *result_.Grasp();
    const grasp::GraspSelector* selector = grasp::FindGraspSelector(cell_.options.take);
    const bool firm =
        (selector && selector->firm) || grasp.contact_angle_rad > cell_.options.firm_from_rad;
    const sim::GraspProgram program{
        plan.reach,    plan.approach,
        plan.lift,     plan.carry,
        plan.lower,    plan.retreat,
        options_.user, grasp.opening_m,
        firm,          options_.target ? sim::EndsBy::kTruth : sim::EndsBy::kAperture};
    result_.log = sim::Execute(world_, *result_.target, program, cell_.options.hand,
                               cell_.options.audit, rng, options_.observer);
    Timed("execute");
    Begin("score");
    result_.others = JudgeOthers(before_W, world_, *result_.target);
    const Outcome outcome = JudgeExecution(*result_.log);
    End(outcome, outcome == Outcome::kDelivered ? "" : WhyOf(*result_.log));
  }

  const Cell& cell_;
  sim::World& world_;
  const AttemptOptions& options_;
  base::Stopwatch watch_;
  Eigen::VectorXd q_start_;           ///< the arm's position before planning
  std::size_t considered_views_ = 0;  ///< number of views at the last detection
  std::size_t detected_views_ = 0;    ///< number of views of the kept detection
  std::optional<Ended> undetected_;   ///< outcome by the strict verdict, if it continues
  Attempt result_;
};

}  // namespace

Case CaseOf(const TrialSpec& spec) {
  return {fmt::format("{}-{:04}", spec.object, spec.index),
          spec.object,
          spec.seed,
          {{"object", spec.object}, {"index", spec.index}}};
}

TrialSpec SpecOf(const Case& which) {
  return {which.params.Text("object"), which.params.Int("index"), which.seed};
}

std::uint64_t TrialSeed(std::uint64_t experiment_seed, const std::string& object, int index) {
  const std::uint64_t of_object =
      base::DeriveSeed(base::DeriveSeed(experiment_seed, "trial"), object);
  return base::DeriveSeed(of_object, static_cast<std::uint64_t>(index));
}

void AddModelsTo(const Options& options, Stamp& stamp) {
  stamp.identity["scene_hash"] = SceneHash(options);
  stamp.identity["mujoco"] = sim::EngineVersion();
}

void AddTitles(const Options& options, Stamp& stamp) {
  for (const std::string& object : options.objects) {
    stamp.data[experiment::kTitlePrefix + object] =
        sim::ObjectTitle(ObjectModelOf(options, object));
  }
}

Result NoArrangement(const Redraws& redraws) {
  return {experiment::kCrashed, "arrange", "no arrangement: " + Text(redraws), "{}", {}};
}

std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec) {
  Redraws redraws;
  return ArrangeTrial(cell, spec, redraws);
}

std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec, Redraws& redraws) {
  base::Rng rng = StageStream(spec.seed, "arrange");
  auto arranged = cell.arranger->Arrange(spec.object, rng, redraws);
  if (arranged) {
    base::Rng friction = StageStream(spec.seed, "friction");
    arranged->world.DrawFriction(friction);
  }
  return arranged;
}

Result RunTrial(const Cell& cell, const TrialSpec& spec, const Detector* detector,
                const sim::ExecutionObserver& observer, Attempt* seen) {
  base::Stopwatch whole;
  ordered_json data = {{"pose_class", ""},   {"friction", nullptr},
                       {"redraws", 0},       {"redraw_reasons", ordered_json::object()},
                       {"scene_objects", 0}, {"touching", 0}};
  double arrange_s = 0.0;
  Attempt attempt{.stage = "arrange"};
  try {
    Redraws redraws;
    auto arranged = ArrangeTrial(cell, spec, redraws);
    arrange_s = whole.Seconds();
    data["redraws"] = Total(redraws);
    for (const auto& [reason, count] : redraws) data["redraw_reasons"][base::Word(reason)] = count;
    if (arranged) {
      data["scene_objects"] = arranged->world.objects();
      data["touching"] = arranged->touching;
      data["pose_class"] = arranged->pose_class;
      data["friction"] = arranged->world.glove_friction(arranged->target).static_mu;
      attempt = RunAttempt(cell, arranged->world,
                           {.seed = spec.seed,
                            .target = arranged->target,
                            .by_text = true,
                            .detector = detector,
                            .observer = observer});
    } else {
      attempt.detail = "no arrangement: " + Text(redraws);
    }
  } catch (const std::exception& e) {
    attempt.detail = e.what();
  }
  data.update(JsonOf(attempt));
  Result result{
      std::string(base::Word(attempt.outcome)), attempt.stage, attempt.detail, data.dump(), {}};
  result.seconds.emplace_back("arrange", arrange_s);
  std::ranges::copy(attempt.seconds, std::back_inserter(result.seconds));
  result.seconds.emplace_back("trial", whole.Seconds());
  if (seen) *seen = std::move(attempt);
  return result;
}

base::Rng StageStream(std::uint64_t seed, std::string_view stage) {
  return base::Rng(base::DeriveSeed(seed, stage));
}

Sensed Look(const Cell& cell, const sim::World& world, std::uint64_t seed) {
  base::Rng rng = StageStream(seed, "scan");
  return cell.sensor->Sense(world, rng);
}

Attempt RunAttempt(const Cell& cell, sim::World& world, const AttemptOptions& options) {
  return AttemptRun(cell, world, options).Run();
}

ordered_json JsonOf(const Attempt& attempt) {
  const grasp::Detection& detection = attempt.detected.detection;
  const grasp::DetectedGrasp* chosen = attempt.Grasp();
  ordered_json json = {
      {"scan_points", attempt.scan_points},
      {"object_points", attempt.detected.kept},
      {"segments", attempt.detected.segments},
      {"objects", detection.objects.size()},
      {"candidates", detection.grasps.size()},
      {"free_candidates", FreeGrasps(detection)},
      {"plans", attempt.plans},
      {"blind", attempt.blind},
      {"brushes", attempt.brushes},
      {"grasp_type", chosen ? std::string(base::Word(chosen->type)) : std::string()},
      {"detected", attempt.accepted},
      {"text",
       {{"detected", attempt.text.detected},
        {"outcome", base::Word(attempt.text.outcome)},
        {"detail", attempt.text.detail}}},
      {"others_moved", attempt.others.moved},
      {"others_left_table", attempt.others.left_table},
      {"others_brought", attempt.others.brought},
      {"log", attempt.log ? JsonOf(*attempt.log, *chosen) : ordered_json::object()}};
  for (const LookRecord& look : attempt.looks) json["looks"].push_back(JsonOf(look));
  return json;
}

std::string GraspText(const ordered_json& attempt, const std::string& name) {
  const auto log = attempt.find("log");
  if (log == attempt.end() || log->empty()) return "";
  const ordered_json& grasp = log->at("grasp");
  std::string text = fmt::format("grasp: {}, pads closing to {:.0f} mm, pitch {:.0f} deg",
                                 name.empty() ? attempt.at("grasp_type").get<std::string>()
                                              : "'" + name + "' of the object's grasps.yaml",
                                 grasp.at("width_m").get<double>() * base::kMmPerM,
                                 base::ToDeg(grasp.at("pitch_rad").get<double>()));
  if (const auto predicted = grasp.find("probability"); predicted != grasp.end()) {
    text += fmt::format(", predicted probability of delivery {:.2f}", predicted->get<double>());
  }
  return text;
}

double GoHome(const Cell& cell, sim::World& world) {
  const auto way = robot::TimeParameterise(cell.robot, {world.ArmPositions(), cell.robot.home},
                                           cell.options.planning.free_motion);
  world.SetArm(cell.robot.home);
  world.Settle();
  return way.Duration();
}

bool IsFinite(const sim::World& world) {
  const auto is_finite = [&](int object) { return world.ObjectPose(object).matrix().allFinite(); };
  return std::ranges::all_of(std::views::iota(0, world.objects()), is_finite) &&
         world.ArmPositions().allFinite();
}

void ReadUser(base::YamlMap map, HandOverOptions& options) {
  map.Read("force_n", options.user.force_N, 0.1, 200.0, "maximum force of the pull");
  map.Finish();
}

sim::UserOptions UserFor(const HandOverOptions& options, const Eigen::Vector3d& out_H,
                         base::Rng& rng) {
  sim::UserOptions user = options.user;
  // Uniform over the spherical cap.
  const double cosine = rng.Uniform(std::cos(options.pull_spread_rad), 1.0);
  const double round = rng.Uniform(0.0, 2.0 * base::kPi);
  const Eigen::Vector3d u = out_H.unitOrthogonal();
  const Eigen::Vector3d v = out_H.cross(u);
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  user.direction_H = cosine * out_H + sine * (std::cos(round) * u + std::sin(round) * v);
  return user;
}

sim::UserOptions UserOf(const HandOverOptions& options, const robot::Robot& robot,
                        std::uint64_t seed) {
  base::Rng rng = StageStream(seed, "user");
  return UserFor(options, robot.hand().X_HG_tip.linear().col(2), rng);
}

std::string HandOverOutcome(const Attempt& attempt) {
  const std::string word(base::Word(attempt.outcome));
  const bool offered = attempt.log && attempt.log->hand_over && attempt.log->held_after_carry;
  if (!offered || attempt.outcome == Outcome::kInvalidPhysics ||
      attempt.outcome == Outcome::kCrashed) {
    return word;
  }
  const sim::HandOverLog& log = *attempt.log->hand_over;
  if (log.early) return "felt_early";
  if (!log.felt) return "not_felt";
  return log.taken ? kHandedOver : "not_taken";
}

}  // namespace rangegrasp::trial
