#include "core/yaml_map.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"

namespace rangegrasp::core {
namespace {

std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string Join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string Number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

struct YamlMap::Impl {
  std::filesystem::path file;
  YAML::Node node;  ///< a map, or null
  std::vector<std::string> asked;

  std::string At(const YAML::Mark& mark) const {
    const std::string line = mark.line >= 0 ? std::to_string(mark.line + 1) : "1";
    return file.string() + ":" + line + ": ";
  }

  // Where the key stands (a value may begin on a later line); the map's begin if it is absent.
  YAML::Mark MarkOf(const std::string& key) const {
    if (node.IsMap()) {
      for (const auto& entry : node) {
        if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.first.Mark();
      }
    }
    return node.Mark();
  }

  // The parser takes a key that stands twice and keeps one value without a word.
  void CheckNoKeyTwice() const {
    std::vector<std::string> seen;
    for (const auto& entry : node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
        throw InputError(At(entry.first.Mark()) + "key '" + key + "': stands twice");
      }
      seen.push_back(key);
    }
  }
};

std::string NearestWord(const std::string& word, const std::vector<std::string>& words) {
  const auto nearest = std::min_element(
      words.begin(), words.end(),
      [&](const auto& a, const auto& b) { return EditDistance(word, a) < EditDistance(word, b); });
  return nearest == words.end() ? "" : *nearest;
}

YamlMap::YamlMap(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
YamlMap::~YamlMap() = default;
YamlMap::YamlMap(YamlMap&&) noexcept = default;

YamlMap YamlMap::FromFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    const bool there = std::filesystem::exists(file, error);
    throw InputError(file.string() + (there ? ": is no file" : ": no such file") +
                     "; a YAML file is needed");
  }
  auto impl = std::make_unique<Impl>();
  impl->file = file;
  try {
    impl->node = YAML::LoadFile(file.string());
  } catch (const YAML::ParserException& e) {
    throw InputError(impl->At(e.mark) + "not valid YAML: " + e.msg);
  } catch (const YAML::Exception& e) {
    throw InputError(file.string() + ": cannot be read: " + e.what());
  }
  if (!impl->node.IsMap()) {
    throw InputError(impl->At(impl->node.Mark()) + "the file must hold 'key: value' lines");
  }
  impl->CheckNoKeyTwice();
  return YamlMap(std::move(impl));
}

bool YamlMap::Has(const std::string& key) const {
  const YAML::Node& node = impl_->node;
  return node.IsMap() && node[key].IsDefined();
}

YamlMap YamlMap::Child(const std::string& key) {
  impl_->asked.push_back(key);
  auto impl = std::make_unique<Impl>();
  impl->file = impl_->file;
  if (Has(key)) {
    const YAML::Node& all = impl_->node;
    impl->node = all[key];
    if (!impl->node.IsMap()) Fail(key, "must hold 'key: value' lines");
    impl->CheckNoKeyTwice();
  }
  return YamlMap(std::move(impl));
}

void YamlMap::Fail(const std::string& key, const std::string& what) const {
  throw InputError(impl_->At(impl_->MarkOf(key)) + "key '" + key + "': " + what);
}

void YamlMap::Require(const std::string& key) const {
  if (!Has(key)) Fail(key, "is missing and has no default");
}

namespace {

template <typename T>
bool Convert(const YAML::Node& node, T& value) {
  return node.IsScalar() && YAML::convert<T>::decode(node, value);
}

std::string Shown(const YAML::Node& node) {
  if (node.IsNull()) return "no value";
  return node.IsScalar() ? "'" + node.Scalar() + "'" : std::string("a list or map");
}

}  // namespace

void YamlMap::Read(const std::string& key, std::string& value) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  if (!Convert(node, value) || value.empty()) Fail(key, Shown(node) + " is no text");
}

void YamlMap::Read(const std::string& key, bool& value) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  if (!Convert(node, value)) Fail(key, Shown(node) + " must be true or false");
}

void YamlMap::Read(const std::string& key, std::uint64_t& value) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  if (!Convert(node, value) || node.Scalar().front() == '-') {
    Fail(key, Shown(node) + " must be a whole number from 0");
  }
}

void YamlMap::Read(const std::string& key, std::vector<std::string>& value) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  if (!node.IsSequence() || node.size() == 0) {
    Fail(key, Shown(node) + " must be a list, e.g. [a, b]");
  }
  value.clear();
  for (const YAML::Node& item : node) {
    std::string text;
    if (!Convert(item, text)) Fail(key, "holds something that is no text");
    value.push_back(text);
  }
}

void YamlMap::Read(const std::string& key, int& value, int low, int high) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  int read = 0;
  if (!Convert(node, read) || read < low || read > high) {
    Fail(key, Shown(node) + " must be a whole number from " + std::to_string(low) + " to " +
                  std::to_string(high));
  }
  value = read;
}

void YamlMap::ReadScaled(const std::string& key, double& value, double unit, double low,
                         double high) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  double read = 0.0;
  if (!Convert(node, read) || !std::isfinite(read) || read < low || read > high) {
    Fail(key, Shown(node) + " must be a number from " + Number(low) + " to " + Number(high));
  }
  value = read * unit;
}

void YamlMap::Read(const std::string& key, std::optional<double>& value, double low, double high) {
  double read = 0.0;
  ReadScaled(key, read, 1.0, low, high);
  if (Has(key)) value = read;
}

void YamlMap::ReadWord(const std::string& key, int& position,
                       const std::vector<std::string>& names) {
  impl_->asked.push_back(key);
  if (!Has(key)) return;
  const YAML::Node node = impl_->node[key];
  std::string word;
  if (!Convert(node, word)) Fail(key, Shown(node) + " must be one of " + Join(names));
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end()) {
    Fail(key,
         "'" + word + "' must be one of " + Join(names) + "; nearest: " + NearestWord(word, names));
  }
  position = static_cast<int>(found - names.begin());
}

void YamlMap::ReadPath(const std::string& key, std::filesystem::path& value) {
  std::string text;
  Read(key, text);
  if (text.empty()) return;
  const std::filesystem::path path = (impl_->file.parent_path() / text).lexically_normal();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    Fail(key, "'" + text + "' does not exist (looked for " + path.string() +
                  "; paths are relative to the YAML file)");
  }
  value = path;
}

void YamlMap::Finish() const {
  if (!impl_->node.IsMap()) return;
  for (const auto& entry : impl_->node) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::find(impl_->asked.begin(), impl_->asked.end(), key) != impl_->asked.end()) continue;
    throw InputError(impl_->At(entry.first.Mark()) + "unknown key '" + key +
                     "'; nearest valid key: '" + NearestWord(key, impl_->asked) +
                     "'; valid: " + Join(impl_->asked));
  }
}

}  // namespace rangegrasp::core
