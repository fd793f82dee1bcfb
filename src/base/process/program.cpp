#include "base/process/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/words.h"

namespace rangegrasp::process {
namespace {

namespace fs = std::filesystem;

/// Blocks SIGPIPE: writing to a program that has ended fails, but does not end this process.
class WithoutPipeSignal {
 public:
  WithoutPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~WithoutPipeSignal() {
    const timespec now{};
    while (sigtimedwait(&pipe_, nullptr, &now) > 0) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  WithoutPipeSignal(const WithoutPipeSignal&) = delete;
  WithoutPipeSignal& operator=(const WithoutPipeSignal&) = delete;

 private:
  sigset_t pipe_{}, before_{};
};

// Exit codes as in shells: the program cannot be executed, or a signal (added) killed it.
constexpr int kNotStarted = 127;
constexpr int kKilled = 128;
// Time [s] for a guard to end all processes before it is killed itself.
constexpr double kMaxSweep_s = 5.0;
constexpr useconds_t kPoll_us = 200;

[[noreturn]] void ThrowErrno(const char* what) {
  throw base::RunError(std::string(what) + ": " + strerror(errno));
}

/// One end of a pipe; negative once closed.
class End {
 public:
  explicit End(int end = -1) : end_(end) {}
  ~End() { Close(); }
  End(End&& other) noexcept : end_(std::exchange(other.end_, -1)) {}
  End& operator=(End&& other) noexcept {
    std::swap(end_, other.end_);
    return *this;
  }

  operator int() const { return end_; }
  void Close() {
    if (end_ >= 0) close(std::exchange(end_, -1));
  }

 private:
  int end_;
};

struct Pipe {
  End out, in;
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) ThrowErrno("pipe");
    out = End(ends[0]);
    in = End(ends[1]);
  }
};

/// Makes this process's end of a pipe non-blocking.
End NotBlocking(End end) {
  fcntl(end, F_SETFL, O_NONBLOCK);
  return end;
}

// Everything that is prepared before the fork. Nothing may be allocated after it, since other
// threads of this process (a renderer's) may have held the heap's lock.
struct Start {
  explicit Start(const Program& p) : program(p), folder(p.folder.string()) {
    for (const std::string& word : p.command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    for (char** entry = environ; *entry; ++entry) {
      const bool is_replaced = std::ranges::any_of(p.environment, [&](const auto& one) {
        return std::string_view(*entry).starts_with(one.first + "=");
      });
      if (!is_replaced) envp.push_back(*entry);
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
  // Closes files of this process (results, sockets).
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

// Kills all remaining processes of the program. Orphans become children of the guard (their
// subreaper), so killing its children repeatedly reaches all of them.
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
      // A number truncated by the buffer would be the id of another process.
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

/// A program and its guard: a process between this one and the program. The guard kills every
/// process that came from the program when it ends, this process dies, or Kill is called. (A
/// process group does not suffice: programs can leave it, e.g. a shell with job control.)
class Guard {
 public:
  End in, out, err;  // non-blocking

  /// @throws base::RunError if no process or pipe can be made.
  explicit Guard(const Program& program) {
    const Start start(program);
    Pipe to, from, error;
    // Blocks all signals, so that those to the guard stay pending from its start.
    sigset_t all, before;
    sigfillset(&all);
    const pid_t parent = getpid();
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pid_ = fork();
    if (pid_ == 0) BecomeGuard(start, parent, to.out, from.in, error.in);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    if (pid_ < 0) ThrowErrno("fork");
    in = NotBlocking(std::move(to.in));
    out = NotBlocking(std::move(from.out));
    err = NotBlocking(std::move(error.out));
  }
  ~Guard() { Kill(); }

  /// The program's exit code, or 128 plus the signal that killed it; -1 while it runs.
  int ExitCode() {
    int status = 0;
    if (pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) {
      pid_ = -1;
      code_ = CodeOf(status);
    }
    return code_;
  }

  /// Kills all processes of the program and waits for their end.
  void Kill() {
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

 private:
  pid_t pid_ = -1;
  int code_ = -1;
};

/// Describes an exit code of Guard: "ended with code 3", "killed by Segmentation fault".
std::string HowItEnded(int code) {
  if (code == kKilled + SIGXFSZ) return "it wrote a file larger than the limit";
  if (code > kKilled) return fmt::format("killed by {}", strsignal(code - kKilled));
  return fmt::format("ended with code {}", code);
}

constexpr const char* kSandbox = "bwrap";
// How much of the program's stderr output is kept, and how much of it is shown.
constexpr std::size_t kKept_bytes = 4096;
constexpr std::size_t kShown = 400;
// Maximum time [s] from the end of its output to its exit; then it is killed.
constexpr double kEnding_s = 1.0;

/// Reads the available data. @return whether the pipe is still open
bool ReadFrom(int pipe, std::string& text) {
  std::array<char, 65536> buffer{};
  const ssize_t n = read(pipe, buffer.data(), buffer.size());
  if (n > 0) text.append(buffer.data(), static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && (errno == EAGAIN || errno == EINTR));
}

/// Reads the program's stderr output and keeps its end.
void ReadErr(Guard& guard, std::string& err) {
  if (guard.err < 0) return;
  if (!ReadFrom(guard.err, err)) guard.err.Close();
  if (err.size() > kKept_bytes) err.erase(0, err.size() - kKept_bytes);
}

/// Waits until one of the pipes is ready; closed pipes (negative) are ignored. Without any output
/// to wait for, only a short time: the program's end is no event.
void WaitFor(const Guard& guard, double left_s) {
  std::array<pollfd, 3> waits{
      {{guard.in, POLLOUT, 0}, {guard.out, POLLIN, 0}, {guard.err, POLLIN, 0}}};
  const bool silent = guard.out < 0 && guard.err < 0;
  poll(waits.data(), waits.size(), 1 + (silent ? 0 : static_cast<int>(left_s * 1000.0)));
}

class Conversation {
 public:
  Conversation(const Program& program, std::string_view question)
      : program_(program), question_(std::string(question) + "\n"), guard_(program) {}

  Reply Hold() {
    const WithoutPipeSignal without;
    while (!reply_.line && reply_.failure.empty()) Step();
    guard_.Kill();
    ReadErr(guard_, err_);
    reply_.last_words = LastWords(err_, kShown);
    return std::move(reply_);
  }

 private:
  void Step() {
    const double left_s = program_.limit_s - watch_.Seconds();
    if (left_s <= 0.0) {
      reply_.failure = fmt::format("no answer within {:g} s", program_.limit_s);
      return;
    }
    WaitFor(guard_, left_s);
    Write();
    if (guard_.out >= 0) ReadOut();
    ReadErr(guard_, err_);
    if (guard_.out < 0 && !reply_.line && reply_.failure.empty()) AtEnd();
  }

  void Write() {
    if (guard_.in < 0) return;
    const ssize_t n = write(guard_.in, question_.data() + sent_, question_.size() - sent_);
    if (n > 0) sent_ += static_cast<std::size_t>(n);
    // A program that does not read the question may still answer.
    const bool broken = n < 0 && errno != EAGAIN && errno != EINTR;
    if (broken || sent_ == question_.size()) guard_.in.Close();
  }

  void ReadOut() {
    const std::size_t before = out_.size();
    if (!ReadFrom(guard_.out, out_)) guard_.out.Close();
    const std::size_t end = out_.find('\n', before);
    if (std::min(end, out_.size()) > program_.max_answer_bytes) {
      reply_.failure =
          fmt::format("sent an answer line of more than {} bytes", program_.max_answer_bytes);
    } else if (end != std::string::npos) {
      reply_.line = out_.substr(0, end);
    }
  }

  // Called when its output has ended without a line break.
  void AtEnd() {
    const base::Stopwatch ending;
    while (guard_.ExitCode() < 0 && ending.Seconds() < kEnding_s) {
      ReadErr(guard_, err_);
      usleep(kPoll_us);
    }
    const int code = guard_.ExitCode();
    if (code == 0 && !out_.empty()) {
      reply_.line = out_;
    } else {
      reply_.failure = (code < 0 ? "closed its output" : HowItEnded(code)) + " without an answer";
    }
  }

  const Program& program_;
  std::string question_;
  std::size_t sent_ = 0;
  base::Stopwatch watch_;
  Guard guard_;
  std::string out_, err_;
  Reply reply_;
};

bool IsIn(const fs::path& inner, const fs::path& outer) {
  return std::ranges::mismatch(outer, inner).in1 == outer.end();
}

fs::path TemporaryFolder() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (!error) return folder;
  const char* named = std::getenv("TMPDIR");
  throw base::RunError(
      fmt::format("no folder for temporary files (TMPDIR is '{}')", named ? named : "/tmp"));
}

std::vector<fs::path> HiddenBy(const Box& box) {
  // Temporary folders are shared by all programs of the machine, and sockets in /run give control
  // over other programs.
  std::vector<fs::path> paths = {"/tmp", "/var/tmp", "/run", TemporaryFolder()};
  paths.insert(paths.end(), box.hidden.begin(), box.hidden.end());
  std::vector<fs::path> hidden;
  for (const fs::path& path : paths) {
    std::error_code error;
    const fs::path real = fs::canonical(path, error);
    if (!error && real != "/" && fs::is_directory(real)) hidden.push_back(real);
  }
  // Outer folders come first, since later mounts cover earlier ones.
  std::ranges::sort(hidden);
  const auto twice = std::ranges::unique(hidden);
  hidden.erase(twice.begin(), twice.end());
  return hidden;
}

}  // namespace

Reply Ask(const Program& program, std::string_view question) {
  return Conversation(program, question).Hold();
}

std::optional<fs::path> Find(const std::string& name) {
  const auto is_program = [](const fs::path& file) {
    return fs::is_regular_file(file) && access(file.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) {
    if (is_program(name)) return fs::absolute(name);
    return std::nullopt;
  }
  const char* path = std::getenv("PATH");
  for (const std::string& folder : base::Split(path ? path : "/usr/bin:/bin", ':')) {
    const auto file = fs::path(folder.empty() ? "." : folder) / name;
    if (is_program(file)) return fs::absolute(file);
  }
  return std::nullopt;
}

std::string LastWords(std::string_view text, std::size_t max_characters) {
  std::string words;
  for (const char c : text) {
    if (c == '\n' || c == '\r') {
      if (!words.empty() && !words.ends_with(" | ")) words += " | ";
    } else {
      words += c >= ' ' && c <= '~' ? c : '?';
    }
  }
  if (words.ends_with(" | ")) words.erase(words.size() - 3);
  if (words.size() > max_characters) words = "..." + words.substr(words.size() - max_characters);
  return words;
}

struct Feed::Impl {
  Program program;
  std::string name;
  Guard guard;
  std::string err;

  Impl(const Program& what, std::string of) : program(what), name(std::move(of)), guard(program) {}

  [[noreturn]] void Fail(const std::string& why) {
    guard.Kill();
    ReadErr(guard, err);
    const std::string words = LastWords(err, kShown);
    throw base::RunError(fmt::format("{}: {} {}{}", name, program.command.front(), why,
                                     words.empty() ? "" : ": " + words));
  }

  // Waits until a pipe is ready, at most for the time limit.
  void Wait(const base::Stopwatch& watch, const char* too_long) {
    const double left_s = program.limit_s - watch.Seconds();
    if (left_s <= 0.0) Fail(fmt::format("{} within {:g} s", too_long, program.limit_s));
    WaitFor(guard, left_s);
    // Its output is not used, but is read so that it does not block the program.
    std::string dropped;
    if (guard.out >= 0 && !ReadFrom(guard.out, dropped)) guard.out.Close();
    ReadErr(guard, err);
  }

  // Reads its remaining output and waits for its exit.
  int ExitCode() {
    const base::Stopwatch watch;
    while (guard.ExitCode() < 0) Wait(watch, "did not exit");
    ReadErr(guard, err);
    return guard.ExitCode();
  }
};

Feed::Feed(const Program& program, std::string name)
    : impl_(std::make_unique<Impl>(program, std::move(name))) {}

Feed::~Feed() = default;

void Feed::Write(std::span<const std::uint8_t> bytes) {
  const WithoutPipeSignal without;
  base::Stopwatch watch;
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t n = write(impl_->guard.in, bytes.data() + sent, bytes.size() - sent);
    if (n > 0) {
      sent += static_cast<std::size_t>(n);
      watch.Restart();
    } else if (errno == EAGAIN || errno == EINTR) {
      impl_->Wait(watch, "accepted no more input");
    } else {
      impl_->guard.in.Close();
      const int code = impl_->ExitCode();
      impl_->Fail(HowItEnded(code) + " before it had read all of its input");
    }
  }
}

void Feed::Finish() {
  impl_->guard.in.Close();
  const int code = impl_->ExitCode();
  if (code != 0) impl_->Fail(HowItEnded(code));
}

void NeedMemory(std::size_t bytes) {
  void* all = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (all == MAP_FAILED) {
    throw base::RunError(fmt::format(
        "{} MB of memory are needed, but the limit of this process is lower (ulimit -v)",
        bytes >> 20U));
  }
  munmap(all, bytes);
}

OwnFolder::OwnFolder() {
  std::string name = (TemporaryFolder() / "rangegrasp-XXXXXX").string();
  if (!mkdtemp(name.data())) {
    throw base::RunError(name + ": this folder cannot be created: " + strerror(errno));
  }
  path_ = fs::canonical(name);
}

OwnFolder::~OwnFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<std::string> InSandbox(const std::vector<std::string>& command, const Box& box) {
  const auto bwrap = Find(kSandbox);
  std::vector<std::string> boxed = {bwrap ? bwrap->string() : kSandbox};
  const auto add = [&](std::initializer_list<std::string> words) {
    boxed.insert(boxed.end(), words);
  };
  add({"--unshare-all", "--die-with-parent", "--new-session", "--cap-drop", "ALL"});
  add({"--ro-bind", "/", "/", "--dev", "/dev", "--proc", "/proc"});
  const auto hidden = HiddenBy(box);
  for (const fs::path& path : hidden) add({"--tmpfs", path.string()});
  for (const fs::path& path : box.shown) {
    const fs::path real = fs::weakly_canonical(path);
    const auto lies_in = [&](const fs::path& other) { return IsIn(other, real); };
    if (std::ranges::none_of(hidden, lies_in)) add({"--ro-bind-try", real.string(), path.string()});
  }
  add({"--bind", fs::canonical(box.folder).string(), box.folder.string()});
  for (const fs::path& path : hidden) add({"--remount-ro", path.string()});
  add({"--chdir", box.folder.string(), "--"});
  boxed.insert(boxed.end(), command.begin(), command.end());
  return boxed;
}

std::optional<std::string> WhyNoSandbox() {
  if (!Find(kSandbox)) {
    return "bubblewrap (the program bwrap) is not installed: apt-get install bubblewrap";
  }
  const OwnFolder folder;
  const auto command = InSandbox({"/bin/sh", "-c", "echo works"}, {folder.path(), {}, {}});
  const Reply reply = Ask({.command = command, .folder = folder.path(), .environment = {}}, "");
  if (reply.line == "works") return std::nullopt;
  return "bubblewrap cannot start (" +
         (reply.last_words.empty() ? reply.failure : reply.last_words) +
         "): this system or container does not allow programs to create namespaces";
}

}  // namespace rangegrasp::process
