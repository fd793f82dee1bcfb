#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "base/installation.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"

namespace rangegrasp::cli {
namespace {

/// An option or a positional argument, as --help shows it.
struct OptionHelp {
  std::vector<std::string> flags;    ///< "-o", "--out"; empty for a positional argument
  std::string name;                  ///< of a positional argument, else empty
  std::string value;                 ///< what follows it, e.g. "TEXT"; empty for a flag
  std::vector<std::string> choices;  ///< all the values it takes; empty if it takes others
  std::string description, default_value;
  bool required = false;
};

/// A command, as --help shows it.
struct CommandHelp {
  std::string path;  ///< the words that call it, e.g. "seam track"; empty for the program itself
  std::string description, footer;
  std::vector<std::string> below;  ///< names of the commands one level below
  std::vector<OptionHelp> options;
};

/// The program and its commands, parents first, in the order of --help; without hidden ones.
using CommandTree = std::vector<CommandHelp>;

constexpr const char* kFiles = R"(.SH ENVIRONMENT
.TP
.B RANGEGRASP_DATA
Folder that holds models/, scenes/ and experiments/, instead of the installed one.
.SH FILES
.TP
.I PREFIX/share/rangegrasp/experiments
Experiments that can be named without a folder.
.TP
.I PREFIX/share/rangegrasp/models, PREFIX/share/rangegrasp/scenes
What they refer to.
)";

// Text as it stands: no line may begin like a request, a dash is one that can be copied.
std::string Escaped(const std::string& text) {
  std::string escaped;
  bool at_begin = true;
  for (const char c : text) {
    if (at_begin && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
    at_begin = c == '\n';
  }
  return escaped;
}

std::string Bold(const std::string& text) { return "\\fB" + Escaped(text) + "\\fR"; }

std::string Italic(const std::string& text) { return "\\fI" + Escaped(text) + "\\fR"; }

// "-o, --out FILE", "--format csv|json" or "experiment".
std::string Heading(const OptionHelp& option) {
  std::vector<std::string> names;
  for (const std::string& flag : option.flags) names.push_back(Bold(flag));
  if (names.empty()) names.push_back(Italic(option.name));
  std::string heading = base::Join(names);
  if (!option.choices.empty()) {
    heading += " " + Escaped(base::Join(option.choices, "|"));
  } else if (!option.value.empty() && !option.flags.empty()) {
    heading += " " + Italic(option.value);
  }
  return heading;
}

std::string OptionList(const CommandHelp& command) {
  std::string text;
  for (const OptionHelp& option : command.options) {
    text += ".TP\n" + Heading(option) + "\n" + Escaped(option.description);
    if (!option.default_value.empty()) text += " (default: " + Escaped(option.default_value) + ")";
    text += "\n";
  }
  return text;
}

// The lines of the footer, as they stand.
std::string Footer(const CommandHelp& command) {
  return command.footer.empty() ? "" : ".PP\n.nf\n" + Escaped(command.footer) + "\n.fi\n";
}

// The arguments are enough: options stand in the list below.
std::string Synopsis(const CommandHelp& command) {
  std::string text = Bold(command.path.empty() ? "rangegrasp" : "rangegrasp " + command.path);
  if (!command.below.empty()) text += " " + Italic("command");
  for (const OptionHelp& option : command.options) {
    if (!option.flags.empty()) continue;
    text += option.required ? " " + Italic(option.name) : " [" + Italic(option.name) + "]";
  }
  return text + " [" + Italic("options") + "]\n";
}

std::string Section(const CommandHelp& command) {
  return ".SS " + Escaped(command.path) + "\n" + Synopsis(command) + ".PP\n" +
         Escaped(command.description) + "\n" + OptionList(command) + Footer(command);
}

/// The manual page of the program and all its commands, in the language of man(7): what --help
/// says, in one page. `version` stands in its footer.
std::string ManPage(const CommandTree& tree, const std::string& version) {
  const CommandHelp& program = tree.front();
  std::string page = fmt::format(
      ".\\\" Made by `rangegrasp man` from the program's --help.\n"
      ".TH RANGEGRASP 1 \"\" \"rangegrasp {}\" \"User Commands\"\n"
      ".SH NAME\nrangegrasp \\- robot grasping from range images, in simulation\n"
      ".SH SYNOPSIS\n{}.SH DESCRIPTION\n{}\n.SH OPTIONS\n{}{}.SH COMMANDS\n",
      version, Synopsis(program), Escaped(program.description), OptionList(program),
      Footer(program));
  for (const CommandHelp& command : tree) {
    if (!command.path.empty()) page += Section(command);
  }
  return page + kFiles;
}

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

/// A bash script that completes the program's commands, options, choices and names of experiments,
/// and files everywhere else.
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
