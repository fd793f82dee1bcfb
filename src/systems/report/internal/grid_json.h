#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "experiment/grid.h"

namespace rangegrasp::report::internal {

/// A table as the page reads it: every cell as it is printed.
inline nlohmann::ordered_json GridJson(const std::string& title, const experiment::Grid& grid) {
  return {{"title", title},
          {"header", grid.header},
          {"left", grid.left},
          {"rows", grid.rows},
          {"total", grid.total}};
}

}  // namespace rangegrasp::report::internal
