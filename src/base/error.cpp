#include "base/error.h"

#include <algorithm>

namespace rangegrasp::base {
std::string TextOf(const Finding& finding) {
  std::string text = finding.where + (finding.error ? ": error: " : ": warning: ");
  if (!finding.element.empty()) text += finding.element + ": ";
  text += finding.what;
  if (finding.cure.empty()) return text;
  text += "\n    cure: ";
  for (const char c : finding.cure) text += c == '\n' ? std::string("\n      ") : std::string(1, c);
  return text;
}

bool HasError(const std::vector<Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.error; });
}

}  // namespace rangegrasp::base
