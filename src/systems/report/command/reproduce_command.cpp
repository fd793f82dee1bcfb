#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/installation.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/reproduction.h"
#include "report/command/report_commands.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;

// The cases to run, of one experiment or of several together.
struct PlannedCases {
  int all = 0;          // finished or not
  int stored = 0;       // finished by an earlier run
  double left_s = 0.0;  // estimated time of the remaining ones
};

// Weight of the plan: as if this much of it had come true before anything was measured [s].
constexpr double kTrust_s = 20.0;

// Progress of several runs: on a terminal a line with the remaining time of all, otherwise a
// message at the start of each run.
class ReproduceProgress {
 public:
  explicit ReproduceProgress(const PlannedCases& all) : all_(all) {}

  // Starts a run.
  // @param name  e.g. "table 5.2"
  void Begin(const std::string& name, const PlannedCases& run) {
    name_ = name;
    run_ = run;
    done_ = 0;
    if (isatty(STDERR_FILENO)) return;
    spdlog::info("{}: {}, {} of them done; {} of {} are in earlier tables, about {} left", name_,
                 base::Counted(run_.all, "case"), run_.stored, before_, all_.all, LeftText());
  }
  void OneDone() {
    ++done_;
    const double planned_s = run_.left_s / (run_.all - run_.stored);
    all_.left_s -= planned_s;
    spent_s_ += planned_s;
    if (!isatty(STDERR_FILENO)) return;
    fmt::print(stderr, "\r{}: {} of {} cases; {} of {} in all, about {} left\033[K", name_,
               run_.stored + done_, run_.all, before_ + run_.stored + done_, all_.all, LeftText());
    std::fflush(stderr);
  }
  // Ends a run, whether or not all of its cases were run.
  void End() {
    const int open = run_.all - run_.stored;
    if (open > 0) all_.left_s -= run_.left_s * (open - done_) / open;
    before_ += run_.all;
    if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K");
  }

 private:
  std::string LeftText() const {
    const double left_s = all_.left_s * (watch_.Seconds() + kTrust_s) / (spent_s_ + kTrust_s);
    return left_s < 90.0 ? fmt::format("{:.0f} s", left_s)
                         : fmt::format("{:.0f} min", left_s / 60.0);
  }

  PlannedCases all_;
  PlannedCases run_;
  std::string name_;
  base::Stopwatch watch_;
  int done_ = 0;          // finished cases of this run, without the stored ones
  int before_ = 0;        // cases of earlier runs
  double spent_s_ = 0.0;  // planned time of the finished cases
};

using experiment::PublishedTable;
using experiment::ReproducedTable;
using experiment::Reproduction;
using experiment::Store;

struct ReproduceArguments {
  std::vector<std::string> tables;
  std::string out, seeds, parts_data, format = "markdown";
  int jobs = 1;
  bool is_short = false;

  fs::path Folder() const {
    if (!out.empty()) return out;
    return fs::path("results") / (is_short ? "reproduced_short" : "reproduced");
  }
};

// The tables, each experiment only once.
std::vector<PublishedTable> RunsOf(const std::vector<PublishedTable>& tables) {
  std::vector<PublishedTable> runs;
  for (const PublishedTable& table : tables) {
    const auto same = std::ranges::find(runs, table.experiment, &PublishedTable::experiment);
    if (same == runs.end()) runs.push_back(table);
  }
  return runs;
}

// Names the tables that an experiment produces, e.g. "table 3.3, 3.5".
std::string NameOf(const PublishedTable& run, const std::vector<PublishedTable>& tables) {
  std::vector<std::string> numbers;
  for (const PublishedTable& table : tables) {
    if (table.experiment == run.experiment) numbers.push_back(table.number);
  }
  return "table " + base::Join(numbers);
}

int JobsOf(const PublishedTable& run, int jobs) { return run.is_of_times ? 1 : jobs; }

// The experiment's own message names a key that this command does not have.
void CheckBenchmark(const fs::path& folder) {
  for (const char* part : {"off", "seg"}) {
    std::error_code error;
    if (fs::is_directory(folder / part, error)) continue;
    throw base::InputError(fmt::format(
        "--psb: '{}' has no folder '{}'; the benchmark's files are off/ID.off and seg/ID/ID_K.seg",
        folder.string(), part));
  }
}

// @throws base::InputError naming --psb if the benchmark is not there
experiment::Changes ChangesOf(const PublishedTable& run, const ReproduceArguments& arguments) {
  experiment::Changes changes;
  if (!run.group.empty()) changes.groups = {run.group};
  if (arguments.is_short) changes.trials = run.short_trials;
  if (!arguments.parts_data.empty() && run.experiment == "parts_psb") {
    const auto folder = fs::absolute(arguments.parts_data).lexically_normal();
    CheckBenchmark(folder);
    changes.set.push_back("data=" + nlohmann::json(folder.string()).dump());  // which is YAML
  }
  return changes;
}

// Reads the results of an experiment from its folder, if there are any.
void ReadInto(const fs::path& folder, const PublishedTable& from, bool is_short,
              ReproducedTable& table) {
  const auto stores = experiment::StoresIn(folder);
  if (!Store::Exists(stores.front())) return;
  const auto results = experiment::ReadResults(folder);
  if (results.records.empty()) return;
  table.done = static_cast<int>(results.records.size());
  table.seeds = experiment::InFolder(
      folder, [&] { return experiment::Need(results.stamp.identity, "seed"); });
  table.crashed =
      static_cast<int>(std::ranges::count_if(results.records, [](const experiment::Record& record) {
        return record.result.outcome == experiment::kCrashed ||
               record.result.outcome == experiment::kTimedOut;
      }));
  std::vector<experiment::PublishedFigure> figures;
  for (auto& figure : experiment::ReportOf(results).published) {
    if (figure.key == from.key) figures.push_back(std::move(figure));
  }
  table.judged = is_short ? experiment::NotJudged(figures)
                          : experiment::Judge(figures, table.done >= table.cases);
}

/// Runs tables into a folder and keeps the page there up to date.
class Reproducer {
 public:
  explicit Reproducer(ReproduceArguments arguments)
      : arguments_(std::move(arguments)),
        seeds_(SeedsFrom(arguments_.seeds)),
        tables_(experiment::ChosenTables(arguments_.tables)) {}

  void RunAll() {
    const auto runs = RunsOf(tables_);
    PlannedCases all;
    for (const PublishedTable& run : runs) {
      const PlannedCases planned = PlanOf(run);
      all.all += planned.all;
      all.stored += planned.stored;
      all.left_s += planned.left_s;
    }
    ReproduceProgress progress(all);
    for (const PublishedTable& run : runs) {
      progress.Begin(NameOf(run, tables_), PlanOf(run));
      RunOne(run, progress);
      progress.End();
      WritePage();
    }
  }

  // Reports an error if none of the requested tables can be run.
  void CheckThatSomeWereRun() const {
    const auto all = Read(tables_);
    if (std::ranges::any_of(all.tables, [](const auto& table) { return table.left_out.empty(); })) {
      return;
    }
    throw base::InputError("none of these tables can be run: " + all.tables.front().left_out);
  }

  experiment::Report Page() const { return experiment::PageOf(Read(Shown())); }
  experiment::Stamp Stamp() const {
    return {{{"experiment", "reproduce"}},
            {{"version", base::Version()}, {"commit", base::Commit()}},
            {}};
  }
  const std::vector<std::string>& failed() const { return failed_; }

 private:
  fs::path FolderOf(const PublishedTable& table) const {
    return arguments_.Folder() / table.experiment;
  }
  std::vector<std::uint64_t> SeedsOf(const PublishedTable& run) const {
    return run.is_drawn ? seeds_ : std::vector<std::uint64_t>();
  }
  bool IsAsked(const PublishedTable& table) const {
    return std::ranges::find(tables_, table.number, &PublishedTable::number) != tables_.end();
  }
  // The runs of one seed each: those asked for, or those that the folder holds already.
  int CasesOf(const PublishedTable& run) const {
    const std::size_t runs =
        IsAsked(run) ? SeedsOf(run).size() : experiment::StoresIn(FolderOf(run)).size();
    return run.Cases(arguments_.is_short) * static_cast<int>(std::max<std::size_t>(1, runs));
  }
  // Whether an earlier command ran the table into the same folder, short as this one or not.
  bool WasRun(const PublishedTable& table) const {
    const auto folder = experiment::StoresIn(FolderOf(table)).front();
    if (!Store::Exists(folder)) return false;
    const auto stamp = Store::Open(folder).ReadStamp();
    const auto cases = stamp.identity.find("cases");
    return cases != stamp.identity.end() &&
           cases->second == std::to_string(table.Cases(arguments_.is_short));
  }
  // The page shows all tables of the folder, as several commands may have filled it.
  std::vector<PublishedTable> Shown() const {
    std::vector<PublishedTable> shown;
    std::ranges::copy_if(
        experiment::PublishedTables(), std::back_inserter(shown),
        [&](const PublishedTable& table) { return IsAsked(table) || WasRun(table); });
    return shown;
  }
  PlannedCases PlanOf(const PublishedTable& run) const {
    PlannedCases planned{.all = CasesOf(run)};
    for (const auto& folder : experiment::StoresIn(FolderOf(run))) {
      if (Store::Exists(folder)) planned.stored += Store::Open(folder).Count();
    }
    planned.stored = std::min(planned.stored, planned.all);
    planned.left_s = (planned.all - planned.stored) * run.case_s / JobsOf(run, arguments_.jobs);
    return planned;
  }

  void RunOne(const PublishedTable& run, ReproduceProgress& progress) {
    const RunIntoOptions options{
        .jobs = JobsOf(run, arguments_.jobs), .resume = true, .progress = [&](int, int) {
          return [&](int, int, const experiment::Record&) { progress.OneDone(); };
        }};
    try {
      const auto file = base::FindExperiment(run.experiment);
      const auto changes = ChangesOf(run, arguments_);
      const Ran ran = RunExperiment(file, changes, SeedsOf(run), FolderOf(run), options);
      if (!ran.failed.empty()) failed_.push_back(NameOf(run, tables_) + ": " + ran.failed);
    } catch (const base::NotBuilt&) {
      throw;  // the user may build it; finished cases are kept
    } catch (const base::InputError& error) {
      left_out_[run.experiment] = error.what();
      spdlog::warn("{} is left out: {}", NameOf(run, tables_), error.what());
    }
  }

  Reproduction Read(const std::vector<PublishedTable>& tables) const {
    Reproduction all{arguments_.is_short, {}, Stamp()};
    for (const PublishedTable& table : tables) {
      ReproducedTable one{.number = table.number,
                          .title = table.title,
                          .experiment = table.experiment,
                          .cases = CasesOf(table)};
      const auto left_out = left_out_.find(table.experiment);
      if (left_out != left_out_.end()) {
        one.left_out = left_out->second;
      } else {
        ReadInto(FolderOf(table), table, arguments_.is_short, one);
      }
      all.tables.push_back(std::move(one));
    }
    return all;
  }

  void WritePage() const {
    const auto page = Page();
    const auto write = [&](const char* name, experiment::TableFormat format) {
      WriteResult(experiment::Format(page, Stamp(), format), arguments_.Folder() / name);
    };
    write("reproduced.md", experiment::TableFormat::kMarkdown);
    write("reproduced.csv", experiment::TableFormat::kCsv);
    write("reproduced.json", experiment::TableFormat::kJson);
  }

  ReproduceArguments arguments_;
  std::vector<std::uint64_t> seeds_;
  std::vector<PublishedTable> tables_;
  std::map<std::string, std::string> left_out_;  // experiment -> reason
  std::vector<std::string> failed_;
};

void Reproduce(const ReproduceArguments& arguments) {
  Reproducer reproducer(arguments);
  reproducer.RunAll();
  reproducer.CheckThatSomeWereRun();
  WriteTables(reproducer.Page(), reproducer.Stamp(), TableFormatFrom(arguments.format));
  spdlog::info("the page is {}", (arguments.Folder() / "reproduced.md").string());
  if (!reproducer.failed().empty()) throw base::RunError(base::Join(reproducer.failed(), "\n"));
}

}  // namespace

void AddReproduceCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "reproduce",
      "Run the experiments of the published tables and write one page: published and reproduced "
      "figures, with a verdict for each. Repeat the command to continue a stopped run.");
  auto a = std::make_shared<ReproduceArguments>();
  command->add_option(
      "tables", a->tables,
      "tables, e.g. 5.2 3.3, or a chapter; default: all (`rangegrasp list tables`)");
  command->add_flag("--short", a->is_short,
                    "about a tenth of the trials, takes minutes: shows only that everything runs, "
                    "gives no verdicts");
  command->add_option("-o,--out", a->out,
                      "output folder (default: results/reproduced, or results/reproduced_short)");
  AddJobsOption(*command, "cases", a->jobs);
  command->add_option(
      "--seeds", a->seeds,
      "seeds instead of each experiment's own, e.g. 1,2,3; each seed runs all trials");
  command->add_option("--psb", a->parts_data,
                      "folder of the Princeton Segmentation Benchmark, for table 6.1");
  AddFormatOption(*command, a->format);
  command->footer("Example: rangegrasp reproduce --short 5.2 5.3");
  command->callback([a] { Reproduce(*a); });
}

}  // namespace rangegrasp::cli
