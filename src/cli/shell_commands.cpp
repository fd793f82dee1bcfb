#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <memory>

#include "base/installation.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"

namespace rangegrasp::cli {
namespace {

// A command that --help shows, and its words, e.g. "seam track"; no words for the program itself.
struct Command {
  std::string path;
  const CLI::App* app;
};

// Commands and options without a group are hidden.
constexpr auto kIsShown = [](const auto* part) { return !part->get_group().empty(); };

// A command and those below it: parents first, in the order of --help.
std::vector<Command> CommandsOf(const CLI::App& app, const std::string& path = "") {
  std::vector<Command> commands = {{path, &app}};
  for (const CLI::App* below : app.get_subcommands(kIsShown)) {
    const std::string name = path.empty() ? below->get_name() : path + " " + below->get_name();
    std::ranges::move(CommandsOf(*below, name), std::back_inserter(commands));
  }
  return commands;
}

// The flags of an option: "-o", "--out"; empty for a positional argument.
std::vector<std::string> FlagsOf(const CLI::Option& option) {
  std::vector<std::string> flags;
  for (const std::string& name : option.get_snames()) flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) flags.push_back("--" + name);
  return flags;
}

// The placeholder after an option, e.g. "TEXT"; empty for a flag.
std::string ValueOf(const CLI::Option& option) {
  return option.get_items_expected_max() > 0 ? option.get_type_name() : "";
}

// All values that an option accepts; empty if it also accepts others. CLI::IsMember shows its words
// as {a,b} in the name of the type, which is the only way to get them.
std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  const std::string type = ValueOf(option);
  const auto begin = type.find('{');
  const auto end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return base::Split(type.substr(begin + 1, end - begin - 1), ',');
}

// Finds the command among the words before the cursor, then the possible words at the cursor:
// choices of the option before it, or options, commands and names of experiments. If there are
// none, bash completes files. bash splits --format=csv into three words at the =.
constexpr const char* kScript =
    R"(# bash completion of rangegrasp; made by `rangegrasp completion bash`
_rangegrasp() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command="" i
  if [[ $cur == = ]]; then
    cur=""
  elif [[ $prev == = ]]; then
    prev=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "${{command:+$command }}${{COMP_WORDS[i]}}" in
      {commands}) command="${{command:+$command }}${{COMP_WORDS[i]}}" ;;
    esac
  done
  COMPREPLY=()
  case "$command $prev" in
{values}  esac
  local words=""
  case "$command" in
{words}  esac
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
}}
complete -o default -F _rangegrasp rangegrasp
)";

// Completions after an option with a value: its choices, or files.
std::string ValueCases(const Command& command) {
  std::string cases;
  for (const CLI::Option* option : command.app->get_options(kIsShown)) {
    std::vector<std::string> patterns;
    for (const std::string& flag : FlagsOf(*option)) {
      patterns.push_back(fmt::format("\"{} {}\"", command.path, flag));
    }
    if (patterns.empty() || ValueOf(*option).empty()) continue;
    const auto choices = ChoicesOf(*option);
    const std::string reply = choices.empty()
                                  ? ""
                                  : fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")); ",
                                                base::Join(choices, " "));
    cases += fmt::format("    {}) {}return ;;\n", base::Join(patterns, "|"), reply);
  }
  return cases;
}

// Completions: options after a dash; else commands, choices of arguments, names of experiments.
std::string WordCase(const Command& command) {
  std::vector<std::string> all_flags;
  std::vector<std::string> words;
  for (const CLI::App* below : command.app->get_subcommands(kIsShown)) {
    words.push_back(below->get_name());
  }
  for (const CLI::Option* option : command.app->get_options(kIsShown)) {
    const auto flags = FlagsOf(*option);
    std::ranges::copy(flags, std::back_inserter(all_flags));
    if (!flags.empty()) continue;
    std::ranges::copy(ChoicesOf(*option), std::back_inserter(words));
    if (option->get_name(/*positional=*/true) == "experiment") {
      words.push_back("$(\"${COMP_WORDS[0]}\" completion experiments 2>/dev/null)");
    }
  }
  return fmt::format(
      "    \"{}\") if [[ $cur == -* ]]; then words=\"{}\"; else words=\"{}\"; fi ;;\n",
      command.path, base::Join(all_flags, " "), base::Join(words, " "));
}

// A bash script that completes the program's commands, options, choices and names of experiments,
// and files everywhere else.
std::string BashCompletion(const CLI::App& program) {
  std::vector<std::string> paths;
  std::string values;
  std::string words;
  for (const Command& command : CommandsOf(program)) {
    if (!command.path.empty()) paths.push_back('"' + command.path + '"');
    values += ValueCases(command);
    words += WordCase(command);
  }
  return fmt::format(kScript, fmt::arg("commands", base::Join(paths, "|")),
                     fmt::arg("values", values), fmt::arg("words", words));
}

}  // namespace

void AddShellCommands(CLI::App& app) {
  auto* completion = app.add_subcommand(
      "completion", "Print the shell completion for this program's commands and options.");
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
                    ? BashCompletion(app)
                    : base::Join(base::ExperimentNames(base::DataFolder()), "\n") + "\n");
  });
}

}  // namespace rangegrasp::cli
