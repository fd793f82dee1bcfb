#include "seam/task/seam_score.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/error.h"
#include "base/stopwatch.h"

namespace rangegrasp::seam {
namespace {

using nlohmann::ordered_json;

// A label this close to the line's end has no visible edge.
constexpr double kMargin_columns = 20.0;
// The middle half of the line is its center (section 3.5).
constexpr double kCenterHalf = 0.25;
// A hazard counts as seen if it begins up to this far beyond the sensor's line: fray and an
// obstacle's border reach out by less.
constexpr double kSeen_m = 0.002;

// Runs a function on the parsed text; anything missing there means a damaged store.
auto From(const std::string& text, auto read) {
  try {
    return read(ordered_json::parse(text));
  } catch (const std::exception& error) {
    throw base::RunError("a seam's record is damaged: " + std::string(error.what()));
  }
}

// [profiles, within 3 px, ...]
ordered_json TallyJson(const Tally& tally) {
  ordered_json json = tally.within;
  json.insert(json.begin(), tally.profiles);
  return json;
}

Tally TallyFrom(const ordered_json& json) {
  Tally tally;
  tally.profiles = json.at(0);
  for (std::size_t t = 0; t < tally.within.size(); ++t) tally.within[t] = json.at(t + 1);
  return tally;
}

constexpr std::array<std::pair<const char*, double RunResult::*>, 4> kRunNumbers = {
    {{"settled_m", &RunResult::settled_m},
     {"mean_error_m", &RunResult::mean_error_m},
     {"max_error_m", &RunResult::max_error_m},
     {"share_within_1mm", &RunResult::share_within_1mm}}};

}  // namespace

std::string TitleOf(DecisionMethod decision) {
  constexpr std::array<const char*, kDecisions.size()> kTitles = {
      "Voting as published", "Weights + history as published", "Tracked steps (own)"};
  return kTitles[static_cast<std::size_t>(decision)];
}

std::string MethodTitle(std::size_t method) {
  if (method >= kAlone) return TitleOf(kDecisions[method - kAlone]);
  if (method == kLocalStep) return "Local step (own)";
  return std::string(base::Word(static_cast<Detector>(method)));
}

std::string PublishedRow(std::size_t method) {
  if (method == kAlone + static_cast<std::size_t>(DecisionMethod::kVoting)) {
    return "Combined Result";
  }
  return method < kDetectors ? MethodTitle(method) : "";
}

void Tally::Count(double error_px) {
  ++profiles;
  for (std::size_t i = 0; i < within.size(); ++i) {
    within[i] += error_px <= kTolerances_px[i] ? 1 : 0;
  }
}

Tally& Tally::operator+=(const Tally& other) {
  profiles += other.profiles;
  for (std::size_t i = 0; i < within.size(); ++i) within[i] += other.within[i];
  return *this;
}

std::array<std::optional<double>, kMethods> PositionsOf(const Readings& readings) {
  std::array<std::optional<double>, kMethods> positions;
  // Of voting; tracked steps have none of the three.
  std::ranges::copy(readings.front().detected, positions.begin());
  positions[kLocalStep] = readings[static_cast<std::size_t>(DecisionMethod::kSteps)].local_step;
  std::ranges::transform(readings, positions.begin() + kAlone, &Reading::column);
  return positions;
}

void ReadSeam(const SeamExperiment& experiment, const Calibration& calibration,
              const Recording& recording,
              const std::function<void(std::size_t, const Readings&,
                                       const std::vector<EdgeTracker>&)>& take) {
  std::vector<EdgeTracker> trackers;
  for (const auto decision : kDecisions) trackers.emplace_back(TrackerFor(experiment, decision));
  for (std::size_t i = 0; i < recording.raw.size(); ++i) {
    const Profile profile = Calibrate(recording.raw[i], calibration);
    Readings readings;
    for (std::size_t d = 0; d < trackers.size(); ++d) readings[d] = trackers[d].Update(profile);
    take(i, readings, trackers);
  }
}

SeamResult ScoreSeam(const SeamExperiment& experiment, const Calibration& calibration,
                     const Recording& recording, int number) {
  SeamResult result{.params = {.number = number, .shape = ShapeOf(experiment, number)},
                    .height_m = MatsOf(experiment, number).height_m};
  const int columns = experiment.sensor.line.columns;
  const auto take = [&](std::size_t i, const Readings& readings, const auto&) {
    ++result.profiles;
    for (std::size_t d = 0; d < readings.size(); ++d) {
      result.no_edge[kAlone + d] += readings[d].status == ProfileStatus::kNoEdge ? 1 : 0;
    }
    const double label = recording.label_column[i];
    if (!(label >= kMargin_columns && label <= columns - 1 - kMargin_columns)) return;
    const bool center = std::abs(label - 0.5 * (columns - 1)) < kCenterHalf * columns;
    const auto positions = PositionsOf(readings);
    for (std::size_t m = 0; m < kMethods; ++m) {
      const double error = std::abs(positions[m].value_or(std::nan("")) - label);
      result.all[m].Count(error);
      (center ? result.center : result.boundary)[m].Count(error);
    }
  };
  ReadSeam(experiment, calibration, recording, take);
  return result;
}

RunResult ScoreRun(const SeamExperiment& experiment, const TrackedRun& tracked) {
  const MatOptions& mats = tracked.mats.options();
  const TrackResult& track = tracked.result;
  const TrackPoint& last = track.path.back();
  RunResult result{track};
  // Where the hazard begins along the track. A head that was still further from it than its sensor
  // sees stopped without a reason.
  const double begin_m = mats.obstacles.empty()
                             ? mats.end_y_m
                             : mats.obstacles[0].y_m - 0.5 * mats.obstacles[0].size_y_m;
  const double sees_to_m = last.y_m + experiment.sensor.lines_ahead_m.front();
  result.stopped_early = track.end != TrackEnd::kDone && sees_to_m < begin_m - kSeen_m;
  result.settled_m = std::max(0.0, last.y_m - track.path.front().y_m - kSettle_m);
  return result;
}

experiment::Params ParamsOf(const SeamParams& params) {
  const std::string shape(base::Word(params.shape));
  if (!params.method) return {{"seam", params.number}, {"shape", shape}};
  return {{"run", params.number},
          {"shape", shape},
          {"method", std::string(base::Word(*params.method))},
          {"hazard", std::string(base::Word(params.hazard))}};
}

SeamParams ParamsFrom(const experiment::Params& params) {
  SeamParams seam;
  seam.shape = base::FromWord<EdgeShape>(params.Text("shape"), "shape");
  seam.number = params.Int(params.Has("seam") ? "seam" : "run");
  if (params.Has("seam")) return seam;
  seam.method = base::FromWord<DecisionMethod>(params.Text("method"), "method");
  seam.hazard = base::FromWord<Hazard>(params.Text("hazard"), "hazard");
  return seam;
}

std::string ToJson(const SeamResult& result) {
  ordered_json json = {{"height_m", result.height_m}, {"profiles", result.profiles}};
  for (std::size_t m = 0; m < kMethods; ++m) {
    json["methods"][MethodTitle(m)] = {{"all", TallyJson(result.all[m])},
                                       {"center", TallyJson(result.center[m])},
                                       {"boundary", TallyJson(result.boundary[m])},
                                       {"no_edge", result.no_edge[m]}};
  }
  return json.dump();
}

SeamResult SeamResultFrom(const SeamParams& params, const std::string& text) {
  return From(text, [&](const ordered_json& json) {
    SeamResult result{
        .params = params, .height_m = json.at("height_m"), .profiles = json.at("profiles")};
    for (std::size_t m = 0; m < kMethods; ++m) {
      const ordered_json& method = json.at("methods").at(MethodTitle(m));
      result.all[m] = TallyFrom(method.at("all"));
      result.center[m] = TallyFrom(method.at("center"));
      result.boundary[m] = TallyFrom(method.at("boundary"));
      result.no_edge[m] = method.at("no_edge");
    }
    return result;
  });
}

std::string ToJson(const RunResult& result) {
  ordered_json json = {{"end", base::Word(result.end)},
                       {"reached_hazard", result.reached_hazard},
                       {"stopped_early", result.stopped_early}};
  for (const auto& [key, value] : kRunNumbers) json[key] = result.*value;
  return json.dump();
}

RunResult RunResultFrom(const SeamParams& params, const std::string& text) {
  return From(text, [&](const ordered_json& json) {
    if (!params.method) throw std::invalid_argument("a run without a method");
    RunResult result;
    result.params = params;
    result.end = base::FromWord<TrackEnd>(json.at("end").get<std::string>(), "end");
    result.reached_hazard = json.at("reached_hazard");
    result.stopped_early = json.at("stopped_early");
    for (const auto& [key, value] : kRunNumbers) result.*value = json.at(key);
    return result;
  });
}

std::vector<std::pair<std::string, double>> TimeSteps(const SeamExperiment& experiment,
                                                      const Calibration& calibration,
                                                      const Recording& recording) {
  std::vector<std::pair<std::string, double>> seconds;
  base::Stopwatch watch;
  const auto end_step = [&] { seconds.emplace_back(kTimedSteps[seconds.size()], watch.Restart()); };
  const TrackerOptions options = TrackerFor(experiment, DecisionMethod::kVoting);
  std::vector<PreparedProfile> prepared;
  watch.Restart();
  for (const auto& raw : recording.raw) {
    prepared.push_back(Prepare(Calibrate(raw, calibration), options.filter));
  }
  end_step();
  for (const auto& profile : prepared) FitEdgeModel(profile.height_m);
  end_step();
  for (const auto& profile : prepared) VoteLocally(profile.height_m);
  end_step();
  for (const auto& profile : prepared) AccumulateGradients(profile.height_m);
  end_step();
  EdgeTracker tracker(options);
  watch.Restart();
  for (const auto& raw : recording.raw) tracker.Update(Calibrate(raw, calibration));
  end_step();
  return seconds;
}

}  // namespace rangegrasp::seam
