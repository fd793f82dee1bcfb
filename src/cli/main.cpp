#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "core/error.h"
#include "core/version.h"
#include "core/words.h"

namespace {

constexpr int kRunFailed = 1;
constexpr int kBadInput = 2;

// Messages go to stderr, results to stdout.
void SetUpLog() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("rangegrasp"));
  spdlog::set_pattern("%^%l%$: %v");
}

// CLI11 would only say that a command is missing.
void CheckCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    commands.push_back(command->get_name());
  }
  throw rangegrasp::core::InputError("'" + std::string(argv[1]) + "' is no command; nearest: '" +
                                     rangegrasp::core::NearestWord(argv[1], commands) +
                                     "'; --help lists them");
}

}  // namespace

int main(int argc, char** argv) {
  SetUpLog();
  // A reader that goes away (`| head`) is a failed write, which WriteResult knows.
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{"Grasping unknown objects from single-view range images, in simulation."};
  app.require_subcommand(1);
  app.set_version_flag("--version", "rangegrasp " + rangegrasp::core::Version(),
                       "version of the program (the command `version`: of its libraries, too)");
  app.footer(
      "Example: rangegrasp run experiments/laser_single.yaml\nExit codes: 0 done, 1 a run that "
      "failed, 2 bad usage or input.");
  rangegrasp::cli::AddRunCommand(app);
  rangegrasp::cli::AddBringCommand(app);
  rangegrasp::cli::AddReproduceCommand(app);
  rangegrasp::cli::AddResultsCommands(app);
  rangegrasp::cli::AddReportCommand(app);
  rangegrasp::cli::AddSlurmCommands(app);
  rangegrasp::cli::AddExportCommand(app);
  rangegrasp::cli::AddPictureCommands(app);
  rangegrasp::cli::AddAddObjectCommand(app);
  rangegrasp::cli::AddPerceiveCommand(app);
  rangegrasp::cli::AddRecognizeCommand(app);
  rangegrasp::cli::AddLearnCommand(app);
  rangegrasp::cli::AddCylindersCommand(app);
  rangegrasp::cli::AddSeamCommands(app);
  rangegrasp::cli::AddStereoCommand(app);
  rangegrasp::cli::AddCalibrateHandEyeCommand(app);
  rangegrasp::cli::AddCalibrateStereoCommand(app);
  rangegrasp::cli::AddCheckCommand(app);
  rangegrasp::cli::AddListCommand(app);
  rangegrasp::cli::AddPartsCommands(app);
  rangegrasp::cli::AddShellCommands(app);
  rangegrasp::cli::AddVersionCommand(app);
  try {
    CheckCommand(app, argc, argv);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return kBadInput;
  } catch (const rangegrasp::core::InputError& e) {
    spdlog::error(e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    spdlog::error(e.what());
    return kRunFailed;
  }
}
