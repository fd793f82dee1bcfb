#pragma once

#include <stdexcept>
#include <string>

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

}  // namespace rangegrasp::base
