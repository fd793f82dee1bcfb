#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/systems.h"
#include "base/version.h"
#include "base/words.h"
#include "cli/commands.h"

namespace rangegrasp::cli {
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
  base::CheckBuilt("command", argv[1]);
  throw base::InputError("unknown command '" + std::string(argv[1]) + "'; did you mean '" +
                         base::NearestWord(argv[1], commands) + "'? --help lists all");
}

// scripts/rangegrasp, where it started the program, builds the system and starts the program again
// with the same arguments, in the place of this one.
int BuildOrEnd(const base::NotBuilt& missing, char** argv) {
  if (const char* builder = std::getenv("RANGEGRASP_BUILDER")) {
    setenv("RANGEGRASP_MISSING_SYSTEM", missing.system().c_str(), /*overwrite=*/1);
    execv(builder, argv);
  }
  spdlog::error(missing.what());
  return kBadInput;
}

std::vector<CommandAdder>& Adders() {
  static std::vector<CommandAdder> adders;
  return adders;
}

}  // namespace

void AddCommand(CommandAdder adder) { Adders().push_back(adder); }
const std::vector<CommandAdder>& AddedCommands() { return Adders(); }

int RunProgram(int argc, char** argv) {
  SetUpLog();
  // A reader that goes away (`| head`) is a failed write, which WriteResult knows.
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{"Grasping unknown objects from single-view range images, in simulation."};
  app.require_subcommand(1);
  app.set_version_flag("--version", "rangegrasp " + base::Version(),
                       "version of the program (the command `version`: of its libraries, too)");
  app.footer(
      "Example: rangegrasp run experiments/laser_single.yaml\nExit codes: 0 done, 1 a run that "
      "failed, 2 bad usage or input.");
  AddRunCommand(app);
  AddResultsCommands(app);
  AddSlurmCommands(app);
  AddListCommand(app);
  for (const CommandAdder add : AddedCommands()) add(app);
  AddShellCommands(app);
  AddVersionCommand(app);
  try {
    CheckCommand(app, argc, argv);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return kBadInput;
  } catch (const base::NotBuilt& e) {
    return BuildOrEnd(e, argv);
  } catch (const base::InputError& e) {
    spdlog::error(e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    spdlog::error(e.what());
    return kRunFailed;
  }
}

}  // namespace rangegrasp::cli
