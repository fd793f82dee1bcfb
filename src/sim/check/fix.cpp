#include "sim/check/fix.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>
#include <set>

#include "base/file.h"
#include "base/pattern.h"
#include "base/words.h"
#include "sim/check/internal/hand.h"
#include "sim/check/internal/model.h"
#include "sim/internal/scene_builder.h"

namespace rangegrasp::check {
namespace {

namespace fs = std::filesystem;
using sim::internal::LineAt;

// Rounds of fixes: names first, then how the hand closes, motions, trials.
constexpr int kRounds = 8;

std::size_t StartOf(const pugi::xml_node& node) {
  return static_cast<std::size_t>(node.offset_debug()) - 1;
}

// A start tag, "<a b='c'>".
std::string TagAt(const std::string& text, std::size_t begin) {
  const auto tag = base::FindMatch(text, R"(<(?:"[^"]*"|'[^']*'|[^"'>])*>)", begin);
  return tag ? tag->groups[0] : "";
}

std::string WithAttribute(const std::string& tag, const std::string& name,
                          const std::string& value) {
  const std::string set =
      value.empty() ? "" : fmt::format(" {}=\"{}\"", name, base::XmlEscaped(value));
  const std::string pattern = "\\s" + name + R"(\s*=\s*("[^"]*"|'[^']*'))";
  if (const auto old = base::FindMatch(tag, pattern)) {
    const std::string blank = tag.substr(old->begin, 1);
    return tag.substr(0, old->begin) + (set.empty() ? "" : blank + set.substr(1)) +
           tag.substr(old->end());
  }
  const std::size_t end = tag.size() - (tag.ends_with("/>") ? 2 : 1);
  const std::size_t last = tag.find_last_not_of(" \t\r\n", end - 1) + 1;
  return tag.substr(0, last) + set + tag.substr(last);
}

std::string Indented(const std::string& block, const std::string& indent) {
  return indent + base::Join(base::Split(block, '\n'), "\n" + indent);
}

std::vector<Change> AddBlock(const base::Edit& edit, const pugi::xml_node& node,
                             std::string& text) {
  const std::size_t begin = StartOf(node);
  const std::string tag = TagAt(text, begin);
  const std::size_t line = text.rfind('\n', begin) + 1;
  const std::string indent =
      text.substr(line, std::min(begin, text.find_first_not_of(" \t", line)) - line);
  const std::string close = fmt::format("</{}>", node.name());
  const std::size_t inner = begin + tag.size();
  if (edit.replace) {  // the element contains none of its own kind
    const std::size_t end = tag.ends_with("/>") ? inner : text.find(close, inner) + close.size();
    const std::string before = text.substr(begin, end - begin);
    const std::string block = Indented(edit.block, indent).substr(indent.size());
    if (before == block) return {};
    text.replace(begin, end - begin, block);
    return {{{}, LineAt(text, begin), before, block}};
  }
  const std::string block =
      "\n" + Indented(edit.block, indent + (indent.starts_with('\t') ? "\t" : "  "));
  if (tag.ends_with("/>")) {
    text.replace(inner - 2, 2, ">" + block + "\n" + indent + close);
  } else {
    text.insert(inner, block);
  }
  return {{{}, LineAt(text, inner) + 1, "", edit.block}};
}

// FILE.bak, or the first of FILE.bak2, FILE.bak3, ... that does not exist.
fs::path FreeBackup(const fs::path& original) {
  fs::path backup = original.string() + ".bak";
  for (int i = 2; fs::exists(backup); ++i) backup = fmt::format("{}.bak{}", original.string(), i);
  return backup;
}

}  // namespace

std::vector<base::Edit> SetNumeric(const fs::path& scene, const std::string& name,
                                   const std::string& data) {
  return internal::Model(scene, Kind::kScene).SetNumeric(name, data, "").edits;
}

std::vector<base::Edit> StifferDrives(const fs::path& scene, const std::vector<int>& joints,
                                      double times) {
  const internal::Model model(scene, Kind::kScene);
  internal::Cure cure;
  for (const int joint : joints) cure += model.Stiffer(model.arm_actuators.at(joint), times);
  return cure.edits;
}

std::string FirmerEqualities(const fs::path& scene) {
  return internal::TextOf(internal::FirmerEqualities(internal::Model(scene, Kind::kScene).m()));
}

std::string FirmerTips(const fs::path& scene) {
  return internal::TextOf(internal::FirmerTips(internal::Model(scene, Kind::kScene)));
}

std::vector<Change> ApplyEdit(const base::Edit& edit, std::string& text) {
  pugi::xml_document document;
  if (!document.load_buffer(text.data(), text.size())) return {};
  pugi::xpath_node_set nodes = document.select_nodes(edit.element.c_str());
  if (nodes.empty()) {
    const std::size_t end = text.rfind(fmt::format("</{}", document.document_element().name()));
    const bool section = edit.element.starts_with("/*/") && edit.element.rfind('/') == 2;
    if (!section || end == std::string::npos) return {};
    // At the end of the file: the last one of repeated sections counts.
    text.insert(end, fmt::format("  <{}/>\n", edit.element.substr(3)));
    return ApplyEdit(edit, text);
  }
  if (!edit.block.empty()) return AddBlock(edit, nodes.first().node(), text);
  std::vector<Change> changes;
  nodes.sort(/*reverse=*/true);  // from the end, so that earlier positions stay valid
  for (const auto& found : nodes) {
    const std::size_t begin = StartOf(found.node());
    const std::string before = TagAt(text, begin);
    std::string after = before;
    for (const auto& [name, value] : edit.set) after = WithAttribute(after, name, value);
    if (after == before) continue;
    text.replace(begin, before.size(), after);
    changes.push_back({{}, LineAt(text, begin), before, after});
  }
  std::ranges::reverse(changes);
  return changes;
}

fs::path Fixer::Original(const fs::path& file) const {
  const fs::path normal = file.lexically_normal();
  const auto found = std::ranges::find(targets_, normal, [](const auto& t) { return t.second; });
  return found == targets_.end() ? normal : found->first;
}

fs::path Fixer::Target(const fs::path& original) const {
  const auto found = targets_.find(original);
  return found == targets_.end() ? original : found->second;
}

std::string& Fixer::Text(const fs::path& original) {
  if (!texts_.contains(original)) texts_[original] = base::ReadFile(original);
  return texts_[original];
}

void Fixer::Edit(const fs::path& original, const base::Edit& edit) {
  for (Change& change : ApplyEdit(edit, Text(original))) {
    targets_[original] =
        in_place_ ? original : original.parent_path() / (original.stem().string() + ".fixed.xml");
    change.file = original;
    // Repeated edits of one element count as one change.
    const auto first = std::ranges::find_if(
        changes_, [&](const Change& c) { return c.file == original && c.after == change.before; });
    if (first == changes_.end() || change.before.empty()) {
      changes_.push_back(change);
    } else {
      first->after = change.after;
    }
  }
}

// Makes a file refer to the copies of what it includes or attaches. Returns whether it has a copy.
bool Fixer::Refer(const fs::path& original, int depth) {
  if (depth > internal::kMaxDepth || !fs::is_regular_file(original)) return false;
  pugi::xml_document document;
  document.load_string(Text(original).c_str());
  for (const auto& found : document.select_nodes("//include[@file]|//asset/model[@file]")) {
    const fs::path file = found.node().attribute("file").value();
    const fs::path child = Original(original.parent_path() / file);
    if (!Refer(child, depth + 1)) continue;
    Edit(original, {.file = {},
                    .element = fmt::format("//{}[@file='{}']", found.node().name(), file.string()),
                    .set = {{"file", (file.parent_path() / Target(child).filename()).string()}}});
  }
  return targets_.contains(original);
}

bool Fixer::Apply(const std::vector<base::Finding>& findings) {
  const auto before = texts_;
  const auto edited = targets_;
  std::set<std::string> done;  // the first of two edits of one thing counts
  for (const base::Finding& finding : findings) {
    for (const base::Edit& edit : finding.edits) {
      const std::string what = edit.set.empty() ? edit.block : edit.set.front().first;
      const fs::path original = Original(edit.file);
      const bool is_first = done.insert(edit.file + "\n" + edit.element + "\n" + what).second;
      if (is_first && fs::is_regular_file(original)) Edit(original, edit);
    }
  }
  if (!in_place_) Refer(mjcf_, 0);
  for (const auto& [original, target] : targets_) {
    if (in_place_ || edited.contains(original) || !fs::exists(target)) continue;
    throw base::InputError(target.string() + ": already exists; move it away, or check it instead");
  }
  // All backups come first: if the disk is full, no file has changed.
  for (const auto& [original, target] : targets_) {
    if (!in_place_ || edited.contains(original)) continue;
    base::WriteFile(FreeBackup(original), base::ReadFile(original));
  }
  bool changed = false;
  for (const auto& [original, target] : targets_) {
    if (edited.contains(original) && before.at(original) == texts_.at(original)) continue;
    base::WriteFile(target, texts_.at(original));
    changed = true;
  }
  return changed;
}

void Fixer::Run(std::vector<base::Finding> findings,
                const std::function<std::vector<base::Finding>()>& check) {
  for (int round = 0; round < kRounds && Apply(findings); ++round) findings = check();
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
