#include "cli/commands.h"
#include "report/command/make_report.h"
#include "report/command/report_commands.h"
#include "report/film/recorder.h"
#include "report/film/video.h"

namespace rangegrasp {

void RegisterReport() {
  trial::SetRecorderMaker(
      [](const trial::Cell& cell, const std::string& prefix,
         const experiment::ReplayOptions& options) -> std::unique_ptr<trial::Recorder> {
        return std::make_unique<report::Recorder>(cell, prefix, options);
      });
  cli::SetFilmJoiner(report::JoinVideos);
  cli::SetReportMaker([](const std::filesystem::path& results, int jobs) {
    cli::MakeReport({.folders = {results}, .out = results / "report", .jobs = jobs});
  });
  cli::AddLibrary("opencv", RANGEGRASP_OPENCV_VERSION);
  cli::AddCommand(cli::AddReportCommand);
  cli::AddCommand(cli::AddReproduceCommand);
  cli::AddCommand(cli::AddExportCommand);
}

}  // namespace rangegrasp
