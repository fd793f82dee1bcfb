#include "cli/run_into.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "base/finding.h"
#include "base/number.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/progress_bar.h"
#include "experiment/hopeless.h"
#include "experiment/kinds.h"
#include "experiment/results.h"
#include "experiment/resume.h"
#include "experiment/store.h"

namespace rangegrasp::cli {
namespace {

using experiment::Experiment;
using experiment::Stamp;
using experiment::Store;

// A store to write to: a new one, or one that an earlier part of the run left.
Store OpenForRun(const std::filesystem::path& folder, const RunIntoOptions& options,
                 const Experiment& e) {
  if (options.overwrite && Store::Exists(folder)) Store::Remove(folder);
  Store store = Store::Create(folder);
  Stamp stamp = e.stamp;
  // What was killed or refused before its first case left nothing to go on with.
  if (store.Count() > 0) {
    if (!options.resume) {
      throw base::InputError(folder.string() +
                             ": holds results already; --resume goes on with them, "
                             "--overwrite starts anew, --out DIR writes elsewhere");
    }
    const std::string before = experiment::Need(store.ReadStamp().identity, "cases");
    if (options.shards > 1 && before != e.stamp.identity.at("cases")) {
      throw base::InputError(folder.string() + ": is a shard of " + before +
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

experiment::Progress ProgressOf(const RunIntoOptions& options, const Experiment& e, int before,
                                int total) {
  if (options.progress) return options.progress(before, total);
  return ProgressBar(before, total, e.kind->success);
}

// @return why it ended early; empty if it did not.
std::string RunTillHopeless(const Experiment& e, std::vector<experiment::Case> cases, Store& store,
                            const RunIntoOptions& options) {
  const experiment::RunOptions how{.jobs = options.jobs, .case_limit_s = e.common.case_limit_s};
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
    RunCases(now, run, store, how, ProgressOf(options, e, 0, total));
    const auto failure = experiment::SameFailure(RecordsOf(first, store), e.kind->success);
    if (failure && !now.empty()) {
      return fmt::format(
          "stopped after {} of {} cases, which all ended in {}; {} cases were not run (--resume "
          "runs them all the same, the key stop_after: 0 never stops; `rangegrasp check {}` looks "
          "for what is wrong)",
          stop_after, cases.size(), *failure, Missing(cases, store).size(), e.common.file.string());
    }
  }
  RunCases(Missing(cases, store), run, store, how, ProgressOf(options, e, done, total));
  return "";
}

}  // namespace

std::string RunInto(const std::filesystem::path& folder, const Experiment& e,
                    const RunIntoOptions& options) {
  e.kind->report(e.stamp, {});  // a broken published table shows before hours of trials
  Store store = OpenForRun(folder, options, e);
  const auto cases = ShardOf(e.cases, options.shard, options.shards);
  const auto before = Missing(cases, store).size();
  const base::Stopwatch watch;
  std::string failed = RunTillHopeless(e, cases, store, options);
  const auto records = store.ReadAll();
  const auto report = experiment::ReportOf({store.ReadStamp(), records}, experiment::AllKinds());
  for (const auto& [name, text] : report.files) WriteResult(text, folder / name);
  spdlog::info("{} cases in {:.1f} s with {} jobs; results in {}",
               before - Missing(cases, store).size(), watch.Seconds(), options.jobs,
               store.file().string());
  const auto crashes = experiment::CrashReasons(records);
  if (!crashes.empty()) {
    failed += (failed.empty() ? "" : "\n") +
              fmt::format("cases crashed:\n  {}", base::Join(crashes, "\n  "));
  }
  return failed;
}

void CheckBeforeRun(const std::filesystem::path& file, const experiment::Changes& changes) {
  const auto findings = experiment::CheckExperiment(file, experiment::AllKinds(), changes);
  std::vector<std::string> errors;
  for (const base::Finding& finding : findings) {
    if (finding.error) {
      errors.push_back(base::TextOf(finding));
    } else {
      spdlog::warn(base::TextOf(finding));
    }
  }
  if (errors.empty()) return;
  throw base::InputError(
      fmt::format("{}: this cannot work:\n{}", file.string(), base::Join(errors, "\n")));
}

Ran RunExperiment(const std::filesystem::path& file, experiment::Changes changes,
                  const std::vector<std::uint64_t>& seeds, const std::filesystem::path& out,
                  const RunIntoOptions& options) {
  Ran ran;
  const auto open = [&] {
    Experiment e = experiment::OpenExperiment(file, experiment::AllKinds(), changes);
    ran.folder = out.empty() ? std::filesystem::path("results") / e.common.name : out;
    e.task->Hide(ran.folder);
    return e;
  };
  if (seeds.empty()) {
    const Experiment e = open();
    ran.failed = RunInto(ran.folder, e, options);
    return ran;
  }
  for (const std::uint64_t seed : seeds) {
    changes.seed = seed;
    const Experiment e = open();
    if (Store::Exists(ran.folder)) {
      throw base::InputError(ran.folder.string() +
                             ": holds results of one seed; --out DIR writes those of several "
                             "elsewhere");
    }
    const std::string failed = RunInto(experiment::SeedFolder(ran.folder, seed), e, options);
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
    if (!seed || std::find(seeds.begin(), seeds.end(), *seed) != seeds.end()) {
      throw base::InputError("--seeds '" + text +
                             "' must be different whole numbers with commas, e.g. 1,2,3");
    }
    seeds.push_back(*seed);
  }
  return seeds;
}

}  // namespace rangegrasp::cli
