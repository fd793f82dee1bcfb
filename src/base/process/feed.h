#pragma once

#include <memory>
#include <span>
#include <string>

#include "base/process/ask.h"

namespace rangegrasp::process {

/// A program that is given bytes, as much as there are, and whose end tells whether it took them.
/// Where this one is destroyed before Finish, it is killed; if this process is killed, it dies too.
class Feed {
 public:
  /// Starts the program. Program::limit_s is how long it may take no byte, and, after the last one,
  /// how long it may take to end.
  /// @param name  for messages: what is made
  /// @throws base::RunError if no process or pipe can be made.
  Feed(const Program& program, std::string name);
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  /// @throws base::RunError with the program's last words if it has ended or takes nothing more.
  void Write(std::span<const std::uint8_t> bytes);
  /// No more bytes: waits for the program's end.
  /// @throws base::RunError with its last words if it does not end, or not with code 0.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::process
