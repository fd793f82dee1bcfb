// The two pictures of a simulated stereo camera.

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

// A pair, as the first of a process is not: with a renderer that is there.
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

// What comes before it in every process.
void PhotographersRenderer(State& state) {
  const sim::World& world = FiveObjects();
  Camera();
  for (auto _ : state) benchmark::DoNotOptimize(Camera().RendererOf(world));
}
BENCHMARK(PhotographersRenderer)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rangegrasp::bench
