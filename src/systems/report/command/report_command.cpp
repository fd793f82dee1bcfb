#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <thread>

#include "base/words.h"
#include "report/command/make_report.h"
#include "report/command/report_commands.h"

namespace rangegrasp::cli {

void AddReportCommand(CLI::App& app) {
  struct Arguments {
    std::vector<std::string> folders;
    std::string out, views = "some";
    int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  };
  auto* command = app.add_subcommand(
      "report",
      "Pages of a run that a browser opens from disk: tables, charts, failures, and trials to look "
      "at from all sides. Several runs stand beside each other, compared in pairs with the first.");
  auto a = std::make_shared<Arguments>();
  command->add_option("folders", a->folders, "results folders, of several seeds, too")->required();
  command->add_option("-o,--out", a->out, "folder of the report (default: FOLDER/report)");
  command
      ->add_option("--views", a->views,
                   "cases that can be looked at, which are run again: up to 100 that failed and 60 "
                   "others, 60 "
                   "MB at most (some), all, none (tasks: grasping, parts, seam)")
      ->check(CLI::IsMember(base::WordList<report::ViewChoice>()));
  command->add_option("--jobs", a->jobs, "trials at the same time (default: the number of cores)")
      ->check(CLI::Range(1, 1024));
  command->footer("Example: rangegrasp report results/laser_single -o report");
  command->callback([a] {
    ReportRequest request;
    request.folders = {a->folders.begin(), a->folders.end()};
    request.out =
        a->out.empty() ? request.folders.front() / "report" : std::filesystem::path(a->out);
    request.views = base::FromWord<report::ViewChoice>(a->views, "--views");
    request.jobs = a->jobs;
    MakeReport(request);
  });
}

}  // namespace rangegrasp::cli
