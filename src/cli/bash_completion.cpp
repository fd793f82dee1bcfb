#include "cli/bash_completion.h"

#include <fmt/format.h>

#include "base/words.h"

namespace rangegrasp::cli {
namespace {

// Finds the command among the words before the cursor, then what may stand at the cursor: a choice
// of the option before it, or an option, a command or an experiment's name. Where nothing is
// offered bash completes files. bash splits --format=csv into three words at the =.
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

// After an option with a value: its choices, or files.
std::string ValueCases(const CommandHelp& command) {
  std::string cases;
  for (const OptionHelp& option : command.options) {
    if (option.flags.empty() || option.value.empty()) continue;
    std::vector<std::string> patterns;
    for (const std::string& flag : option.flags) {
      patterns.push_back(fmt::format("\"{} {}\"", command.path, flag));
    }
    const std::string reply = option.choices.empty()
                                  ? ""
                                  : fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")); ",
                                                base::Join(option.choices, " "));
    cases += fmt::format("    {}) {}return ;;\n", base::Join(patterns, "|"), reply);
  }
  return cases;
}

// Options where a dash is typed; else commands, choices of the arguments, names of experiments.
std::string WordCase(const CommandHelp& command) {
  std::vector<std::string> flags;
  std::vector<std::string> words = command.below;
  for (const OptionHelp& option : command.options) {
    flags.insert(flags.end(), option.flags.begin(), option.flags.end());
    if (!option.flags.empty()) continue;
    words.insert(words.end(), option.choices.begin(), option.choices.end());
    if (option.name == "experiment") {
      words.push_back("$(\"${COMP_WORDS[0]}\" completion experiments 2>/dev/null)");
    }
  }
  return fmt::format(
      "    \"{}\") if [[ $cur == -* ]]; then words=\"{}\"; else words=\"{}\"; fi ;;\n",
      command.path, base::Join(flags, " "), base::Join(words, " "));
}

}  // namespace

std::string BashCompletion(const CommandTree& tree) {
  std::vector<std::string> paths;
  std::string values;
  std::string words;
  for (const CommandHelp& command : tree) {
    if (!command.path.empty()) paths.push_back('"' + command.path + '"');
    values += ValueCases(command);
    words += WordCase(command);
  }
  return fmt::format(kScript, fmt::arg("commands", base::Join(paths, "|")),
                     fmt::arg("values", values), fmt::arg("words", words));
}

}  // namespace rangegrasp::cli
