#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/file.h"
#include "base/stopwatch.h"
#include "temp_folder.h"

namespace rangegrasp::testing_support {

/// The `rangegrasp` program in a child process.
class Command {
 public:
  /// @param preload  a shared library to preload (LD_PRELOAD); none if empty
  explicit Command(std::vector<std::string> arguments, const std::string& stdout_file = "",
                   const std::string& stdin_file = "/dev/null", const std::string& preload = "") {
    arguments.insert(arguments.begin(), RANGEGRASP_BINARY);
    const std::string out = stdout_file.empty() ? (folder_ / "out").string() : stdout_file;
    const std::string err = (folder_ / "err").string();
    pid_ = fork();
    if (pid_ != 0) return;
    if (!preload.empty()) setenv("LD_PRELOAD", preload.c_str(), 1);
    Redirect(stdin_file, O_RDONLY, STDIN_FILENO);
    Redirect(out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
    Redirect(err, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Command() {
    if (!ended_) Kill();
  }
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  void Kill() {
    kill(pid_, SIGKILL);
    Wait(10.0);
  }
  void Send(int signal) const { kill(pid_, signal); }
  bool Runs() {
    if (!ended_) ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return !ended_;
  }
  /// @return the exit code; -n if signal n ended it, -1000 if it was killed here after the limit
  int Wait(double limit_s = 300.0) {
    const base::Stopwatch watch;
    while (Runs()) {
      if (watch.Seconds() > limit_s) {
        kill(pid_, SIGKILL);
        ended_ = waitpid(pid_, &status_, 0) == pid_;
        return -1000;
      }
      usleep(1000);
    }
    return WIFSIGNALED(status_) ? -WTERMSIG(status_) : WEXITSTATUS(status_);
  }
  std::string Out() const { return Text("out"); }
  std::string Err() const { return Text("err"); }

 private:
  static void Redirect(const std::string& file, int flags, int to) {
    const int fd = open(file.c_str(), flags, 0600);
    if (fd < 0 || dup2(fd, to) < 0) _exit(126);
  }
  std::string Text(const std::string& name) const {
    const auto file = folder_ / name;
    if (!std::filesystem::exists(file) || std::filesystem::is_empty(file)) return "";
    return base::ReadFile(file);
  }

  TempFolder folder_;
  pid_t pid_ = -1;
  int status_ = 0;
  bool ended_ = false;
};

struct Ran {
  int code = 0;
  std::string out, err;
};

/// Runs the program to its end.
inline Ran RunProgram(const std::vector<std::string>& arguments,
                      const std::string& stdout_file = "",
                      const std::string& stdin_file = "/dev/null") {
  Command command(arguments, stdout_file, stdin_file);
  const int code = command.Wait();
  return {code, command.Out(), command.Err()};
}

/// Passes on what a run gave. Throws, so that the test fails and ends, if its exit code is not 0.
inline Ran Succeeded(Ran ran) {
  if (ran.code != 0) {
    throw std::runtime_error("ended with code " + std::to_string(ran.code) + ":\n" + ran.out +
                             ran.err);
  }
  return ran;
}

/// Expects bad usage or input: code 2, nothing on stdout, a message on stderr that contains `says`.
inline void ExpectRefusal(const Ran& ran, const std::string& says) {
  EXPECT_EQ(ran.code, 2) << ran.err;
  EXPECT_EQ(ran.out, "") << ran.err;
  EXPECT_THAT(ran.err, ::testing::HasSubstr(says));
}
inline void ExpectRefused(const std::vector<std::string>& arguments, const std::string& says) {
  SCOPED_TRACE(::testing::PrintToString(arguments));
  ExpectRefusal(RunProgram(arguments), says);
}

}  // namespace rangegrasp::testing_support
