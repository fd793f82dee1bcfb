#include "report/command/report_commands.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <set>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/runner.h"
#include "experiment/statistics.h"
#include "experiment/view.h"
#include "report/film/internal/recorder.h"
#include "report/internal/page.h"
#include "report/internal/view_file.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using experiment::Case;
using experiment::Record;
using experiment::Result;

struct ReportRequest {
  std::vector<std::string> folders;  // results folders, also of several seeds
  std::string out;                   // empty: `report` in the first one
  std::string views = "some";
  int jobs = 1;
  bool run_detector = false;

  fs::path Out() const {
    return out.empty() ? fs::path(folders.front()) / "report" : fs::path(out);
  }
};

// A case that has a view, and its number in the report.
struct Shown {
  Record record;
  std::size_t number = 0;
};

std::vector<report::Run> ReadRuns(const ReportRequest& request) {
  std::vector<report::Run> runs;
  for (const auto& folder : request.folders) {
    report::Run& run = runs.emplace_back();
    run.results = experiment::ReadResults(folder);
    run.tables = experiment::ReportOf(run.results);
    run.kind = &experiment::KindOf(run.results.stamp);
    run.name = fs::weakly_canonical(folder).filename().string();
    for (const auto& store : experiment::StoresIn(folder)) {
      const int count = experiment::Store::Open(store).Count();
      run.stores.emplace_back(store, static_cast<std::size_t>(count));
    }
    if (run.kind == runs.front().kind) continue;
    throw base::InputError(folder + ": has another task than " + request.folders.front() + " (" +
                           runs.front().kind->name + ")");
  }
  return runs;
}

// A store whose cases are run again for their views.
struct Replayed {
  fs::path store;
  experiment::Experiment experiment;  // reopened
  std::vector<Shown> shown;
};

// @return numbers of the cases that now have a view
std::set<std::size_t> WriteViews(const Replayed& of, const fs::path& out, int jobs) {
  const experiment::Experiment& e = of.experiment;
  for (const auto& hidden : {of.store, out}) e.task->Hide(hidden);
  e.task->Prepare();
  std::map<std::string, const Shown*> by_id;
  std::vector<Case> cases;
  for (const Shown& one : of.shown) {
    by_id[one.record.which.id] = &one;
    cases.push_back(CaseOf(e, one.record.which.id));
  }
  const auto run = [&](const Case& which) {
    experiment::View view;
    experiment::ReplayOptions options;
    options.view = &view;
    Result result = e.task->Replay(which, options);
    if (!view.Empty()) report::WriteView(view, out, by_id.at(which.id)->number);
    return result;
  };
  std::set<std::size_t> made;
  int differing = 0;
  std::vector<Record> crashed;  // cases that crashed only when run again
  ProgressBar bar(0, static_cast<int>(cases.size()));
  experiment::RunCases(cases, run, {.jobs = jobs, .case_limit_s = e.common.case_limit_s},
                       [&](int done, int total, const Record& replayed) {
                         bar(done, total, replayed);
                         const Shown& stored = *by_id.at(replayed.which.id);
                         if (replayed.result.outcome == experiment::kCrashed &&
                             stored.record.result.outcome != experiment::kCrashed) {
                           crashed.push_back(replayed);
                         } else {
                           differing += SameButTimes(stored.record, replayed) ? 0 : 1;
                         }
                         const auto file = out / "views" / (std::to_string(stored.number) + ".js");
                         if (fs::exists(file)) made.insert(stored.number);
                       });
  if (!crashed.empty()) {
    spdlog::warn("{}: {} of {} cases could not be run again:\n  {}", of.store.string(),
                 crashed.size(), cases.size(),
                 base::Join(experiment::CrashReasons(crashed), "\n  "));
  }
  if (differing > 0) {
    spdlog::warn(
        "{}: {} of {} cases differ from their records when they are run again: has the program or "
        "a model changed since?",
        of.store.string(), differing, cases.size());
  }
  return made;
}

// Positions of the cases that get a view, by run; also both cases of a pair that differs.
std::vector<std::set<std::size_t>> ChosenOf(const std::vector<report::Run>& runs,
                                            report::ViewChoice choice) {
  std::vector<std::set<std::size_t>> chosen;
  const std::string first_success = runs.front().Success();
  for (const report::Run& run : runs) {
    const auto& records = run.results.records;
    const std::string success = run.Success();
    const auto of_run = report::ChooseViews(records, success, choice);
    chosen.emplace_back(of_run.begin(), of_run.end());
    if (choice == report::ViewChoice::kNone || success.empty() || success != first_success)
      continue;
    auto differing = experiment::Differing(runs.front().results.records, records, success);
    if (choice == report::ViewChoice::kSome && differing.size() > report::kFailuresShown) {
      differing.resize(report::kFailuresShown);
    }
    for (const auto& [a, b] : differing) {
      chosen.front().insert(a);
      chosen.back().insert(b);
    }
  }
  return chosen;
}

// Adds the stores of a run that contain chosen cases, with their experiments reopened.
// @param first  number of the run's first case
// @throws base::InputError if results name a program that may not be started.
void AddReplayed(const report::Run& run, const std::set<std::size_t>& chosen, std::size_t first,
                 bool run_detector, std::vector<Replayed>& replayed) {
  if (!run.kind->has_views) return;
  auto next = chosen.begin();
  std::size_t begin = 0;  // position of a store's first record in the run
  for (const auto& [folder, count] : run.stores) {
    const std::size_t end = begin + count;
    std::vector<Shown> shown;
    for (; next != chosen.end() && *next < end; ++next) {
      shown.push_back({run.results.records[*next], first + *next});
    }
    begin = end;
    if (shown.empty()) continue;
    const auto stamp = experiment::Store::Open(folder).ReadStamp();
    replayed.push_back(
        {folder, ReopenExperiment(stamp, folder.string(), run_detector), std::move(shown)});
  }
}

std::uintmax_t SizeOf(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

// Removes views until the report is within its maximum size.
std::set<std::size_t> Cut(const std::set<std::size_t>& views, const fs::path& out) {
  const auto files = [&](std::size_t number) {
    const auto base = (out / "views" / std::to_string(number)).string();
    return std::array{fs::path(base + ".js"), fs::path(base + ".png")};
  };
  std::vector<std::size_t> numbers(views.begin(), views.end());
  std::vector<std::uintmax_t> sizes;
  for (const std::size_t number : numbers) {
    auto& size = sizes.emplace_back(0);
    for (const auto& file : files(number)) size += fs::file_size(file);
  }
  const auto all = std::accumulate(sizes.begin(), sizes.end(), std::uintmax_t{0});
  const auto rest = std::min(report::kMaxReport_bytes, SizeOf(out) - all);
  std::set<std::size_t> kept;
  for (const std::size_t i : report::Fitting(sizes, report::kMaxReport_bytes - rest)) {
    kept.insert(numbers[i]);
  }
  for (const std::size_t number : numbers) {
    if (kept.contains(number)) continue;
    for (const auto& file : files(number)) fs::remove(file);
  }
  return kept;
}

// Message of the page and the program about cases without a view; empty if every failure has one.
std::string NoteOf(const std::vector<report::Run>& runs, const std::set<std::size_t>& views) {
  std::size_t number = 0, failed = 0, shown = 0;
  for (const report::Run& run : runs) {
    const std::string success = run.Success();
    for (const Record& record : run.results.records) {
      const bool counts = success.empty() || record.result.outcome != success;
      failed += counts ? 1 : 0;
      shown += counts && views.contains(number) ? 1 : 0;
      ++number;
    }
  }
  if (shown == failed) return "";
  return fmt::format("{} of {} cases{} have a 3-D view; --views all makes a view of every case.",
                     shown, failed, runs.front().Success().empty() ? "" : " that failed");
}

// Writes a report of results folders. Cases that get a view are run again; warns of those that end
// differently from their records.
// @throws base::InputError also if the folders are of different kinds of experiments.
void MakeReport(const ReportRequest& request) {
  const base::Stopwatch watch;
  const auto choice = base::FromWord<report::ViewChoice>(request.views, "--views");
  const fs::path out = request.Out();
  const auto runs = ReadRuns(request);
  const auto chosen = ChosenOf(runs, choice);
  std::vector<Replayed> replayed;
  std::size_t first = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    AddReplayed(runs[i], chosen[i], first, request.run_detector, replayed);
    first += runs[i].results.records.size();
  }
  const experiment::FolderLock lock(out);
  report::PrepareFolder(out);  // clears an earlier report, so not before it may be refused
  std::set<std::size_t> views;
  for (const Replayed& one : replayed) views.merge(WriteViews(one, out, request.jobs));
  report::WritePage(out);
  report::WriteData(runs, views, "", out);  // to measure its size
  const bool is_limited = choice == report::ViewChoice::kSome;
  if (is_limited) views = Cut(views, out);
  const std::string note = is_limited && runs.front().kind->has_views ? NoteOf(runs, views) : "";
  report::WriteData(runs, views, note, out);
  if (!note.empty()) spdlog::info(note);
  spdlog::info("{}, {} with a 3-D view, in {:.1f} s: open {}", base::Counted(first, "case"),
               views.size(), watch.Seconds(), (out / "index.html").string());
}

void AddReportCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "report",
      "Write a report of a run for the browser: tables, charts, failures, and trials with a 3-D "
      "view. Several runs are shown side by side, each compared with the first.");
  auto a = std::make_shared<ReportRequest>();
  command->add_option("folders", a->folders, "results folders, of one or of several seeds")
      ->required();
  command->add_option("-o,--out", a->out, "output folder (default: FOLDER/report)");
  command
      ->add_option("--views", a->views,
                   "cases with a 3-D view, which are run again: some (up to 100 failed and 60 "
                   "other cases, at most 60 MB), all or none (tasks: grasping, parts, seam)")
      ->check(CLI::IsMember(base::WordList<report::ViewChoice>()));
  AddRunDetectorOption(*command, a->run_detector);
  AddJobsOption(*command, "trials", a->jobs);
  command->footer("Example: rangegrasp report results/laser_single -o report");
  command->callback([a] { MakeReport(*a); });
}

}  // namespace
}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterReport() {
  trial::PictureMaker() = report::MakeRecorder;
  cli::MakeReportFor() = [](const std::filesystem::path& results, int jobs, bool run_detector) {
    cli::MakeReport(
        {.folders = {results.string()}, .out = "", .jobs = jobs, .run_detector = run_detector});
  };
  cli::AddLibrary("opencv", RANGEGRASP_OPENCV_VERSION);
  cli::AddCommand(cli::AddReportCommand);
  cli::AddCommand(cli::AddReproduceCommand);
  cli::AddCommand(cli::AddExportCommand);
}

}  // namespace rangegrasp
