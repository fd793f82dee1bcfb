#include "experiment/trial.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/stopwatch.h"
#include "core/units.h"
#include "sim/execute.h"

namespace rangegrasp::experiment {
namespace {

constexpr int kMostDraws = 50;
constexpr double kMinLift_m = 0.1;
constexpr double kDeliveryRadius_m = 0.15;

core::Rng Stream(std::uint64_t trial_seed, std::string_view stage) {
  return core::Rng(core::DeriveSeed(trial_seed, stage));
}

// Whether all vertices of the target's visual surface lie in the scanner's field of view.
bool InView(const sim::World& world, int target, const core::Pose& X_WS,
            const sensing::LineScannerOptions& scanner) {
  const core::Pose X_SW = X_WS.inverse();
  for (const auto& visual : world.VisualMeshes()) {
    if (visual.label != static_cast<std::uint32_t>(target) + 1) continue;
    for (const Eigen::Vector3d& p_W : visual.mesh_W.vertices) {
      const Eigen::Vector3d p_S = X_SW * p_W;
      const double pan = std::atan2(p_S.x(), p_S.z());
      const double fan = std::atan2(p_S.y(), std::hypot(p_S.x(), p_S.z()));
      if (std::abs(pan) > 0.5 * scanner.pan_range_rad || std::abs(fan) > 0.5 * scanner.fan_rad) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

TrialContext Prepare(const Experiment& experiment) {
  TrialContext context{experiment,
                       robot::Robot::Load(experiment.scene),
                       sensing::ReadLineScanner(experiment.sensor),
                       {}};
  for (const std::string& object : experiment.objects) {
    const auto model = ObjectModelOf(experiment, object);
    auto poses = sim::StableRestingPoses(model, experiment.min_tipping_rad);
    if (poses.empty()) {
      throw core::InputError(model.mjcf.string() + ": no resting pose tips over later than at " +
                             std::to_string(core::ToDeg(experiment.min_tipping_rad)) +
                             " deg; lower min_tipping_deg or change the collision geometry");
    }
    context.resting_poses[object] = std::move(poses);
  }
  return context;
}

std::string TrialId(const TrialSpec& spec) {
  std::array<char, 16> number{};
  std::snprintf(number.data(), number.size(), "-%04d", spec.index);
  return spec.object + number.data();
}

std::uint64_t TrialSeed(std::uint64_t experiment_seed, const TrialSpec& spec) {
  const std::uint64_t object =
      core::DeriveSeed(core::DeriveSeed(experiment_seed, "trial"), spec.object);
  return core::DeriveSeed(object, static_cast<std::uint64_t>(spec.index));
}

std::vector<TrialSpec> AllTrials(const Experiment& experiment) {
  std::vector<TrialSpec> trials;
  for (const std::string& object : experiment.objects) {
    for (int i = 0; i < experiment.trials_per_object; ++i) trials.push_back({object, i});
  }
  return trials;
}

TrialSpec TrialFrom(const Experiment& experiment, const std::string& id) {
  for (const TrialSpec& spec : AllTrials(experiment)) {
    if (TrialId(spec) == id) return spec;
  }
  throw core::InputError("no trial '" + id + "' in experiment " + experiment.name +
                         "; ids are <object>-<number>, e.g. " +
                         TrialId({experiment.objects.front(), 0}));
}

std::optional<ArrangedTrial> Arrange(const TrialContext& context, const TrialSpec& spec,
                                     std::uint64_t trial_seed) {
  const Experiment& e = context.experiment;
  core::Rng rng = Stream(trial_seed, "arrange");
  ArrangedTrial trial{sim::World(e.scene, {ObjectModelOf(e, spec.object)}, e.physics), 0, "", 0};
  trial.world.SetArm(context.robot.home);
  const auto& poses = context.resting_poses.at(spec.object);
  for (int draw = 0; draw < kMostDraws; ++draw) {
    const sim::RestingPose& pose = poses[rng.Index(poses.size())];
    const double radius = context.robot.workspace_radius_m * std::sqrt(rng.Uniform());
    const double angle = rng.Uniform(0.0, 2.0 * core::kPi);
    const double yaw = rng.Uniform(0.0, 2.0 * core::kPi);
    const Eigen::Vector3d place =
        context.robot.X_WWorkspace *
        Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    core::Pose X_WO = core::MakePose(
        (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * pose.R_WO).toRotationMatrix(),
        Eigen::Vector3d(place.x(), place.y(), pose.height_m + 0.0005));
    trial.world.PlaceObject(trial.target, X_WO);
    // The centre of mass, not the body's origin, comes to the drawn place.
    const Eigen::Vector3d shift = place - trial.world.ObjectCenterOfMass(trial.target);
    X_WO.translation() += Eigen::Vector3d(shift.x(), shift.y(), 0.0);
    trial.world.PlaceObject(trial.target, X_WO);
    const bool rests = trial.world.Settle();
    // It may creep into place, but not fall into another pose.
    const double turned =
        (trial.world.ObjectPose(trial.target).linear().transpose() * X_WO.linear()).trace();
    const bool same_pose = turned > 1.0 + 2.0 * std::cos(0.1);
    if (rests && same_pose &&
        InView(trial.world, trial.target, context.robot.X_WScanner, context.scanner)) {
      trial.pose_class = pose.label;
      trial.redraws = draw;
      return trial;
    }
  }
  return std::nullopt;
}

sensing::Scan ScanWorld(const TrialContext& context, const sim::World& world,
                        std::uint64_t trial_seed) {
  core::Rng rng = Stream(trial_seed, "scan");
  return sensing::ScanScene(world.VisualMeshes(), context.robot.X_WScanner, context.scanner, rng);
}

perception::Scene PerceiveImage(const TrialContext& context, const geometry::RangeImage& image,
                                std::uint64_t trial_seed, geometry::Indices& source) {
  core::Rng rng = Stream(trial_seed, "perceive");
  const Experiment& e = context.experiment;
  const core::Pose X_WorkspaceW = context.robot.X_WWorkspace.inverse();
  const double radius = context.robot.workspace_radius_m + e.workspace_margin_m;
  geometry::Indices in_image;
  const geometry::PointCloud cloud = geometry::ToCloud(image, &in_image);
  geometry::Points points;
  source.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if ((X_WorkspaceW * cloud.points[i]).head<2>().norm() > radius) continue;
    points.push_back(cloud.points[i]);
    source.push_back(in_image[i]);
  }
  return perception::Perceive(points, image.origins_C.front(), e.perception, rng);
}

DetectionVerdict JudgeDetection(const perception::Scene& scene,
                                const std::vector<std::uint32_t>& label_of_cloud,
                                std::uint32_t target_label) {
  DetectionVerdict verdict;
  if (scene.objects.empty()) return verdict;
  const auto is_target = [&](std::uint32_t i) { return label_of_cloud[i] == target_label; };
  const auto& points = scene.objects.front().points;
  const auto hits = std::count_if(points.begin(), points.end(), is_target);
  const auto visible = std::count(label_of_cloud.begin(), label_of_cloud.end(), target_label);
  if (points.empty() || visible == 0) return verdict;
  verdict.share_of_object = static_cast<double>(hits) / static_cast<double>(points.size());
  verdict.share_of_target = static_cast<double>(hits) / static_cast<double>(visible);
  verdict.right_target = verdict.share_of_object > 0.5;
  verdict.segmented = verdict.share_of_target > 0.5;
  return verdict;
}

Outcome JudgeExecution(const sim::ExecutionLog& log) {
  if (!log.audit.failed.empty()) return Outcome::kInvalidPhysics;
  if (!(log.lift_height_m >= kMinLift_m) || !log.held_after_lift) return Outcome::kNotLifted;
  if (!log.held_after_carry) return Outcome::kDropped;
  const bool in_place = log.final_distance_m <= kDeliveryRadius_m && log.at_rest &&
                        !log.touched_by_hand && log.on_support;
  return in_place ? Outcome::kDelivered : Outcome::kMisplaced;
}

namespace {

std::string LogToJson(const sim::ExecutionLog& log, const grasp::Grasp& grasp) {
  const sim::Audit& a = log.audit;
  nlohmann::ordered_json json = {
      {"lift_height_m", log.lift_height_m},
      {"held_after_lift", log.held_after_lift},
      {"held_after_carry", log.held_after_carry},
      {"final_distance_m", log.final_distance_m},
      {"at_rest", log.at_rest},
      {"touched_by_hand", log.touched_by_hand},
      {"on_support", log.on_support},
      {"tilt_in_hand_rad", log.tilt_in_hand_rad},
      {"slip_in_hand_m", log.slip_in_hand_m},
      {"grip_force_n", log.grip_force_N},
      {"simulated_s", log.simulated_s},
      {"grasp",
       {{"pitch_rad", grasp.pitch_rad}, {"width_m", grasp.width_m}, {"score", grasp.score}}},
      {"audit",
       {{"penetration_p95_m", a.penetration_p95_m},
        {"penetration_max_m", a.penetration_max_m},
        {"creep_m_s", a.creep_m_s},
        {"creep_rad_s", a.creep_rad_s},
        {"equality_error_rad", a.equality_error_rad},
        {"torque_ratio", a.torque_ratio},
        {"energy_gain_j", a.energy_gain_J},
        {"warnings", a.warnings},
        {"failed", a.failed}}}};
  return json.dump();
}

sim::GraspProgram ProgramFrom(const planning::PickPlan& plan, const grasp::Grasp& grasp) {
  return {plan.reach, plan.approach, plan.lift,      plan.carry,
          plan.lower, plan.retreat,  grasp.opening_m};
}

// One trial while it runs: what a stage leaves for the next.
class TrialRun {
 public:
  TrialRun(const TrialContext& context, const TrialSpec& spec, const TrialObserver& observer)
      : context_(context), spec_(spec), observer_(observer) {
    result_.id = TrialId(spec);
    result_.object = spec.object;
    result_.index = spec.index;
    result_.seed = TrialSeed(context.experiment.seed, spec);
  }

  TrialResult Run() {
    core::Stopwatch whole;
    try {
      RunStages();
    } catch (const std::exception& e) {
      End(Outcome::kCrashed, e.what());
    }
    result_.seconds.emplace_back("trial", whole.Seconds());
    return result_;
  }

 private:
  void End(Outcome outcome, const std::string& detail) {
    result_.outcome = outcome;
    result_.detail = detail;
  }

  void Begin(const std::string& stage) { result_.stage = stage; }
  void Timed(const std::string& stage) { result_.seconds.emplace_back(stage, watch_.Restart()); }

  void RunStages() {
    watch_.Restart();
    Begin("arrange");
    auto trial = Arrange(context_, spec_, result_.seed);
    Timed("arrange");
    if (!trial) return End(Outcome::kCrashed, "no arrangement came to rest in view");
    result_.pose_class = trial->pose_class;
    result_.redraws = trial->redraws;

    Begin("scan");
    const sensing::Scan scan = ScanWorld(context_, trial->world, result_.seed);
    Timed("scan");

    Begin("perceive");
    const perception::Scene scene = PerceiveScan(scan);
    if (!Detect(scene, scan, *trial)) return;

    Begin("plan");
    const auto [plan, grasp] = PlanMotion(scene);
    Timed("plan");
    if (!plan) return;

    Begin("execute");
    result_.grasp_type = grasp::Name(grasp.type);
    const auto& e = context_.experiment;
    const auto log = sim::Execute(trial->world, trial->target, ProgramFrom(*plan, grasp), e.hand,
                                  e.audit, observer_.execution);
    Timed("execute");
    Begin("score");
    result_.log = LogToJson(log, grasp);
    End(JudgeExecution(log), log.audit.failed);
  }

  perception::Scene PerceiveScan(const sensing::Scan& scan) {
    perception::Scene scene = PerceiveImage(context_, scan.image, result_.seed, source_);
    Timed("perceive");
    for (const auto& [step, seconds] : scene.seconds) {
      result_.seconds.emplace_back("perceive: " + step, seconds);
    }
    const auto& points = scan.image.points_C;
    result_.scan_points = static_cast<int>(
        std::count_if(points.begin(), points.end(), [](const auto& p) { return p.allFinite(); }));
    result_.object_points = static_cast<int>(scene.cloud.size());
    result_.segments = static_cast<int>(scene.segments.size());
    result_.objects = static_cast<int>(scene.objects.size());
    return scene;
  }

  // Grasps for the topmost object, and the scorer's verdict on the detection; false if the trial
  // ends here.
  bool Detect(const perception::Scene& scene, const sensing::Scan& scan,
              const ArrangedTrial& trial) {
    Begin("grasp");
    watch_.Restart();
    if (!scene.objects.empty()) {
      grasps_ =
          grasp::PlanGrasps(scene, 0, context_.robot.hand(), ArmBase(), context_.experiment.grasp);
    }
    Timed("grasp");
    if (observer_.on_perceived) observer_.on_perceived(scene, grasps_, scan);
    watch_.Restart();
    result_.candidates = static_cast<int>(grasps_.size());
    std::erase_if(grasps_, [](const grasp::Grasp& g) { return g.collides; });
    result_.free_candidates = static_cast<int>(grasps_.size());

    std::vector<std::uint32_t> labels(scene.cloud.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
      labels[i] = scan.truth.label[source_[scene.source[i]]];
    }
    const auto verdict =
        JudgeDetection(scene, labels, static_cast<std::uint32_t>(trial.target) + 1);
    if (!verdict.right_target || !verdict.segmented) {
      Begin("perceive");
      End(scene.objects.empty() || verdict.right_target ? Outcome::kNotSegmented
                                                        : Outcome::kWrongTarget,
          "share of the object " + std::to_string(verdict.share_of_object) + ", of the target " +
              std::to_string(verdict.share_of_target));
      return false;
    }
    if (grasps_.empty()) {
      End(Outcome::kNoGrasp, std::to_string(result_.candidates) + " candidates, all collide");
      return false;
    }
    result_.detected = true;
    return true;
  }

  Eigen::Vector3d ArmBase() const { return context_.robot.links().front().X_PB.translation(); }

  planning::PlanningScene PlanningSceneFrom(const perception::Scene& scene) const {
    planning::PlanningScene planning;
    const auto& plane = scene.table.plane;
    planning.table_z_m = -plane.offset_m / plane.normal.z();
    planning.target_W = scene.objects.front().surface_C;
    for (std::size_t i = 1; i < scene.objects.size(); ++i) {
      planning.obstacles_W.push_back(scene.objects[i].surface_C);
    }
    return planning;
  }

  std::pair<std::optional<planning::PickPlan>, grasp::Grasp> PlanMotion(
      const perception::Scene& scene) {
    const auto& e = context_.experiment;
    core::Rng rng = Stream(result_.seed, "plan");
    planning::Planner planner(context_.robot, e.planning);
    const planning::PlanningScene planning = PlanningSceneFrom(scene);
    std::map<std::string, int> failures;
    for (const grasp::Grasp& grasp : grasps_) {
      if (result_.plans >= e.most_plans) break;
      ++result_.plans;
      planning::PickRequest request;
      request.q_start = context_.robot.home;
      request.X_WH = grasp.X_CH;
      request.approach_W = grasp.X_CG.linear().col(2);
      request.opening_m = grasp.opening_m;
      request.closed_gap_m = grasp.width_m;
      auto planned = planner.Plan(planning, request, rng);
      if (planned.plan) return {std::move(planned.plan), grasp};
      ++failures[planning::Name(planned.failure)];
    }
    std::string detail;
    for (const auto& [name, count] : failures) {
      detail += (detail.empty() ? "" : ", ") + name + " x" + std::to_string(count);
    }
    End(Outcome::kNoPath, detail);
    return {std::nullopt, {}};
  }

  const TrialContext& context_;
  const TrialSpec& spec_;
  const TrialObserver& observer_;
  core::Stopwatch watch_;
  TrialResult result_;
  geometry::Indices source_;
  std::vector<grasp::Grasp> grasps_;
};

}  // namespace

TrialResult RunTrial(const TrialContext& context, const TrialSpec& spec,
                     const TrialObserver& observer) {
  return TrialRun(context, spec, observer).Run();
}

}  // namespace rangegrasp::experiment
