#pragma once

#include <string>
#include <vector>

namespace rangegrasp::base {

/// What a check of a file found wrong, and how one edit cures it.
struct Finding {
  bool error = true;    ///< what it is in cannot work; false: it works worse than it could
  std::string where;    ///< "arm.xml:33", the file alone where no line is known
  std::string element;  ///< "joint \"joint1\""
  std::string what;     ///< a sentence without its end
  std::string cure;     ///< likewise; may hold lines to paste
};

/// "arm.xml:33: error: joint "joint1": WHAT" and "  cure: CURE", lines of the cure indented.
std::string TextOf(const Finding& finding);

bool HasError(const std::vector<Finding>& findings);

}  // namespace rangegrasp::base
