#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace rangegrasp::base {

/// Bad usage or bad input (a file, a key, a value); the command line exits with code 2.
/// The message names the file, the line or key, the value, and what is expected.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A run that failed although its input is valid (a full disk, a lost worker): exit code 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An edit of an XML file: it sets attributes or inserts a block of text.
struct Edit {
  std::string file;
  std::string element;  ///< XPath, e.g. "//joint[@name='joint1']"; or "/*/custom", made if missing
  /// Attributes of all matching elements; an attribute with an empty value is removed.
  std::vector<std::pair<std::string, std::string>> set = {};
  std::string block = {};  ///< text inserted into the first match
  bool replace = false;    ///< the block replaces the element
  bool operator==(const Edit&) const = default;
};

/// A problem that a check of a file has found, and how to fix it.
struct Finding {
  bool error = true;             ///< false: a warning
  std::string where;             ///< "arm.xml:33", or the file alone
  std::string element;           ///< "joint \"joint1\""
  std::string what;              ///< the problem: a sentence without its period
  std::string cure;              ///< advice in addition to the edits
  std::vector<Edit> edits = {};  ///< edits that fix it, if the fix is definite
};

/// The fix as text: the edits, then the additional advice. May have several lines.
std::string CureOf(const Finding& finding);

/// "arm.xml:33: error: joint "joint1": WHAT", then "fix: CURE" with its lines indented.
std::string TextOf(const Finding& finding);
/// The same without the word "error" or "warning", for a log that has it.
std::string MessageOf(const Finding& finding);

inline bool HasError(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, &Finding::error);
}

}  // namespace rangegrasp::base
