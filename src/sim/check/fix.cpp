#include "sim/check/fix.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <pugixml.hpp>
#include <set>

#include "base/file.h"
#include "base/words.h"

namespace rangegrasp::check {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxNesting = 8;  // files that attach each other in a ring are the engine's to refuse

// A start tag, from '<' to behind '>'.
struct Tag {
  std::size_t begin, end;
  bool empty;  // "<a/>"
};

Tag TagAt(const std::string& text, std::size_t begin) {
  char quote = 0;
  std::size_t i = begin;
  for (; i < text.size() && (quote != 0 || text[i] != '>'); ++i) {
    if (quote != 0) {
      if (text[i] == quote) quote = 0;
    } else if (text[i] == '"' || text[i] == '\'') {
      quote = text[i];
    }
  }
  return {begin, i + 1, text[i - 1] == '/'};
}

// An attribute, from its name to behind its quote.
std::optional<std::pair<std::size_t, std::size_t>> Attribute(const std::string& text,
                                                             const Tag& tag,
                                                             const std::string& name) {
  std::size_t i = text.find_first_of(" \t\r\n", tag.begin);
  while (i < tag.end) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n", i);
    const std::size_t quote = text.find_first_of("\"'", begin);
    if (quote >= tag.end) break;
    const std::size_t end = text.find(text[quote], quote + 1) + 1;
    const std::size_t name_end = text.find_first_of(" \t\r\n=", begin);
    if (text.compare(begin, name_end - begin, name) == 0) return std::pair(begin, end);
    i = end;
  }
  return std::nullopt;
}

void SetAttribute(std::string& text, std::size_t begin, const std::string& name,
                  const std::string& value) {
  const Tag tag = TagAt(text, begin);
  const std::string set = fmt::format("{}=\"{}\"", name, base::XmlEscaped(value));
  if (const auto old = Attribute(text, tag, name)) {
    const std::size_t blank = value.empty() ? 1 : 0;
    text.replace(old->first - blank, old->second - old->first + blank, value.empty() ? "" : set);
  } else if (!value.empty()) {
    const std::size_t end = tag.end - (tag.empty ? 2 : 1);
    const std::size_t last = text.find_last_not_of(" \t\r\n", end - 1) + 1;
    text.insert(last, " " + set);
  }
}

std::string IndentOf(const std::string& text, std::size_t at) {
  const std::size_t line = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
  return text.substr(line, std::min(at, text.find_first_not_of(" \t", line)) - line);
}

// Each line of a block behind an indent.
std::string Indented(const std::string& block, const std::string& indent) {
  return indent + base::Join(base::Split(block, '\n'), "\n" + indent);
}

int LineAt(const std::string& text, std::size_t at) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(at);
  return 1 + static_cast<int>(std::count(text.begin(), end, '\n'));
}

// A section at the end of the file: of repeated ones, the last decides.
Change AddSection(const base::Edit& edit, const std::string& root, std::string& text) {
  const std::string name = edit.element.substr(edit.element.rfind('/') + 1);
  std::string section = "<" + name;
  for (const auto& [key, value] : edit.set) {
    section += fmt::format(" {}=\"{}\"", key, base::XmlEscaped(value));
  }
  section +=
      edit.block.empty() ? "/>" : fmt::format(">\n{}\n</{}>", Indented(edit.block, "  "), name);
  const std::size_t at = text.rfind("</" + root);
  text.insert(at, Indented(section, "  ") + "\n");
  return {{}, LineAt(text, at), "", section};
}

Change AddBlock(const base::Edit& edit, const pugi::xml_node& node, std::string& text) {
  const std::size_t begin = static_cast<std::size_t>(node.offset_debug()) - 1;
  const Tag tag = TagAt(text, begin);
  const std::string indent = IndentOf(text, begin);
  if (edit.replace) {
    // What is replaced holds none of its own kind.
    const std::string close = fmt::format("</{}>", node.name());
    const std::size_t end = tag.empty ? tag.end : text.find(close, tag.end) + close.size();
    Change change{{}, LineAt(text, begin), text.substr(begin, end - begin), edit.block};
    const std::string block = Indented(edit.block, indent).substr(indent.size());
    if (change.before == block) return {};
    text.replace(begin, end - begin, block);
    return change;
  }
  const std::string unit = indent.find('\t') == std::string::npos ? "  " : "\t";
  std::string block = "\n" + Indented(edit.block, indent + unit);
  if (tag.empty) {
    text.replace(tag.end - 2, 2, ">" + block + fmt::format("\n{}</{}>", indent, node.name()));
    return {{}, LineAt(text, begin) + 1, "", edit.block};
  }
  text.insert(tag.end, block);
  return {{}, LineAt(text, tag.end) + 1, "", edit.block};
}

std::vector<Change> SetAttributes(const base::Edit& edit, pugi::xpath_node_set nodes,
                                  std::string& text) {
  std::vector<Change> changes;
  nodes.sort(/*reverse=*/true);  // what was found further up stays where it is
  for (const auto& found : nodes) {
    const std::size_t begin = static_cast<std::size_t>(found.node().offset_debug()) - 1;
    const auto tag = [&] { return text.substr(begin, TagAt(text, begin).end - begin); };
    const std::string before = tag();
    for (const auto& [name, value] : edit.set) SetAttribute(text, begin, name, value);
    if (tag() != before) changes.push_back({{}, LineAt(text, begin), before, tag()});
  }
  return changes;
}

}  // namespace

std::vector<Change> ApplyEdit(const base::Edit& edit, const fs::path& file, std::string& text) {
  pugi::xml_document document;
  if (!document.load_buffer(text.data(), text.size())) return {};
  const pugi::xpath_node_set nodes = document.select_nodes(edit.element.c_str());
  const std::string root = document.document_element().name();
  std::vector<Change> changes;
  if (nodes.empty()) {
    const bool section = edit.element.rfind('/') == 2 && edit.element.starts_with("/*/");
    if (section && text.rfind("</" + root) != std::string::npos) {
      changes.push_back(AddSection(edit, root, text));
    }
  } else if (edit.block.empty()) {
    changes = SetAttributes(edit, nodes, text);
  } else {
    changes.push_back(AddBlock(edit, nodes.first().node(), text));
  }
  std::erase_if(changes, [](const Change& change) { return change.after.empty(); });
  for (Change& change : changes) change.file = file;
  return changes;
}

fs::path Fixer::Original(const fs::path& file) const {
  const fs::path normal = file.lexically_normal();
  for (const auto& [original, target] : targets_) {
    if (target == normal) return original;
  }
  return normal;
}

fs::path Fixer::Target(const fs::path& original) const {
  const auto found = targets_.find(original);
  return found == targets_.end() ? original : found->second;
}

const std::string& Fixer::Text(const fs::path& original) {
  const auto found = texts_.find(original);
  return found != texts_.end() ? found->second
                               : texts_.emplace(original, base::ReadFile(original)).first->second;
}

std::vector<fs::path> Fixer::References(const fs::path& original) {
  std::vector<fs::path> files;
  pugi::xml_document document;
  document.load_string(Text(original).c_str());
  for (const auto& found : document.select_nodes("//include[@file]|//asset/model[@file]")) {
    files.push_back(found.node().attribute("file").value());
  }
  return files;
}

// Lets a file refer to the copies of what it includes or attaches. Whether it has a copy itself.
bool Fixer::Refer(const fs::path& original, int depth) {
  if (depth > kMaxNesting || !fs::is_regular_file(original)) return false;
  for (const fs::path& file : References(original)) {
    const fs::path child = Original(original.parent_path() / file);
    if (!Refer(child, depth + 1) || file.filename() == Target(child).filename()) continue;
    const std::string copy = (file.parent_path() / Target(child).filename()).string();
    std::string text = Text(original);
    for (const char* element : {"//include", "//asset/model"}) {
      const base::Edit edit{.file = {},
                            .element = fmt::format("{}[@file='{}']", element, file.string()),
                            .set = {{"file", copy}}};
      const auto made = ApplyEdit(edit, original, text);
      changes_.insert(changes_.end(), made.begin(), made.end());
    }
    texts_[original] = text;
    targets_[original] = original.parent_path() / (original.stem().string() + ".fixed.xml");
  }
  return targets_.contains(original);
}

void Fixer::Back(const std::set<fs::path>& files) {
  const auto backup = [](const fs::path& file) { return fs::path(file.string() + ".bak"); };
  for (const fs::path& file : files) {
    if (!fs::exists(backup(file))) continue;
    throw base::InputError(backup(file).string() +
                           ": is there already; move it away, or let --fix write copies");
  }
  for (const fs::path& file : files) base::WriteFile(backup(file), base::ReadFile(file));
}

bool Fixer::Apply(const std::vector<base::Finding>& findings) {
  std::set<std::string> done;  // of two edits for one thing, the first
  std::set<fs::path> first;    // files that were not edited before
  const std::size_t before = changes_.size();
  for (const base::Finding& finding : findings) {
    for (const base::Edit& edit : finding.edits) {
      const std::string names = edit.set.empty() ? edit.block : edit.set.front().first;
      if (!done.insert(edit.file + "\n" + edit.element + "\n" + names).second) continue;
      const fs::path original = Original(edit.file);
      if (!fs::is_regular_file(original)) continue;
      std::string text = Text(original);
      const auto made = ApplyEdit(edit, original, text);
      if (made.empty()) continue;
      changes_.insert(changes_.end(), made.begin(), made.end());
      texts_[original] = text;
      const fs::path copy = original.parent_path() / (original.stem().string() + ".fixed.xml");
      if (targets_.emplace(original, in_place_ ? original : copy).second) first.insert(original);
    }
  }
  if (changes_.size() == before) return false;
  if (in_place_) {
    Back(first);
  } else {
    Refer(mjcf_, 0);
  }
  for (const auto& [original, target] : targets_) base::WriteFile(target, texts_.at(original));
  return true;
}

std::vector<Change> Fixer::changes() const {
  std::vector<Change> changes = changes_;
  for (Change& change : changes) {
    const std::string& text = texts_.at(change.file);
    const std::size_t at = text.find(change.after.substr(0, change.after.find('\n')));
    if (at != std::string::npos) change.line = LineAt(text, at);
    change.file = Target(change.file);
  }
  return changes;
}

}  // namespace rangegrasp::check
