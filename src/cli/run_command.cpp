#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <thread>

#include "base/data_folder.h"
#include "base/error.h"
#include "base/number.h"
#include "base/systems.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/run_into.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "experiment/results.h"

namespace rangegrasp::cli {
namespace {

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
  const auto parts = base::Split(text, '/');
  const auto shard = base::NumberFrom<int>(parts.front());
  const auto shards = base::NumberFrom<int>(parts.back());
  if (parts.size() != 2 || !shard || !shards || *shard < 1 || *shard > *shards) {
    throw base::InputError("--shard '" + text + "' must be I/N with 1 <= I <= N, e.g. 2/8");
  }
  return {*shard, *shards};
}

ReportMaker& Maker() {
  static ReportMaker maker = nullptr;
  return maker;
}

void Run(RunArguments arguments) {
  if (arguments.report) GetReportMaker();  // before hours of trials
  if (!arguments.groups.empty()) arguments.changes.groups = base::Split(arguments.groups, ',');
  const auto [shard, shards] = ParseShard(arguments.shard);
  const RunIntoOptions options{.jobs = arguments.jobs,
                               .shard = shard,
                               .shards = shards,
                               .resume = arguments.resume,
                               .overwrite = arguments.overwrite};
  const std::filesystem::path file = base::FindExperiment(arguments.experiment);
  CheckBeforeRun(file, arguments.changes);
  const Ran ran =
      RunExperiment(file, arguments.changes, SeedsFrom(arguments.seeds), arguments.out, options);
  const auto results = experiment::ReadResults(ran.folder);
  WriteTables(experiment::ReportOf(results, experiment::AllKinds()), results.stamp,
              TableFormatFrom(arguments.format));
  if (arguments.report) {
    GetReportMaker()(ran.folder, arguments.jobs);
  }
  if (!ran.failed.empty()) throw base::RunError(ran.failed);
}

}  // namespace

void SetReportMaker(ReportMaker maker) { Maker() = maker; }

ReportMaker GetReportMaker() {
  if (Maker()) return Maker();
  base::CheckBuilt("command", "report");
  throw base::InputError("--report: this program was built without reports");
}

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
