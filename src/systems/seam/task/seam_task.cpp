#include "seam/task/seam_task.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "experiment/view.h"
#include "seam/profile_io.h"
#include "seam/task/seam_score.h"

namespace rangegrasp::seam {
namespace {

using base::kMmPerM;
using draw::Panel;
using draw::Series;
using experiment::Case;
using experiment::Result;
using experiment::View;

// ---- pictures ----

// The dissertation's colors of the three detectors (fig. 3.17): green, blue, red.
constexpr std::array kDetectorColors = {"#2ca02c", "#1f77b4", "#d62728"};
constexpr const char* kTruthColor = "#444444";
constexpr std::array<const char*, kDecisions.size()> kDecisionColors = {"#c5b0d5", "#ffbb78",
                                                                        "#d62728"};
constexpr const char* kLocalStepColor = "#17becf";
// Pages of a view: evenly spaced profiles, and those with the largest errors. Their number
// determines the view's size, 25 kB per page.
constexpr std::size_t kEvenPages = 8;
constexpr std::size_t kWorstPages = 8;
// The decision method that pages show: unlike voting, it has a weight function to plot. Its edge
// may come from another profile of the last 100 ms.
constexpr auto kShown = static_cast<std::size_t>(DecisionMethod::kWeights);
// Distance between points of the true edge beyond the needle's path.
constexpr double kEdgeStep_m = 1e-3;

const char* ColorOf(std::size_t method) {
  if (method >= kAlone) return kDecisionColors[method - kAlone];
  return method == kLocalStep ? kLocalStepColor : kDetectorColors[method];
}

Panel PanelOf(const std::string& title, const std::string& x_label, const std::string& y_label) {
  return {title, x_label, y_label, {}, {}, {}};
}

void Add(Series& series, double along_m, double across_m) {
  series.x.push_back(along_m * kMmPerM);
  series.y.push_back(across_m * kMmPerM);
}

// A closed-loop run: needle, edge and the positions that were sent; below, the error along the
// path.
std::vector<Panel> TrackPanels(const TrackedRun& tracked, double wanted_distance_m) {
  const TrackResult& track = tracked.result;
  Panel map = PanelOf("Closed loop, seen from above", "along the track [mm]", "across [mm]");
  map.equal_axes = true;
  Series edge{"edge", {}, {}, kTruthColor};
  Series needle{"needle", {}, {}, "#d62728", false, 1.8};
  Series sensed{"positions sent", {}, {}, "#1f77b4", true};
  Panel errors =
      PanelOf("Error of the distance between seam and edge", "along the track [mm]", "[mm]");
  Series error{"", {}, {}, "#d62728"};
  for (const auto& point : track.path) {
    Add(needle, point.y_m, -point.x_m);
    Add(error, point.y_m, point.distance_m - wanted_distance_m);
    Add(edge, point.y_m, -tracked.mats.EdgeX(point.y_m));
  }
  for (const auto& point : track.sensed) Add(sensed, point.y_m, -point.x_m);
  // The line is ahead of the needle: its last positions need the true edge, too.
  const double end_m = track.sensed.empty() ? 0.0 : track.sensed.back().y_m;
  for (double y_m = track.path.back().y_m; y_m < end_m; y_m += kEdgeStep_m) {
    Add(edge, y_m, -tracked.mats.EdgeX(y_m));
  }
  map.series = {edge, sensed, needle};
  errors.series = {error};
  return {map, errors};
}

constexpr double kNoColumn = std::numeric_limits<double>::quiet_NaN();

// Positions that all methods reported for a seam's profiles.
struct Reported {
  std::vector<double> along_mm, truth;                // [column]
  std::array<std::vector<double>, kMethods> columns;  // of each method
  std::vector<double> wrong;                          // shown decision's error; not found: infinite
};

Reported ReportedOf(const SeamExperiment& experiment, const Calibration& calibration,
                    const Recording& recording) {
  Reported reported;
  reported.truth = recording.label_column;
  for (const RawProfile& raw : recording.raw) {
    reported.along_mm.push_back((raw.time_s - recording.raw.front().time_s) *
                                experiment.record.speed_m_s * kMmPerM);
  }
  const auto take = [&](std::size_t i, const Readings& readings, const auto&) {
    const auto positions = PositionsOf(readings);
    for (std::size_t m = 0; m < kMethods; ++m) {
      reported.columns[m].push_back(positions[m].value_or(kNoColumn));
    }
    const auto& shown = readings[kShown].column;
    const double error = std::abs(shown.value_or(kNoColumn) - reported.truth[i]);
    const bool none = std::isnan(reported.truth[i]) && !shown;
    reported.wrong.push_back(none ? 0.0 : std::isnan(error) ? INFINITY : error);
  };
  ReadSeam(experiment, calibration, recording, take);
  return reported;
}

Panel PathPanel(const LineGeometry& line, const Reported& reported) {
  Panel panel = PanelOf("Edge along the seam: true and detected positions", "along the seam [mm]",
                        "across, on the line [mm]");
  const auto add = [&](const std::string& name, const std::vector<double>& columns,
                       const char* color, bool dots) {
    Series& series = panel.series.emplace_back(Series{name, reported.along_mm, {}, color, dots});
    for (const double column : columns) series.y.push_back(line.ToMeters(column) * kMmPerM);
  };
  add("truth", reported.truth, kTruthColor, false);
  for (std::size_t m = 0; m < kMethods; ++m) {
    add(MethodTitle(m), reported.columns[m], ColorOf(m), m < kAlone);
  }
  return panel;
}

Panel ErrorPanel(const LineGeometry& line, const Reported& reported) {
  Panel panel = PanelOf("Error of each decision", "along the seam [mm]", "[mm]");
  for (std::size_t d = 0; d < kDecisions.size(); ++d) {
    Series series{TitleOf(kDecisions[d]), reported.along_mm, {}, kDecisionColors[d]};
    for (std::size_t i = 0; i < reported.truth.size(); ++i) {
      const double columns = reported.columns[kAlone + d][i] - reported.truth[i];
      series.y.push_back(columns / line.columns_per_m * kMmPerM);
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

// Indices of the profiles that pages show.
std::set<std::size_t> Shown(const std::vector<double>& wrong) {
  std::vector<std::size_t> order(wrong.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return wrong[i]; });
  order.resize(std::min(order.size(), kWorstPages));
  std::set<std::size_t> shown(order.begin(), order.end());
  const std::size_t even = std::min(kEvenPages, wrong.size());
  for (std::size_t i = 0; i < even; ++i) shown.insert(i * wrong.size() / even);
  return shown;
}

View::Page PageOf(const LineGeometry& line, const Reported& reported, std::size_t i,
                  const Reading& reading, const EdgeTracker& tracker) {
  View::Page page;
  const double truth = reported.truth[i];
  const double error_mm =
      (reading.column.value_or(kNoColumn) - truth) / line.columns_per_m * kMmPerM;
  page.name = fmt::format("profile {} of {}, {:.1f} mm along the seam: {}", i + 1,
                          reported.truth.size(), reported.along_mm[i], base::Word(reading.status));
  if (std::isfinite(error_mm)) page.name += fmt::format(", error {:.2f} mm", error_mm);
  page.panels = ProfilePanels(tracker, reading, line);
  if (!std::isfinite(truth)) return page;
  for (Panel& panel : page.panels) {
    panel.markers.insert(panel.markers.begin(), {truth, "truth", kTruthColor});
  }
  return page;
}

// A recorded seam: the true edge along it, the positions from each detector and decision method,
// and pages of profiles: evenly spaced ones and those with the largest errors.
View SeamView(const SeamExperiment& experiment, const Calibration& calibration,
              const Recording& recording) {
  const LineGeometry& line = experiment.sensor.line;
  const Reported reported = ReportedOf(experiment, calibration, recording);
  View view;
  view.panels = {PathPanel(line, reported), ErrorPanel(line, reported)};
  const auto shown = Shown(reported.wrong);
  const auto take = [&](std::size_t i, const Readings& readings, const auto& trackers) {
    if (!shown.contains(i)) return;
    view.pages.push_back(PageOf(line, reported, i, readings[kShown], trackers[kShown]));
  };
  ReadSeam(experiment, calibration, recording, take);
  return view;
}

// A closed-loop run, and the positions that each detector reported on the way.
View TrackView(const SeamExperiment& experiment, const TrackedRun& tracked) {
  View view;
  view.panels = TrackPanels(tracked, experiment.track.wanted_distance_m);
  Panel reported = PanelOf("Positions reported by each detector, on the sensor's line", "time [s]",
                           "across, on the line [mm]");
  const auto add = [&](Series series, const auto& column_of) {
    for (const Reading& reading : tracked.result.readings) {
      series.x.push_back(reading.time_s);
      const auto column = column_of(reading);
      const double shown = column ? *column : kNoColumn;
      series.y.push_back(experiment.sensor.line.ToMeters(shown) * kMmPerM);
    }
    reported.series.push_back(std::move(series));
  };
  for (std::size_t k = 0; k < kDetectors; ++k) {
    add({MethodTitle(k), {}, {}, kDetectorColors[k], true},
        [k](const Reading& reading) { return reading.detected[k]; });
  }
  add({"decided", {}, {}, kTruthColor}, [](const Reading& reading) { return reading.column; });
  view.panels.push_back(std::move(reported));
  return view;
}

std::string PathCsv(const TrackResult& track) {
  std::string text = "time_s,x_mm,y_mm,heading_deg,distance_mm\n";
  for (const TrackPoint& p : track.path) {
    text += fmt::format("{:.3f},{:.4f},{:.4f},{:.4f},{:.4f}\n", p.time_s, p.x_m * kMmPerM,
                        p.y_m * kMmPerM, base::ToDeg(p.heading_rad), p.distance_m * kMmPerM);
  }
  return text;
}

// ---- the task ----

std::string OutcomeOf(const RunResult& run) {
  if (run.reached_hazard) return "hazard_reached";
  if (run.stopped_early) return "stopped_early";
  return std::string(base::Word(run.end));
}

std::string DetailOf(const SeamResult& seam) {
  std::vector<std::string> details;
  for (std::size_t m = kAlone; m < kMethods; ++m) {
    const Tally& tally = seam.all[m];
    details.push_back(fmt::format("{}: {} of {} within {} px", MethodTitle(m), tally.within.back(),
                                  tally.profiles, kTolerances_px.back()));
  }
  return base::Join(details, "; ");
}

std::string DetailOf(const RunResult& run) {
  return fmt::format(
      "end: {}; error after 100 mm: mean {:.3f} mm, max {:.3f} mm; within 1 mm: "
      "{:.2f} % of the length",
      base::Word(run.end), run.mean_error_m * kMmPerM, run.max_error_m * kMmPerM,
      run.share_within_1mm * 100.0);
}

class SeamRunner final : public experiment::Task {
 public:
  explicit SeamRunner(SeamExperiment experiment)
      : experiment_(std::move(experiment)),
        sensor_(experiment_.sensor),
        calibration_(CalibrationOf(experiment_, sensor_)) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (int number = 0; number < experiment_.seams; ++number) {
      SeamParams params;
      params.number = number;
      params.shape = ShapeOf(experiment_, number);
      if (experiment_.kind == SeamKind::kRates) {
        cases.push_back(CaseOf(params));
        continue;
      }
      params.hazard = HazardOf(MatsOf(experiment_, number), experiment_.track.length_m);
      for (const auto method : experiment_.decisions) {
        params.method = method;
        cases.push_back(CaseOf(params));
      }
    }
    return cases;
  }

  Result Run(const Case& which) const override { return Run(which, nullptr); }

  Result Replay(const Case& which, const experiment::ReplayOptions& options) const override {
    if (!options.video.empty()) {
      throw base::InputError(
          "--video: seams have no video; their pictures are SVG files in the folder");
    }
    if (!options.camera.empty()) {
      throw base::InputError("--camera: seams have no cameras; they are shown from above");
    }
    return Run(which, &options);
  }

  void AddTo(experiment::Stamp& stamp) const override { seam::AddTo(stamp, experiment_); }

 private:
  Case CaseOf(const SeamParams& params) const {
    const std::string method(params.method ? base::Word(*params.method) : "");
    Case which;
    which.seed = SeamSeed(experiment_, params.number);
    which.params = ParamsOf(params);
    which.id = params.method ? fmt::format("run-{:04}-{}", params.number, method)
                             : fmt::format("seam-{:04}", params.number);
    which.group = base::Word(params.shape);
    if (experiment_.kind == SeamKind::kTracks) which.group = method;
    if (experiment_.kind == SeamKind::kHazards) which.group = base::Word(params.hazard);
    return which;
  }

  Result Run(const Case& which, const experiment::ReplayOptions* replay) const {
    const SeamParams params = ParamsFrom(which.params);
    const base::Stopwatch watch;
    if (!params.method) {
      const Recording recording = RecordSeam(experiment_, sensor_, params.number);
      if (replay) Show(recording, *replay, which.id);
      const SeamResult seam = ScoreSeam(experiment_, calibration_, recording, params.number);
      Result result{"measured", "score", DetailOf(seam), ToJson(seam), {{"seam", watch.Seconds()}}};
      std::ranges::move(TimeSteps(experiment_, calibration_, recording),
                        std::back_inserter(result.seconds));
      return result;
    }
    const TrackedRun tracked =
        TrackRun(experiment_, sensor_, calibration_, *params.method, params.number);
    if (replay) Show(tracked, *replay, which.id);
    const RunResult run = ScoreRun(experiment_, tracked);
    return {OutcomeOf(run), "score", DetailOf(run), ToJson(run), {{"run", watch.Seconds()}}};
  }

  // The recorded profiles with their labels, and a picture of the first one.
  void Show(const Recording& recording, const experiment::ReplayOptions& replay,
            const std::string& id) const {
    if (replay.view) {
      *replay.view = SeamView(experiment_, calibration_, recording);
      return;
    }
    std::vector<Profile> profiles;
    for (const RawProfile& raw : recording.raw) profiles.push_back(Calibrate(raw, calibration_));
    base::WriteFile(replay.folder / id / "labels.csv", LabelsCsv(recording));
    WriteProfiles(profiles, replay.folder / id / "profiles.csv");
    EdgeTracker tracker(TrackerFor(experiment_, DecisionMethod::kWeights));
    const Reading reading = tracker.Update(profiles.front());
    base::WriteFile(replay.folder / id / "profile.svg",
                    draw::PlotSvg(ProfilePanels(tracker, reading, experiment_.sensor.line)));
  }

  void Show(const TrackedRun& tracked, const experiment::ReplayOptions& replay,
            const std::string& id) const {
    if (replay.view) {
      *replay.view = TrackView(experiment_, tracked);
      return;
    }
    base::WriteFile(replay.folder / id / "path.csv", PathCsv(tracked.result));
    base::WriteFile(replay.folder / id / "packets.xml", base::Join(tracked.result.packets, ""));
    const auto panels = TrackPanels(tracked, experiment_.track.wanted_distance_m);
    base::WriteFile(replay.folder / id / "path.svg", draw::PlotSvg(panels, 900, 320));
  }

  SeamExperiment experiment_;
  StripeSensor sensor_;
  Calibration calibration_;
};

}  // namespace

const experiment::TaskKind& SeamTask() {
  static const experiment::TaskKind kind{
      .name = "seam",
      .description =
          "Detection of the edges of overlapping fibre mats in laser-stripe profiles, and a head "
          "that follows them.",
      .trials_key = "seams",
      .uses_seed = true,
      .success = {},
      .read = [](base::YamlMap& map,
                 const experiment::Common& common) -> std::unique_ptr<experiment::Task> {
        return std::make_unique<SeamRunner>(ReadSeamExperiment(map, common));
      },
      .read_keys =
          [](base::YamlMap& map) {
            SeamExperiment experiment;
            ReadKeys(map, experiment);
          },
      .report = ReportOf,
      .has_views = true};
  return kind;
}

std::string LabelsCsv(const Recording& recording) {
  std::string text = "profile,column\n";
  for (std::size_t i = 0; i < recording.label_column.size(); ++i) {
    const double label = recording.label_column[i];
    text += fmt::format("{},{}\n", i + 1, std::isfinite(label) ? fmt::format("{:.2f}", label) : "");
  }
  return text;
}

std::vector<Panel> ProfilePanels(const EdgeTracker& tracker, const Reading& reading,
                                 const LineGeometry& line) {
  // In the line's own columns, as the reading's.
  const auto series = [&](std::vector<float> values, double scale, const std::string& name,
                          const char* color) {
    if (tracker.mirrored()) std::ranges::reverse(values);
    Series curve{name, {}, {}, color};
    for (std::size_t i = 0; i < values.size(); ++i) {
      curve.x.push_back(static_cast<double>(i));
      curve.y.push_back(static_cast<double>(values[i]) * scale);
    }
    return curve;
  };
  const auto& prepared = tracker.prepared();
  Panel measured = PanelOf("Profile as measured", "", "height [mm]");
  measured.series.push_back(series(prepared.original_m, kMmPerM, "", "#444444"));
  Panel flat = PanelOf(fmt::format("Prepared: {}", base::Word(reading.status)), "", "height [mm]");
  flat.series.push_back(series(prepared.height_m, kMmPerM, "", "#444444"));
  if (reading.column) flat.markers.push_back({*reading.column, "edge", "#d62728"});
  Panel weights =
      PanelOf("Weight functions and positions of the three detectors",
              fmt::format("column ({} a mm)", std::lround(line.columns_per_m / kMmPerM)), "weight");
  for (std::size_t d = 0; d < kDetectors; ++d) {
    const std::string name(base::Word(static_cast<Detector>(d)));
    weights.series.push_back(series(tracker.results()[d].weight, 1.0, name, kDetectorColors[d]));
    const auto& column = reading.detected[d];
    if (column) weights.markers.push_back({static_cast<double>(*column), "", kDetectorColors[d]});
  }
  if (!tracker.weight().empty()) {
    weights.series.push_back(series(tracker.weight(), 1.0, "sum, weighted by history", "#7f7f7f"));
  }
  return {measured, flat, weights};
}

}  // namespace rangegrasp::seam
