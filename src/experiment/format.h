#pragma once

#include <array>
#include <string>
#include <string_view>

#include "experiment/report.h"
#include "experiment/stamp.h"

namespace rangegrasp::experiment {

enum class TableFormat { kText, kMarkdown, kCsv, kJson };
constexpr std::array<std::string_view, 4> WordsOf(TableFormat) {
  return {"text", "markdown", "csv", "json"};
}

/// The tables one after the other, the stamp below them; CSV holds the tables alone, JSON the whole
/// report with the stamp in front.
std::string Format(const Report& report, const Stamp& stamp, TableFormat format);

}  // namespace rangegrasp::experiment
