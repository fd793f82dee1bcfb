#include <CLI/CLI.hpp>
#include <memory>

#include "base/data_folder.h"
#include "base/version.h"
#include "base/words.h"
#include "cli/bash_completion.h"
#include "cli/commands.h"
#include "cli/man_page.h"
#include "cli/output.h"

namespace rangegrasp::cli {
namespace {

// CLI::IsMember shows its words as {a,b} in the name of the type; nothing else gives them.
std::vector<std::string> ChoicesIn(const std::string& type) {
  const auto begin = type.find('{');
  const auto end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return base::Split(type.substr(begin + 1, end - begin - 1), ',');
}

OptionHelp Describe(const CLI::Option& option) {
  OptionHelp help;
  for (const std::string& name : option.get_snames()) help.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) help.flags.push_back("--" + name);
  if (help.flags.empty()) help.name = option.get_name(/*positional=*/true);
  if (option.get_items_expected_max() > 0) help.value = option.get_type_name();
  help.choices = ChoicesIn(help.value);
  help.description = option.get_description();
  help.default_value = option.get_default_str();
  help.required = option.get_required();
  return help;
}

// What has no group is hidden.
void AddTo(CommandTree& tree, const CLI::App& command, const std::string& path) {
  CommandHelp help{path, command.get_description(), command.get_footer(), {}, {}};
  const auto is_shown = [](const auto* part) { return !part->get_group().empty(); };
  const auto commands = command.get_subcommands(is_shown);
  for (const CLI::App* below : commands) help.below.push_back(below->get_name());
  for (const CLI::Option* option : command.get_options(is_shown)) {
    help.options.push_back(Describe(*option));
  }
  tree.push_back(help);
  for (const CLI::App* below : commands) {
    AddTo(tree, *below, path.empty() ? below->get_name() : path + " " + below->get_name());
  }
}

CommandTree TreeOf(const CLI::App& program) {
  CommandTree tree;
  AddTo(tree, program, "");
  return tree;
}

}  // namespace

void AddShellCommands(CLI::App& app) {
  auto* completion = app.add_subcommand(
      "completion", "Print what a shell needs to complete this program's commands and options.");
  auto what = std::make_shared<std::string>();
  completion
      ->add_option("what", *what,
                   "a script for bash (zsh reads it after bashcompinit), or the names of the "
                   "installed experiments")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>{"bash", "experiments"}));
  completion->footer(
      "Example: rangegrasp completion bash > rangegrasp.bash; source rangegrasp.bash");
  completion->callback([&app, what] {
    WriteResult(*what == "bash"
                    ? BashCompletion(TreeOf(app))
                    : base::Join(base::ExperimentNames(base::DataFolder()), "\n") + "\n");
  });

  // For the installation; nobody calls it by hand.
  auto* man = app.add_subcommand("man", "Print the manual page.")->group("");
  man->callback([&app] { WriteResult(ManPage(TreeOf(app), base::Version())); });
}

}  // namespace rangegrasp::cli
