// Benchmarks of a scan, grasp planning, motion planning, physics, and a whole trial.

#include <benchmark/benchmark.h>

#include "base/stopwatch.h"
#include "grasp/grasp.h"
#include "robot/planning/planning.h"
#include "sensing/depth_camera.h"
#include "tabletop.h"

namespace rangegrasp::bench {
namespace {

using benchmark::Counter;
using benchmark::State;

// The first trial of a standing object.
trial::TrialSpec FirstTrial() { return {"spread", 0, trial::TrialSeed(1, "spread", 0)}; }

void Arrange(State& state) {
  const auto& cell = Cell();
  for (auto _ : state) {
    benchmark::DoNotOptimize(trial::ArrangeTrial(cell, FirstTrial()));
  }
}
BENCHMARK(Arrange)->Unit(benchmark::kMillisecond);

void Scan(State& state) {
  const auto& cell = Cell();
  const sim::World& world = FiveObjects();
  for (auto _ : state) {
    benchmark::DoNotOptimize(trial::Look(cell, world, 1));
  }
  state.counters["points"] = static_cast<double>(FiveObjectsCloud().size());
}
BENCHMARK(Scan)->Unit(benchmark::kMillisecond);

// One image of 640 x 480 pixels with noise. Arguments: the principle (active stereo, time of
// flight), and whether the image has colors.
void DepthImage(State& state) {
  auto camera = sensing::ReadDepthCamera(RANGEGRASP_SOURCE_DIR
                                         "/models/sensors/depth_camera_active_stereo.yaml");
  camera.principle = static_cast<sensing::DepthPrinciple>(state.range(0));
  camera.color = state.range(1) != 0;
  const std::vector<sim::VisualMesh> meshes = FiveObjects().VisualMeshes();
  for (auto _ : state) {
    base::Rng rng(1);
    benchmark::DoNotOptimize(sensing::ScanScene(meshes, *camera.X_WS, camera, rng));
  }
}
BENCHMARK(DepthImage)
    ->ArgNames({"time_of_flight", "color"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({0, 1})
    ->Unit(benchmark::kMillisecond);

std::vector<grasp::Grasp> GraspsForTheTopmost() {
  const auto& cell = Cell();
  const Eigen::Vector3d arm = cell.robot.links().front().X_PB.translation();
  return grasp::PlanGrasps(FiveObjectsScene(), 0, cell.robot.hand(), arm, cell.options.grasp);
}

void PlanGrasps(State& state) {
  FiveObjectsScene();
  for (auto _ : state) benchmark::DoNotOptimize(GraspsForTheTopmost());
}
BENCHMARK(PlanGrasps)->Unit(benchmark::kMillisecond);

// Plans until the first collision-free grasp with a path. All plans up to it are counted.
void PlanMotion(State& state) {
  const auto& cell = Cell();
  const auto& scene = FiveObjectsScene();
  planning::PlanningScene obstacles;
  obstacles.target_W = scene.objects.front().surface_C;
  for (std::size_t i = 1; i < scene.objects.size(); ++i) {
    obstacles.obstacles_W.push_back(scene.objects[i].surface_C);
  }
  auto grasps = GraspsForTheTopmost();
  std::erase_if(grasps, [](const grasp::Grasp& g) { return g.collides; });
  int plans = 0;
  bool found = false;
  for (auto _ : state) {
    base::Rng rng(1);
    planning::Planner planner(cell.robot, cell.options.planning);
    planner.SetScene(obstacles);
    plans = 0;
    found = false;
    for (const auto& grasp : grasps) {
      planning::PickRequest request;
      request.q_start = cell.robot.home;
      request.X_WH = grasp.X_CH;
      request.approach_W = grasp.X_CG.linear().col(2);
      request.opening_m = grasp.opening_m;
      request.closed_gap_m = grasp.width_m;
      ++plans;
      found = planner.Plan(request, rng).plan.has_value();
      if (found) break;
    }
  }
  state.counters["plans"] = plans;
  state.counters["found"] = found ? 1.0 : 0.0;
}
BENCHMARK(PlanMotion)->Unit(benchmark::kMillisecond);

// One step of the tabletop with the arm at home and one object at rest on it.
void PhysicsStep(State& state) {
  const auto& cell = Cell();
  auto trial = trial::ArrangeTrial(cell, FirstTrial());
  if (!trial) return state.SkipWithError("no arrangement");
  double simulated_s = 0.0;
  for (auto _ : state) {
    trial->world.Step();
    simulated_s += cell.options.physics.timestep_s;
  }
  state.counters["real_time_factor"] = Counter(simulated_s, Counter::kIsRate);
}
BENCHMARK(PhysicsStep)->Unit(benchmark::kMicrosecond);

// Counters: seconds of every stage, and simulated time / wall time of the execution.
void Trial(State& state) {
  const auto& cell = Cell();
  std::map<std::string, double> sum_s;
  bool delivered = false;
  for (auto _ : state) {
    const auto result = trial::RunTrial(cell, FirstTrial());
    for (const auto& [stage, seconds] : result.seconds) {
      if (stage.find(':') == std::string::npos) sum_s[stage] += seconds;
    }
    delivered = result.outcome == "delivered";
  }
  for (const auto& [stage, seconds] : sum_s) {
    state.counters[stage + "_s"] = Counter(seconds, Counter::kAvgIterations);
  }
  state.counters["delivered"] = delivered ? 1.0 : 0.0;
}
BENCHMARK(Trial)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rangegrasp::bench
