#include "experiment/runner.h"

#include <fcntl.h>
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
#include <exception>
#include <memory>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/stopwatch.h"
#include "core/version.h"
#include "sim/info.h"
#include "sim/world.h"

namespace rangegrasp::experiment {
namespace {

constexpr double kGrace_s = 1.0;

// A trial in a process of its own; reads its result from a pipe.
class Worker {
 public:
  Worker(const RunPlan& plan, const TrialSpec& spec) : spec_(spec), plan_(&plan) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw core::RunError(Errno("pipe"));
    log_ = memfd_create("trial", MFD_CLOEXEC);
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ < 0) throw core::RunError(Errno("fork"));
    if (pid_ == 0) RunChild(parent, ends[1]);
    close(ends[1]);
    pipe_ = ends[0];
  }
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
  double Left() const { return plan_->trial_limit_s - watch_.Seconds(); }

  // Takes what the pipe holds; true when the process has closed it.
  bool Read() {
    std::array<char, 65536> buffer{};
    const ssize_t n = read(pipe_, buffer.data(), buffer.size());
    if (n > 0) text_.append(buffer.data(), static_cast<std::size_t>(n));
    return n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN);
  }

  // After the pipe's end. A process that closed it but does not exit has kGrace_s to do so.
  TrialResult Finish() {
    int status = 0;
    const core::Stopwatch waited;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (waited.Seconds() > kGrace_s) return TimeOut();
      usleep(200);
    }
    pid_ = -1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      try {
        return FromJson(text_);
      } catch (const core::RunError&) {
        return Failed(Outcome::kCrashed, "the process handed over no result" + Tail());
      }
    }
    const std::string how = WIFSIGNALED(status)
                                ? std::string("killed by ") + strsignal(WTERMSIG(status))
                                : "ended with code " + std::to_string(WEXITSTATUS(status));
    return Failed(Outcome::kCrashed, how + Tail());
  }

  TrialResult TimeOut() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
    return Failed(Outcome::kTimedOut, "no result within the limit");
  }

 private:
  static std::string Errno(const char* what) { return std::string(what) + ": " + strerror(errno); }

  // noexcept: nothing may unwind into the parent's loop, whose workers and store are copies here.
  [[noreturn]] void RunChild(pid_t parent, int out) noexcept {
    // Dies with its parent, so that a killed run leaves nothing behind.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(3);
    const int null = open("/dev/null", O_RDWR);
    dup2(null, STDIN_FILENO);
    dup2(null, STDOUT_FILENO);
    if (log_ >= 0) dup2(log_, STDERR_FILENO);
    std::string text;
    try {
      text = ToJson(plan_->run(spec_));
    } catch (const std::exception& e) {
      dprintf(STDERR_FILENO, "%s\n", e.what());
      _exit(5);
    }
    std::size_t sent = 0;
    while (sent < text.size()) {
      const ssize_t n = write(out, text.data() + sent, text.size() - sent);
      if (n <= 0) _exit(4);
      sent += static_cast<std::size_t>(n);
    }
    _exit(0);
  }

  // The last line that the process wrote to stderr.
  std::string Tail() const {
    if (log_ < 0) return "";
    const off_t size = lseek(log_, 0, SEEK_END);
    std::string text(static_cast<std::size_t>(std::min<off_t>(size, 2000)), '\0');
    const ssize_t n = pread(log_, text.data(), text.size(), size - static_cast<off_t>(text.size()));
    text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    const std::size_t line = text.rfind('\n');
    if (line != std::string::npos) text.erase(0, line + 1);
    return text.empty() ? "" : ": " + text;
  }

  TrialResult Failed(Outcome outcome, const std::string& detail) const {
    TrialResult result;
    result.id = TrialId(spec_);
    result.object = spec_.object;
    result.index = spec_.index;
    result.seed = TrialSeed(plan_->seed, spec_);
    result.outcome = outcome;
    result.stage = "trial";
    result.detail = detail;
    result.seconds.emplace_back("trial", watch_.Seconds());
    return result;
  }

  TrialSpec spec_;
  const RunPlan* plan_;
  core::Stopwatch watch_;
  pid_t pid_ = -1;
  int pipe_ = -1;
  int log_ = -1;
  std::string text_;
};

std::vector<TrialSpec> Wanted(const RunPlan& plan, const Store& store, const RunOptions& options) {
  std::set<std::string> done;
  if (options.resume) {
    for (const TrialResult& result : store.ReadAll()) done.insert(result.id);
  }
  std::vector<TrialSpec> wanted;
  for (std::size_t i = 0; i < plan.trials.size(); ++i) {
    const bool mine =
        i % static_cast<std::size_t>(options.shards) == static_cast<std::size_t>(options.shard - 1);
    if (mine && !done.contains(TrialId(plan.trials[i]))) wanted.push_back(plan.trials[i]);
  }
  return wanted;
}

}  // namespace

std::map<std::string, std::string> MakeStamp(const Experiment& e) {
  std::map<std::string, std::string> stamp = {
      {"version", core::Version()},
      {"commit", core::Commit()},
      {"experiment", e.name},
      {"experiment_file", std::filesystem::absolute(e.file).lexically_normal().string()},
      {"experiment_hash", ExperimentHash(e)},
      {"scene_hash", SceneHash(e)},
      {"seed", std::to_string(e.seed)},
      {"trials_per_object", std::to_string(e.trials_per_object)},
      {"mujoco", sim::EngineVersion()},
  };
  std::string objects;
  for (const std::string& object : e.objects) {
    objects += (objects.empty() ? "" : ",") + object;
    stamp["title." + object] = sim::ObjectTitle(ObjectModelOf(e, object));
  }
  stamp["objects"] = objects;
  if (!e.reference.empty()) stamp["reference"] = core::ReadNonEmptyFile(e.reference);
  return stamp;
}

void RunTrials(const RunPlan& plan, Store& store, const RunOptions& options,
               const Progress& progress) {
  const std::vector<TrialSpec> wanted = Wanted(plan, store, options);
  const int total = static_cast<int>(wanted.size());
  std::vector<std::unique_ptr<Worker>> running;
  std::size_t next = 0;
  int done = 0;
  const auto record = [&](const TrialResult& result) {
    store.Write(result);
    ++done;
    if (progress) progress(done, total, result);
  };
  while (next < wanted.size() || !running.empty()) {
    while (next < wanted.size() && running.size() < static_cast<std::size_t>(options.jobs)) {
      running.push_back(std::make_unique<Worker>(plan, wanted[next++]));
    }
    std::vector<pollfd> waits;
    double soonest = 3600.0;
    for (const auto& worker : running) {
      waits.push_back({worker->pipe(), POLLIN, 0});
      soonest = std::min(soonest, worker->Left());
    }
    poll(waits.data(), waits.size(), std::max(1, static_cast<int>(soonest * 1000.0)));
    for (std::size_t i = running.size(); i-- > 0;) {
      const bool ended = waits[i].revents != 0 && running[i]->Read();
      if (!ended && running[i]->Left() > 0.0) continue;
      record(ended ? running[i]->Finish() : running[i]->TimeOut());
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
}

void RunExperiment(const TrialContext& context, Store& store, const RunOptions& options,
                   const Progress& progress) {
  const Experiment& e = context.experiment;
  const auto run = [&](const TrialSpec& spec) { return RunTrial(context, spec); };
  RunTrials({AllTrials(e), e.seed, e.trial_limit_s, run}, store, options, progress);
}

}  // namespace rangegrasp::experiment
