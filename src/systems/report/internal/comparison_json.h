#pragma once

#include <nlohmann/json_fwd.hpp>

#include "report/report_data.h"

namespace rangegrasp::report::internal {

/// A run beside another one, in pairs of the same id and seed (experiment/compare.h): a table with
/// a row a group, and the numbers of the cases whose success differs.
/// @param first_number, second_number  of the runs' first cases
nlohmann::ordered_json ComparisonJson(const Run& first, std::size_t first_number, const Run& second,
                                      std::size_t second_number);

}  // namespace rangegrasp::report::internal
