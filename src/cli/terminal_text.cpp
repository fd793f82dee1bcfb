#include "cli/terminal_text.h"

#include <fmt/color.h>
#include <unistd.h>

#include <cstdlib>
#include <regex>
#include <string_view>

#include "base/words.h"

namespace rangegrasp::cli {
namespace {

const auto kBold = fmt::emphasis::bold;
const auto kFaint = fmt::emphasis::faint;

bool IsRule(std::string_view line) {
  return !line.empty() && line.find_first_not_of('-') == std::string_view::npos;
}

std::string Styled(const std::string& text, const fmt::text_style& style) {
  return text.empty() ? text : fmt::format(style, "{}", text);
}

// Of a table's row: "worse", "better", and figures that are marked as below the published ones.
std::string WithVerdicts(const std::string& row) {
  static const std::regex marked(R"((\S+\*)(?=\s|$)|\b(worse|better)\b)");
  std::string text;
  auto after = row.begin();
  for (std::sregex_iterator match(row.begin(), row.end(), marked), end; match != end; ++match) {
    text.append(after, (*match)[0].first);
    const bool good = (*match)[0] == "better";
    text +=
        Styled((*match)[0], fmt::fg(good ? fmt::terminal_color::green : fmt::terminal_color::red));
    after = (*match)[0].second;
  }
  return text.append(after, row.end());
}

}  // namespace

bool StdoutShowsColors() {
  const char* terminal = std::getenv("TERM");
  const char* none = std::getenv("NO_COLOR");
  return isatty(STDOUT_FILENO) == 1 && terminal && std::string_view(terminal) != "dumb" &&
         !(none && *none != '\0');
}

std::string ForTerminal(const std::string& text) {
  const auto lines = base::Split(text, '\n');
  const auto at = [&](std::size_t i) { return i < lines.size() ? lines[i] : std::string(); };
  std::string shown;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const bool begins = i == 0 || lines[i - 1].empty();
    const bool title = begins && (at(i + 1).empty() || lines[i].ends_with(':'));
    const bool stamp = lines[i].find(": rangegrasp ") != std::string::npos;
    if (IsRule(lines[i]) || stamp) {
      shown += Styled(lines[i], kFaint);
    } else if (title || (begins && IsRule(at(i + 1)))) {
      shown += Styled(lines[i], kBold);
    } else {
      shown += WithVerdicts(lines[i]);
    }
    if (i + 1 < lines.size()) shown += '\n';
  }
  return shown;
}

}  // namespace rangegrasp::cli
