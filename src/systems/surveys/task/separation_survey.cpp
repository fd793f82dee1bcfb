#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "base/words.h"
#include "pcl_bridge/pcl_segmentation.h"
#include "perception/perceive.h"
#include "perception/preprocess.h"
#include "sim/world.h"
#include "surveys/separation.h"
#include "surveys/task/measures.h"

namespace rangegrasp::surveys {
namespace {

using experiment::Column;
using experiment::Section;
using nlohmann::ordered_json;

/// One view with the ground truth of each sample, for evaluation only.
struct LabelledScan {
  geometry::Observation observation;
  std::vector<std::uint32_t> label;  ///< as in surveys::Compare
  std::optional<perception::Workspace> workspace;
  bool depth_camera = false;  ///< point spacing grows with depth; else a line scanner's

  const geometry::Points& points_C() const { return observation.views.front().image.points_C; }
};

LabelledScan ScanOf(const trial::Cell& cell, const sim::World& world, std::uint64_t seed) {
  auto sensed = trial::Look(cell, world, seed);
  LabelledScan scan{std::move(sensed.observation),
                    {},
                    trial::WorkspaceOf(cell.robot, cell.options.workspace_margin_m)};
  constexpr std::uint32_t kScene = 1;
  for (std::size_t i = 0; i < scan.points_C().size(); ++i) {
    const Eigen::Vector3d& p_C = scan.points_C()[i];
    const std::uint32_t body = sensed.truth.front().label[i];
    const bool counts = p_C.allFinite() && scan.workspace->Contains(p_C);
    const bool object = body != 0 && body != sim::kContainerLabel;
    scan.label.push_back(!counts ? 0 : object ? kFirstObject + body - 1 : kScene);
  }
  return scan;
}

struct Found {
  std::vector<geometry::Points> objects;
  double seconds = 0.0;
};

Found Perceived(const LabelledScan& scan, perception::PerceptionOptions options,
                perception::SegmentMethod method) {
  options.segment.method = method;
  base::Rng rng(1);
  Found found;
  const base::Stopwatch watch;
  const auto scene = perception::Perceive(scan.observation, options, rng, scan.workspace);
  found.seconds = watch.Seconds();
  for (const auto& object : scene.objects) {
    found.objects.push_back(geometry::Select(scene.cloud.points, object.points));
  }
  return found;
}

/// Input of the library's methods: the points above the table, which this program finds for them.
/// Their timing starts afterwards.
geometry::Points AboveTable(const LabelledScan& scan, const Eigen::Vector3d& origin_C) {
  geometry::Points points;
  for (std::size_t i = 0; i < scan.label.size(); ++i) {
    // A depth camera's unlabeled points are measured, too.
    const bool measured = scan.depth_camera ? scan.points_C()[i].allFinite() : scan.label[i] > 0;
    if (measured) points.push_back(scan.points_C()[i]);
  }
  perception::PerceptionOptions options;
  base::Rng rng(1);
  const auto sampling = perception::MeasureSampling(points, options.sampling);
  perception::AdaptLengths(sampling, options);
  const auto table = perception::FindTable(points, origin_C, options.preprocess, rng);
  if (!table) return {};
  const auto fit = perception::FitNoisy(table->plane, points, options.preprocess.preselection_m,
                                        options.sampling);
  const double clearance_m =
      std::max<double>(options.preprocess.table_clearance_m, 5.0 * fit.noise_m);
  std::erase_if(points, [&](const auto& p) { return fit.plane.Distance(p) <= clearance_m; });
  return points;
}

/// Stein et al. 2014, as implemented in the library, with lengths that suit the sensor.
Found LocallyConvex(const geometry::Points& above, const Eigen::Vector3d& origin_C,
                    bool depth_camera) {
  pcl_bridge::LocalConvexityOptions options{.voxel_m = 0.010, .seed_m = 0.040};
  if (depth_camera) options = {.voxel_m = 0.0075, .seed_m = 0.030, .camera_depth = true};
  const base::Stopwatch watch;
  const auto segment = pcl_bridge::SegmentByLocalConvexity(above, origin_C, options);
  Found found{{}, watch.Seconds()};
  for (std::size_t i = 0; i < above.size(); ++i) {
    if (segment[i] < 0) continue;
    const auto s = static_cast<std::size_t>(segment[i]);
    found.objects.resize(std::max(found.objects.size(), s + 1));
    found.objects[s].push_back(above[i]);
  }
  std::erase_if(found.objects, [](const auto& object) { return object.empty(); });
  return found;
}

Found Clustered(const geometry::Points& above, const Eigen::Vector3d& origin_C) {
  // Covers two lines of the laser's points, or the noise of a depth camera.
  const pcl_bridge::EuclideanClusterOptions options{.tolerance_m = 0.010};
  const base::Stopwatch watch;
  const auto clusters = pcl_bridge::EuclideanClusters(above, origin_C, options);
  Found found;
  for (const auto& cluster : clusters) found.objects.push_back(geometry::Select(above, cluster));
  found.seconds = watch.Seconds();
  return found;
}

/// The labels of recorded clouds with one label per object: 20 to 29 are parts of the first, e.g.
/// the inside of a cup whose middle is hidden.
std::vector<std::uint32_t> WholeObjects(std::vector<std::uint32_t> label) {
  for (std::uint32_t& one : label) one -= one >= kFirstObject ? one % 10 : 0;
  return label;
}

ordered_json Measure(const LabelledScan& scan, const perception::PerceptionOptions& options,
                     Seconds& seconds) {
  const Eigen::Vector3d origin_C =
      geometry::Centroid(scan.observation.views.front().image.origins_C);
  const geometry::Points above = AboveTable(scan, origin_C);
  const std::vector<std::uint32_t> whole_label =
      scan.depth_camera ? WholeObjects(scan.label) : std::vector<std::uint32_t>();
  ordered_json data = ordered_json::object();
  const auto add = [&](const std::string& name, const Found& found) {
    const auto segment = AssignToObjects(scan.points_C(), found.objects);
    const auto score = Compare(scan.label, segment);
    data[name] = {{"overlap", score.overlap},      {"over", score.over},
                  {"under", score.under},          {"points", score.points},
                  {"right", score.right},          {"objects", score.objects},
                  {"found", found.objects.size()}, {"of_table", score.of_table}};
    if (scan.depth_camera) {
      const auto whole = Compare(whole_label, segment);
      data[name]["whole_overlap"] = whole.overlap;
      data[name]["whole_right"] = whole.right;
    }
    seconds.emplace_back(name, found.seconds);
  };
  for (const auto method : base::ValuesOf<perception::SegmentMethod>()) {
    add(std::string(base::Word(method)), Perceived(scan, options, method));
  }
  add("lccp", LocallyConvex(above, origin_C, scan.depth_camera));
  add("euclidean", Clustered(above, origin_C));
  return data;
}

}  // namespace

ordered_json MeasureSeparation(const trial::Cell& cell, const trial::Arrangement& scene,
                               std::uint64_t seed, Seconds& seconds) {
  return Measure(ScanOf(cell, scene.world, seed), cell.options.perception, seconds);
}

ordered_json MeasureSeparation(const geometry::CloudFile& cloud,
                               const perception::PerceptionOptions& options, Seconds& seconds) {
  geometry::RangeImage image{.profiles = 1,
                             .samples = static_cast<int>(cloud.points.size()),
                             .points_C = cloud.points,
                             .origins_C = {cloud.sensor_origin.value_or(Eigen::Vector3d::Zero())}};
  return Measure({geometry::ObservationOf(std::move(image)), cloud.labels, {}, true}, options,
                 seconds);
}

Section SeparationTable(const std::vector<Measured>& scans) {
  struct Row {
    std::string name;
    std::vector<ordered_json> scores;
    std::vector<double> seconds;

    /// Mean weighted by the objects' points, and its standard error over the scans.
    std::pair<double, double> Weighted(const char* value) const {
      double sum = 0.0, weight = 0.0, squares = 0.0;
      for (const auto& s : scores) {
        sum += s.at("points").get<double>() * s.at(value).get<double>();
        weight += s.at("points").get<double>();
      }
      const double mean = sum / std::max(weight, 1.0);
      for (const auto& s : scores) {
        squares += std::pow(s.at("points").get<double>() * (s.at(value).get<double>() - mean), 2);
      }
      return {mean, std::sqrt(squares) / std::max(weight, 1.0)};
    }
    int Right(const char* verdict) const {
      return static_cast<int>(
          std::ranges::count_if(scores, [&](const auto& s) { return s.at(verdict); }));
    }
    int Count() const { return static_cast<int>(scores.size()); }
  };
  std::vector<Row> rows;
  for (const Measured& scan : scans) {
    for (const auto& [name, score] : scan.data.items()) {
      auto row = std::ranges::find(rows, name, &Row::name);
      if (row == rows.end()) row = rows.insert(rows.end(), {name, {}, {}});
      row->scores.push_back(score);
      for (const auto& [step, seconds] : scan.record->result.seconds) {
        if (step == name) row->seconds.push_back(seconds);
      }
    }
  }
  const auto mean = [](const char* value) {
    return [value](const Row& row) { return row.Weighted(value).first; };
  };
  const auto right = [](const char* verdict) {
    return [verdict](const Row& row) {
      return experiment::PercentText(row.Right(verdict), row.Count(), 1);
    };
  };
  std::vector<Column<Row>> columns = {
      {"segmentation", "", &Row::name, experiment::kLeft},
      {"scans", "", &Row::Count},
      {"overlap", ".3f", mean("overlap")},
      {"+-", ".3f", [](const Row& row) { return row.Weighted("overlap").second; }},
      {"over", ".3f", mean("over")},
      {"under", ".3f", mean("under")},
      {"all objects right %", "", right("right")},
      {"95 %", "",
       [](const Row& row) { return experiment::IntervalText(row.Right("right"), row.Count()); }},
      {"t [s]", ".3f", [](const Row& row) { return experiment::MeanOf(row.seconds).mean; }}};
  if (!rows.empty() && rows.front().scores.front().contains("whole_overlap")) {
    columns.push_back({"overlap of whole objects", ".3f", mean("whole_overlap")});
    columns.push_back(
        {"+- of them", ".3f", [](const Row& row) { return row.Weighted("whole_overlap").second; }});
    columns.push_back({"all whole objects right %", "", right("whole_right")});
  }
  return {"Separation of touching objects, weighted by their points", GridOf(columns, rows)};
}

}  // namespace rangegrasp::surveys
