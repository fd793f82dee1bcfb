// Benchmarks of the two pictures of a simulated stereo camera.

#include <benchmark/benchmark.h>

#include "stereo/sensing/stereo_camera.h"
#include "tabletop.h"

namespace rangegrasp::bench {
namespace {

using benchmark::State;

const sensing::StereoCamera& Camera() {
  static const sensing::StereoCamera camera{sensing::StereoCameraOptions{}};
  return camera;
}

// A pair of pictures with an existing renderer, unlike the first pair of a process.
void Photograph(State& state) {
  const sim::World& world = FiveObjects();
  const base::Pose X_WS = world.SitePose("scanner");
  const auto renderer = Camera().RendererOf(world);
  for (auto _ : state) {
    base::Rng rng(1);
    benchmark::DoNotOptimize(Camera().Photograph(world, *renderer, X_WS, rng));
  }
}
BENCHMARK(Photograph)->Unit(benchmark::kMillisecond);

// The creation of the renderer, which every process needs before its first pair.
void PhotographersRenderer(State& state) {
  const sim::World& world = FiveObjects();
  Camera();
  for (auto _ : state) benchmark::DoNotOptimize(Camera().RendererOf(world));
}
BENCHMARK(PhotographersRenderer)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rangegrasp::bench
