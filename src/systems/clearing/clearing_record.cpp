#include "clearing/clearing_record.h"

#include <nlohmann/json.hpp>

#include "base/words.h"
#include "experiment/stage_seconds.h"

namespace rangegrasp::clearing {
namespace {

using nlohmann::ordered_json;

ordered_json JsonOf(const Clearing& clearing, const Step& step) {
  const auto name = [&](int object) {
    return clearing.objects[static_cast<std::size_t>(object)].object;
  };
  ordered_json taken = ordered_json::array();
  for (const int object : step.taken_away) taken.push_back(name(object));
  ordered_json json = {
      {"scan", step.scan},
      {"object", step.attempt.target ? ordered_json(name(*step.attempt.target)) : nullptr},
      {"held", step.attempt.log ? ordered_json(name(step.attempt.log->target)) : nullptr},
      {"try", step.try_number},
      {"outcome", base::Word(step.attempt.outcome)},
      {"stage", step.attempt.stage},
      {"detail", step.attempt.detail},
      {"felt", step.felt},
      {"taken_away", taken}};
  json.update(trial::JsonOf(step.attempt));
  return json;
}

int CountFate(const Clearing& clearing, Fate fate) {
  int count = 0;
  for (const ObjectEnd& end : clearing.objects) count += end.fate == fate ? 1 : 0;
  return count;
}

// Each stage's sum, in the order in which they first occur.
std::vector<std::pair<std::string, double>> SumsOf(const Clearing& clearing) {
  std::vector<std::pair<std::string, double>> sums = {{"scan", clearing.scan_s}};
  for (const Step& step : clearing.steps) {
    for (const auto& [stage, seconds] : step.attempt.seconds) {
      experiment::AddSeconds(stage, seconds, sums);
    }
  }
  return sums;
}

}  // namespace

experiment::Result ResultOf(const Clearing& clearing, const std::string& target) {
  double simulated_s = 0.0;
  ordered_json attempts = ordered_json::array();
  for (const Step& step : clearing.steps) {
    if (step.attempt.log) simulated_s += step.attempt.log->simulated_s;
    attempts.push_back(JsonOf(clearing, step));
  }
  ordered_json per_object = ordered_json::array();
  for (const ObjectEnd& end : clearing.objects) {
    per_object.push_back({{"object", end.object},
                          {"fate", base::Word(end.fate)},
                          {"grasps", end.grasps},
                          {"why", end.why}});
  }
  const ordered_json data = {{"target", target},
                             {"objects", clearing.objects.size()},
                             {"delivered", clearing.Delivered()},
                             {"brought", CountFate(clearing, Fate::kBrought)},
                             {"left", CountFate(clearing, Fate::kLeft)},
                             {"grasps", clearing.Grasps()},
                             {"scans", clearing.scans},
                             {"perceived", clearing.perceived},
                             {"stop", base::Word(clearing.stop)},
                             {"simulated_s", simulated_s},
                             {"homing_s", clearing.homing_s},
                             {"per_object", per_object},
                             {"attempts", attempts}};
  const bool cleared = clearing.Delivered() == static_cast<int>(clearing.objects.size());
  return {cleared ? kCleared : std::string(base::Word(clearing.stop)), "clear", clearing.detail,
          data.dump(), SumsOf(clearing)};
}

ClearedCase ReadCase(const experiment::Record& record) {
  ClearedCase read;
  read.group = record.which.group;
  read.outcome = record.result.outcome;
  for (const auto& [stage, seconds] : record.result.seconds) read.seconds[stage] += seconds;
  const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
  if (!data.is_object() || !data.contains("per_object")) {
    read.objects = nlohmann::json::parse(record.which.params).value("objects", 0);
    return read;
  }
  read.recorded = true;
  read.objects = data.at("objects");
  read.delivered = data.at("delivered");
  read.brought = data.at("brought");
  read.grasps = data.at("grasps");
  read.scans = data.at("scans");
  read.robot_s = data.at("simulated_s").get<double>() + data.at("homing_s").get<double>();
  for (const auto& end : data.at("per_object")) {
    read.ends.push_back({end.at("object"),
                         base::FromWord<Fate>(end.at("fate").get<std::string>(), "fate"),
                         end.at("grasps"), end.at("why")});
  }
  for (const auto& attempt : data.at("attempts")) {
    ++read.attempts;
    if (attempt.at("log").empty()) continue;
    const std::string outcome = attempt.at("outcome");
    ++read.grasp_outcomes[outcome];
    read.felt_wrong += attempt.at("felt").get<bool>() != (outcome == "delivered") ? 1 : 0;
  }
  return read;
}

}  // namespace rangegrasp::clearing
