#include "base/error.h"

#include <regex>

namespace rangegrasp::base {
namespace {

// `<joint name="joint1">` for "//worldbody//joint[@name='joint1']", `<custom>` for "/*/custom".
std::string Readable(const std::string& xpath) {
  static const std::regex named(R"(.*/([^/\[]+)\[@(\w+)='([^']*)'\])"), section(R"(/\*/(\w+))");
  if (std::regex_match(xpath, section)) return std::regex_replace(xpath, section, "<$1>");
  return std::regex_replace(xpath, named, "<$1 $2=\"$3\">");
}

// Names the edited file if the finding is about another file.
std::string FileOf(const Edit& edit, const Finding& finding) {
  return finding.where.starts_with(edit.file) ? "" : " of " + edit.file;
}

// What follows the place: the problem, then the fix.
std::string ProblemOf(const Finding& finding) {
  std::string text = finding.element.empty() ? "" : finding.element + ": ";
  text += finding.what;
  const std::string cure = CureOf(finding);
  if (cure.empty()) return text;
  text += "\n    fix: ";
  for (const char c : cure) text += c == '\n' ? std::string("\n      ") : std::string(1, c);
  return text;
}

}  // namespace

std::string CureOf(const Finding& finding) {
  std::string text;
  const Edit* last = nullptr;
  for (const Edit& edit : finding.edits) {
    const std::string place = Readable(edit.element) + FileOf(edit, finding);
    if (last != nullptr && edit.block.empty() && edit.set == last->set) {
      text += ", " + place;
      continue;
    }
    if (last != nullptr) text += "\n";
    last = &edit;
    for (const auto& [name, value] : edit.set) {
      if (!value.empty()) text += name + "=\"" + value + "\" ";
    }
    if (edit.block.empty()) {
      text += "in " + place;
    } else {
      text += (edit.replace ? "instead of " : "in ") + place + ":" +
              (edit.block.find('\n') == std::string::npos ? " " : "\n") + edit.block;
    }
  }
  return text + finding.cure;
}

std::string TextOf(const Finding& finding) {
  return finding.where + (finding.error ? ": error: " : ": warning: ") + ProblemOf(finding);
}

std::string MessageOf(const Finding& finding) { return finding.where + ": " + ProblemOf(finding); }

}  // namespace rangegrasp::base
