#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <thread>

#include "cli/commands.h"
#include "cli/make_report.h"
#include "cli/output.h"
#include "cli/progress_bar.h"
#include "core/data_folder.h"
#include "core/error.h"
#include "core/finding.h"
#include "core/number.h"
#include "core/stopwatch.h"
#include "core/words.h"
#include "experiment/experiment.h"
#include "experiment/hopeless.h"
#include "experiment/results.h"
#include "experiment/resume.h"
#include "experiment/runner.h"
#include "experiment/store.h"
#include "tasks/kinds.h"

namespace rangegrasp::cli {
namespace {

using experiment::Experiment;
using experiment::Stamp;
using experiment::Store;

struct RunArguments {
  std::string experiment;
  std::string out;
  std::string groups;
  std::string shard = "1/1";
  std::string seeds;
  std::string format = "text";
  experiment::Changes changes;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool resume = false;
  bool overwrite = false;
  bool report = false;
};

std::pair<int, int> ParseShard(const std::string& text) {
  const auto parts = core::Split(text, '/');
  const auto shard = core::NumberFrom<int>(parts.front());
  const auto shards = core::NumberFrom<int>(parts.back());
  if (parts.size() != 2 || !shard || !shards || *shard < 1 || *shard > *shards) {
    throw core::InputError("--shard '" + text + "' must be I/N with 1 <= I <= N, e.g. 2/8");
  }
  return {*shard, *shards};
}

// A store to write to: a new one, or one that an earlier part of the run left.
Store OpenForRun(const std::filesystem::path& folder, const RunArguments& arguments,
                 const Experiment& e) {
  if (arguments.overwrite && Store::Exists(folder)) Store::Remove(folder);
  Store store = Store::Create(folder);
  Stamp stamp = e.stamp;
  // What was killed or refused before its first case left nothing to go on with.
  if (store.Count() > 0) {
    if (!arguments.resume) {
      throw core::InputError(folder.string() +
                             ": holds results already; --resume goes on with them, "
                             "--overwrite starts anew, --out DIR writes elsewhere");
    }
    const std::string before = experiment::Need(store.ReadStamp().identity, "cases");
    if (ParseShard(arguments.shard).second > 1 && before != e.stamp.identity.at("cases")) {
      throw core::InputError(folder.string() + ": is a shard of " + before +
                             " cases; more trials would be shared out otherwise: run them without "
                             "--shard, or into new folders");
    }
    stamp = experiment::Resume(store, e.stamp, e.cases);
    if (stamp.build.contains("resumed_with")) {
      spdlog::warn("the run was begun by commit {}, other rows are of {}: they may differ",
                   stamp.build.at("commit"), stamp.build.at("resumed_with"));
    }
  }
  store.WriteStamp(stamp);
  WriteResult(experiment::FileAsRun(stamp), folder / "experiment.yaml");
  return store;
}

// Those of the records that are of the cases.
std::vector<experiment::Record> RecordsOf(const std::vector<experiment::Case>& cases,
                                          const Store& store) {
  std::vector<experiment::Record> records;
  for (const experiment::Record& record : store.ReadAll()) {
    const bool wanted = std::any_of(cases.begin(), cases.end(), [&](const experiment::Case& c) {
      return c.id == record.which.id;
    });
    if (wanted) records.push_back(record);
  }
  return records;
}

// Runs the first cases of each group before all others, and these only if not all of the first fail
// in the same way. A run that is resumed after that goes on.
// @return why it ended early; empty if it did not.
std::string RunTillHopeless(const Experiment& e, std::vector<experiment::Case> cases, Store& store,
                            const RunArguments& arguments) {
  const experiment::RunOptions options{.jobs = arguments.jobs,
                                       .case_limit_s = e.common.case_limit_s};
  const auto run = [&](const experiment::Case& which) { return e.task->Run(which); };
  const auto missing = Missing(cases, store);
  const int total = static_cast<int>(missing.size());
  if (total > 0) e.task->Prepare();
  int done = 0;
  const auto stop_after = static_cast<std::size_t>(e.common.stop_after);
  if (stop_after > 0 && cases.size() > stop_after && e.kind->stops_when_hopeless) {
    auto first = experiment::InTurn(cases);
    first.resize(stop_after);
    const auto now = Missing(first, store);
    done = static_cast<int>(now.size());
    RunCases(now, run, store, options, ProgressBar(0, total));
    const auto failure = experiment::SameFailure(RecordsOf(first, store), e.kind->success);
    if (failure && !now.empty()) {
      return fmt::format(
          "stopped after {} of {} cases, which all ended in {}; {} cases were not run (--resume "
          "runs them all the same, the key stop_after: 0 never stops; `rangegrasp check {}` looks "
          "for what is wrong)",
          stop_after, cases.size(), *failure, Missing(cases, store).size(), e.common.file.string());
    }
  }
  RunCases(Missing(cases, store), run, store, options, ProgressBar(done, total));
  return "";
}

// One experiment of one seed into its folder.
// @return what has failed of the run as a whole; empty if nothing.
std::string RunInto(const std::filesystem::path& folder, const Experiment& e,
                    const RunArguments& arguments) {
  e.kind->report(e.stamp, {});  // a broken published table shows before hours of trials
  const auto [shard, shards] = ParseShard(arguments.shard);
  Store store = OpenForRun(folder, arguments, e);
  const auto cases = ShardOf(e.cases, shard, shards);
  const auto before = Missing(cases, store).size();
  const core::Stopwatch watch;
  std::string failed = RunTillHopeless(e, cases, store, arguments);
  const auto records = store.ReadAll();
  const auto report = experiment::ReportOf({store.ReadStamp(), records}, tasks::AllKinds());
  for (const auto& [name, text] : report.files) WriteResult(text, folder / name);
  spdlog::info("{} cases in {:.1f} s with {} jobs; results in {}",
               before - Missing(cases, store).size(), watch.Seconds(), arguments.jobs,
               store.file().string());
  const auto crashes = experiment::CrashReasons(records);
  if (!crashes.empty()) {
    failed += (failed.empty() ? "" : "\n") +
              fmt::format("cases crashed:\n  {}", core::Join(crashes, "\n  "));
  }
  return failed;
}

// What a run would only find out trial after trial. @throws core::InputError with all errors.
void CheckBeforeRun(const std::filesystem::path& file, const experiment::Changes& changes) {
  const auto findings = experiment::CheckExperiment(file, tasks::AllKinds(), changes);
  std::vector<std::string> errors;
  for (const core::Finding& finding : findings) {
    if (finding.error) {
      errors.push_back(core::TextOf(finding));
    } else {
      spdlog::warn(core::TextOf(finding));
    }
  }
  if (errors.empty()) return;
  throw core::InputError(
      fmt::format("{}: this cannot work:\n{}", file.string(), core::Join(errors, "\n")));
}

std::vector<std::uint64_t> ParseSeeds(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  for (const std::string& part : core::Split(text, ',')) {
    const auto seed = core::NumberFrom<std::uint64_t>(part);
    if (!seed || std::find(seeds.begin(), seeds.end(), *seed) != seeds.end()) {
      throw core::InputError("--seeds '" + text +
                             "' must be different whole numbers with commas, e.g. 1,2,3");
    }
    seeds.push_back(*seed);
  }
  return seeds;
}

void Run(RunArguments arguments) {
  if (!arguments.groups.empty()) arguments.changes.groups = core::Split(arguments.groups, ',');
  ParseShard(arguments.shard);  // wrong ones show before anything is made
  const std::filesystem::path file = core::FindExperiment(arguments.experiment);
  CheckBeforeRun(file, arguments.changes);
  const auto open = [&] {
    return experiment::OpenExperiment(file, tasks::AllKinds(), arguments.changes);
  };
  std::string failed;
  const auto folder_of = [&](const Experiment& e) {
    return arguments.out.empty() ? std::filesystem::path("results") / e.common.name
                                 : std::filesystem::path(arguments.out);
  };
  std::filesystem::path folder;
  if (arguments.seeds.empty()) {
    const Experiment e = open();
    folder = folder_of(e);
    e.task->Hide(folder);
    failed = RunInto(folder, e, arguments);
  } else {
    for (const std::uint64_t seed : ParseSeeds(arguments.seeds)) {
      arguments.changes.seed = seed;
      const Experiment e = open();
      folder = folder_of(e);
      e.task->Hide(folder);
      if (Store::Exists(folder)) {
        throw core::InputError(folder.string() +
                               ": holds results of one seed; --out DIR writes those of several "
                               "elsewhere");
      }
      const std::string failed_now = RunInto(experiment::SeedFolder(folder, seed), e, arguments);
      if (!failed_now.empty()) {
        failed += fmt::format("{}seed {}: {}", failed.empty() ? "" : "\n", seed, failed_now);
      }
    }
  }
  const auto results = experiment::ReadResults(folder);
  WriteResult(experiment::Format(experiment::ReportOf(results, tasks::AllKinds()), results.stamp,
                                 TableFormatFrom(arguments.format)));
  if (arguments.report) {
    MakeReport({.folders = {folder}, .out = folder / "report", .jobs = arguments.jobs});
  }
  if (!failed.empty()) throw core::RunError(failed);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "run", "Run an experiment of any kind and print its tables beside the published ones.");
  auto a = std::make_shared<RunArguments>();
  command->add_option("experiment", a->experiment, "experiment file (YAML)")->required();
  command->add_option("-o,--out", a->out, "results folder (default: results/<experiment name>)");
  command
      ->add_option("--trials", a->changes.trials,
                   "trials of each object, seams, or models of each class, instead of the file's")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--objects", a->groups,
                      "only these objects, shapes or classes, e.g. coffee_cup,cleaner");
  command->add_option("--jobs", a->jobs, "cases at the same time (default: the number of cores)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--seed", a->changes.seed, "instead of the file's")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--seeds", a->seeds,
                   "one run after the other, e.g. 1,2,3, each in a folder of its own below the "
                   "results folder; the table is that of all")
      ->excludes("--seed");
  command->add_option("--set", a->changes.set,
                      "KEY=VALUE, instead of what the file says, e.g. physics.timestep_ms=1; "
                      "may stand several times");
  command->add_flag("--resume", a->resume, "go on with a run that was stopped");
  command->add_flag("--overwrite", a->overwrite, "throw away results that are in the folder");
  command->add_option("--shard", a->shard, "I/N: every N-th case, from the I-th (join with merge)");
  command->add_flag("--report", a->report, "then pages for a browser, as `report` writes them");
  AddFormatOption(*command, a->format);
  command->footer(
      "Example: rangegrasp run experiments/laser_single.yaml --objects coffee_cup --trials 3 "
      "--jobs 2");
  command->callback([a] { Run(*a); });
}

}  // namespace rangegrasp::cli
