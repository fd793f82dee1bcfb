#include "seam/task/seam_json.h"

#include <nlohmann/json.hpp>

#include "base/error.h"

namespace rangegrasp::seam_task {
namespace {

using nlohmann::ordered_json;

// Runs a function on the parsed text; what it cannot find there is a damaged store.
template <typename F>
auto From(const std::string& text, F read) {
  try {
    return read(ordered_json::parse(text));
  } catch (const std::exception& error) {
    throw base::RunError("a seam's record is damaged: " + std::string(error.what()));
  }
}

template <typename Enum>
Enum WordAt(const ordered_json& json, const char* key) {
  return base::FromWord<Enum>(json.at(key).get<std::string>(), key);
}

// [profiles, within 3 px, ...]
ordered_json TallyJson(const Tally& tally) {
  ordered_json json = {tally.profiles};
  for (const int within : tally.within) json.push_back(within);
  return json;
}

Tally TallyFrom(const ordered_json& json) {
  Tally tally;
  tally.profiles = json.at(0);
  for (std::size_t t = 0; t < tally.within.size(); ++t) tally.within[t] = json.at(t + 1);
  return tally;
}

}  // namespace

std::string ToJson(const SeamParams& params) {
  if (!params.method) {
    return ordered_json{{"seam", params.number}, {"shape", base::Word(params.shape)}}.dump();
  }
  return ordered_json{{"run", params.number},
                      {"shape", base::Word(params.shape)},
                      {"method", base::Word(*params.method)},
                      {"hazard", base::Word(params.hazard)}}
      .dump();
}

SeamParams ParamsFrom(const std::string& text) {
  return From(text, [](const ordered_json& json) {
    SeamParams params;
    params.shape = WordAt<stitching::EdgeShape>(json, "shape");
    if (json.contains("seam")) {
      params.number = json.at("seam");
      return params;
    }
    params.number = json.at("run");
    params.method = WordAt<seam::DecisionMethod>(json, "method");
    params.hazard = WordAt<Hazard>(json, "hazard");
    return params;
  });
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
    SeamResult result;
    result.seam = params.number;
    result.shape = params.shape;
    result.height_m = json.at("height_m");
    result.profiles = json.at("profiles");
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
  return ordered_json{{"end", base::Word(result.end)},
                      {"reached_hazard", result.reached_hazard},
                      {"stopped_early", result.stopped_early},
                      {"settled_m", result.settled_m},
                      {"mean_error_m", result.mean_error_m},
                      {"p95_error_m", result.p95_error_m},
                      {"max_error_m", result.max_error_m},
                      {"share_within_1mm", result.share_within_1mm},
                      {"rest_m", result.rest_m},
                      {"beside_corners_m", result.good_beside_corners_m}}
      .dump();
}

RunResult RunResultFrom(const SeamParams& params, const std::string& text) {
  return From(text, [&](const ordered_json& json) {
    RunResult result;
    result.run = params.number;
    result.method = params.method.value();
    result.hazard = params.hazard;
    result.end = WordAt<stitching::TrackEnd>(json, "end");
    result.reached_hazard = json.at("reached_hazard");
    result.stopped_early = json.at("stopped_early");
    result.settled_m = json.at("settled_m");
    result.mean_error_m = json.at("mean_error_m");
    result.p95_error_m = json.at("p95_error_m");
    result.max_error_m = json.at("max_error_m");
    result.share_within_1mm = json.at("share_within_1mm");
    // Runs of earlier versions have neither.
    result.rest_m = json.value("rest_m", 0.0);
    result.good_beside_corners_m = json.value("beside_corners_m", 0.0);
    return result;
  });
}

}  // namespace rangegrasp::seam_task
