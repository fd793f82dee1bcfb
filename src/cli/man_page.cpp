#include "cli/man_page.h"

#include <fmt/format.h>

#include "base/words.h"

namespace rangegrasp::cli {
namespace {

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

}  // namespace

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

}  // namespace rangegrasp::cli
