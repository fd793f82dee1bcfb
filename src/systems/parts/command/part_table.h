#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "parts/function/description.h"

namespace rangegrasp::cli {

/// Adds to a part's JSON what someone who grasps by parts wants, in the file's unit of length.
void DescribePart(const parts::PartDescription& part, bool mesh, nlohmann::ordered_json& json);

/// The same for people: "area 0.02, 0.1 x 0.08 x 0.08 about (0, 0, 0.05), borders on 1 (0.06)".
std::string PartMeasures(const nlohmann::ordered_json& part);

/// CSV of a file's parts, a part a line; `neighbors` as "label:border label:border".
std::string PartTable(const nlohmann::ordered_json& json);

}  // namespace rangegrasp::cli
