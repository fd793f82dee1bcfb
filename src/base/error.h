#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace rangegrasp::base {

/// Bad usage or bad input (a file, a key, a value): the command line ends with exit code 2.
/// The text names the file, the line or key, the value, and what would be right.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A run that failed through no fault of its input (a full disk, a lost worker): exit code 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a check of a file found wrong, and how one edit cures it.
struct Finding {
  bool error = true;    ///< false: a warning
  std::string where;    ///< "arm.xml:33", or the file alone
  std::string element;  ///< "joint \"joint1\""
  std::string what;     ///< a sentence without its full stop
  std::string cure;     ///< the same; may hold lines to paste
};

/// "arm.xml:33: error: joint "joint1": WHAT" and "  fix: CURE", lines of the cure indented.
inline std::string TextOf(const Finding& finding) {
  std::string text = finding.where + (finding.error ? ": error: " : ": warning: ");
  if (!finding.element.empty()) text += finding.element + ": ";
  text += finding.what;
  if (finding.cure.empty()) return text;
  text += "\n    fix: ";
  for (const char c : finding.cure) text += c == '\n' ? std::string("\n      ") : std::string(1, c);
  return text;
}

inline bool HasError(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, &Finding::error);
}

}  // namespace rangegrasp::base
