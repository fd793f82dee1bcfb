#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

namespace rangegrasp::testing_support {

/// Runs `action` in a child process.
/// @return its exit code, 100 if it threw, 200 + n for signal n
inline int InChild(const std::function<int()>& action) {
  const pid_t pid = fork();
  if (pid == 0) {
    int code = 100;
    try {
      code = action();
    } catch (...) {
    }
    _exit(code);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFSIGNALED(status) ? 200 + WTERMSIG(status) : WEXITSTATUS(status);
}

/// Limits the files of this process to `bytes` from now on: writing more fails, as on a full disk.
inline void LimitFileSize(rlim_t bytes) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_FSIZE, &limit);
}

}  // namespace rangegrasp::testing_support
