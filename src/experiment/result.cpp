#include "experiment/result.h"

#include <array>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace rangegrasp::experiment {
namespace {

constexpr std::array<std::pair<Outcome, const char*>, 11> kNames = {{
    {Outcome::kDelivered, "delivered"},
    {Outcome::kNotSegmented, "not_segmented"},
    {Outcome::kWrongTarget, "wrong_target"},
    {Outcome::kNoGrasp, "no_grasp"},
    {Outcome::kNoPath, "no_path"},
    {Outcome::kNotLifted, "not_lifted"},
    {Outcome::kDropped, "dropped"},
    {Outcome::kMisplaced, "misplaced"},
    {Outcome::kInvalidPhysics, "invalid_physics"},
    {Outcome::kCrashed, "crashed"},
    {Outcome::kTimedOut, "timed_out"},
}};

}  // namespace

const char* Name(Outcome outcome) {
  for (const auto& [value, name] : kNames) {
    if (value == outcome) return name;
  }
  return "crashed";
}

Outcome OutcomeFrom(const std::string& name) {
  for (const auto& [value, text] : kNames) {
    if (name == text) return value;
  }
  throw core::InputError("'" + name + "' is no outcome of a trial");
}

const std::vector<Outcome>& AllOutcomes() {
  static const std::vector<Outcome> all = [] {
    std::vector<Outcome> outcomes;
    for (const auto& [value, name] : kNames) outcomes.push_back(value);
    return outcomes;
  }();
  return all;
}

std::string ToJson(const TrialResult& r) {
  nlohmann::ordered_json json = {{"id", r.id},
                                 {"object", r.object},
                                 {"index", r.index},
                                 {"seed", r.seed},
                                 {"pose_class", r.pose_class},
                                 {"redraws", r.redraws},
                                 {"scan_points", r.scan_points},
                                 {"object_points", r.object_points},
                                 {"segments", r.segments},
                                 {"objects", r.objects},
                                 {"candidates", r.candidates},
                                 {"free_candidates", r.free_candidates},
                                 {"plans", r.plans},
                                 {"grasp_type", r.grasp_type},
                                 {"detected", r.detected},
                                 {"outcome", Name(r.outcome)},
                                 {"stage", r.stage},
                                 {"detail", r.detail},
                                 {"log", r.log},
                                 {"seconds", r.seconds}};
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

TrialResult FromJson(const std::string& text) {
  try {
    const auto json = nlohmann::json::parse(text);
    TrialResult r;
    json.at("id").get_to(r.id);
    json.at("object").get_to(r.object);
    json.at("index").get_to(r.index);
    json.at("seed").get_to(r.seed);
    json.at("pose_class").get_to(r.pose_class);
    json.at("redraws").get_to(r.redraws);
    json.at("scan_points").get_to(r.scan_points);
    json.at("object_points").get_to(r.object_points);
    json.at("segments").get_to(r.segments);
    json.at("objects").get_to(r.objects);
    json.at("candidates").get_to(r.candidates);
    json.at("free_candidates").get_to(r.free_candidates);
    json.at("plans").get_to(r.plans);
    json.at("grasp_type").get_to(r.grasp_type);
    json.at("detected").get_to(r.detected);
    r.outcome = OutcomeFrom(json.at("outcome").get<std::string>());
    json.at("stage").get_to(r.stage);
    json.at("detail").get_to(r.detail);
    json.at("log").get_to(r.log);
    json.at("seconds").get_to(r.seconds);
    return r;
  } catch (const nlohmann::json::exception& e) {
    throw core::RunError(std::string("a trial's process handed over no result: ") + e.what());
  } catch (const core::InputError& e) {
    throw core::RunError(std::string("a trial's process handed over no result: ") + e.what());
  }
}

}  // namespace rangegrasp::experiment
