#pragma once

#include <sys/types.h>

#include <string>

#include "base/process/ask.h"

namespace rangegrasp::process::internal {

/// A program under a guard: a process between this one and the program that stays until the program
/// has ended, this process has died, or it is told to end, and then kills every process that came
/// from the program. (A process group does not do: programs leave it, as a shell with job control.)
class Guard {
 public:
  /// @throws base::RunError if no process or pipe can be made.
  explicit Guard(const Program& program);
  ~Guard();  ///< kills everything
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  // Ends of pipes, not blocking; -1 once closed.
  int in() const { return in_; }
  int out() const { return out_; }
  int err() const { return err_; }
  void CloseIn();
  void CloseOut();
  void CloseErr();

  /// How the program ended: its exit code, or 128 and the signal that killed it; -1 if it runs.
  int ExitCode();
  void Kill();  ///< waits until nothing is left

 private:
  pid_t pid_ = -1;
  int in_ = -1;
  int out_ = -1;
  int err_ = -1;
  int code_ = -1;
};

/// An exit code of Guard's in words: "ended with code 3", "killed by Segmentation fault".
std::string HowItEnded(int code);

}  // namespace rangegrasp::process::internal
