#include "seam/task/seam_task.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/file.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "seam/profile_io.h"
#include "seam/task/seam_files.h"
#include "seam/task/seam_json.h"
#include "seam/task/seam_pictures.h"
#include "seam/task/seam_tables.h"
#include "seam/task/seam_times.h"
#include "seam/task/seam_view.h"

namespace rangegrasp::seam_task {
namespace {

using experiment::Case;
using experiment::Result;

std::string OutcomeOf(const RunResult& run) {
  if (run.reached_hazard) return "hazard_reached";
  if (run.stopped_early) return "stopped_early";
  return std::string(base::Word(run.end));
}

std::string DetailOf(const SeamResult& seam) {
  std::string detail;
  const std::size_t last = kTolerances_px.size() - 1;
  for (std::size_t m = kAlone; m < kMethods; ++m) {
    const Tally& tally = seam.all[m];
    detail += fmt::format("{}{}: {} of {} within {} px", detail.empty() ? "" : "; ", MethodTitle(m),
                          tally.within[last], tally.profiles, kTolerances_px[last]);
  }
  return detail;
}

std::string DetailOf(const RunResult& run) {
  return fmt::format(
      "end: {}; error after 100 mm: mean {:.3f} mm, 95 % {:.3f} mm, max {:.3f} mm; within 1 mm: "
      "{:.2f} % of the length",
      base::Word(run.end), run.mean_error_m * base::kMmPerM, run.p95_error_m * base::kMmPerM,
      run.max_error_m * base::kMmPerM, run.share_within_1mm * 100.0);
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

  Result Run(const Case& which) const override {
    const SeamParams params = ParamsFrom(which.params);
    const base::Stopwatch watch;
    if (!params.method) return Measured(params, watch);
    return Driven(params, TrackOf(params), watch);
  }

  Result Replay(const Case& which, const experiment::ReplayOptions& options) const override {
    if (!options.video.empty()) {
      throw base::InputError("--video: a seam has none; its pictures are SVG, in the folder");
    }
    if (!options.camera.empty()) {
      throw base::InputError("--camera: a seam is shown from above; there is none to choose");
    }
    const SeamParams params = ParamsFrom(which.params);
    const base::Stopwatch watch;
    const auto folder = options.folder / which.id;
    if (!params.method) {
      if (options.view) {
        *options.view =
            SeamView(experiment_, calibration_, RecordSeam(experiment_, sensor_, params.number));
      } else {
        ShowSeam(params.number, folder);
      }
      return Measured(params, watch);
    }
    const TrackedRun tracked = TrackOf(params);
    if (options.view) {
      *options.view = TrackView(experiment_, tracked);
      return Driven(params, tracked, watch);
    }
    base::WriteFile(folder / "path.csv", PathCsv(tracked.result));
    base::WriteFile(folder / "packets.xml", PacketsXml(tracked.result));
    base::WriteFile(folder / "path.svg",
                    draw::PlotSvg(TrackPanels(tracked.result, tracked.mats,
                                              experiment_.track.wanted_distance_m),
                                  900, 320));
    return Driven(params, tracked, watch);
  }

  void AddTo(experiment::Stamp& stamp) const override { seam_task::AddTo(stamp, experiment_); }

 private:
  Case CaseOf(const SeamParams& params) const {
    const std::string method(params.method ? base::Word(*params.method) : "");
    Case which;
    which.id = params.method ? fmt::format("run-{:04}-{}", params.number, method)
                             : fmt::format("seam-{:04}", params.number);
    which.group = base::Word(params.shape);
    if (experiment_.kind == SeamKind::kTracks) which.group = method;
    if (experiment_.kind == SeamKind::kHazards) which.group = base::Word(params.hazard);
    which.seed = SeamSeed(experiment_, params.number);
    which.params = ToJson(params);
    return which;
  }

  TrackedRun TrackOf(const SeamParams& params) const {
    return TrackRun(experiment_, sensor_, calibration_, *params.method, params.number);
  }

  Result Measured(const SeamParams& params, const base::Stopwatch& watch) const {
    const stitching::Recording recording = RecordSeam(experiment_, sensor_, params.number);
    const SeamResult seam = ScoreSeam(experiment_, calibration_, recording, params.number);
    Result result{"measured", "score", DetailOf(seam), ToJson(seam), {{"seam", watch.Seconds()}}};
    for (auto& step : TimeSteps(experiment_, calibration_, recording)) {
      result.seconds.push_back(std::move(step));
    }
    return result;
  }

  Result Driven(const SeamParams& params, const TrackedRun& tracked,
                const base::Stopwatch& watch) const {
    const RunResult run = ScoreRun(experiment_, *params.method, params.number, tracked);
    return {OutcomeOf(run), "score", DetailOf(run), ToJson(run), {{"run", watch.Seconds()}}};
  }

  // The recorded profiles with their labels, and a picture of the first one.
  void ShowSeam(int number, const std::filesystem::path& folder) const {
    const stitching::Recording recording = RecordSeam(experiment_, sensor_, number);
    std::vector<seam::Profile> profiles;
    for (const seam::RawProfile& raw : recording.raw) {
      profiles.push_back(seam::Calibrate(raw, calibration_));
    }
    base::WriteFile(folder / "labels.csv", LabelsCsv(recording));
    seam::WriteProfiles(profiles, folder / "profiles.csv", {});
    seam::EdgeTracker tracker(TrackerFor(experiment_, seam::DecisionMethod::kWeights));
    const seam::Reading reading = tracker.Update(profiles.front());
    base::WriteFile(folder / "profile.svg",
                    draw::PlotSvg(ProfilePanels(tracker, reading, experiment_.sensor.line)));
  }

  SeamExperiment experiment_;
  stitching::StripeSensor sensor_;
  seam::Calibration calibration_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  return std::make_unique<SeamRunner>(ReadSeamExperiment(map, common));
}

void ReadKeysAlone(base::YamlMap& map) {
  SeamExperiment experiment;
  ReadKeys(map, experiment);
}

}  // namespace

const experiment::TaskKind& SeamTask() {
  static const experiment::TaskKind kind{
      .name = "seam",
      .description =
          "Edges of overlapping fibre mats in laser-stripe profiles, and a head that follows them.",
      .trials_key = "seams",
      .uses_seed = true,
      .success = {},
      .read = Read,
      .read_keys = ReadKeysAlone,
      .report = ReportOf,
      .has_views = true};
  return kind;
}

}  // namespace rangegrasp::seam_task
