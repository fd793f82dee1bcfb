#include "tasks/grasping/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/stopwatch.h"
#include "tasks/grasping/judge.h"

namespace rangegrasp::tasks::grasping {
namespace {

using nlohmann::ordered_json;

core::Rng Stream(const TrialSpec& spec, std::string_view stage) {
  return core::Rng(core::DeriveSeed(spec.seed, stage));
}

ordered_json JsonOf(const sim::Audit& a) {
  return {{"penetration_p95_m", a.penetration_p95_m},
          {"penetration_max_m", a.penetration_max_m},
          {"penetration_share", a.penetration_share},
          {"creep_m_s", a.creep_m_s},
          {"creep_rad_s", a.creep_rad_s},
          {"equality_share", a.equality_share},
          {"drive_limit_s", a.drive_limit_s},
          {"tracking_error_rad", a.tracking_error_rad},
          {"energy_gain_j", a.energy_gain_J},
          {"warnings", a.warnings},
          {"failed", a.failed}};
}

ordered_json JsonOf(const sim::ExecutionLog& log, const grasp::DetectedGrasp& grasp) {
  return {{"lift_height_m", log.lift_height_m},
          {"held_after_lift", log.held_after_lift},
          {"held_after_carry", log.held_after_carry},
          {"final_distance_m", log.final_distance_m},
          {"at_rest", log.at_rest},
          {"touched_by_hand", log.touched_by_hand},
          {"on_support", log.on_support},
          {"tilt_in_hand_rad", log.tilt_in_hand_rad},
          {"slip_in_hand_m", log.slip_in_hand_m},
          {"grip_force_n", log.grip_force_N},
          {"slips_heard", log.slips_heard},
          {"tracking_error_m", log.tracking_error_m},
          {"joints_at_limits", log.joints_at_limits},
          {"stopped_by_contact", log.stopped_by_contact},
          {"simulated_s", log.simulated_s},
          {"grasp",
           {{"pitch_rad", grasp.pitch_rad},
            {"width_m", grasp.width_m},
            {"contact_angle_rad", grasp.contact_angle_rad},
            {"score", grasp.score}}},
          {"audit", JsonOf(log.audit)}};
}

std::size_t MeasuredSamples(const geometry::Observation& observation) {
  std::size_t count = 0;
  for (const auto& view : observation.views) {
    count += static_cast<std::size_t>(
        std::count_if(view.image.points_C.begin(), view.image.points_C.end(),
                      [](const Eigen::Vector3d& p) { return p.allFinite(); }));
  }
  return count;
}

std::ptrdiff_t FreeGrasps(const grasp::Detection& detection) {
  return std::count_if(detection.grasps.begin(), detection.grasps.end(),
                       [](const grasp::DetectedGrasp& g) { return !g.collides; });
}

// One trial while it runs: what a stage leaves for the next.
class TrialRun {
 public:
  TrialRun(const Cell& cell, const TrialSpec& spec, const Detector& detector,
           const sim::ExecutionObserver& observer)
      : cell_(cell), spec_(spec), detector_(detector), observer_(observer) {}

  experiment::Result Run() {
    core::Stopwatch whole;
    try {
      RunStages();
    } catch (const std::exception& e) {
      End(Outcome::kCrashed, e.what());
    }
    result_.seconds.emplace_back("trial", whole.Seconds());
    result_.data = data_.dump();
    return result_;
  }

 private:
  void End(Outcome outcome, const std::string& detail) {
    result_.outcome = core::Word(outcome);
    result_.detail = detail;
  }
  void Begin(const char* stage) {
    result_.stage = stage;
    watch_.Restart();
  }
  void Timed(const char* stage) { result_.seconds.emplace_back(stage, watch_.Restart()); }

  void RunStages() {
    Begin("arrange");
    Redraws redraws;
    auto arranged = ArrangeTrial(cell_, spec_, redraws);
    Timed("arrange");
    data_["redraws"] = Total(redraws);
    for (const auto& [reason, count] : redraws) data_["redraw_reasons"][core::Word(reason)] = count;
    if (!arranged) return End(Outcome::kCrashed, "no arrangement: " + Text(redraws));
    data_["scene_objects"] = arranged->world.objects();
    data_["touching"] = arranged->touching;
    core::Rng friction = Stream(spec_, "friction");
    arranged->world.DrawFriction(friction);
    data_["pose_class"] = arranged->pose_class;
    data_["friction"] = arranged->world.glove_friction(arranged->target).static_mu;

    Begin("scan");
    const Sensed sensed = SenseTrial(cell_, arranged->world, spec_);
    Timed("scan");
    data_["scan_points"] = MeasuredSamples(sensed.observation);

    Begin("perceive");
    const Detected detected = Detect(sensed.observation);
    if (!Accept(detected, sensed, *arranged)) return;

    Begin("plan");
    core::Rng rng = Stream(spec_, "plan");
    const Move move = cell_.mover->Plan(detected.detection, rng);
    Timed("plan");
    data_["plans"] = move.tried;
    if (!move.plan) return End(Outcome::kNoPath, move.failures);

    Execute(*arranged, *move.plan, detected.detection.grasps[move.grasp]);
  }

  Detected Detect(const geometry::Observation& observation) {
    core::Rng rng = Stream(spec_, "perceive");
    Detected detected = detector_.Detect(observation, rng);
    result_.seconds.insert(result_.seconds.end(), detected.seconds.begin(), detected.seconds.end());
    data_["object_points"] = detected.kept;
    data_["segments"] = detected.segments;
    data_["objects"] = detected.detection.objects.size();
    data_["candidates"] = detected.detection.grasps.size();
    data_["free_candidates"] = FreeGrasps(detected.detection);
    return detected;
  }

  // The judge's verdict on the detection; false if the trial ends here.
  bool Accept(const Detected& detected, const Sensed& sensed, const Arrangement& arranged) {
    const auto verdict =
        JudgeDetection(detected.detection, sensed,
                       {static_cast<std::uint32_t>(arranged.target) + 1, cell_.TablePlane(),
                        cell_.options.perception.preprocess.table_clearance_m});
    if (!verdict.right_target || !verdict.segmented) {
      const bool none = detected.detection.objects.empty();
      End(none || verdict.right_target ? Outcome::kNotSegmented : Outcome::kWrongTarget,
          fmt::format("share of the object {:f}, of the target {:f}", verdict.share_of_object,
                      verdict.share_of_target));
      return false;
    }
    if (FreeGrasps(detected.detection) == 0) {
      Begin("grasp");
      End(Outcome::kNoGrasp,
          fmt::format("{} candidates, all collide", detected.detection.grasps.size()));
      return false;
    }
    data_["detected"] = true;
    return true;
  }

  void Execute(Arrangement& arranged, const planning::PickPlan& plan,
               const grasp::DetectedGrasp& grasp) {
    Begin("execute");
    data_["grasp_type"] = core::Word(grasp.type);
    const sim::GraspProgram program{
        plan.reach,      plan.approach,
        plan.lift,       plan.carry,
        plan.lower,      plan.retreat,
        grasp.opening_m, grasp.contact_angle_rad > cell_.options.firm_from_rad};
    const auto before_W = CentersOf(arranged.world);
    const auto log = sim::Execute(arranged.world, arranged.target, program, cell_.options.hand,
                                  cell_.options.audit, Stream(spec_, "execute"), observer_);
    Timed("execute");
    Begin("score");
    data_["log"] = JsonOf(log, grasp);
    const auto others = JudgeOthers(before_W, arranged.world, arranged.target);
    data_["others_moved"] = others.moved;
    data_["others_left_table"] = others.left_table;
    End(JudgeExecution(log), log.audit.failed);
  }

  const Cell& cell_;
  const TrialSpec& spec_;
  const Detector& detector_;
  const sim::ExecutionObserver& observer_;
  core::Stopwatch watch_;
  experiment::Result result_;
  ordered_json data_ = {{"pose_class", ""},
                        {"friction", nullptr},
                        {"redraws", 0},
                        {"redraw_reasons", ordered_json::object()},
                        {"scene_objects", 0},
                        {"touching", 0},
                        {"scan_points", 0},
                        {"object_points", 0},
                        {"segments", 0},
                        {"objects", 0},
                        {"candidates", 0},
                        {"free_candidates", 0},
                        {"plans", 0},
                        {"grasp_type", ""},
                        {"detected", false},
                        {"others_moved", 0},
                        {"others_left_table", 0},
                        {"log", ordered_json::object()}};
};

}  // namespace

Cell::Cell(Options o)
    : options(std::move(o)),
      robot(robot::Robot::Load(options.scene)),
      scanner(sensing::ReadLineScanner(options.sensor)),
      arranger(MakeArranger(options, robot, scanner)),
      sensor(MakeLineScanner(scanner, robot.X_WScanner)),
      detector(MakeDetector(options, robot)),
      mover(MakeMover(options, robot)) {}

geometry::Plane Cell::TablePlane() const {
  const Eigen::Vector3d up_W = robot.X_WWorkspace.linear().col(2);
  return {up_W, -up_W.dot(robot.X_WWorkspace.translation())};
}

std::string TrialId(const TrialSpec& spec) {
  return fmt::format("{}-{:04}", spec.object, spec.index);
}

std::uint64_t TrialSeed(std::uint64_t experiment_seed, const std::string& object, int index) {
  const std::uint64_t of_object =
      core::DeriveSeed(core::DeriveSeed(experiment_seed, "trial"), object);
  return core::DeriveSeed(of_object, static_cast<std::uint64_t>(index));
}

std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec) {
  Redraws redraws;
  return ArrangeTrial(cell, spec, redraws);
}

std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec, Redraws& redraws) {
  core::Rng rng = Stream(spec, "arrange");
  return cell.arranger->Arrange(spec.object, rng, redraws);
}

Sensed SenseTrial(const Cell& cell, const sim::World& world, const TrialSpec& spec) {
  core::Rng rng = Stream(spec, "scan");
  return cell.sensor->Sense(world, rng);
}

experiment::Result RunTrial(const Cell& cell, const TrialSpec& spec, const Detector* detector,
                            const sim::ExecutionObserver& observer) {
  return TrialRun(cell, spec, detector ? *detector : *cell.detector, observer).Run();
}

}  // namespace rangegrasp::tasks::grasping
