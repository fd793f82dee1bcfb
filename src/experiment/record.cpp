#include "experiment/record.h"

#include <nlohmann/json.hpp>
#include <tuple>

#include "core/error.h"

namespace rangegrasp::experiment {

using nlohmann::ordered_json;

std::string ToJson(const Record& record) {
  const auto& [which, result] = record;
  try {
    ordered_json json = {{"id", which.id},
                         {"group", which.group},
                         {"seed", which.seed},
                         {"params", ordered_json::parse(which.params)},
                         {"outcome", result.outcome},
                         {"stage", result.stage},
                         {"detail", result.detail},
                         {"data", ordered_json::parse(result.data)},
                         {"seconds", ordered_json::object()}};
    for (const auto& [stage, seconds] : result.seconds) json["seconds"][stage] = seconds;
    return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  } catch (const ordered_json::parse_error& e) {
    throw core::RunError("case " + which.id + ": its record is damaged: " + e.what());
  }
}

bool SameButTimes(const Record& a, const Record& b) {
  const auto all = [](const Record& r) {
    return std::tie(r.which.id, r.which.group, r.which.seed, r.which.params, r.result.outcome,
                    r.result.stage, r.result.detail, r.result.data);
  };
  return all(a) == all(b);
}

}  // namespace rangegrasp::experiment
