#include "base/process/internal/guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/stopwatch.h"

namespace rangegrasp::process::internal {
namespace {

// Shells say so of a program that cannot be executed, and of one that a signal killed.
constexpr int kNotStarted = 127;
constexpr int kKilled = 128;
// A guard has this long to end everything [s] before it is killed itself.
constexpr double kMaxSweep_s = 5.0;
constexpr useconds_t kPoll_us = 200;

[[noreturn]] void ThrowErrno(const char* what) {
  throw base::RunError(std::string(what) + ": " + strerror(errno));
}

struct Pipe {
  std::array<int, 2> ends{-1, -1};
  Pipe() {
    if (pipe2(ends.data(), O_CLOEXEC) != 0) ThrowErrno("pipe");
  }
  ~Pipe() {
    for (const int end : ends) {
      if (end >= 0) close(end);
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  // This process's end.
  int Take(std::size_t which) {
    const int end = std::exchange(ends[which], -1);
    fcntl(end, F_SETFL, O_NONBLOCK);
    return end;
  }
};

// Whatever is made before the fork: after it nothing may allocate, since other threads of this
// process (a renderer's) may have held the heap's lock.
struct Start {
  explicit Start(const Program& p) : program(p), folder(p.folder.string()) {
    for (const std::string& word : p.command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    const auto is_replaced = [&](std::string_view entry) {
      return std::any_of(p.environment.begin(), p.environment.end(),
                         [&](const auto& one) { return entry.starts_with(one.first + "="); });
    };
    for (char** entry = environ; *entry; ++entry) {
      if (!is_replaced(*entry)) envp.push_back(*entry);
    }
    for (const auto& [name, value] : p.environment) own.push_back(name + "=" + value);
    for (std::string& entry : own) envp.push_back(entry.data());
    envp.push_back(nullptr);
  }
  const Program& program;
  std::string folder;
  std::vector<std::string> own;
  std::vector<char*> argv, envp;
};

void Limit(__rlimit_resource what, std::uint64_t bytes) {
  const rlimit limit{bytes, bytes};
  setrlimit(what, &limit);
}

[[noreturn]] void BecomeProgram(const Start& start, int in, int out, int err) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  setpgid(0, 0);
  dup2(in, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  // Files of this process: results, sockets.
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  Limit(RLIMIT_CORE, 0);
  if (start.program.max_memory_bytes > 0) Limit(RLIMIT_AS, start.program.max_memory_bytes);
  if (start.program.max_file_bytes > 0) Limit(RLIMIT_FSIZE, start.program.max_file_bytes);
  signal(SIGPIPE, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (chdir(start.folder.c_str()) == 0) execve(start.argv[0], start.argv.data(), start.envp.data());
  const char* why = strerror(errno);
  for (const char* text : {"cannot be started: ", why, "\n"}) {
    if (write(STDERR_FILENO, text, strlen(text)) < 0) break;
  }
  _exit(kNotStarted);
}

// Kills what is left of the program. Orphans come to the guard (it is their subreaper), so that
// killing its children over and over reaches all.
void Sweep() {
  const int list = open("/proc/thread-self/children", O_RDONLY | O_CLOEXEC);
  std::array<char, 4096> text{};
  for (bool more = true; more;) {
    const ssize_t n = list < 0 ? 0 : pread(list, text.data(), text.size() - 1, 0);
    const char* at = text.data();
    const char* const end = at + std::max<ssize_t>(n, 0);
    while (at < end) {
      pid_t child = 0;
      const auto read = std::from_chars(at, end, child);
      // A number that the buffer cuts off is another process's.
      if (read.ec != std::errc() || read.ptr == end) break;
      kill(child, SIGKILL);
      at = read.ptr + 1;
    }
    const pid_t reaped = waitpid(-1, nullptr, list < 0 ? WNOHANG : 0);
    more = reaped > 0 || (reaped < 0 && errno == EINTR);
  }
}

int CodeOf(int status) {
  return WIFSIGNALED(status) ? kKilled + WTERMSIG(status) : WEXITSTATUS(status);
}

[[noreturn]] void BecomeGuard(const Start& start, pid_t parent, int in, int out, int err) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  if (getppid() != parent) _exit(kNotStarted);
  const pid_t program = fork();
  if (program == 0) BecomeProgram(start, in, out, err);
  close_range(0, ~0U, 0);
  int code = kNotStarted;
  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  sigaddset(&awaited, SIGTERM);
  while (program > 0) {
    int status = 0;
    const pid_t ended = waitpid(-1, &status, WNOHANG);
    if (ended == program) code = CodeOf(status);
    if (ended == program || ended < 0) break;
    if (ended == 0 && sigwaitinfo(&awaited, nullptr) == SIGTERM) break;
  }
  if (program > 0) kill(-program, SIGKILL);
  Sweep();
  _exit(code);
}

}  // namespace

Guard::Guard(const Program& program) {
  const Start start(program);
  Pipe in;
  Pipe out;
  Pipe err;
  // A guard's signals wait from its first moment on.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  const pid_t parent = getpid();
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pid_ = fork();
  if (pid_ == 0) BecomeGuard(start, parent, in.ends[0], out.ends[1], err.ends[1]);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (pid_ < 0) ThrowErrno("fork");
  in_ = in.Take(1);
  out_ = out.Take(0);
  err_ = err.Take(0);
}

Guard::~Guard() {
  Kill();
  CloseIn();
  CloseOut();
  CloseErr();
}

void Guard::CloseIn() {
  if (in_ >= 0) close(std::exchange(in_, -1));
}
void Guard::CloseOut() {
  if (out_ >= 0) close(std::exchange(out_, -1));
}
void Guard::CloseErr() {
  if (err_ >= 0) close(std::exchange(err_, -1));
}

int Guard::ExitCode() {
  int status = 0;
  if (pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) {
    pid_ = -1;
    code_ = CodeOf(status);
  }
  return code_;
}

void Guard::Kill() {
  if (pid_ <= 0) return;
  kill(pid_, SIGTERM);
  const base::Stopwatch waited;
  while (ExitCode() < 0 && pid_ > 0) {
    if (waited.Seconds() > kMaxSweep_s) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
      pid_ = -1;
      return;
    }
    usleep(kPoll_us);
  }
}

std::string HowItEnded(int code) {
  if (code == kKilled + SIGXFSZ) return "a file that it wrote was larger than the limit";
  if (code > kKilled) return fmt::format("killed by {}", strsignal(code - kKilled));
  return fmt::format("ended with code {}", code);
}

}  // namespace rangegrasp::process::internal
