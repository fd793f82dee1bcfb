#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/progress_bar.h"
#include "cli/reopen.h"
#include "experiment/experiment.h"
#include "experiment/hopeless.h"
#include "experiment/results.h"
#include "experiment/runner.h"
#include "experiment/store.h"
#include "report/command/report_commands.h"
#include "report/data_set.h"
#include "trial/grasping_task.h"

namespace rangegrasp::cli {
namespace {

using experiment::Record;
using experiment::Store;

struct ExportArguments {
  std::string folder, out;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool clouds = false;
};

void ExportRecords(const std::vector<Record>& records, const std::filesystem::path& out) {
  std::string lines;
  for (const Record& record : records) lines += experiment::ToJson(record) + "\n";
  WriteResult(lines, out / "records.jsonl");
  WriteResult(CsvOf(experiment::FlatGridOf(records)), out / "records.csv");
}

// Those cases of an experiment that a store has records of.
std::vector<experiment::Case> CasesOf(const experiment::Experiment& e,
                                      const std::vector<Record>& records) {
  std::set<std::string> ids;
  for (const Record& record : records) ids.insert(record.which.id);
  std::vector<experiment::Case> cases = e.cases;
  std::erase_if(cases, [&](const experiment::Case& c) { return !ids.contains(c.id); });
  return cases;
}

// Where a trial ends differently from its record, the program or a model is another one.
int Differing(const std::vector<Record>& records, const std::vector<Record>& exported) {
  std::map<std::string, std::string> outcomes;
  for (const Record& record : records) outcomes[record.which.id] = record.result.outcome;
  return static_cast<int>(std::count_if(
      exported.begin(), exported.end(),
      [&](const Record& record) { return outcomes[record.which.id] != record.result.outcome; }));
}

// Runs the trials again, each in a process of its own. What is done is kept in a store, until all
// is: an export that was stopped goes on.
void ExportClouds(const Store& store, const std::string& folder, const ExportArguments& arguments,
                  const std::filesystem::path& out) {
  const auto stamp = store.ReadStamp();
  const auto e = ReopenExperiment(stamp, folder);
  e.task->Hide(folder);
  e.task->Hide(out);
  const trial::Cell& cell = trial::CellOf(*e.task);
  const auto records = store.ReadAll();
  const auto cases = CasesOf(e, records);
  if (Store::Exists(out)) {
    const auto begun = Store::Open(out).ReadStamp();
    if (!begun.identity.empty()) CheckSameRun(begun, e.stamp, out.string());
  }
  Store exported = Store::Create(out);
  exported.WriteStamp(e.stamp);
  const auto missing = Missing(cases, exported);
  if (!missing.empty()) e.task->Prepare();
  RunCases(
      missing,
      [&](const experiment::Case& which) {
        return report::ExportTrial(cell, trial::SpecOf(which), out);
      },
      exported, {.jobs = arguments.jobs, .case_limit_s = e.common.case_limit_s},
      ProgressBar(static_cast<int>(cases.size() - missing.size()), static_cast<int>(cases.size())));
  const auto made = exported.ReadAll();
  WriteResult(report::AnnotationsOf(stamp, made), out / "annotations.json");
  if (const int differing = Differing(records, made); differing > 0) {
    spdlog::warn(
        "{} of {} trials ended differently from their records: was the program or a model "
        "changed since?",
        differing, records.size());
  }
  const auto crashes = experiment::CrashReasons(made);
  if (!crashes.empty()) {
    throw base::RunError(
        fmt::format("{}: trials crashed:\n  {}", out.string(), base::Join(crashes, "\n  ")));
  }
}

void Export(const ExportArguments& arguments) {
  const auto stores = experiment::StoresIn(arguments.folder);
  for (const auto& folder : stores) {
    const std::filesystem::path out = stores.size() == 1 ? std::filesystem::path(arguments.out)
                                                         : arguments.out / folder.filename();
    const Store store = Store::Open(folder);
    ExportRecords(store.ReadAll(), out);
    if (arguments.clouds) {
      if (std::filesystem::weakly_canonical(out) == std::filesystem::weakly_canonical(folder)) {
        throw base::InputError(out.string() + ": holds the run itself; --out names another folder");
      }
      ExportClouds(store, folder.string(), arguments, out);
      Store::Remove(out);
    }
    spdlog::info("{} trials in {}", store.Count(), out.string());
  }
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "export",
      "Records of a run as CSV and JSON lines; with --clouds a data set: clouds with labels, poses "
      "of the objects, all candidate grasps with the outcomes of those that were tried.");
  auto a = std::make_shared<ExportArguments>();
  command->add_option("folder", a->folder, "results folder, of several seeds, too")->required();
  command->add_option("-o,--out", a->out, "folder for records.csv, records.jsonl, ...")->required();
  command->add_flag("--clouds", a->clouds,
                    "run the trials again and write clouds/<id>.pcd and annotations.json (task: "
                    "grasping)");
  command->add_option("--jobs", a->jobs, "trials at the same time (default: the number of cores)")
      ->check(CLI::Range(1, 1024));
  command->footer(
      "Example: rangegrasp export results/laser_single -o data/laser_single --clouds\n"
      "An export that was stopped goes on when it is called again.");
  command->callback([a] { Export(*a); });
}

}  // namespace rangegrasp::cli
