#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "core/version.h"
#include "libraries.h"
#include "sim/info.h"

namespace rangegrasp::cli {

void AddVersionCommand(CLI::App& app) {
  auto* command = app.add_subcommand("version", "Versions of the program and of its libraries.");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON");
  command->footer("Example: rangegrasp version --json");
  command->callback([json] {
    nlohmann::ordered_json versions = {{"rangegrasp", core::Version()},
                                       {"commit", core::Commit()},
                                       {"mujoco", sim::EngineVersion()}};
    for (const auto& [name, version] : kLibraries) versions[name] = version;
    std::string text;
    for (const auto& [name, version] : versions.items()) {
      text += name + " " + version.get<std::string>() + "\n";
    }
    WriteResult(*json ? versions.dump(2) + "\n" : text);
  });
}

}  // namespace rangegrasp::cli
