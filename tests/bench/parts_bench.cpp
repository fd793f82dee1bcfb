// Segmentation into parts: the growth with the number of points, and the benchmark's models if they
// are available (the published method and the shape diameter function, table 6.1).
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "base/rng.h"
#include "parts/baselines/baselines.h"
#include "parts/hierarchy/hierarchy.h"
#include "parts/mirror/mirroring.h"
#include "parts/shape/shape_file.h"
#include "parts/stretched/embedding.h"

namespace rangegrasp {
namespace {

// A noisy ball with four arms.
parts::Shape ArmedCloud(std::size_t n) {
  base::Rng rng(1);
  parts::Shape cloud;
  while (cloud.points.size() < n) {
    if (rng.Uniform() < 0.6) {
      const Eigen::Vector3d d(rng.Normal(), rng.Normal(), rng.Normal());
      cloud.points.push_back((1.0 + 0.01 * rng.Normal()) * d.normalized());
      continue;
    }
    const double angle = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    const Eigen::Vector3d arm(rng.Uniform(0.97, 2.5), 0.25 * std::cos(angle),
                              0.25 * std::sin(angle));
    const double turn = 0.5 * std::numbers::pi * static_cast<double>(rng.Index(4));
    cloud.points.push_back(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * arm);
  }
  return cloud;
}

// The time per point should not grow.
void MirrorCloud(benchmark::State& state) {
  const parts::Shape cloud = ArmedCloud(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(parts::SegmentByMirroring(cloud));
  state.counters["per_point"] = benchmark::Counter(
      static_cast<double>(state.range(0)),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(MirrorCloud)
    ->RangeMultiplier(10)
    ->Range(10'000, 1'000'000)
    ->Unit(benchmark::kMillisecond);

void PoseInvariantCloudOf3000(benchmark::State& state) {
  const parts::Shape cloud = ArmedCloud(3000);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        parts::SegmentByMirroring(parts::PoseInvariant(cloud), /*go_on_outside=*/true));
  }
}
BENCHMARK(PoseInvariantCloudOf3000)->Unit(benchmark::kMillisecond);

// All 40 models, which are processed in turn. The time is the mean per model.
const std::vector<parts::Shape>& Models() {
  static const std::vector<parts::Shape> models = [] {
    std::vector<parts::Shape> read;
    const auto off = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared/data/psb/off";
    for (int id = 1; id <= 400 && std::filesystem::exists(off); ++id) {
      const auto file = off / (std::to_string(id) + ".off");
      if (std::filesystem::exists(file)) read.push_back(parts::ReadShape(file));
    }
    return read;
  }();
  return models;
}

template <class Method>
void OverModels(benchmark::State& state, Method method) {
  const auto& models = Models();
  if (models.empty()) {
    state.SkipWithError("no benchmark models");
    return;
  }
  for (auto _ : state) {
    for (const parts::Shape& model : models) benchmark::DoNotOptimize(method(model));
  }
  state.counters["per_model"] = benchmark::Counter(
      static_cast<double>(models.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void MirrorModels(benchmark::State& state) {
  OverModels(state, [](const parts::Shape& model) {
    return parts::SegmentByMirroring(model, /*go_on_outside=*/true);
  });
}
BENCHMARK(MirrorModels)->Unit(benchmark::kSecond);

void HierarchyModels(benchmark::State& state) {
  OverModels(state, [](const parts::Shape& model) { return parts::SegmentHierarchy(model, {}); });
}
BENCHMARK(HierarchyModels)->Unit(benchmark::kSecond)->Iterations(1);

void SdfModels(benchmark::State& state) {
  OverModels(state, [](const parts::Shape& model) { return parts::SegmentBySdf(model); });
}
BENCHMARK(SdfModels)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace rangegrasp
