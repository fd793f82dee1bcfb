// Perception of a scene with five objects, as a whole and by steps, compared with the Point Cloud
// Library's counterparts in the same run on the same cloud.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>

#include "base/stopwatch.h"
#include "pcl_bridge/pcl_segmentation.h"
#include "perception/perceive.h"
#include "tabletop.h"

namespace rangegrasp::bench {
namespace {

using benchmark::Counter;

perception::Scene PerceiveFiveObjects() {
  base::Rng rng(1);
  return perception::Perceive(FiveObjectsCloud(), SensorOrigin(), Cell().options.perception, rng);
}

double SecondsOf(const perception::Scene& scene, const std::string& step) {
  double sum = 0.0;
  for (const auto& [name, seconds] : scene.seconds) sum += name == step ? seconds : 0.0;
  return sum;
}

// Counters: milliseconds of every step.
void Perceive(benchmark::State& state) {
  FiveObjectsCloud();
  std::map<std::string, double> sum_s;
  std::size_t objects = 0;
  for (auto _ : state) {
    const auto scene = PerceiveFiveObjects();
    for (const auto& [step, seconds] : scene.seconds) sum_s[step] += seconds;
    objects = scene.objects.size();
  }
  for (const auto& [step, seconds] : sum_s) {
    state.counters[step + "_ms"] = Counter(seconds * 1e3, Counter::kAvgIterations);
  }
  state.counters["points"] = static_cast<double>(FiveObjectsCloud().size());
  state.counters["objects"] = static_cast<double>(objects);
}
BENCHMARK(Perceive)->Unit(benchmark::kMillisecond);

// Runs our steps (normals, segments) and PCL's (normals, clusters) in turn in every iteration, on
// the filtered points above the table. Counters: milliseconds of both, and the ratio ours / PCL for
// both steps and for the sum.
void PerceiveBesidePcl(benchmark::State& state) {
  FiveObjectsCloud();
  double normals = 0.0;
  double segments = 0.0;
  double pcl_normals = 0.0;
  double pcl_clusters = 0.0;
  std::size_t found_clusters = 0;
  for (auto _ : state) {
    const auto scene = PerceiveFiveObjects();
    normals += SecondsOf(scene, "normals");
    segments += SecondsOf(scene, "segments");
    base::Stopwatch watch;
    benchmark::DoNotOptimize(pcl_bridge::EstimateNormals(scene.cloud.points, SensorOrigin()));
    pcl_normals += watch.Restart();
    found_clusters = pcl_bridge::EuclideanClusters(scene.cloud.points, SensorOrigin()).size();
    pcl_clusters += watch.Restart();
  }
  auto& c = state.counters;
  c["ours_ms"] = Counter((normals + segments) * 1e3, Counter::kAvgIterations);
  c["pcl_ms"] = Counter((pcl_normals + pcl_clusters) * 1e3, Counter::kAvgIterations);
  c["pcl_segments"] = static_cast<double>(found_clusters);
  c["ratio"] = (normals + segments) / (pcl_normals + pcl_clusters);
  c["ratio_normals"] = normals / pcl_normals;
  c["ratio_segments"] = segments / pcl_clusters;
}
BENCHMARK(PerceiveBesidePcl)->Unit(benchmark::kMillisecond)->MinTime(2.0);

enum class PclSegmentation { kEuclidean, kLocalConvexity };

std::size_t CountPclSegments(PclSegmentation method, geometry::PointSpan points) {
  switch (method) {
    case PclSegmentation::kEuclidean:
      return pcl_bridge::EuclideanClusters(points, SensorOrigin()).size();
    case PclSegmentation::kLocalConvexity:
      return static_cast<std::size_t>(
          std::ranges::max(pcl_bridge::SegmentByLocalConvexity(points, SensorOrigin())) + 1);
  }
  return 0;
}

// Runs only the segmentation, ours and one of PCL's in turn, on the filtered points above the
// table. Argument: PCL's Euclidean clusters or local convexity (LCCP). Counters: milliseconds and
// segments of both, and the ratio ours / PCL. The scene has five objects.
void SegmentBesidePcl(benchmark::State& state) {
  const auto method = static_cast<PclSegmentation>(state.range(0));
  const geometry::PointCloud& points = FiveObjectsScene().cloud;
  double ours_s = 0.0;
  double pcl_s = 0.0;
  std::size_t ours = 0;
  std::size_t pcl = 0;
  for (auto _ : state) {
    base::Stopwatch watch;
    ours = perception::Segment(points, Cell().options.perception.segment).size();
    ours_s += watch.Restart();
    pcl = CountPclSegments(method, points.points);
    pcl_s += watch.Restart();
  }
  auto& c = state.counters;
  c["ours_ms"] = Counter(ours_s * 1e3, Counter::kAvgIterations);
  c["pcl_ms"] = Counter(pcl_s * 1e3, Counter::kAvgIterations);
  c["ours_segments"] = static_cast<double>(ours);
  c["pcl_segments"] = static_cast<double>(pcl);
  c["ratio"] = ours_s / pcl_s;
}
BENCHMARK(SegmentBesidePcl)->ArgName("method")->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rangegrasp::bench
