#include "cli/run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <memory>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/installation.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/slurm.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using experiment::Case;
using experiment::Experiment;
using experiment::Progress;
using experiment::Record;
using experiment::Stamp;
using experiment::Store;

// While it exists, Ctrl-C and SIGTERM (`kill`, a batch system) tell how many cases the run has
// done, and then end the program as usual. The store keeps the finished cases of a killed run.
class TellsWhenStopped {
 public:
  TellsWhenStopped() {
    process_ = getpid();
    for (auto& [signal, before] : before_) {
      before = std::signal(signal, Stop);
      if (before == SIG_IGN) std::signal(signal, SIG_IGN);  // in the background of a script
    }
  }
  ~TellsWhenStopped() {
    for (const auto& [signal, before] : before_) std::signal(signal, before);
  }
  TellsWhenStopped(const TellsWhenStopped&) = delete;
  TellsWhenStopped& operator=(const TellsWhenStopped&) = delete;

  static void Begin(std::size_t done, std::size_t total) {
    done_ = done;
    total_ = total;
  }
  static void CountOne() { ++done_; }

 private:
  static void Stop(int signal) {
    if (getpid() == process_ && total_ > 0) {  // a worker is a fork with the same handler
      std::array<char, 128> text{};            // without memory from the heap, as in any handler
      const auto end = fmt::format_to_n(text.data(), text.size(),
                                        "\nstopped after {} of {} cases; `--resume` continues\n",
                                        done_.load(), total_.load());
      std::ignore = write(STDERR_FILENO, text.data(), end.size);
    }
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }

  static inline std::atomic<std::size_t> done_ = 0, total_ = 0;
  static inline pid_t process_ = 0;
  std::array<std::pair<int, void (*)(int)>, 2> before_ = {{{SIGINT, SIG_DFL}, {SIGTERM, SIG_DFL}}};
};

// Opens the store to write to: a new one, or the one of an earlier part of the run.
Store OpenForRun(const fs::path& folder, const RunIntoOptions& options, const Experiment& e) {
  if (options.overwrite && Store::Exists(folder)) Store::Remove(folder);
  Store store = Store::Create(folder);
  Stamp stamp = e.stamp;
  // A run that was killed or refused before its first case has left nothing to resume.
  if (store.Count() > 0) {
    if (!options.resume) {
      throw base::InputError(fmt::format(
          "{}: already contains results; {} continues them, {} deletes them, {} writes elsewhere",
          folder.string(), options.names.resume, options.names.overwrite, options.names.out));
    }
    const Stamp stored = store.ReadStamp();
    const std::string before =
        experiment::InFolder(folder, [&] { return experiment::Need(stored.identity, "cases"); });
    if (options.shards > 1 && before != e.stamp.identity.at("cases")) {
      throw base::InputError(folder.string() + ": is a shard of " + before +
                             " cases; more trials would change the shards: run them without "
                             "--shard, or into new folders");
    }
    stamp = experiment::Resume(store, e.stamp, e.cases, options.names);
    if (stamp.build.contains("resumed_with")) {
      spdlog::warn(
          "the run was started with commit {} and continued with {}: the results of the two may "
          "differ",
          experiment::ValueOr(stamp.build, "commit", "?"), stamp.build.at("resumed_with"));
    }
  }
  store.WriteStamp(stamp);
  WriteResult(experiment::FileAsRun(stamp), folder / "experiment.yaml");
  return store;
}

bool Contains(const std::vector<Case>& cases, const std::string& id) {
  return std::ranges::find(cases, id, &Case::id) != cases.end();
}

Progress ProgressOf(const RunIntoOptions& options, const Experiment& e, int before, int total) {
  Progress show = options.progress ? options.progress(before, total)
                                   : ProgressBar(before, total, SuccessOf(*e.kind, e.stamp));
  return [show = std::move(show)](int done, int of, const Record& last) {
    TellsWhenStopped::CountOne();
    show(done, of, last);
  };
}

// The command that checks the file with the changes of this run.
std::string CheckCommand(const Experiment& e) {
  std::string command = "rangegrasp check " + e.common.file.string();
  for (const std::string& set : experiment::SetOf(e.stamp)) {
    command += " --set " + experiment::ShellQuoted(set);
  }
  return command;
}

// @return why the run ended early; empty if it did not.
std::string RunTillHopeless(const Experiment& e, const std::vector<Case>& cases, Store& store,
                            const RunIntoOptions& options) {
  const experiment::RunOptions how{
      .jobs = options.jobs, .case_limit_s = e.common.case_limit_s, .processes = options.processes};
  const auto run = [&](const Case& which) { return e.task->Run(which); };
  auto missing = Missing(cases, store, options.resume);
  const int total = static_cast<int>(missing.size());
  if (total > 0) e.task->Prepare();
  int done = 0;
  const auto stop_after = static_cast<std::size_t>(e.common.stop_after);
  if (stop_after > 0 && cases.size() > stop_after && e.kind->stops_when_hopeless) {
    auto first = experiment::InTurn(cases);
    first.resize(stop_after);
    const bool begun_before = Missing(first, store).empty();
    const auto now = Missing(first, store, options.resume);
    std::erase_if(missing, [&](const Case& which) { return Contains(now, which.id); });
    done = static_cast<int>(now.size());
    RunCases(now, run, store, how, ProgressOf(options, e, 0, total));
    auto records = store.ReadAll();
    std::erase_if(records, [&](const Record& record) { return !Contains(first, record.which.id); });
    const auto failure = experiment::SameFailure(records, SuccessOf(*e.kind, e.stamp));
    if (failure && !begun_before) {
      return fmt::format(
          "stopped after {} of {} cases, which all ended in {}; {} cases were not run ({} runs "
          "them anyway; stop_after: 0 never stops a run; `{}` looks for errors)",
          stop_after, cases.size(), *failure, Missing(cases, store).size(), options.names.resume,
          CheckCommand(e));
    }
  }
  RunCases(missing, run, store, how, ProgressOf(options, e, done, total));
  return "";
}

// Runs one experiment with one seed. The first cases of each group are run before all others, which
// are run only if the first ones do not all fail in the same way. Resuming the run continues it.
Ran RunInto(const fs::path& folder, const Experiment& e, const RunIntoOptions& options) {
  experiment::ReportOf(
      {e.stamp, {}, e.common.file});  // finds a broken published table before hours of trials
  const experiment::FolderLock lock(folder);
  Store store = OpenForRun(folder, options, e);
  const auto cases = ShardOf(e.cases, options.shard, options.shards);
  const auto before = Missing(cases, store, options.resume).size();
  TellsWhenStopped::Begin(cases.size() - before, cases.size());
  const base::Stopwatch watch;
  std::string failed = RunTillHopeless(e, cases, store, options);
  store.Finish();
  experiment::Results results{store.ReadStamp(), store.ReadAll(), folder};
  auto report = experiment::ReportOf(results);
  for (const auto& [name, text] : report.files) WriteResult(text, folder / name);
  spdlog::info("{} in {:.1f} s (--jobs {}); results in {}",
               base::Counted(before - Missing(cases, store).size(), "case"), watch.Seconds(),
               options.jobs, store.file().string());
  const auto same = experiment::SameFailure(results.records, SuccessOf(*e.kind, e.stamp));
  if (same && results.records.front().result.outcome == e.kind->unusable) {
    failed += (failed.empty() ? "" : "\n") + ("all cases ended in " + *same);
  }
  const auto crashes = experiment::CrashReasons(results.records);
  if (!crashes.empty()) {
    failed += (failed.empty() ? "" : "\n") +
              fmt::format("cases crashed:\n  {}", base::Join(crashes, "\n  "));
  }
  return {folder, std::move(failed), std::move(results.stamp), std::move(report)};
}

struct RunArguments {
  std::string experiment, out, groups, seeds, shard = "1/1", format = "text";
  experiment::Changes changes;
  RunIntoOptions options;
  bool report = false;
};

std::pair<int, int> ParseShard(const std::string& text) {
  const auto parts = base::Split(text, '/');
  const auto shard = base::NumberFrom<int>(parts.front());
  const auto shards = base::NumberFrom<int>(parts.back());
  if (parts.size() != 2 || !shard || !shards || *shard < 1 || *shard > *shards) {
    throw base::InputError("--shard '" + text + "' must be I/N with 1 <= I <= N, e.g. 2/8");
  }
  return {*shard, *shards};
}

void Run(RunArguments a) {
  const auto make_report = MakeReportFor();
  if (a.report && !make_report) {  // checked before hours of trials
    base::CheckBuilt("command", "report");
    throw base::InputError("--report: this program was built without reports");
  }
  if (!a.groups.empty()) a.changes.groups = base::Split(a.groups, ',');
  std::tie(a.options.shard, a.options.shards) = ParseShard(a.shard);
  const fs::path file = base::FindExperiment(a.experiment);
  const Ran ran = [&] {
    const TellsWhenStopped tells;
    return RunExperiment(file, a.changes, SeedsFrom(a.seeds), a.out, a.options);
  }();
  const auto format = TableFormatFrom(a.format);
  if (ran.report) {
    WriteTables(*ran.report, ran.stamp, format);
  } else {
    const auto results = experiment::ReadResults(ran.folder);
    WriteTables(experiment::ReportOf(results), results.stamp, format);
  }
  if (a.report) make_report(ran.folder, a.options.jobs, /*run_detector=*/true);
  if (!ran.failed.empty()) throw base::RunError(ran.failed);
}

}  // namespace

experiment::OnFindings RefuseErrors(const fs::path& file) {
  return [file](const std::vector<base::Finding>& findings) {
    std::vector<std::string> errors;
    for (const base::Finding& finding : findings) {
      if (finding.error) {
        errors.push_back(base::TextOf(finding));
      } else {
        spdlog::warn(base::MessageOf(finding));
      }
    }
    if (errors.empty()) return true;
    throw base::InputError(
        fmt::format("{}: the experiment has errors:\n{}", file.string(), base::Join(errors, "\n")));
  };
}

Ran RunExperiment(const fs::path& file, experiment::Changes changes,
                  const std::vector<std::uint64_t>& seeds, const fs::path& out,
                  const RunIntoOptions& options) {
  if (options.resume && options.overwrite) {
    throw base::InputError(
        fmt::format("{} continues existing results, {} deletes them: give one of the two",
                    options.names.resume, options.names.overwrite));
  }
  Ran ran;
  const auto open = [&](const experiment::OnFindings& on_findings) {
    Experiment e = experiment::OpenExperiment(file, changes, on_findings);
    ran.folder = out.empty() ? fs::path("results") / e.common.name : out;
    e.task->Hide(ran.folder);
    return e;
  };
  const auto refuse_errors = RefuseErrors(file);
  if (seeds.empty()) {
    const Experiment e = open(refuse_errors);
    if (experiment::StoresIn(ran.folder).front() != ran.folder) {
      throw base::InputError(
          fmt::format("{}: holds runs of several seeds, which its table would then no longer show; "
                      "{} adds a seed, {} writes elsewhere",
                      ran.folder.string(), options.names.seeds, options.names.out));
    }
    return RunInto(ran.folder, e, options);
  }
  for (const std::uint64_t seed : seeds) {
    changes.seed = seed;
    const Experiment e = open(seed == seeds.front() ? refuse_errors : experiment::OnFindings());
    if (Store::Exists(ran.folder)) {
      throw base::InputError(fmt::format(
          "{}: contains the results of one seed; {} writes those of several seeds elsewhere",
          ran.folder.string(), options.names.out));
    }
    const std::string failed = RunInto(experiment::SeedFolder(ran.folder, seed), e, options).failed;
    if (failed.empty()) continue;
    ran.failed += fmt::format("{}seed {}: {}", ran.failed.empty() ? "" : "\n", seed, failed);
  }
  return ran;
}

std::vector<std::uint64_t> SeedsFrom(const std::string& text) {
  if (text.empty()) return {};
  std::vector<std::uint64_t> seeds;
  for (const std::string& part : base::Split(text, ',')) {
    const auto seed = base::NumberFrom<std::uint64_t>(part);
    if (!seed || std::ranges::find(seeds, *seed) != seeds.end()) {
      throw base::InputError("--seeds '" + text +
                             "' must be different whole numbers separated by commas, e.g. 1,2,3");
    }
    seeds.push_back(*seed);
  }
  return seeds;
}

void AddRunCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "run", "Run an experiment of any kind and print its tables next to the published ones.");
  auto a = std::make_shared<RunArguments>();
  command->add_option("experiment", a->experiment, "experiment file (YAML)")->required();
  command->add_option("-o,--out", a->out, "results folder (default: results/<experiment name>)");
  command
      ->add_option("--trials", a->changes.trials,
                   "number of trials of each object, of seams, or of models of each class; "
                   "overrides the file")
      ->transform(WholeNumber(1, 1'000'000));
  command->add_option(
      "--objects", a->groups,
      "only these groups of the tables: objects, shapes, classes, methods or hazards, e.g. "
      "coffee_cup,cleaner; objects as targets: the others of the file stay in the heap");
  AddJobsOption(*command, "cases", a->options.jobs);
  command->add_option("--seed", a->changes.seed, "overrides the seed of the file")
      ->transform(WholeNumber());
  command
      ->add_option("--seeds", a->seeds,
                   "one run for each seed, e.g. 1,2,3, each in its own subfolder of the results "
                   "folder; the table combines them")
      ->excludes("--seed");
  command
      ->add_option(
          "--set", a->changes.set,
          "KEY=VALUE, overrides a key of the file, e.g. physics.timestep_ms=1; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--resume", a->options.resume, "continue a stopped run");
  command->add_flag("--overwrite", a->options.overwrite, "delete existing results in the folder");
  command->add_option("--shard", a->shard, "I/N: every N-th case, from the I-th (join with merge)");
  command->add_flag("--report", a->report, "afterwards write the pages of the command `report`");
  AddFormatOption(*command, a->format);
  command->footer(
      "Example: rangegrasp run experiments/laser_single.yaml --objects coffee_cup --trials 3 "
      "--jobs 2");
  command->callback([a] { Run(*a); });
}

void AddRunDetectorOption(CLI::App& command, bool& run_detector) {
  command.add_flag("--run-detector", run_detector,
                   "allow starting the detector program that is named in the results; only for "
                   "results that you trust");
}

bool& HasPythonDetector() {
  static bool has = false;
  return has;
}

experiment::Experiment ReopenExperiment(const experiment::Stamp& stamp, const std::string& folder,
                                        bool run_detector) {
  const std::string function = experiment::ValueOr(stamp.identity, "detector_function", "");
  if (!function.empty() && !HasPythonDetector()) {
    throw base::InputError(
        folder + ": the detector was the Python function " + function +
        ": only the Python program that ran it can run its trials again "
        "(rangegrasp.evaluate(...).report()); `report --views none` and `export` without "
        "`--clouds` work");
  }
  auto e = experiment::InFolder(folder, [&] { return experiment::OpenAgain(stamp, run_detector); });
  for (const auto& [name, value] : e.stamp.identity) {
    if (experiment::ValueOr(stamp.identity, name, value) != value) {
      spdlog::warn("the {} has changed since the run: results may differ", name);
    }
  }
  return e;
}

}  // namespace rangegrasp::cli
