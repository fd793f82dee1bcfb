// How well objects that touch, lean and lie on each other come apart: this program's segmentations
// beside the Point Cloud Library's, on the same labelled clouds in one run. One line a cloud and
// segmentation as CSV; then, to stderr, one a segmentation. The labels are for evaluation alone.
//
//   rangegrasp_separation_survey --kinect tune|held_out|all
//   rangegrasp_separation_survey EXPERIMENT.yaml --seed N --scans N [--objects a,b] [--set K=V ...]
//     [--keep FOLDER]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "base/words.h"
#include "experiment/experiment.h"
#include "labelled_cloud.h"
#include "labelled_scan.h"
#include "pcl_bridge/pcl_segmentation.h"
#include "perception/perceive.h"
#include "perception/preprocess.h"
#include "register_all.h"
#include "separation_score.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp {
namespace {

using bench::LabelledScan;

/// What a segmentation made of a scan.
struct Found {
  std::vector<geometry::Points> objects;
  double seconds = 0.0;          ///< all of it
  double segment_seconds = 0.0;  ///< the segmentation's own step
};
using Method = std::function<Found(const LabelledScan&)>;

/// Perception as a whole.
Found Perceived(const LabelledScan& scan, perception::PerceptionOptions options,
                perception::SegmentMethod method) {
  options.segment.method = method;
  base::Rng rng(1);
  Found found;
  base::Stopwatch watch;
  const auto scene = perception::Perceive(scan.observation, options, rng, scan.workspace);
  found.seconds = watch.Seconds();
  for (const auto& [step, seconds] : scene.seconds) {
    if (step == "segments") found.segment_seconds = seconds;
  }
  for (const auto& object : scene.objects) {
    found.objects.push_back(geometry::Select(scene.cloud.points, object.points));
  }
  return found;
}

/// The segments before they are merged.
Found Segments(const LabelledScan& scan, perception::PerceptionOptions options) {
  options.segment.method = perception::SegmentMethod::kConvexity;
  base::Rng rng(1);
  Found found;
  const auto scene = perception::Perceive(scan.observation, options, rng, scan.workspace);
  for (const auto& segment : scene.segments) {
    found.objects.push_back(geometry::Select(scene.cloud.points, segment));
  }
  return found;
}

/// The points that the peers get: those above the table, which this program finds for them. Their
/// time begins after it.
geometry::Points AboveTable(const LabelledScan& scan) {
  const geometry::Points points = scan.Measured();
  perception::PerceptionOptions options;
  base::Rng rng(1);
  const auto sampling = perception::MeasureSampling(points, options.sampling);
  perception::AdaptLengths(sampling, options);
  auto table = perception::FindTable(points, scan.origin_C, options.preprocess, rng);
  if (!table) return {};
  const auto fit = perception::FitNoisy(table->plane, points, options.preprocess.preselection_m,
                                        options.sampling);
  const double clearance_m =
      std::max<double>(options.preprocess.table_clearance_m, 5.0 * fit.noise_m);
  geometry::Points above;
  for (const auto& p : points) {
    if (fit.plane.Distance(p) > clearance_m) above.push_back(p);
  }
  return above;
}

std::vector<geometry::Points> Grouped(const geometry::Points& points,
                                      const std::vector<std::int32_t>& segment) {
  std::vector<geometry::Points> groups;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (segment[i] < 0) continue;
    const auto s = static_cast<std::size_t>(segment[i]);
    if (groups.size() <= s) groups.resize(s + 1);
    groups[s].push_back(points[i]);
  }
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  return groups;
}

/// Stein et al. 2014 as the library has it, with the lengths that suit the sensor.
Found LocallyConvex(const LabelledScan& scan) {
  const geometry::Points above = AboveTable(scan);
  pcl_bridge::LocalConvexityOptions options{.voxel_m = 0.010, .seed_m = 0.040};
  if (scan.depth_camera) options = {.voxel_m = 0.0075, .seed_m = 0.030, .camera_depth = true};
  base::Stopwatch watch;
  const auto found =
      pcl_bridge::SegmentByLocalConvexity(pcl_bridge::Cloud(above, scan.origin_C), options);
  const double seconds = watch.Seconds();
  return {Grouped(above, found.segment), seconds, seconds};
}

Found Clustered(const LabelledScan& scan) {
  const geometry::Points above = AboveTable(scan);
  // Two lines of the laser's points; the noise of a depth camera.
  const pcl_bridge::EuclideanClusterOptions options{.tolerance_m = 0.010};
  base::Stopwatch watch;
  const auto clusters =
      pcl_bridge::EuclideanClusters(pcl_bridge::Cloud(above, scan.origin_C), options);
  Found found;
  for (const auto& cluster : clusters) found.objects.push_back(geometry::Select(above, cluster));
  found.seconds = found.segment_seconds = watch.Seconds();
  return found;
}

/// Scores of one segmentation over all scans.
class Sum {
 public:
  void Add(const labelled::Separation& score, const Found& found) {
    scores_.push_back(score);
    seconds_ += found.seconds;
    segment_seconds_ += found.segment_seconds;
    max_seconds_ = std::max(max_seconds_, found.seconds);
  }

  void Print(const std::string& name) const {
    const double n = static_cast<double>(scores_.size());
    double right = 0.0;
    for (const auto& s : scores_) right += s.right ? 1.0 : 0.0;
    const auto [overlap, error] = Weighted(&labelled::Separation::overlap);
    fmt::print(stderr,
               "{:16} overlap {:.3f} +- {:.3f}, over {:.3f}, under {:.3f}, wholly right {:5.1f} % "
               "+- {:.1f} of {}, {:.3f} s a cloud (most {:.3f}), segmentation {:.3f} s\n",
               name, overlap, error, Weighted(&labelled::Separation::over).first,
               Weighted(&labelled::Separation::under).first, 100.0 * right / n,
               100.0 * std::sqrt(right / n * (1.0 - right / n) / n), scores_.size(), seconds_ / n,
               max_seconds_, segment_seconds_ / n);
  }

 private:
  /// Mean weighted by the objects' points, and its standard error over the clouds.
  std::pair<double, double> Weighted(double labelled::Separation::*value) const {
    double sum = 0.0;
    double weight = 0.0;
    for (const auto& s : scores_) {
      sum += s.points * s.*value;
      weight += s.points;
    }
    const double mean = sum / weight;
    double squares = 0.0;
    for (const auto& s : scores_) {
      squares += s.points * s.points * (s.*value - mean) * (s.*value - mean);
    }
    return {mean, std::sqrt(squares) / weight};
  }

  std::vector<labelled::Separation> scores_;
  double seconds_ = 0.0;
  double segment_seconds_ = 0.0;
  double max_seconds_ = 0.0;
};

class Survey {
 public:
  explicit Survey(std::vector<std::pair<std::string, Method>> methods)
      : methods_(std::move(methods)) {
    fmt::print("scan,segmentation,overlap,over,under,right,objects,found,of_table,seconds\n");
  }

  void Add(const LabelledScan& scan) {
    for (const auto& [name, method] : methods_) {
      const Found found = method(scan);
      const auto assigned = labelled::AssignToObjects(scan.image().points_C, found.objects);
      const auto score = labelled::Compare(scan.label, assigned);
      sums_[name].Add(score, found);
      // A vessel's inside, a handle and what occlusion cuts off have labels of their own on the
      // depth camera's clouds: the tens of a label are the body.
      std::vector<std::uint32_t> body = scan.label;
      if (scan.depth_camera) {
        for (auto& label : body) label = label >= 20 ? label / 10 * 10 : label;
      }
      sums_[name + " by body"].Add(labelled::Compare(body, assigned), found);
      fmt::print("{},{},{:.4f},{:.4f},{:.4f},{},{},{},{},{:.3f}\n", scan.name, name, score.overlap,
                 score.over, score.under, score.right ? 1 : 0, score.objects, found.objects.size(),
                 score.of_table, found.seconds);
    }
  }

  void Print() const {
    for (const auto& [name, method] : methods_) sums_.at(name).Print(name);
    for (const auto& [name, method] : methods_)
      sums_.at(name + " by body").Print(name + " by body");
  }

 private:
  std::vector<std::pair<std::string, Method>> methods_;
  std::map<std::string, Sum> sums_;
};

std::vector<std::pair<std::string, Method>> Methods(const perception::PerceptionOptions& options,
                                                    const std::vector<std::string>& only) {
  std::vector<std::pair<std::string, Method>> methods;
  for (const auto word : WordsOf(perception::SegmentMethod{})) {
    const auto method = base::FromWord<perception::SegmentMethod>(word, "");
    methods.emplace_back(word, [options, method](const LabelledScan& scan) {
      return Perceived(scan, options, method);
    });
  }
  methods.emplace_back("segments",
                       [options](const LabelledScan& scan) { return Segments(scan, options); });
  methods.emplace_back("lccp", LocallyConvex);
  methods.emplace_back("euclidean", Clustered);
  std::erase_if(methods, [&](const auto& m) {
    return !only.empty() && std::ranges::find(only, m.first) == only.end();
  });
  return methods;
}

void SurveyKinect(const std::string& which, Survey& survey) {
  constexpr int kTuned = 4;  // numbers divisible by it may be tuned on
  for (const int number : labelled::KinectNumbers()) {
    if (which == "tune" && number % kTuned != 0) continue;
    if (which == "held_out" && number % kTuned == 0) continue;
    survey.Add(bench::OfCamera(labelled::ReadKinect(number), fmt::format("learn{}", number)));
  }
}

void SurveyTrials(const trial::Cell& cell, const std::vector<std::string>& objects,
                  std::uint64_t seed, int scans, const std::string& keep, Survey& survey) {
  for (const auto& object : objects.empty() ? cell.options.objects : objects) {
    for (int i = 0; i < scans; ++i) {
      const auto scan = bench::OfTrial(cell, {object, i, trial::TrialSeed(seed, object, i)}, keep);
      if (scan) survey.Add(*scan);
    }
  }
}

}  // namespace
}  // namespace rangegrasp

int main(int argc, char** argv) {
  rangegrasp::RegisterAll();
  using namespace rangegrasp;
  std::string file, kinect, keep;
  std::vector<std::string> only;
  std::uint64_t seed = 0;
  int scans = 10;
  experiment::Changes changes;
  CLI::App app{"How well objects that touch come apart, beside the Point Cloud Library."};
  app.add_option("experiment", file, "experiment file (YAML) of the clutter to scan");
  app.add_option("--kinect", kinect, "labelled clouds instead")
      ->check(CLI::IsMember({"tune", "held_out", "all"}));
  app.add_option("--seed", seed, "of the experiment");
  app.add_option("--scans", scans, "with each object as the target");
  app.add_option("--objects", changes.groups, "only these targets")->delimiter(',');
  app.add_option("--set", changes.set, "KEY=VALUE")->take_all();
  app.add_option("--only", only, "only these segmentations")->delimiter(',');
  app.add_option("--keep", keep, "folder that scans are kept in and read again from");
  CLI11_PARSE(app, argc, argv);
  if (!kinect.empty()) {
    Survey survey(Methods({}, only));
    SurveyKinect(kinect, survey);
    survey.Print();
    return 0;
  }
  const auto experiment = experiment::OpenExperiment(file, experiment::AllKinds(), changes);
  const auto& cell = trial::CellOf(*experiment.task);
  Survey survey(Methods(cell.options.perception, only));
  SurveyTrials(cell, changes.groups, seed, scans, keep, survey);
  survey.Print();
  return 0;
}
