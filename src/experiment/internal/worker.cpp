#include "experiment/internal/worker.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"

namespace rangegrasp::experiment::internal {
namespace {

// A process that has handed over its result has this long to end [s] before it counts as hanging.
constexpr double kGrace_s = 1.0;
// How often it is looked whether it has [us].
constexpr useconds_t kPoll_us = 200;
// Of what a process wrote to stderr, the last line within so many bytes is kept.
constexpr off_t kTail_bytes = 2000;

// Exit codes of a child that hands over no result.
constexpr int kLostParent = 3;
constexpr int kNotSent = 4;
constexpr int kThrew = 5;

[[noreturn]] void ThrowErrno(const char* what) {
  throw base::RunError(std::string(what) + ": " + strerror(errno));
}

// As it goes through the pipe: MessagePack keeps strings and numbers as they are.
std::string Packed(const Result& r) {
  const nlohmann::json json = {r.outcome, r.stage, r.detail, r.data, r.seconds};
  std::string bytes;
  nlohmann::json::to_msgpack(json, bytes);
  return bytes;
}

std::optional<Result> Unpacked(const std::string& bytes) {
  const auto json = nlohmann::json::from_msgpack(bytes, true, false);
  if (!json.is_array() || json.size() != 5) return std::nullopt;
  try {
    Result result;
    json[0].get_to(result.outcome);
    json[1].get_to(result.stage);
    json[2].get_to(result.detail);
    json[3].get_to(result.data);
    json[4].get_to(result.seconds);
    return result;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

Worker::Worker(const Case& which, double limit_s, const std::function<Result(const Case&)>& run)
    : which_(which), limit_s_(limit_s) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) ThrowErrno("pipe");
  log_ = memfd_create("case", MFD_CLOEXEC);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) ThrowErrno("fork");
  if (pid_ == 0) RunChild(parent, ends[1], run);
  close(ends[1]);
  pipe_ = ends[0];
}

Worker::~Worker() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (pipe_ >= 0) close(pipe_);
  if (log_ >= 0) close(log_);
}

bool Worker::Read() {
  std::array<char, 65536> buffer{};
  const ssize_t n = read(pipe_, buffer.data(), buffer.size());
  if (n > 0) text_.append(buffer.data(), static_cast<std::size_t>(n));
  return n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN);
}

Result Worker::Finish() {
  int status = 0;
  const base::Stopwatch waited;
  while (waitpid(pid_, &status, WNOHANG) == 0) {
    if (waited.Seconds() > kGrace_s) {
      // Threads of libraries that run when nothing else does (Mesa's, which stores shaders) end
      // seconds late on a busy machine: a result that is whole counts. Whatever is left is killed.
      auto late = Unpacked(text_);
      return late ? std::move(*late) : TimeOut();
    }
    usleep(kPoll_us);
  }
  pid_ = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    if (auto result = Unpacked(text_)) return std::move(*result);
    return Failed(kCrashed, "the process handed over no result" + LastLine());
  }
  const std::string how = WIFSIGNALED(status)
                              ? fmt::format("killed by {}", strsignal(WTERMSIG(status)))
                              : fmt::format("ended with code {}", WEXITSTATUS(status));
  return Failed(kCrashed, how + LastLine());
}

Result Worker::TimeOut() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
  return Failed(kTimedOut, "no result within the limit");
}

// noexcept: nothing may unwind into the parent's loop, whose workers and store are copies here.
void Worker::RunChild(int parent, int out, const std::function<Result(const Case&)>& run) noexcept {
  // Dies with its parent, so that a killed run leaves nothing behind.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kLostParent);
  const int null = open("/dev/null", O_RDWR);
  dup2(null, STDIN_FILENO);
  dup2(null, STDOUT_FILENO);
  if (log_ >= 0) dup2(log_, STDERR_FILENO);
  std::string bytes;
  try {
    bytes = Packed(run(which_));
  } catch (const std::exception& e) {
    dprintf(STDERR_FILENO, "%s\n", e.what());
    _exit(kThrew);
  }
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t n = write(out, bytes.data() + sent, bytes.size() - sent);
    if (n <= 0) _exit(kNotSent);
    sent += static_cast<std::size_t>(n);
  }
  close(out);  // whoever waits knows now that it is whole, however long the end takes
  _exit(0);
}

std::string Worker::LastLine() const {
  if (log_ < 0) return "";
  const off_t size = lseek(log_, 0, SEEK_END);
  std::string text(static_cast<std::size_t>(std::min(size, kTail_bytes)), '\0');
  const ssize_t n = pread(log_, text.data(), text.size(), size - static_cast<off_t>(text.size()));
  text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t line = text.rfind('\n');
  if (line != std::string::npos) text.erase(0, line + 1);
  return text.empty() ? "" : ": " + text;
}

Result Worker::Failed(const char* outcome, const std::string& detail) const {
  return {outcome, "case", detail, "{}", {{"case", watch_.Seconds()}}};
}

}  // namespace rangegrasp::experiment::internal
