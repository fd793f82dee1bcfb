#pragma once

#include <string>

namespace rangegrasp::cli {

/// Whether stdout is a terminal that shows colors and its user wants them: TERM is not "dumb", and
/// NO_COLOR is not set (https://no-color.org).
bool StdoutShowsColors();

/// Tables and lists as a terminal shows them: titles and headers bold, rules and the line that says
/// where the results come from faint, verdicts and what is significantly below the published in
/// color.
std::string ForTerminal(const std::string& text);

}  // namespace rangegrasp::cli
