#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "cli/commands.h"
#include "cli/output.h"

namespace rangegrasp::cli {
namespace {

std::vector<std::pair<std::string, std::string>>& Libraries() {
  static std::vector<std::pair<std::string, std::string>> libraries;
  return libraries;
}

}  // namespace

void AddLibrary(const std::string& name, const std::string& version) {
  for (const auto& [known, of_it] : Libraries()) {
    if (known == name) return;  // of two systems that use it
  }
  Libraries().emplace_back(name, version);
}

void AddVersionCommand(CLI::App& app) {
  auto* command = app.add_subcommand("version", "Versions of the program and of its libraries.");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON");
  command->footer("Example: rangegrasp version --json");
  command->callback([json] {
    nlohmann::ordered_json versions = {{"rangegrasp", base::Version()}, {"commit", base::Commit()}};
    for (const auto& [name, version] : Libraries()) versions[name] = version;
    std::string text;
    for (const auto& [name, version] : versions.items()) {
      text += name + " " + version.get<std::string>() + "\n";
    }
    WriteResult(*json ? versions.dump(2) + "\n" : text);
  });
}

}  // namespace rangegrasp::cli
