#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "tasks/grasping/options.h"
#include "tasks/kinds.h"

namespace rangegrasp::cli {
namespace {

constexpr const char* kKeysPage = R"(# Experiment files

An experiment file is YAML: `key: value` lines, with keys below keys where a table says so (`physics.timestep_ms` is
`timestep_ms` below `physics`). What is not given keeps its default. The unit stands in the key's name. Paths are relative
to the file. An unknown key, a value of the wrong type or out of its range, or a file that is missing is told with its line
and the nearest valid word. `rangegrasp run FILE --set KEY=VALUE` changes any key without a change to the file.

This page is made by `rangegrasp list keys` from the code that reads the files; a test compares them.

)";

std::string Kinds() {
  std::string text;
  for (const auto& kind : tasks::AllKinds()) {
    text += fmt::format("{:<10} {}\n", kind.name, kind.description);
  }
  return text;
}

std::string Additions() {
  std::string text;
  for (const auto& key : tasks::grasping::AdditionKeys()) {
    text += fmt::format("{:<33} {}\n", key.path, key.doc);
  }
  return text;
}

}  // namespace

void AddListCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "list", "What there is: kinds of experiments, their keys, what the method adds.");
  auto what = std::make_shared<std::string>("kinds");
  command
      ->add_option("what", *what,
                   "kinds, or keys: the page docs/experiment-file.md, or additions: keys of "
                   "grasping experiments that go beyond the dissertation (kinds)")
      ->check(CLI::IsMember({"kinds", "keys", "additions"}));
  command->footer("Example: rangegrasp list keys");
  command->callback([what] {
    if (*what == "keys") {
      WriteResult(kKeysPage + experiment::KeysAsMarkdown(tasks::AllKinds()));
    } else {
      WriteResult(*what == "additions" ? Additions() : Kinds());
    }
  });
}

}  // namespace rangegrasp::cli
