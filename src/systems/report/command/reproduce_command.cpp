#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/installation.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/reproduction.h"
#include "report/command/report_commands.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;

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

  void Run() {
    const fs::path page = arguments_.Folder() / "reproduced.md";
    for (const PublishedTable& run : tables_) {
      // Tables of one experiment share its run.
      if (&*std::ranges::find(tables_, run.experiment, &PublishedTable::experiment) != &run) {
        continue;
      }
      spdlog::info("{}: {}, {} of them done", NameOf(run), base::Counted(CasesOf(run), "case"),
                   StoredOf(run));
      RunOne(run);
      WriteResult(experiment::Format(Page(), stamp_, experiment::TableFormat::kMarkdown), page);
    }
    const auto all = Read(tables_).tables;
    if (std::ranges::none_of(all, [](const auto& table) { return table.left_out.empty(); })) {
      throw base::InputError("none of these tables can be run: " + all.front().left_out);
    }
    WriteTables(Page(), stamp_, TableFormatFrom(arguments_.format));
    spdlog::info("the page is {}", page.string());
    if (!failed_.empty()) throw base::RunError(base::Join(failed_, "\n"));
  }

 private:
  experiment::Report Page() const { return experiment::PageOf(Read(Shown())); }
  // Names the tables that an experiment produces, e.g. "table 3.3, 3.5".
  std::string NameOf(const PublishedTable& run) const {
    std::vector<std::string> numbers;
    for (const PublishedTable& table : tables_) {
      if (table.experiment == run.experiment) numbers.push_back(table.number);
    }
    return "table " + base::Join(numbers);
  }
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
    return Store::Exists(folder) &&
           experiment::ValueOr(Store::Open(folder).ReadStamp().identity, "cases", "") ==
               std::to_string(table.Cases(arguments_.is_short));
  }
  // The page shows all tables of the folder, as several commands may have filled it.
  std::vector<PublishedTable> Shown() const {
    std::vector<PublishedTable> shown;
    std::ranges::copy_if(
        experiment::PublishedTables(), std::back_inserter(shown),
        [&](const PublishedTable& table) { return IsAsked(table) || WasRun(table); });
    return shown;
  }
  // The number of cases that an earlier command finished.
  int StoredOf(const PublishedTable& run) const {
    int stored = 0;
    for (const auto& folder : experiment::StoresIn(FolderOf(run))) {
      if (Store::Exists(folder)) stored += Store::Open(folder).Count();
    }
    return stored;
  }

  void RunOne(const PublishedTable& run) {
    const RunIntoOptions options{.jobs = run.is_of_times ? 1 : arguments_.jobs, .resume = true};
    try {
      const auto file = base::FindExperiment(run.experiment);
      const auto changes = ChangesOf(run, arguments_);
      const Ran ran = RunExperiment(file, changes, SeedsOf(run), FolderOf(run), options);
      if (!ran.failed.empty()) failed_.push_back(NameOf(run) + ": " + ran.failed);
    } catch (const base::NotBuilt&) {
      throw;  // the user may build it; finished cases are kept
    } catch (const base::InputError& error) {
      left_out_[run.experiment] = error.what();
      spdlog::warn("{} is left out: {}", NameOf(run), error.what());
    }
  }

  Reproduction Read(const std::vector<PublishedTable>& tables) const {
    Reproduction all{arguments_.is_short, {}};
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

  const experiment::Stamp stamp_ = {{{"experiment", "reproduce"}},
                                    {{"version", base::Version()}, {"commit", base::Commit()}},
                                    {}};
  ReproduceArguments arguments_;
  std::vector<std::uint64_t> seeds_;
  std::vector<PublishedTable> tables_;
  std::map<std::string, std::string> left_out_;  // experiment -> reason
  std::vector<std::string> failed_;
};

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
  command->callback([a] { Reproducer(*a).Run(); });
}

}  // namespace rangegrasp::cli
