#include "experiment/runner.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
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
#include <ctime>
#include <exception>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

// Time [s] that a process has to exit after sending its result; then it counts as hanging.
constexpr double kGrace_s = 1.0;
// A process that waits instead of computing hangs after this multiple of the limit.
constexpr double kMaxWait = 5.0;
// Polling interval of its exit [us].
constexpr useconds_t kPoll_us = 200;
// The last line within this many bytes of a process's stderr output is kept.
constexpr off_t kTail_bytes = 2000;

// Exit codes of a child that sends no result.
constexpr int kLostParent = 3;
constexpr int kNotSent = 4;
constexpr int kThrew = 5;

[[noreturn]] void ThrowErrno(const char* what) {
  throw base::RunError(std::string(what) + ": " + strerror(errno));
}

// The bytes sent through the pipe: MessagePack preserves strings and numbers exactly.
std::string Packed(const Result& r) {
  const nlohmann::json json = {r.outcome, r.stage, r.detail, r.data, r.seconds};
  std::string bytes;
  nlohmann::json::to_msgpack(json, bytes);
  return bytes;
}

std::optional<Result> Unpacked(const std::string& bytes) {
  const auto json = nlohmann::json::from_msgpack(bytes, true, false);
  try {
    return Result{json.at(0), json.at(1), json.at(2), json.at(3), json.at(4)};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

// A case in its own process, forked from this one; its result comes through a pipe.
class Worker {
 public:
  // @param run  called in the child; its output does not mix with the output of this process.
  // @throws base::RunError if no process or pipe can be made.
  Worker(const Case& which, const RunOptions& options, const CaseRunner& run)
      : which_(which), limit_s_(options.case_limit_s) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) ThrowErrno("pipe");
    log_ = memfd_create("case", MFD_CLOEXEC);
    const pid_t parent = getpid();
    pid_ = options.processes.fork ? options.processes.fork() : fork();
    if (pid_ < 0) ThrowErrno("fork");
    if (pid_ == 0) RunChild(parent, ends[1], run);
    close(ends[1]);
    pipe_ = ends[0];
  }
  // Kills the process if it still runs.
  ~Worker() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    if (pipe_ >= 0) close(pipe_);
    if (log_ >= 0) close(log_);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int pipe() const { return pipe_; }
  const Case& which() const { return which_; }
  // Time left until the limit [s], of the computing time or of the time on the clock.
  double Left() const {
    return std::min(limit_s_ - Computed(), kMaxWait * limit_s_ - watch_.Seconds());
  }
  // Reads the available data from the pipe; true when the process has closed it.
  bool Read() {
    std::array<char, 65536> buffer{};
    const ssize_t n = read(pipe_, buffer.data(), buffer.size());
    if (n > 0) text_.append(buffer.data(), static_cast<std::size_t>(n));
    return n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN);
  }

  // The result, after the pipe was closed; waits a short time for the process to exit.
  Result Finish() {
    int status = 0;
    const base::Stopwatch waited;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (waited.Seconds() > kGrace_s) {
        // Idle-priority threads of libraries (Mesa's, which stores shaders) end seconds late on a
        // busy machine: a complete result counts. The remaining process is killed.
        auto late = Unpacked(text_);
        return late ? std::move(*late) : TimeOut();
      }
      usleep(kPoll_us);
    }
    pid_ = -1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      if (auto result = Unpacked(text_)) return std::move(*result);
      return Failed(kCrashed, "the process returned no result" + LastLine());
    }
    const std::string how = WIFSIGNALED(status)
                                ? fmt::format("killed by {}", strsignal(WTERMSIG(status)))
                                : fmt::format("ended with code {}", WEXITSTATUS(status));
    return Failed(kCrashed, how + LastLine());
  }

  // Kills the process; the outcome is kTimedOut.
  Result TimeOut() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
    return Failed(kTimedOut, "no result within the time limit");
  }

 private:
  // noexcept: no exception may reach the parent's loop, whose workers and store are copies here.
  [[noreturn]] void RunChild(int parent, int out, const CaseRunner& run) noexcept {
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
    } catch (const std::bad_alloc&) {
      dprintf(STDERR_FILENO, "out of memory\n");
      _exit(kThrew);
    } catch (const std::exception& e) {
      dprintf(STDERR_FILENO, "%s\n", e.what());
      _exit(kThrew);
    }
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = write(out, bytes.data() + sent, bytes.size() - sent);
      if (n <= 0) {
        dprintf(STDERR_FILENO, "the result could not be sent: %s\n", strerror(errno));
        _exit(kNotSent);
      }
      sent += static_cast<std::size_t>(n);
    }
    close(out);  // signals a complete result, however long the exit takes
    _exit(0);
  }

  // Computing time of the process and its threads [s]; 0 once it has ended.
  double Computed() const {
    clockid_t clock{};
    timespec used{};
    if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0.0;
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  }

  std::string LastLine() const {
    if (log_ < 0) return "";
    const off_t size = lseek(log_, 0, SEEK_END);
    std::string text(static_cast<std::size_t>(std::min(size, kTail_bytes)), '\0');
    const ssize_t n = pread(log_, text.data(), text.size(), size - static_cast<off_t>(text.size()));
    text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    text.erase(text.find_last_not_of('\n') + 1);
    text.erase(0, text.rfind('\n') + 1);
    return text.empty() ? "" : ": " + text;
  }

  Result Failed(const char* outcome, const std::string& detail) const {
    return {outcome, "case", detail, "{}", {{"case", watch_.Seconds()}}};
  }

  Case which_;
  double limit_s_;
  base::Stopwatch watch_;
  int pid_ = -1;
  int pipe_ = -1;
  int log_ = -1;
  std::string text_;
};

// Waits until a worker sends data or has used up its time.
std::vector<pollfd> Wait(const std::vector<std::unique_ptr<Worker>>& running,
                         const Processes& processes) {
  std::vector<pollfd> waits;
  double soonest_s = running.front()->Left();
  for (const auto& worker : running) {
    waits.push_back({worker->pipe(), POLLIN, 0});
    soonest_s = std::min(soonest_s, worker->Left());
  }
  const auto wait = [&] {
    poll(waits.data(), waits.size(), std::max(1, static_cast<int>(soonest_s * 1000.0)));
  };
  if (processes.wait) {
    processes.wait(wait);
  } else {
    wait();
  }
  return waits;
}

// The stored records with the cases of a run that may have more of them.
std::vector<Record> Replaced(std::vector<Record> records, const std::vector<Case>& cases,
                             const std::string& where) {
  std::unordered_map<std::string, const Case*> by_id;
  for (const Case& c : cases) by_id.emplace(c.id, &c);
  for (Record& record : records) {
    const auto found = by_id.find(record.which.id);
    if (found == by_id.end() || found->second->seed != record.which.seed) {
      throw base::InputError(
          fmt::format("{}: contains the case {}, which is not one of these {} cases; to continue, "
                      "use at least as many trials as at the start",
                      where, record.which.id, cases.size()));
    }
    record.which = *found->second;
  }
  return records;
}

// Whether the run has the stored groups in the same order, and perhaps others: tasks whose shapes
// or hazards take turns reach more of them with more trials.
bool ContainsGroups(const Stamp& run, const Stamp& stored) {
  const auto groups = [](const Stamp& stamp) {
    return base::Split(ValueOr(stamp.identity, "groups", ""), ',');
  };
  const auto wanted = groups(stored);
  auto next = wanted.begin();
  for (const std::string& group : groups(run)) {
    if (next != wanted.end() && *next == group) ++next;
  }
  return next == wanted.end();
}

// Most frequent first, ties in order of their text.
std::vector<std::pair<std::string, int>> Ranked(const std::map<std::string, int>& counts) {
  std::vector<std::pair<std::string, int>> ranked(counts.begin(), counts.end());
  std::ranges::stable_sort(ranked, std::greater{}, &std::pair<std::string, int>::second);
  return ranked;
}

}  // namespace

std::vector<Case> ShardOf(const std::vector<Case>& cases, int shard, int shards) {
  std::vector<Case> mine;
  for (auto i = static_cast<std::size_t>(shard - 1); i < cases.size();
       i += static_cast<std::size_t>(shards)) {
    mine.push_back(cases[i]);
  }
  return mine;
}

std::vector<Case> Missing(const std::vector<Case>& cases, const Store& store, bool again_crashed) {
  const auto done = store.Ids(again_crashed ? kCrashed : "");
  std::vector<Case> missing = cases;
  std::erase_if(missing, [&](const Case& c) { return done.contains(c.id); });
  return missing;
}

Result RunApart(const Case& which, double limit_s, const CaseRunner& run) {
  Result result;
  RunCases({which}, run, {.case_limit_s = limit_s},
           [&](int, int, const Record& record) { result = record.result; });
  return result;
}

void RunCases(const std::vector<Case>& cases, const CaseRunner& run, Store& store,
              const RunOptions& options, const Progress& progress) {
  RunCases(cases, run, options, [&](int done, int total, const Record& record) {
    store.Write(record);
    if (progress) progress(done, total, record);
  });
}

void RunCases(const std::vector<Case>& cases, const CaseRunner& run, const RunOptions& options,
              const Progress& done) {
  const int total = static_cast<int>(cases.size());
  std::vector<std::unique_ptr<Worker>> running;
  std::size_t next = 0;
  int ended_cases = 0;
  while (next < cases.size() || !running.empty()) {
    while (next < cases.size() && running.size() < static_cast<std::size_t>(options.jobs)) {
      running.push_back(std::make_unique<Worker>(cases[next++], options, run));
    }
    const auto waits = Wait(running, options.processes);
    for (std::size_t i = running.size(); i-- > 0;) {
      const bool ended = waits[i].revents != 0 && running[i]->Read();
      if (!ended && running[i]->Left() > 0.0) continue;
      const Record record{running[i]->which(),
                          ended ? running[i]->Finish() : running[i]->TimeOut()};
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
      done(++ended_cases, total, record);
    }
  }
}

Stamp Resume(Store& store, const Stamp& now, const std::vector<Case>& cases,
             const RunOptionNames& names) {
  const Stamp stored = store.ReadStamp();
  const std::string where = store.file().parent_path().string();
  Stamp alike = stored;
  alike.identity["cases"] = Need(now.identity, "cases");
  if (ContainsGroups(now, stored)) alike.identity["groups"] = ValueOr(now.identity, "groups", "");
  CheckSameRun(alike, now, where,
               fmt::format("choose another folder with {}, or use {} ({} can only add trials)",
                           names.out, names.overwrite, names.resume));
  if (stored.identity != now.identity) {
    for (const Record& record : Replaced(store.ReadAll(), cases, where)) store.Write(record);
  }
  Stamp resumed = now;
  resumed.build = stored.build;
  AddCommit(ValueOr(now.build, "commit", ""), resumed);
  return resumed;
}

std::vector<Case> InTurn(const std::vector<Case>& cases) {
  std::map<std::string, int> of_group;
  std::vector<std::pair<int, Case>> turns;
  for (const Case& c : cases) turns.emplace_back(of_group[c.group]++, c);
  std::ranges::stable_sort(turns, {}, &std::pair<int, Case>::first);
  std::vector<Case> in_turn;
  for (auto& [turn, c] : turns) in_turn.push_back(std::move(c));
  return in_turn;
}

std::optional<std::string> SameFailure(const std::vector<Record>& records,
                                       const std::string& success) {
  if (records.empty()) return std::nullopt;
  const Result& first = records.front().result;
  std::map<std::string, int> details;
  for (const Record& record : records) {
    const Result& result = record.result;
    if (result.outcome == success || result.outcome != first.outcome ||
        result.stage != first.stage) {
      return std::nullopt;
    }
    if (!result.detail.empty()) ++details[result.detail];
  }
  std::string text = first.outcome;
  if (!first.stage.empty()) text += " in " + first.stage;
  const auto ranked = Ranked(details);
  return ranked.empty() ? text : text + ": " + ranked.front().first;
}

std::vector<std::string> CrashReasons(const std::vector<Record>& records) {
  std::map<std::string, int> reasons;
  for (const Record& record : records) {
    const Result& result = record.result;
    if (result.outcome != kCrashed) continue;
    ++reasons[(result.stage.empty() ? "" : result.stage + ": ") +
              (result.detail.empty() ? "no reason given" : result.detail)];
  }
  std::vector<std::string> texts;
  for (const auto& [reason, count] : Ranked(reasons)) {
    texts.push_back(fmt::format("{} x {}", count, reason));
  }
  return texts;
}

}  // namespace rangegrasp::experiment
