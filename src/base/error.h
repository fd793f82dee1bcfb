#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
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

/// One edit of an XML file: attributes that are set, or a block of text.
struct Edit {
  std::string file;
  std::string element;  ///< XPath, e.g. "//joint[@name='joint1']"; or "/*/custom", made if missing
  /// Of all elements that match; what gets an empty value is removed.
  std::vector<std::pair<std::string, std::string>> set = {};
  std::string block = {};  ///< what the first of them then holds
  bool replace = false;    ///< the block takes its place
  bool operator==(const Edit&) const = default;
};

/// What a check of a file found wrong, and how to cure it.
struct Finding {
  bool error = true;             ///< false: a warning
  std::string where;             ///< "arm.xml:33", or the file alone
  std::string element;           ///< "joint \"joint1\""
  std::string what;              ///< a sentence without its full stop
  std::string cure;              ///< what is to be said besides the edits
  std::vector<Edit> edits = {};  ///< which cure it, where that is definite
};

/// The edits as text, then what is said besides; may have several lines.
std::string CureOf(const Finding& finding);

/// "arm.xml:33: error: joint "joint1": WHAT" and "  fix: CURE", lines of the cure indented.
std::string TextOf(const Finding& finding);

inline bool HasError(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, &Finding::error);
}

}  // namespace rangegrasp::base
