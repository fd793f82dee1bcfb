// The steps of detecting given cylinders in a cloud as large as that of table 4.2, compared with
// the Point Cloud Library's counterparts in the same run on the same cloud.

#include <benchmark/benchmark.h>

#include <map>

#include "base/stopwatch.h"
#include "cylinders/detect.h"
#include "cylinders/task/tabletop_scan.h"
#include "pcl_bridge/pcl_segmentation.h"

namespace rangegrasp::bench {
namespace {

using benchmark::Counter;
namespace scans = cylinders::samples;

const std::vector<cylinders::GivenCylinder> kGiven = {{0.02575, 0.173}, {0.02675, 0.134}};

/// The two given cylinders among boxes and a third cylinder, in 76,176 points (table 4.2: 75,863).
/// @param field_deg  field of view in both directions; a narrower one has more points on objects
geometry::Observation TabletopOf(std::int64_t field_deg) {
  const scans::Tabletop tabletop = {
      {scans::Standing(0.0, -0.07, 0.02575, 0.173), scans::Lying(0.04, 0.07, 1.2, 0.02675, 0.134),
       scans::Standing(-0.08, 0.06, 0.035, 0.15)},
      {scans::StandingBox(-0.05, -0.13, 0.4, {0.06, 0.05, 0.10}),
       scans::StandingBox(0.10, -0.03, 1.1, {0.05, 0.04, 0.06})}};
  base::Rng rng(1);
  const scans::Sensor sensor{.target = {0.0, 0.0, 0.05},
                             .profiles = 276,
                             .samples = 276,
                             .field_rad = base::Deg(static_cast<double>(field_deg))};
  return scans::Scan(tabletop, sensor, rng);
}

struct PclCylinderSeconds {
  double normals = 0.0, clusters = 0.0, cylinders = 0.0;

  double Sum() const { return normals + clusters + cylinders; }
};

/// Times NormalEstimation, EuclideanClusterExtraction, and SACSegmentation for a cylinder in every
/// cluster.
PclCylinderSeconds RunPcl(const geometry::Points& above, const Eigen::Vector3d& origin) {
  PclCylinderSeconds seconds;
  base::Stopwatch watch;
  const auto normals = pcl_bridge::EstimateNormals(above, origin);
  seconds.normals = watch.Restart();
  const auto clusters = pcl_bridge::EuclideanClusters(above, origin);
  seconds.clusters = watch.Restart();
  for (const auto& cluster : clusters) {
    const auto part = geometry::Select(above, cluster);
    const auto part_normals = geometry::Select(normals, cluster);
    watch.Restart();
    benchmark::DoNotOptimize(pcl_bridge::FitCylinder(part, origin, part_normals,
                                                     {.min_radius_m = 0.02, .max_radius_m = 0.03}));
    seconds.cylinders += watch.Restart();
  }
  return seconds;
}

// Argument: the sensor's field of view [deg]. Counters: milliseconds of our steps and of PCL, which
// gets the points that our filter kept, and the ratio of all of ours to PCL's.
void DetectCylindersBesidePcl(benchmark::State& state) {
  const geometry::Observation observation = TabletopOf(state.range(0));
  const geometry::RangeImage& image = observation.views.front().image;
  const std::size_t points = geometry::ToCloud(image).points.size();
  std::map<std::string, double> ours;
  double sum_s = 0.0;
  double pcl_s = 0.0;
  PclCylinderSeconds pcl;
  std::size_t found = 0;
  std::size_t above = 0;
  for (auto _ : state) {
    base::Rng rng(1);
    base::Stopwatch watch;
    const auto scene =
        cylinders::DetectCylinders(observation, kGiven, cylinders::DetectOptions{}, rng);
    sum_s += watch.Seconds();
    for (const auto& [step, seconds] : scene.seconds) ours[step] += seconds;
    found = scene.cylinders.size();
    above = scene.cloud.size();
    pcl = RunPcl(scene.cloud.points, image.origins_C.front());
    pcl_s += pcl.Sum();
  }
  auto& c = state.counters;
  for (const auto& [step, seconds] : ours) {
    c[step + "_ms"] = Counter(seconds * 1e3, Counter::kAvgIterations);
  }
  c["ours_ms"] = Counter(sum_s * 1e3, Counter::kAvgIterations);
  c["pcl_ms"] = Counter(pcl_s * 1e3, Counter::kAvgIterations);
  c["pcl_last_cylinders_ms"] = pcl.cylinders * 1e3;
  c["ratio"] = sum_s / pcl_s;
  c["points"] = static_cast<double>(points);
  c["above"] = static_cast<double>(above);
  c["found"] = static_cast<double>(found);
}
BENCHMARK(DetectCylindersBesidePcl)
    ->ArgName("field_deg")
    ->Arg(28)
    ->Arg(18)
    ->Unit(benchmark::kMillisecond)
    ->MinTime(2.0);

}  // namespace
}  // namespace rangegrasp::bench
