#include "base/yaml_map.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <ranges>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"

namespace rangegrasp::base {
namespace {

// Data shared by all mappings of one file.
struct Document {
  std::filesystem::path file;
  std::vector<KeyDoc> keys;
  std::vector<std::string> overridden;  ///< key paths set by --set
  bool only_documentation = false;

  KeyDoc& Key(const std::string& path) {
    const auto known = std::ranges::find(keys, path, &KeyDoc::path);
    return known != keys.end() ? *known : keys.emplace_back(KeyDoc{path, "", "", "", "", false});
  }
};

template <typename T>
bool Convert(const YAML::Node& node, T& value) {
  return node.IsScalar() && YAML::convert<T>::decode(node, value);
}

bool Contains(const std::vector<std::string>& words, const std::string& word) {
  return std::ranges::find(words, word) != words.end();
}

/// The key of an entry of a map.
std::string KeyOf(const YAML::const_iterator::value_type& entry) {
  return entry.first.IsScalar() ? entry.first.Scalar() : "?";
}

/// "'3' must be a text", "must be a text, not a list".
std::string MustBe(const YAML::Node& node, const std::string& what) {
  if (node.IsNull()) return "its value is missing; it must be " + what;
  if (node.IsScalar()) return "'" + Excerpt(node.Scalar()) + "' must be " + what;
  return "must be " + what + (node.IsMap() ? ", not a map" : ", not a list");
}

}  // namespace

struct YamlMap::Impl {
  std::shared_ptr<Document> document;
  std::string prefix;  ///< "" or "outer.inner."
  YAML::Node node;     ///< a map, or null
  std::vector<std::string> asked;

  std::string At(const YAML::Mark& mark) const {
    return fmt::format("{}:{}: ", document->file.string(), std::max(mark.line, 0) + 1);
  }
  // The start of a message about a key: "--set key: " if it is from the command line.
  std::string Where(const std::string& key, const YAML::Mark& mark) const {
    const std::string path = prefix + key;
    for (const std::string& given : document->overridden) {
      if ((path + ".").starts_with(given + ".")) return "--set " + path + ": ";
      // A mapping that is not in the file has no mark.
      if (mark.is_null() && given.starts_with(path + ".")) return "--set " + given + ": ";
    }
    return At(mark);
  }

  // Position of the key (its value may begin on a later line), or of the map if the key is absent.
  YAML::Mark MarkOf(const std::string& key) const {
    for (const auto& entry : node) {
      if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.first.Mark();
    }
    return node.Mark();
  }

  // The parser accepts a duplicate key and silently keeps one of the values.
  void CheckNoKeyTwice() const {
    std::vector<std::string> seen;
    for (const auto& entry : node) {
      const std::string key = KeyOf(entry);
      if (Contains(seen, key)) {
        throw InputError(At(entry.first.Mark()) + "key '" + key + "': is given twice");
      }
      seen.push_back(key);
    }
  }

  /// The key that an unknown one is meant for, also of a mapping that was read before; empty: none.
  std::string Nearest(const std::string& key) const {
    for (const KeyDoc& known : document->keys) {
      if (known.path == key || known.path.ends_with("." + key)) return known.path;
    }
    return NearestWord(key, asked);
  }

  /// The first key that is not known so far and a misspelt form of this one; empty: none.
  std::string MistakenFor(const std::string& key) const {
    constexpr std::ptrdiff_t kLonger = 2;
    std::vector<std::string> known = asked;
    known.push_back(key);
    for (const auto& entry : node) {
      const std::string given = KeyOf(entry);
      const bool alike = std::abs(std::ssize(given) - std::ssize(key)) <= kLonger;
      if (alike && !Contains(known, given) && NearestWord(given, known) == key) return given;
    }
    return "";
  }

  /// Undefined if the key is absent. (Non-const access would create the key.)
  YAML::Node ValueOf(const std::string& key) const { return node[key]; }

  // Records the key as known and for the documentation. @return its value if present
  std::optional<YAML::Node> Ask(const std::string& key, const std::string& type,
                                const std::string& default_value, const std::string& range,
                                const std::string& doc) {
    if (!Contains(asked, key)) asked.push_back(key);
    KeyDoc& entry = document->Key(prefix + key);
    entry = {prefix + key, type, default_value, range, doc, entry.required};
    const YAML::Node value = ValueOf(key);
    return value.IsDefined() ? std::optional(value) : std::nullopt;
  }

  // Sets "key.inner=value" in the tree below `node`.
  void Override(const std::string& text) {
    // Results store each of them as one line.
    if (text.find('\n') != std::string::npos) {
      throw InputError(fmt::format(
          "--set {:?}: must be on one line; write lists and maps as [a, b] and {{key: value}}",
          text));
    }
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0) {
      throw InputError("--set '" + text + "': must be KEY=VALUE, e.g. physics.timestep_ms=1");
    }
    const std::string path = text.substr(0, sign);
    YAML::Node value;
    try {
      value = YAML::Load(text.substr(sign + 1));
    } catch (const YAML::Exception& e) {
      throw InputError("--set '" + text + "': the value is not valid YAML: " + e.msg);
    }
    const std::vector<std::string> keys = Split(path, '.');
    YAML::Node at = node;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
      if (at[keys[i]].IsDefined() && !at[keys[i]].IsMap()) {
        throw InputError("--set '" + text + "': '" + keys[i] + "' has no keys");
      }
      at.reset(at[keys[i]]);
    }
    at[keys.back()] = value;
    document->overridden.push_back(path);
  }
};

YamlMap::YamlMap(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
YamlMap::~YamlMap() = default;
YamlMap::YamlMap(YamlMap&&) noexcept = default;

YamlMap YamlMap::FromFile(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides) {
  return FromText(ReadFile(file), file, overrides);
}

YamlMap YamlMap::FromText(const std::string& text, const std::filesystem::path& file,
                          const std::vector<std::string>& overrides) {
  auto impl = std::make_unique<Impl>();
  impl->document = std::make_shared<Document>();
  impl->document->file = file;
  CheckUtf8(text, file.string());
  try {
    impl->node = YAML::Load(text);
  } catch (const YAML::ParserException& e) {
    throw InputError(impl->At(e.mark) + "not valid YAML: " + e.msg +
                     " (see also the line before: a space must follow ':', tabs are not allowed)");
  } catch (const YAML::Exception& e) {
    throw InputError(file.string() + ": cannot be read: " + e.what());
  }
  if (!impl->node.IsMap()) {
    throw InputError(impl->At(impl->node.Mark()) + "the file must contain 'key: value' lines");
  }
  impl->CheckNoKeyTwice();
  for (const std::string& one : overrides) impl->Override(one);
  return YamlMap(std::move(impl));
}

void YamlMap::Override(const std::string& one) { impl_->Override(one); }

YamlMap YamlMap::ForDocumentation() {
  auto impl = std::make_unique<Impl>();
  impl->document = std::make_shared<Document>();
  impl->document->only_documentation = true;
  return YamlMap(std::move(impl));
}

const std::filesystem::path& YamlMap::file() const { return impl_->document->file; }

bool YamlMap::Has(const std::string& key) const { return impl_->ValueOf(key).IsDefined(); }

bool YamlMap::HoldsMap(const std::string& key) const {
  return Has(key) && impl_->ValueOf(key).IsMap();
}

std::vector<std::string> YamlMap::Names() const {
  std::vector<std::string> names;
  for (const auto& entry : impl_->node) names.push_back(KeyOf(entry));
  return names;
}

namespace {

// Levels of keys that files have; an anchor may make a mapping contain itself.
constexpr int kLevels = 3;

std::string OnOneLine(YAML::Node value) {
  if (value.IsScalar()) return value.Scalar();  // without quotes
  value.SetStyle(YAML::EmitterStyle::Flow);
  return YAML::Dump(value);
}

void AddValues(const YAML::Node& map, const std::string& prefix, int levels,
               std::map<std::string, std::string>& values) {
  for (const auto& entry : map) {
    const std::string path = prefix + KeyOf(entry);
    if (entry.second.IsMap() && levels > 1) {
      AddValues(entry.second, path + ".", levels - 1, values);
    } else {
      values[path] = OnOneLine(entry.second);
    }
  }
}

}  // namespace

std::map<std::string, std::string> YamlMap::Values() const {
  std::map<std::string, std::string> values;
  AddValues(impl_->node, impl_->prefix, kLevels, values);
  return values;
}

YamlMap YamlMap::Child(const std::string& key, const std::string& doc) {
  impl_->Ask(key, "mapping", "", "", doc);
  return Inner(key);
}

YamlMap YamlMap::Inner(const std::string& key) const {
  auto impl = std::make_unique<Impl>();
  impl->document = impl_->document;
  impl->prefix = impl_->prefix + key + ".";
  if (Has(key)) {
    impl->node = impl_->ValueOf(key);
    if (!impl->node.IsMap()) Fail(key, "must contain 'key: value' lines");
    impl->CheckNoKeyTwice();
  }
  return YamlMap(std::move(impl));
}

void YamlMap::Fail(const std::string& key, const std::string& what) const {
  throw InputError(impl_->Where(key, impl_->MarkOf(key)) + "key '" + key + "': " + what);
}

std::optional<std::string> YamlMap::PlaceOf(const std::string& key) const {
  if (!Has(key)) return std::nullopt;
  const std::string where = impl_->Where(key, impl_->MarkOf(key));
  return where.substr(0, where.rfind(": "));
}

void YamlMap::Require(const std::string& key) {
  impl_->document->Key(impl_->prefix + key).required = true;
  if (!Has(key) && !impl_->document->only_documentation) {
    const std::string& in = impl_->prefix;
    const std::string given = impl_->MistakenFor(key);
    Fail(key, "is missing" + (in.empty() ? "" : " in '" + in.substr(0, in.size() - 1) + "'") +
                  " and has no default" +
                  (given.empty() ? "" : "; is '" + given + "' meant for it?"));
  }
}

void YamlMap::Read(const std::string& key, std::string& value, const std::string& doc) {
  const auto node = impl_->Ask(key, "text", value, "", doc);
  if (!node) return;
  if (!Convert(*node, value) || value.empty()) Fail(key, MustBe(*node, "a text"));
}

void YamlMap::Read(const std::string& key, bool& value, const std::string& doc) {
  const auto node = impl_->Ask(key, "true or false", value ? "true" : "false", "", doc);
  if (!node) return;
  if (!Convert(*node, value)) Fail(key, MustBe(*node, "true or false"));
}

void YamlMap::Read(const std::string& key, std::uint64_t& value, const std::string& doc) {
  const auto node = impl_->Ask(key, "whole number", fmt::format("{}", value), "from 0", doc);
  if (!node) return;
  if (!Convert(*node, value) || node->Scalar().front() == '-') {
    Fail(key, MustBe(*node, "a whole number from 0"));
  }
}

void YamlMap::Read(const std::string& key, std::vector<std::string>& value,
                   const std::string& doc) {
  const auto node = impl_->Ask(key, "list", value.empty() ? "" : "[" + Join(value) + "]", "", doc);
  if (!node) return;
  if (!node->IsSequence()) Fail(key, MustBe(*node, "a list, e.g. [a, b]"));
  if (node->size() == 0) {
    Fail(key, "is an empty list; it must have at least one element, e.g. [a, b]");
  }
  value.clear();
  for (const YAML::Node& item : *node) {
    std::string text;
    if (!Convert(item, text)) Fail(key, "must contain only texts");
    value.push_back(text);
  }
}

void YamlMap::Read(const std::string& key, int& value, int low, int high, const std::string& doc) {
  const auto node = impl_->Ask(key, "whole number", fmt::format("{}", value),
                               fmt::format("{} to {}", low, high), doc);
  if (!node) return;
  int read = 0;
  if (!Convert(*node, read) || read < low || read > high) {
    Fail(key, MustBe(*node, fmt::format("a whole number from {} to {}", low, high)));
  }
  value = read;
}

void YamlMap::ReadScaled(const std::string& key, double& value, double unit, double low,
                         double high, const std::string& doc) {
  const auto node = impl_->Ask(key, "number", fmt::format("{:.6g}", value / unit),
                               fmt::format("{} to {}", low, high), doc);
  if (!node) return;
  double read = 0.0;
  if (!Convert(*node, read) || !std::isfinite(read) || read < low || read > high) {
    Fail(key, MustBe(*node, fmt::format("a number from {} to {}", low, high)));
  }
  value = read * unit;
}

void YamlMap::Read(const std::string& key, std::optional<double>& value, double low, double high,
                   const std::string& doc) {
  double read = value.value_or(0.0);
  ReadScaled(key, read, 1.0, low, high, doc);
  if (!value) impl_->document->Key(impl_->prefix + key).default_value.clear();
  if (Has(key)) value = read;
}

void YamlMap::Read(const std::string& key, std::string& value,
                   const std::vector<std::string>& words, const std::string& doc) {
  auto position = static_cast<std::size_t>(std::ranges::find(words, value) - words.begin());
  ReadWord(key, position, words, doc);
  value = words[position];
}

void YamlMap::ReadWord(const std::string& key, std::size_t& position,
                       const std::vector<std::string>& words, const std::string& doc) {
  const auto node = impl_->Ask(key, "word", words[position], "one of " + Join(words), doc);
  if (!node) return;
  std::string word;
  if (!Convert(*node, word)) Fail(key, MustBe(*node, "one of " + Join(words)));
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) {
    CheckBuilt("value", impl_->prefix + key + "=" + word, impl_->Where(key, node->Mark()));
    Fail(key, MustBeOneOf(word, words));
  }
  position = static_cast<std::size_t>(found - words.begin());
}

void YamlMap::ReadWords(const std::string& key, std::vector<std::string>& values,
                        const std::vector<std::string>& words, const std::string& doc) {
  Read(key, values, doc);
  impl_->document->Key(impl_->prefix + key).range = "of " + Join(words);
  for (const std::string& word : values) {
    if (!Contains(words, word)) Fail(key, MustBeOneOf(word, words));
  }
}

namespace {

// Letters that the names of two files have in common at the start if one is meant for the other.
constexpr std::size_t kSameStart = 3;

/// "; the program has FILE" if a path that does not exist is that of a file of the program, or has
/// the name of a scene or sensor of the program or one like it.
std::string Shipped(const std::filesystem::path& text) {
  std::filesystem::path inner;
  for (const auto& part : text.lexically_normal()) {
    if (part != "..") inner /= part;
  }
  const auto has = [](const std::filesystem::path& file) {
    return "; the program has " + file.string();
  };
  try {
    std::error_code error;
    for (const auto& folder : {DataFolder(), DataFolder() / "experiments"}) {
      if (inner.empty() || inner.is_absolute()) break;
      if (std::filesystem::exists(folder / inner, error)) return has(folder / inner);
    }
    std::map<std::string, std::filesystem::path> files;
    for (const auto& folder : {DataFolder() / "scenes", DataFolder() / "models/sensors"}) {
      for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        files[entry.path().stem().string()] = entry.path();
      }
    }
    const auto names = std::views::keys(files);
    const std::string stem = text.stem().string();
    const std::string nearest = NearestWord(stem, {names.begin(), names.end()});
    if (stem.size() >= kSameStart && nearest.starts_with(stem.substr(0, kSameStart))) {
      return has(files.at(nearest));
    }
  } catch (const InputError&) {  // a program without data
  }
  return "";
}

}  // namespace

void YamlMap::ReadPath(const std::string& key, std::filesystem::path& value,
                       const std::string& doc) {
  const auto node = impl_->Ask(key, "path", value.generic_string(), "", doc);
  if (!node) return;
  std::string text;
  if (!Convert(*node, text) || text.empty()) Fail(key, MustBe(*node, "a text"));
  const std::filesystem::path path =
      (impl_->document->file.parent_path() / text).lexically_normal();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    Fail(key, "'" + text + "' does not exist (looked for " + path.string() +
                  "; paths are relative to the YAML file)" + Shipped(text));
  }
  // Results may name a device or pipe, which may never end.
  if (!std::filesystem::is_regular_file(path, error) &&
      !std::filesystem::is_directory(path, error)) {
    Fail(key, "'" + text + "' is a device or pipe; it must be a file or folder");
  }
  value = path;
}

void YamlMap::Finish() const {
  for (const auto& entry : impl_->node) {
    const std::string key = KeyOf(entry);
    if (Contains(impl_->asked, key)) continue;
    const std::string at = impl_->Where(key, entry.first.Mark());
    CheckBuilt("key", impl_->prefix + key, at);
    const std::string nearest = impl_->Nearest(key);
    throw InputError(at + "unknown key '" + key + "'; " +
                     (nearest.empty() ? "" : "nearest valid key: '" + nearest + "'; ") +
                     "valid: " + Join(impl_->asked));
  }
}

const std::vector<KeyDoc>& YamlMap::Keys() const { return impl_->document->keys; }

void RangeCheck::Read(const std::string& key, int value, int low, int high) const {
  if (value < low || value > high) Fail(key, value, low, high);
}

void RangeCheck::ReadScaled(const std::string& key, double value, double unit, double low,
                            double high) const {
  // A relative tolerance for bounds that were converted to SI units and back.
  const double slack = 1e-9 * std::max(std::abs(low), std::abs(high));
  const double in_unit = value / unit;
  if (!(in_unit >= low - slack && in_unit <= high + slack)) Fail(key, in_unit, low, high);
}

void RangeCheck::Fail(const std::string& key, double value, double low, double high) const {
  throw std::invalid_argument(fmt::format("{}: {}: {:g} is out of range, must be from {:g} to {:g}",
                                          what_, key, value, low, high));
}

}  // namespace rangegrasp::base
